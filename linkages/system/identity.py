"""The identity of a system: what its results depend on, as a text."""

from __future__ import annotations

import json

from linkages.input.files.versions import versions
from linkages.system.system import System


def identity(system: System) -> str:
    """Return the experiment, the text of the machine's file and the versions of the packages as one text."""
    experiment = system.experiment
    made_of = [experiment.model_dump_json(), experiment.mechanism_path.read_text(encoding="utf-8"), versions()]
    return json.dumps(made_of, sort_keys=True)
