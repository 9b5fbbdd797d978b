"""Generated pages are fresh, references complete, links alive; code of pages and docstrings runs."""

import ast
import doctest
import inspect
import json
import pkgutil
import re
import tomllib
from importlib import import_module
from pathlib import Path
from unittest.mock import patch

import numpy as np
import pytest
from drake_missing import ExampleRunner
from test_words import replaced_words

import linkages
from linkages import laws
from linkages.cli import commands

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"
PAGES = [ROOT / "README.md", ROOT / "SKILL.md", ROOT / "sdf" / "README.md", *sorted(DOCS.glob("*.md"))]
#: What scripts, notebooks and pages import from.
PUBLIC = (
    "linkages",
    "linkages.engines.drake",
    "linkages.laws",
    "linkages.laws.film.surface",
    "linkages.plots",
    "linkages.plots.three_rrr",
    "linkages.three_rrr",
    "optim",
)


def test_the_list_of_experiment_keys_is_fresh():
    assert (DOCS / "experiment.md").read_text(encoding="utf-8") == import_module("make_experiment").markdown()


@pytest.mark.parametrize("name", ["study_files.md", "identification_keys.md"])
def test_the_lists_of_study_keys_are_fresh(name):
    text = (DOCS / name).read_text(encoding="utf-8")
    assert import_module("make_optimisation").page(text, name) == text
    known = {
        "study_files.md": "- `constraints.NAME.at_least`: lower limit\n",
        "identification_keys.md": "- `fit.starts`: number",
    }
    assert known[name] in text


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.name)
def test_pages_use_the_terms_of_the_glossary(page):
    """Not the words that a term replaced."""
    words = replaced_words()
    assert len(words) >= 10
    text = re.sub(r"```.*?```|`[^`]*`", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    text = " ".join(text.split())
    assert not [word for word in words if re.search(rf"\b{re.escape(word)}\b", text, re.IGNORECASE)]


def test_every_page_is_three_links_from_the_start():
    """Links of the texts alone, without the navigation."""
    distances, pages = {"index.md": 0}, ["index.md"]
    for page in pages:
        for target in re.findall(r"\]\((\w+\.md)", (DOCS / page).read_text(encoding="utf-8")):
            if target not in distances:
                distances[target] = distances[page] + 1
                pages.append(target)
    assert set(distances) == {path.name for path in DOCS.glob("*.md")}
    assert max(distances.values()) <= 3


@pytest.mark.parametrize("page", sorted(DOCS.glob("*.md")), ids=lambda path: path.name)
def test_every_page_names_its_reader(page):
    """The text before the first section says for whom the page is."""
    opening = page.read_text(encoding="utf-8").split("\n## ")[0]
    reader = r"\bfor (\w+ ){0,3}?(users|readers|engineers|developers|reader)\b"
    assert re.search(reader, opening, re.IGNORECASE)


def test_the_list_of_misprints_is_fresh():
    assert (DOCS / "misprints.md").read_text(encoding="utf-8") == import_module("make_misprints").page()


def test_what_the_laws_cite_is_among_the_references():
    """A source that names its year has the entry ``surnameYEAR`` of its first author."""
    entries = set(re.findall(r"@\w+\{(\w+),", (DOCS / "references.bib").read_text(encoding="utf-8")))
    sources = re.findall(r"\| ([^|]+) \|$", (DOCS / "laws.md").read_text(encoding="utf-8"), re.MULTILINE)
    for path in (ROOT / "linkages" / "laws").rglob("*.py"):
        sources += re.findall(r"[Ss]ource: (.+)", path.read_text(encoding="utf-8"))
    parts = [part.strip() for source in sources for part in source.split(";")]
    cited = {
        found[1].lower() + found[2]
        for part in parts
        if (found := re.match(r"(?:passivity: )?([A-Z][a-zA-Z]+)\b.*?\b((?:18|19|20)\d\d)\b", part))
    }
    assert len(cited) > 15
    assert cited <= entries


def test_the_reason_for_each_dependency_is_given():
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8").partition("## Dependencies")[2]
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    project = declared["project"]
    groups = (declared["build-system"]["requires"], project["dependencies"], *project["optional-dependencies"].values())
    for name in {re.match(r"[\w-]+", one)[0] for group in groups for one in group}:
        assert re.search(rf"^\|[^|]*\b{name}\b[^|]*\|", text, re.MULTILINE), name


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.name)
def test_links_between_pages_lead_somewhere(page):
    """Links in the repository's files, without the site."""
    text = page.read_text(encoding="utf-8")
    for target in re.findall(r"\]\(([^)#\s]+)", text):
        assert target.startswith("https://") or (page.parent / target).exists(), target


