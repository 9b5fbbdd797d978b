"""The tables of modules in package docstrings, and the order of imports they state."""

import ast
import re
import tomllib
from pathlib import Path

import pytest

from linkages.elements.machine import KINDS, OF_ELEMENTS

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = sorted(file.parent for name in ("linkages", "optim") for file in (ROOT / name).rglob("__init__.py"))
WITH_A_TABLE = [folder for folder in PACKAGES if len(list(folder.glob("*.py"))) > 2]
LAYERS = next(
    contract["layers"]
    for contract in tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]
    if contract["type"] == "layers"
)


def name_of(folder: Path) -> str:
    return ".".join(folder.relative_to(ROOT).parts)


def table_of(folder: Path) -> list[str]:
    """First cells of the table of modules or folders in a package's docstring."""
    text = ast.get_docstring(ast.parse((folder / "__init__.py").read_text(encoding="utf-8"))) or ""
    table = re.search(r"^\| (?:module|folder) .*\n\|-.*\n((?:\|.*(?:\n|$))+)", text, re.MULTILINE)
    return re.findall(r"^\| (\w+) ", table[1], re.MULTILINE) if table else []


def modules_of(folder: Path) -> set[str]:
    modules = {file.stem for file in folder.glob("*.py")} - {"__init__"}
    return modules | {file.parent.name for file in folder.glob("*/__init__.py")}


def imported(file: Path) -> set[str]:
    nodes = ast.walk(ast.parse(file.read_text(encoding="utf-8")))
    return {node.module or "" for node in nodes if isinstance(node, ast.ImportFrom)}


def attributes(file: Path) -> set[str]:
    nodes = ast.walk(ast.parse(file.read_text(encoding="utf-8")))
    return {node.attr for node in nodes if isinstance(node, ast.Attribute)}


@pytest.mark.parametrize("folder", WITH_A_TABLE, ids=name_of)
def test_table_lists_every_module_once(folder):
    assert sorted(table_of(folder)) == sorted(modules_of(folder))


def test_only_tables_of_experiments_name_a_kind_of_element():
    """All other modules loop over the kinds: a new kind is a module, and a field of `Experiment`."""
    kinds = {kind.keys.__module__ for kind in KINDS}
    files = [file for name in ("linkages", "optim") for file in (ROOT / name).rglob("*.py")]
    found = {file.relative_to(ROOT).as_posix() for file in files if imported(file) & kinds}
    assert {name for name in found if not name.startswith("linkages/elements/")} == {
        "linkages/input/model/experiment.py",
        "linkages/system/ideal_linkage.py",  # motions and torques of the tree's coordinates are functions of drives
    }


@pytest.mark.parametrize("package", ["linkages", "optim"])
def test_table_of_folders_is_in_the_order_of_the_import_contract(package):
    layers = [[name.partition(".")[2] for name in layer.split(" | ")] for layer in reversed(LAYERS)
              if layer.startswith(f"{package}.")]  # fmt: skip
    height = {name.partition(".")[0]: level for level, names in enumerate(layers) for name in names}  # the highest part
    levels = [height[name] for name in table_of(ROOT / package)]
    assert levels == sorted(levels)


def test_every_module_is_in_a_layer():
    layers = {".".join(name.split(".")[:2]) for layer in LAYERS for name in layer.split(" | ")}
    assert layers == {f"{package}.{name}" for package in ("linkages", "optim") for name in modules_of(ROOT / package)}


#: Modules above `linkages.system` that read its mechanism or experiment, and why; all others ask the system.
READERS = {
    "linkages/cli/options.py": "replaces the models of the joints that the file names",
    "linkages/cli/simulate.py": "asks about implausible values of the input",
    "linkages/cli/sweep.py": "colours of public figures, which take a mechanism",
    "linkages/engines/compiled/batch/lengths.py": "rounding of the coordinates in the file",
    "linkages/engines/drake/diagram.py": "gravity in space",
    "linkages/explore/transmission.py": "dyads of a mechanism",
    "linkages/show/live/answers.py": "saves the input with other values",
    "linkages/show/live/controls.py": "lists the numbers and choices of the input",
    "linkages/show/live/edits.py": "edits the input",
    "linkages/show/live/exploring.py": "varies the input",
    "linkages/show/live/pins.py": "varies the lengths of the file",
    "linkages/show/live/view.py": "pins, also where a frame has the name of a joint",
    "linkages/show/plots/drawing/drawing.py": "draws mechanisms that cannot be assembled",
    "optim/identify/load.py": "digest of the input",
    "optim/identify/writing.py": "writes the input with other values",
}


def reads_input(file: Path) -> bool:
    """Whether a module reads ``.experiment`` or ``.mechanism`` of a system or tree: of a name or attribute that is one."""
    systems = {"system", "_system", "tree", "ideal", "asked", "changed", "shown", "whole", "found", "pose"}
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Attribute) and node.attr in ("experiment", "mechanism"):
            owner = node.value.attr if isinstance(node.value, ast.Attribute) else getattr(node.value, "id", "")
            if owner in systems:
                return True
    return False


def test_rooms_above_the_system_ask_it_and_not_its_input():
    above = LAYERS[: LAYERS.index("linkages.system")]
    names = [name for layer in above for name in layer.split(" | ")]
    places = [ROOT.joinpath(*name.split(".")) for name in names]
    files = [
        file for place in places for file in (place.rglob("*.py") if place.is_dir() else [place.with_suffix(".py")])
    ]
    assert {file.relative_to(ROOT).as_posix() for file in files if reads_input(file)} == set(READERS)


#: Modules that ask for drives: they move coordinates of the tree, from the start on.
MOVERS = {
    "linkages/input/model/capabilities.py",
    "linkages/input/model/check.py",
    "linkages/input/model/plausibility.py",
    "linkages/show/plots/drawing/drawing.py",
    "linkages/show/plots/drawing/facts.py",
    "linkages/system/assembly.py",
    "linkages/system/facts.py",
    "linkages/system/flexible_link.py",
    "linkages/system/joints.py",
    "linkages/system/ideal_linkage.py",
}


@pytest.mark.parametrize("table", OF_ELEMENTS)
def test_no_room_asks_an_experiment_for_a_kind_of_element_by_name(table):
    """They loop over the kinds, so that a new kind needs no edit there."""
    files = [file for name in ("linkages", "optim") for file in (ROOT / name).rglob("*.py")]
    asked = re.compile(
        rf"\bexperiment\.{table}\b|getattr\((?:\w+\.)*experiment, \"{table}\"|\b(?:parts|elements)\[\"{table}\"\]"
    )
    found = {file.relative_to(ROOT).as_posix() for file in files if asked.search(file.read_text(encoding="utf-8"))}
    assert found == (MOVERS if table == "drives" else set())


def test_rooms_above_the_system_ask_for_shapes_and_not_whether_a_link_is_flexible():
    """A link may become deformable by another model than a beam: they ask the tree, or the duties of kinds."""
    above = LAYERS[: LAYERS.index("linkages.system")]
    places = [ROOT.joinpath(*name.split(".")) for layer in above for name in layer.split(" | ")]
    files = [
        file for place in places for file in (place.rglob("*.py") if place.is_dir() else [place.with_suffix(".py")])
    ]
    assert not [name_of(file) for file in files if attributes(file) & {"flexible", "bends", "has_beam"}]
