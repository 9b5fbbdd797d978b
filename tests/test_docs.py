"""Generated pages are fresh, references complete, links alive."""

import importlib.util
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"


def generator(name):
    spec = importlib.util.spec_from_file_location(name, DOCS / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_list_of_experiment_keys_is_fresh():
    assert (DOCS / "experiment.md").read_text(encoding="utf-8") == generator("make_experiment").markdown()


def test_the_list_of_study_keys_is_fresh():
    text = (DOCS / "optimisation.md").read_text(encoding="utf-8")
    assert generator("make_optimisation").page(text) == text
    assert "| `constraints.NAME.at_least` | lower limit |" in text


def test_what_the_laws_cite_is_among_the_references():
    """A source that names its year has the entry ``surnameYEAR`` of its first author."""
    entries = set(re.findall(r"@\w+\{(\w+),", (DOCS / "references.bib").read_text(encoding="utf-8")))
    sources = re.findall(r"\| ([^|]+) \|$", (DOCS / "laws.md").read_text(encoding="utf-8"), re.MULTILINE)
    for path in (ROOT / "linkages" / "laws").glob("*.py"):
        sources += re.findall(r"[Ss]ource: (.+)", path.read_text(encoding="utf-8"))
    parts = [part.strip() for source in sources for part in source.split(";")]
    cited = {
        found[1].lower() + found[2]
        for part in parts
        if (found := re.match(r"(?:passivity: )?([A-Z][a-zA-Z]+)\b.*?\b((?:18|19|20)\d\d)\b", part))
    }
    assert len(cited) > 15
    assert cited <= entries


@pytest.mark.parametrize(
    "page", [ROOT / "README.md", ROOT / "sdf" / "README.md", *DOCS.glob("*.md")], ids=lambda path: path.name
)
def test_links_between_pages_lead_somewhere(page):
    """As they stand in the repository, without the site."""
    text = page.read_text(encoding="utf-8")
    for target in re.findall(r"\]\(([^)#\s]+)", text):
        assert target.startswith("https://") or (page.parent / target).exists(), target