def anchors(page):
    """Names of the places in a page: its headings as the site and GitHub write them, and explicit ones."""
    text = re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
    headings = [re.sub(r"[^\w\s-]", "", title).strip().lower() for title in re.findall(r"^#+ (.*)", text, re.MULTILINE)]
    return {re.sub(r"[-\s]+", "-", title) for title in headings} | set(re.findall(r'id="([\w-]+)"', text))


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.name)
def test_links_to_a_place_in_a_page_find_it(page):
    for target, place in re.findall(r"\]\(((?:[\w./]+\.md)?)#([\w-]+)\)", page.read_text(encoding="utf-8")):
        assert place in anchors((page.parent / target) if target else page), f"{target}#{place}"


def test_the_list_of_outputs_is_fresh():
    text = (DOCS / "outputs.md").read_text(encoding="utf-8")
    assert import_module("make_outputs").page(text) == text
    assert "- `DRIVE.power`, `DRIVE (backlash).power`: power delivered by the drive [W]\n" in text


def test_the_house_is_drawn_as_the_contracts_have_it():
    text = (DOCS / "architecture.md").read_text(encoding="utf-8")
    assert import_module("make_architecture").page(text) == text
    assert text.index("| `optim/cli` |") < text.index("| `linkages/system` |") < text.index("| `linkages/laws` |")


def test_the_ports_in_the_docs_are_those_of_the_code():
    text = (DOCS / "drake_engine.md").read_text(encoding="utf-8")
    assert import_module("make_drake").page(text) == text


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.name)
def test_what_pages_name_is_there(page):
    """Modules and public names in code font, files of the repository, tests that prove a statement."""
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    tests = "\n".join(path.read_text(encoding="utf-8") for path in (ROOT / "tests").rglob("*.py"))
    names = re.findall(r"`((?:linkages|optim)(?:\.\w+)+)[`(]", text)
    for name in set(names) - {"linkages.commands"}:  # a group of entry points
        pkgutil.resolve_name(name)
    for name in re.findall(r"`((?:tests|docs|linkages|optim|benchmarks|sdf)/[\w/]+\.\w+)`", text):
        assert (ROOT / name).exists(), name
    for name in re.findall(r"`(test_\w+)`", text):
        assert f"def {name}(" in tests, name


@pytest.mark.parametrize("page", [path for path in PAGES if path.name != "extend.md"], ids=lambda path: path.name)
def test_code_of_pages_uses_public_names_that_exist(page):
    """The page of laws has a separate test: half of its blocks are parts of modules."""
    blocks = re.findall(r"^```python\n(.*?)^```", page.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)
    tree = ast.parse("\n".join(blocks))
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and (node.module or "").partition(".")[0] in ("linkages", "optim"):
            assert node.module in PUBLIC, node.module
            for alias in node.names:
                pkgutil.resolve_name(f"{node.module}:{alias.name}")
        package = node.value if isinstance(node, ast.Attribute) else None
        if isinstance(package, ast.Name) and package.id in ("linkages", "optim"):
            assert node.attr in pkgutil.resolve_name(package.id).__all__, node.attr


