"""Analyses, and the models of elements that some of them cannot treat."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any


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


@dataclass(frozen=True)
class Unsupported:
    """A model of elements that some analyses cannot treat."""

    key: str  # that gives an element this model
    has: Callable[[Any, bool], bool]  # of its keys, and whether a drive turns steadily
    problems: Mapping[Analysis, str]  # what is wrong, and the remedy


#: Of elements with a ``sample_time``.
SAMPLED = Unsupported(
    "sample_time",
    lambda keys, turns: keys.sample_time is not None,
    {
        analysis: f"makes sampling instants, which {analysis} cannot follow; make it continuous"
        for analysis in (Analysis.DIAGRAM, Analysis.PERIODIC, Analysis.EXPONENT, Analysis.LINEAR)
    },
)
