"""The named parts of a system, by table and name: links, drives, and the elements of `linkages.elements`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from linkages.input.model.experiment import Experiment

#: Keys of the parts, by table and name.
NamedElements = Mapping[str, Mapping[str, Any]]


def parts_of(experiment: Experiment) -> NamedElements:
    """Return the named parts of an experiment, by table."""
    parts: NamedElements = {"links": experiment.links, "drives": experiment.drives}
    return {**parts, **experiment.elements}