@pytest.mark.parametrize(
    "name", ["README.md", "docs/drake.md", "docs/batches.md", "docs/index.md", "docs/nonlinear.md"]
)
def test_code_of_pages_runs(name):
    """With short runs."""
    text = (ROOT / name).read_text(encoding="utf-8")
    for long, short in {
        "revolutions=3000, transient=50": "revolutions=2",
        "revolutions=150, transient=30, renormalisations=40": "revolutions=2",
        "advance(simulator, 1.0)": "advance(simulator, 0.002)",
        "advance(simulator, 0.1)": "advance(simulator, 0.002)",
        "windows=[[1.0, 2.0]]": "windows=[[0.0, 0.1]]",
        '{"joints.A.clearance": 2e-4}': '{"joints.A.clearance": 2e-4, "duration": 0.1}',
        '"seven_bar.toml"))': '"seven_bar.toml"), {"duration": 0.1})',
    }.items():
        text = text.replace(long, short)
    blocks = re.findall(r"^```python\n(.*?)^```", text, re.DOTALL | re.MULTILINE)
    names = {"__name__": "__main__"}
    for block in blocks:
        exec(compile(block, name, "exec"), names)
    if name == "docs/batches.md":
        for statistic in ["peak", *re.search(r"; likewise (.*)", text)[1].split(", ")]:
            assert getattr(names["batch"], statistic).shape == (2, 1, 2)
    elif name == "docs/nonlinear.md":
        np.testing.assert_allclose(names["touching"]["B.penetration"], 0.0, atol=1e-9)


@pytest.mark.parametrize("model", ["lubricated", "dry", "mixed"])
def test_the_tables_of_a_clearance_joint_are_complete(model):
    """As they stand on the page, without further keys."""
    blocks = re.findall(
        r"^```toml\n(.*?)^```", (DOCS / "clearance.md").read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE
    )
    (table,) = (joint for block in blocks if (joint := tomllib.loads(block)["joints"]["B"])["model"] == model)
    system = linkages.load(linkages.find_file("slider_crank_dry.toml"), {"joints.B": table, "duration": 1e-3})
    assert linkages.simulate(system).status.value == "ok"


def public_functions():
    """Public objects by name: functions of the packages, methods of a system."""
    found = {"linkages.system.system:System.replaced", "linkages.system.system:System.value"}
    for package in ("linkages", "linkages.laws", "optim"):
        for name in pkgutil.resolve_name(package).__all__:
            thing = getattr(pkgutil.resolve_name(package), name)
            if inspect.isfunction(thing):
                found.add(f"{thing.__module__}:{name}")
    return sorted(found)


@pytest.fixture
def no_laws_stay(monkeypatch):
    """Remove registrations of an example after it."""
    monkeypatch.setattr("linkages.laws.user_laws._registered", {})
    with patch.dict(laws.CONTACTS), patch.dict(laws.FILMS), patch.dict(laws.FRICTIONS):
        yield


@pytest.mark.parametrize("name", public_functions())
def test_example_of_a_public_function_is_right(name, no_laws_stay):
    """As a user's script runs it."""
    function = pkgutil.resolve_name(name)
    examples = doctest.DocTestFinder().find(function, name, globs={"__name__": "__main__"})
    runner = ExampleRunner()
    assert sum(len(example.examples) for example in examples) > 0, "no example"
    for example in examples:
        runner.run(example)
    assert runner.summarize(verbose=False).failed == 0


@pytest.mark.slow
def test_examples_of_all_other_docstrings_are_right(no_laws_stay):
    """Also of functions that only this package calls; without the Drake engine, whose import takes seconds."""
    public = {name.replace(":", ".") for name in public_functions()}
    modules = [
        import_module(found.name)
        for package in ("linkages", "optim")
        for found in pkgutil.walk_packages(pkgutil.resolve_name(package).__path__, f"{package}.")
        if ".drake" not in found.name
    ]
    examples = [one for module in modules for one in doctest.DocTestFinder().find(module) if one.examples]
    others = [one for one in examples if one.name not in public]
    runner = ExampleRunner()
    for example in others:
        runner.run(example)
    assert len(others) > 20
    assert runner.summarize(verbose=False).failed == 0


def test_the_gallery_has_every_command_and_is_fresh():
    """A picture, or a row for a command that draws nothing."""
    gallery = import_module("make_gallery")
    text = gallery.PAGE.read_text(encoding="utf-8")
    assert {name for name in commands() if f"linkages {name}" not in text} == set()
    told = json.loads((DOCS / "figures" / "gallery.json").read_text(encoding="utf-8"))
    assert all(gallery.written(name, tile, told[name]) in text for name, tile in gallery.TILES.items())


def test_a_page_is_short_in_the_median():
    """Words without the rows of tables, but with code: a page answers one question."""
    words = [
        sum(len(line.split()) for line in page.read_text(encoding="utf-8").splitlines() if line[:1] != "|")
        for page in DOCS.glob("*.md")
    ]
    assert np.median(words) <= 400
