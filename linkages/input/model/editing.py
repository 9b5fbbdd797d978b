"""Texts of experiments with other values."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import tomlkit
from tomlkit.items import Array, Item

from linkages.input.files.toml import parse_value
from linkages.input.model.experiment import Experiment


def edited(experiment: Experiment, values: Mapping[str, Any], target: Path, origin: str | Mapping[str, str]) -> str:
    """Return the text of an experiment's file with other values; comments state their origin, and the values before.

    The origin is one for all values, or by path. Strings are read as TOML values. The paths of the mechanism and of
    data files are relative if these have a folder in common with the target.
    """
    document = tomlkit.parse(experiment.source.read_text(encoding="utf-8"))
    for path, given in values.items():
        source = origin if isinstance(origin, str) else origin.get(path, "")
        _replace(document, path, parse_value(given) if isinstance(given, str) else given, source)
    _link(document, "mechanism", experiment.mechanism_path, target)
    for path in [*experiment.from_files, *(["data"] if "data" in document else [])]:
        named = _at(document, path)["file"]
        _link(document, f"{path}.file", experiment.source.parent / str(named), target)
    return tomlkit.dumps(document)


def _link(document: tomlkit.TOMLDocument, path: str, file: Path, target: Path) -> None:
    """Set the path of a file as the target sees it."""
    file, folder = file.resolve(), target.resolve().parent
    apart = os.path.commonpath([file, folder]) == file.anchor
    named = str(file) if apart else Path(os.path.relpath(file, folder)).as_posix()
    owner, _, key = path.rpartition(".")
    if named != _at(document, owner)[key]:
        _replace(document, path, named, "")


def _at(document: tomlkit.TOMLDocument, path: str) -> Any:
    """Return the table at a dotted path; the document if it is empty."""
    here: Any = document
    for name in path.split(".") if path else ():
        here = here[name]
    return here


def _replace(document: tomlkit.TOMLDocument, path: str, value: Any, origin: str) -> None:
    """Set a value at a dotted path, with its origin and the value before as its comment."""
    *tables, key = path.split(".")
    here: Any = document
    for name in tables:
        if name not in here:
            here[name] = tomlkit.table()
        here = here[name]
    if isinstance(here, Array):
        here[int(key)] = value
        here.comment(origin)
        return
    before = here.get(key)
    item: Item = tomlkit.item(value)
    was = "" if before is None or isinstance(before, dict) else f"; before: {tomlkit.item(before).as_string()}"
    comment = f"{origin}{was}" if len(was) < 60 else origin
    if comment:
        item.comment(comment.removeprefix("; "))
    here[key] = item
