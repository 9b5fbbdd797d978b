"""What is done with a machine, and why an element cannot take part in it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from enum import StrEnum
from typing import Any, NamedTuple


class Analysis(StrEnum):
    """What is done with a system; the values are for messages."""

    DRAKE = "Drake"
    DIAGRAM = "a Drake diagram"
    DERIVATIVES = "derivatives"
    PERIODIC = "the return map"
    EXPONENT = "the Lyapunov exponent"
    WEAR = "wear over a service life"
    LINEAR = "the linear model"
    LIVE = "the live page"
    EQUILIBRIUM = 'start = "equilibrium"'


class Refusal(NamedTuple):
    """Analyses that cannot treat the elements with some keys."""

    key: str  # that is wrong
    applies: Callable[[Any], bool]  # whether an element's keys are such
    problems: Mapping[Analysis, str]  # what is wrong, and the remedy
    turning: bool = False  # whether only in machines that a drive turns steadily


#: Of elements with a ``sample_time``.
SAMPLED = Refusal(
    "sample_time",
    lambda keys: keys.sample_time is not None,
    {
        analysis: f"makes sampling instants, which {analysis} cannot follow; make it continuous"
        for analysis in (Analysis.DIAGRAM, Analysis.PERIODIC, Analysis.EXPONENT, Analysis.LINEAR)
    },
)
