"""Public classes document their fields, tables of files their keys."""

import ast
import inspect
import re
from importlib import import_module
from pathlib import Path

import pytest
from test_docs import PUBLIC, ROOT

import linkages
from linkages.input.files.table_keys import table_keys
from linkages.input.model.experiment import Experiment
from linkages.three_rrr.robot import Robot
from optim.problem.schema import StudyFile


def classes_of_the_source():
    """Class statements of both packages by name; of two with one name, the public one."""
    files = [path for package in ("linkages", "optim") for path in (ROOT / package).rglob("*.py")]
    files += [Path(inspect.getfile(linkages.Stepper))]
    statements = [node for path in files for node in ast.parse(path.read_text(encoding="utf-8")).body]
    return {node.name: node for node in statements if isinstance(node, ast.ClassDef)}


SOURCE = classes_of_the_source()


def named_in(text):
    return [name for name in re.findall(r"\w+", text) if name in SOURCE]


def with_bases(name):
    """Class statements of a class and of its bases."""
    bases = [base for one in SOURCE[name].bases for base in named_in(ast.unparse(one))]
    return [SOURCE[name], *(node for base in bases for node in with_bases(base))]


def fields_of(name):
    """Fields with their types, also those that ``__init__`` sets."""
    for node in with_bases(name):
        for line in node.body:
            if isinstance(line, ast.AnnAssign):
                yield line.target.id, ast.unparse(line.annotation)
            elif isinstance(line, ast.FunctionDef) and line.name == "__init__":
                parts = [part for part in ast.walk(line) if isinstance(part, ast.Attribute)]
                yield from ((part.attr, "") for part in parts if isinstance(part.ctx, ast.Store))


def public_classes():
    """Names of public classes, of classes that public functions return, and of classes of their fields; no tables."""
    waiting = []
    for package in PUBLIC:
        module = import_module(package)
        for name in getattr(module, "__all__", dir(module)):
            thing = getattr(module, name)
            if inspect.isclass(thing) and thing.__name__ in SOURCE:
                waiting.append(thing.__name__)
            elif inspect.isfunction(thing):
                waiting += named_in(str(thing.__annotations__.get("return", "")))
    found = set()
    while waiting:
        if (name := waiting.pop()) not in found and SOURCE["Table"] not in with_bases(name):
            found.add(name)
            waiting += [one for field, kind in fields_of(name) if field[0] != "_" for one in named_in(kind)]
    return found


def test_public_classes_document_their_fields():
    """In the lists of attributes and parameters."""
    missing = []
    for name in sorted(public_classes()):
        text = "\n".join(ast.get_docstring(node) or "" for node in with_bases(name))
        known = re.findall(r"\w+", " ".join(re.findall(r"^(\w+(?:, \w+)*)(?: : .*|\n    .*)", text, re.MULTILINE)))
        missing += [f"{name}.{field}" for field, _ in fields_of(name) if field[0] != "_" and field not in known]
    assert not missing


@pytest.mark.parametrize("table", [Experiment, StudyFile, Robot])
def test_tables_of_files_describe_their_keys(table):
    keys = dict(table_keys(table))
    assert len(keys) > 20
    assert not [key for key, meaning in keys.items() if not meaning]
