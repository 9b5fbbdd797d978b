"""The elements of a system, by table and name."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from linkages.input.model.experiment import Experiment

#: Keys of the parts, by table and name.
NamedElements = Mapping[str, Mapping[str, Any]]


def parts_of(experiment: Experiment) -> NamedElements:
    """Return the named parts of an experiment, by table."""
    return experiment.elements
