"""Add pages from outside docs/ to the site: the README of sdf/, and the notebooks (executed ones from the folder NOTEBOOKS).

Formulas become MathML, which browsers show without a script or a network.
"""

import html
import logging
import os
import re
from pathlib import Path

from latex2mathml.converter import convert
from make_references import markdown as references
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page
from nbconvert import MarkdownExporter

from linkages.base.palette import VARIABLES

_ROOT = Path(__file__).resolve().parents[2]
_NOTEBOOKS = Path(os.environ.get("NOTEBOOKS", _ROOT / "notebooks"))
#: Weights in the search, by part of the site; a word in a title counts 1000 times one in a text, so a guide's text
#: precedes a title of the API, and about equals one of the evidence.
_WEIGHTS = {"API": 1e-4, "Evidence": 1e-3, "Notebooks": 0.05, "Explanation": 0.3, "Reference": 0.5}
_KEYS = re.compile(r"<h2 id=\"all-keys\"|<h2 id=\"outputs\"")  # headings of generated lists
_FORMULA = re.compile(r"\\\((.+?)\\\)|\\\[(.+?)\\\]", re.DOTALL)


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages that live elsewhere in the repository, where the links of docs/ point to."""
    if (_ROOT / "docs" / "references.md").read_text(encoding="utf-8") != references():
        logging.getLogger("mkdocs").warning("references.md is not fresh: python docs/site/make_references.py")
    files.append(File.generated(config, "machines.md", abs_src_path=str(_ROOT / "sdf" / "README.md")))
    files.append(File.generated(config, "site/palette.css", content=_palette()))
    for path in sorted(_NOTEBOOKS.glob("*.ipynb")):
        name = f"notebooks/{path.stem}"
        page, resources = MarkdownExporter().from_filename(path, {"unique_key": path.stem})
        files.append(File.generated(config, f"{name}.md", content=page))
        for picture, content in resources["outputs"].items():
            files.append(File.generated(config, f"notebooks/{picture}", content=content))
    return files


def on_page_markdown(markdown: str, page: Page, **_: object) -> str:
    """Point links between docs/ and the added pages to the site's pages; weigh the page in the search by its part."""
    for part in page.ancestors:
        if part.title in _WEIGHTS:
            page.meta["search"] = {"boost": _WEIGHTS[part.title]}
            break
    inside = markdown.replace("](../sdf/README.md", "](machines.md").replace("](../notebooks/", "](notebooks/")
    inside = inside.replace("](../docs/", "](")
    return inside.replace(".ipynb)", ".md)")


def on_page_content(content: str, **_: object) -> str:
    """Convert what the Markdown extension marked as formulas, and leave generated lists of keys out of the search."""
    content = _KEYS.sub(lambda found: f"{found[0]} data-search-exclude", content)
    return _FORMULA.sub(_mathml, content)


def on_post_page(output: str, **_: object) -> str:
    """Name the search dialog for screen readers."""
    return output.replace(
        'data-md-component="search" role="dialog"', 'data-md-component="search" role="dialog" aria-label="Search"'
    )


def _palette() -> str:
    """Write the colours of the package as variables of the site's two colour schemes."""
    schemes = {"default": 0, "slate": 1}
    rules = {
        scheme: "".join(f"--{name}: {pair[k]}; " for name, pair in VARIABLES.items()) for scheme, k in schemes.items()
    }
    return "".join(f'[data-md-color-scheme="{scheme}"] {{ {rule}}}\n' for scheme, rule in rules.items())


def _mathml(found: re.Match[str]) -> str:
    inline, block = found.groups()
    return convert(html.unescape(inline or block), display="inline" if inline else "block")
