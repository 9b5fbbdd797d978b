"""The input of a system, for records of results and for comparison."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Collection
from typing import Any

from linkages.input.files.toml import leaves
from linkages.input.files.versions import versions
from linkages.system.system import System


def input_tables(system: System, without: Collection[str] = ()) -> dict[str, Any]:
    """Return the tables of the experiment as plain values, defaults included, without some of its keys."""
    return system.experiment.model_dump(exclude=set(without))


def input_record(system: System) -> dict[str, Any]:
    """Return what a result records of its input: given tables and file, folder of the file, sources of values."""
    experiment = system.experiment
    return {
        "experiment": experiment.model_dump(exclude_unset=True, exclude_none=True) | {"file": experiment.source.name},
        "folder": str(experiment.source.resolve().parent),
        "sources": experiment.sources,
    }


def identity(system: System) -> str:
    """Return the experiment, the machine and the versions of the packages as one text, with digests of data files."""
    experiment = system.experiment
    keys = leaves(experiment.model_dump())
    names = sorted({text for path, text in keys if text and path.rpartition(".")[2] in ("mechanism", "file")})
    files = [hashlib.sha256((experiment.source.parent / name).read_bytes()).hexdigest() for name in names]
    return json.dumps([experiment.model_dump_json(), files, versions()], sort_keys=True)
