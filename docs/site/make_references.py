"""Writes docs/references.md from references.bib: ``python docs/site/make_references.py`` (needs the extra ``docs``)."""

from pathlib import Path

from pybtex.database import parse_file
from pybtex.plugin import find_plugin

_DOCS = Path(__file__).resolve().parents[1]

_HEAD = """# References

For readers who look for a source: all publications cited in these pages and in the code. `python docs/site/make_references.py` writes this page from
[references.bib](references.bib). "The paper" is the publication that a page names first. *Unchecked*: not compared with a second source.

"""


def markdown() -> str:
    """Return the page."""
    style = find_plugin("pybtex.style.formatting", "plain")()
    backend = find_plugin("pybtex.backends", "markdown")()
    entries = style.format_bibliography(parse_file(_DOCS / "references.bib", "bibtex"))
    lines = [f"- {' '.join(entry.text.render(backend).split())}\n" for entry in entries]
    return _HEAD + "".join(lines)


if __name__ == "__main__":
    (_DOCS / "references.md").write_text(markdown(), encoding="utf-8")
