"""The duties of a kind of element, in the order in which a run needs them.

A kind is one module of `linkages.elements`, and one `Element`. It knows bodies as markers and closure terms, never the
system: see `Places` and `Checks` for what it may ask.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Generic, NoReturn, Protocol, TypeVar

import numpy as np

from linkages.base.arrays import Array
from linkages.input.files.toml import Table
from linkages.mechanics.planar.loads import ENERGY, POWER, SECOND, VALUE

__all__ = ["ENERGY", "POWER", "SECOND", "VALUE"]  # columns of `Element.tell`

K = TypeVar("K", bound=Table)

Marker = tuple[int, float, float]  #: body, and place in its frame [m]; a `MARKER`
Point = str | Sequence[float]  #: origin of a link or frame, by name; or a fixed point in plane axes [m]


class Places(Protocol):
    """Places on the bodies of a machine, for `Element.pack`."""

    def marker_of(self, point: Point) -> Marker:
        """Return the marker of a point."""

    def coordinate_of(self, joint: str | None, links: Iterable[str]) -> tuple[tuple[Any, ...], float]:
        """Return a `TERM` of a joint's coordinate, or of the second link's angle to the first, and its sign."""


class Checks(Protocol):
    """Checks of an element's keys against the machine, for `Element.check`; a refusal names file, key and reason."""

    def refuse(self, key: str, problem: str) -> NoReturn:
        """Refuse the value of a key, or the table."""

    def link_of(self, key: str, point: Point) -> str:
        """Return the link of a point, "world" for a fixed one; refuse an unknown one."""

    def known_link(self, key: str, name: str) -> str:
        """Return the name of a link or "world"; refuse an unknown one."""

    def moving(self, name: str) -> str:
        """Return the name of a joint; refuse an unknown or a fixed one."""

    def slides(self, joint: str) -> bool:
        """Tell whether a joint is prismatic."""

    def units(self, table: type[Table], slides: bool) -> None:
        """Refuse units that do not belong to a coordinate that is a displacement, or an angle."""


@dataclass(frozen=True)
class Between:
    """A picture: a dashed line between two points."""

    one: Point
    other: Point


@dataclass(frozen=True)
class Around:
    """A picture: a spiral at a joint or at a link's centre of mass; a zigzag along a prismatic joint."""

    joint: str | None
    link: str | None


Picture = Between | Around


@dataclass(frozen=True)
class Quantities:
    """The outputs of an element: the first one is characteristic, and its peak is in summaries."""

    label: str  #: of the kind, in the documentation
    texts: Mapping[str, str]  #: meaning and unit by name, in the order of the columns `VALUE`, `SECOND`

    @property
    def effort(self) -> str:
        """Return the name of the characteristic output."""
        return next(iter(self.texts))


@dataclass(frozen=True)
class Element(Generic[K]):
    """A kind of element of a machine.

    Attributes
    ----------
    table : str
        Its table in experiments.
    keys : type of Table
        The keys of one element.
    check : callable
        ``check(keys, checks)`` refuses what contradicts the machine.
    points : callable
        ``points(keys)`` are the points at which it acts on links.
    record : dtype
        The numbers of its kernels, made by ``record_type``.
    pack : callable
        ``pack(keys, places)`` returns the numbers of a record by field.
    act : kernel
        ``act(element, pose, vel, wrench)`` adds its forces to the bodies' wrenches.
    tell : kernel
        ``tell(element, pose, vel, row)`` fills its row: value, second value, the power that it delivers to the bodies
        [W], the energy that it stores [J].
    outputs : sequence of Quantities
        Its outputs; one for each sort of element.
    sort : callable
        ``sort(keys, slides)`` is the index of its outputs; ``slides(joint)`` tells whether a joint is prismatic.
    force : callable
        ``force(keys, slides, extent)`` is a force that sets the machine in motion [N], for the scale of time.
    problem_at_start : callable
        ``problem_at_start(keys, row, closest)`` names the error of an element at t = 0, with its row;
        points that are closer than ``closest`` [m] coincide. Empty without an error.
    picture : callable
        ``picture(keys)`` is its shape in drawings.
    """

    table: str
    keys: type[K]
    check: Callable[[K, Checks], None]
    points: Callable[[K], Iterable[Point]]
    record: np.dtype[Any]
    pack: Callable[[K, Places], Mapping[str, Any]]
    act: Callable[[np.record, Array, Array, Array], None]
    tell: Callable[[np.record, Array, Array, Array], None]
    outputs: tuple[Quantities, ...]
    picture: Callable[[K], Picture]
    force: Callable[[K, Callable[[str], bool], float], float]
    sort: Callable[[K, Callable[[str], bool]], int] = lambda keys, slides: 0
    problem_at_start: Callable[[K, Array, float], str] = lambda keys, row, closest: ""

    def outputs_of(self, keys: K, slides: Callable[[str], bool]) -> Quantities:
        """Return the outputs of an element."""
        return self.outputs[self.sort(keys, slides)]
