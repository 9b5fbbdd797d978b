"""The inputs of all results of a system, as a text."""

from __future__ import annotations

import hashlib
import json

from linkages.input.files.toml import leaves
from linkages.input.files.versions import versions
from linkages.system.system import System


def identity(system: System) -> str:
    """Return the experiment, the machine and the versions of the packages as one text, with digests of data files."""
    experiment = system.experiment
    keys = leaves(experiment.model_dump())
    names = sorted({text for path, text in keys if text and path.rpartition(".")[2] in ("mechanism", "file")})
    files = [hashlib.sha256((experiment.source.parent / name).read_bytes()).hexdigest() for name in names]
    return json.dumps([experiment.model_dump_json(), files, versions()], sort_keys=True)
