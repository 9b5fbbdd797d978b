"""Outputs of elements: names, meanings, units, and where their values come from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum


class Source(Enum):
    """The numbers of a run that the outputs of an element are."""

    TOLD = "its row: value, second value, and the power that it delivers to the linkage"
    REACTION = "the effort of its closure row on the second joint, and the power that it transmits"
    BETWEEN = "the sum of its two contacts: effort on the second joint, transmitted power, place between them"
    EFFORT = "torque or force of the drive on its joint, rate of the joint, power"
    EFFORT_OF_WHEEL = "the same of a drive that turns a gearbox' output wheel"
    ALONG = "extremes along each deformable link: deflection, moment, stress, compressive force, and places of two"
    FRAME = "the deflection of each frame on a deformable link"
    CONTACT = "each of its contacts, with the outputs of `linkages.mechanics.planar.contacts`"


@dataclass(frozen=True)
class Quantities:
    """Outputs of an element: the first one is characteristic, and its peak is in summaries."""

    label: str  #: of the kind, in the documentation
    texts: Mapping[str, str]  #: meaning and unit by name; in the order of the source's numbers, except of a contact
    source: Source = Source.TOLD
    columns: Mapping[str, str] = field(default_factory=dict)  #: of a contact: its output by name, if it has another one
    peaks: tuple[str, ...] = ()  #: of a model of a joint or link: the outputs whose peaks are in summaries
    size: Mapping[str, str] = field(default_factory=dict)  #: meaning of the magnitude of both values, if it has one

    @property
    def effort(self) -> str:
        """Return the name of the characteristic output: the magnitude or the first one."""
        return next(iter(self.size or self.texts))

    @property
    def real(self) -> bool:
        """Whether a linkage with ideal joints lacks them."""
        return self.source in (Source.BETWEEN, Source.CONTACT)
