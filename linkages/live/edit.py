"""An experiment's file with changed values: the text is kept, each changed value has its origin as a comment."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import tomlkit
from tomlkit.items import Item

from linkages.errors import InputError
from linkages.files.toml import parse_value
from linkages.files.writing import errors_of_writing, whole
from linkages.model.experiment import Experiment


def edited(experiment: Experiment, values: Mapping[str, Any], target: Path) -> str:
    """Return the text of an experiment's file with other values; comments say that they are from the live page.

    Strings are read as TOML values. The mechanism's path is relative if it is in the folder of the target or below.

    Examples
    --------
    >>> import linkages
    >>> from linkages.live.edit import edited
    >>> experiment = linkages.load_experiment(linkages.find_file("seven_bar.toml"))
    >>> text = edited(experiment, {"joints.A.clearance": 2e-4}, experiment.source.with_name("thin.toml"))
    >>> [line for line in text.splitlines() if "live page" in line]
    ['clearance    = 0.0002 # live page; before: 0.3e-3']
    """
    document = tomlkit.parse(experiment.source.read_text(encoding="utf-8"))
    for path, given in values.items():
        _replace(document, path, parse_value(given) if isinstance(given, str) else given)
    machine, folder = experiment.mechanism_path.resolve(), target.resolve().parent
    named = str(machine.relative_to(folder) if machine.is_relative_to(folder) else machine)
    if named != document["mechanism"]:
        _replace(document, "mechanism", named)
    return tomlkit.dumps(document)


def save(experiment: Experiment, values: Mapping[str, Any], target: Path, replace: bool = False) -> Path:
    """Write an experiment's file with other values, whole or not at all; see `edited`.

    InputError if the file exists and is not to be replaced, or cannot be written.
    """
    if target.exists() and not replace:
        raise InputError("page", target.name, f"exists in {target.parent.resolve()}; choose another name")
    text = edited(experiment, values, target)
    with errors_of_writing(target.parent):
        target.parent.mkdir(parents=True, exist_ok=True)
    with whole(target) as partial:
        partial.write_text(text, encoding="utf-8")
    return target


def _replace(document: tomlkit.TOMLDocument, path: str, value: Any) -> None:
    """Set a value at a dotted path, with its origin and the value before as its comment."""
    *tables, key = path.split(".")
    here: Any = document
    for name in tables:
        if name not in here:
            here[name] = tomlkit.table()
        here = here[name]
    before = here.get(key)
    item: Item = tomlkit.item(value)
    was = "" if before is None or isinstance(before, dict) else f"; before: {tomlkit.item(before).as_string()}"
    item.comment(f"live page{was}" if len(was) < 60 else "live page")
    here[key] = item
