"""The tables of modules in package docstrings, and the order of imports they state."""

import ast
import re
import tomllib
from pathlib import Path

import pytest

from linkages.elements.machine import OF_ELEMENTS

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


@pytest.mark.parametrize("folder", WITH_A_TABLE, ids=name_of)
def test_table_lists_every_module_once(folder):
    assert sorted(table_of(folder)) == sorted(modules_of(folder))


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


@pytest.mark.parametrize("table", OF_ELEMENTS)
def test_no_room_asks_an_experiment_for_a_kind_of_element_by_name(table):
    """They loop over the kinds, so that a new kind needs no edit there."""
    files = [file for name in ("linkages", "optim") for file in (ROOT / name).rglob("*.py")]
    asked = re.compile(rf"\bexperiment\.{table}\b|getattr\((?:\w+\.)*experiment, \"{table}\"")
    assert not [name_of(file) for file in files if asked.search(file.read_text(encoding="utf-8"))]
