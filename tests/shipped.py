"""The experiments that come with the package, and runs of them that several tests look at."""

from __future__ import annotations

from functools import cache

import linkages
from linkages.files.shipped import data_folder

#: Experiments with a linkage; the flexible robot has a command of its own.
NAMES = sorted(path.stem for path in data_folder().glob("*.toml") if not path.name.startswith("three_rrr"))


def shipped(name: str, **overrides) -> linkages.System:
    """Load a shipped experiment, with values replaced by dotted path."""
    return linkages.load(data_folder() / f"{name}.toml", overrides)


@cache
def run(engine: str, name: str, **overrides) -> linkages.Trajectory:
    """Run a shipped experiment; whoever asks for the same run gets the same trajectory."""
    return linkages.simulate(shipped(name, **overrides), engine)
