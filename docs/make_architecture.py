"""Writes the house in docs/architecture.md from the import contracts: ``python docs/make_architecture.py``."""

import ast
import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "architecture.md"
START, END = "<!-- house: docs/make_architecture.py -->\n", "<!-- house end -->\n"


def page(text: str) -> str:
    """Return the page with the folders as the contracts and their docstrings have them."""
    before, after = text.partition(START)[0], text.partition(END)[2]
    return "".join([before, START, "\n", house(), "\n", END, after])


def house() -> str:
    """Return the layers from top to bottom as a table, and the other contracts as a list."""
    setup = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    contracts = setup["tool"]["importlinter"]["contracts"]
    (layers,) = (contract["layers"] for contract in contracts if contract["type"] == "layers")
    names = [name for layer in layers for name in layer.split(" | ")]
    rows = [f"| `{name.replace('.', '/')}` | {first_sentence(name)} |\n" for name in names]
    others = [f"- {contract['name']}.\n" for contract in contracts if contract["type"] != "layers"]
    return "".join(["| folder | what lives there |\n|---|---|\n", *rows, "\n", *others])


def first_sentence(name: str) -> str:
    """Return the first sentence of the docstring of a folder or module."""
    path = ROOT / name.replace(".", "/")
    file = path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
    text = ast.get_docstring(ast.parse(file.read_text(encoding="utf-8"))) or ""
    found = re.match(r".+?\.(?=\s|$)", text, re.DOTALL)
    if found is None:
        raise ValueError(f"{file} does not begin with a sentence that says what lives there")
    return " ".join(found[0].split()).replace("``", "`").replace("|", "\\|")


if __name__ == "__main__":
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
