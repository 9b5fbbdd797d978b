"""The duties of a kind of element, in the order in which a run needs them.

A kind is one module of `linkages.elements`, and one `Element`. It knows bodies as markers and closure terms, never the
system: see `Places` and `Checks` for what it may ask.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, Generic, NamedTuple, NoReturn, Protocol, TypeVar

import numpy as np

from linkages.base.arrays import Array
from linkages.elements.analysis import Refusal
from linkages.input.files.toml import Table
from linkages.input.functions.definitions import Function, Quantity
from linkages.input.functions.smoothing import SmoothSignal
from linkages.mechanics.planar.functions import Given
from linkages.mechanics.planar.loads import ENERGY, POWER, SECOND, VALUE

__all__ = ["ENERGY", "POWER", "SECOND", "VALUE"]  # columns of `Element.tell`

Marker = tuple[int, float, float]  #: body, and place in its frame [m]; a `MARKER`
Point = str | Sequence[float]  #: origin of a link or frame, by name; or a fixed point in plane axes [m]


class Places(Protocol):
    """Places on the bodies of a machine, for `Element.pack`."""

    def marker_of(self, point: Point) -> Marker:
        """Return the marker of a point."""

    def angle_of(self, point: str) -> float:
        """Return the angle of a frame in its body, at its origin [rad]."""

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

    def moved_link(self, key: str, name: str) -> str:
        """Return the name of a link; refuse an unknown one, and the world."""

    def revolute(self, key: str, name: str) -> str:
        """Return the name of a revolute joint; refuse others."""

    def slides(self, joint: str) -> bool:
        """Tell whether a joint is prismatic."""

    def units(self, table: type[Table], slides: bool) -> None:
        """Refuse units that do not belong to a coordinate that is a displacement, or an angle."""

    def unit(self, key: str, unit: str) -> None:
        """Refuse a value with a unit of another kind than this SI unit."""

    def covers(self, times: list[float] | None, fits: Iterable[SmoothSignal]) -> None:
        """Refuse a table over time, and signals of files, that end before the run."""

    def signal(self, key: str, name: str, text: str) -> str:
        """Return the unit of an input of a function, whose text is given; refuse an unknown one."""

    def over_time(self, key: str, text: str | None) -> None:
        """Refuse a formula with other names than the time and values."""

    def name_for_formulas(self) -> None:
        """Refuse the element's name if formulas cannot have it."""

    def is_free(self, joint: str) -> bool:
        """Tell whether a joint is ideal and has no prescribed motion."""

    def has_gearbox(self, joint: str) -> bool:
        """Tell whether the drive of a joint has backlash."""

    def ends_of(self, joint: str) -> tuple[str, str]:
        """Return the parent and child of a joint."""

    def has_beam(self, link: str) -> bool:
        """Tell whether a link has a beam."""


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


@dataclass(frozen=True)
class Arrow:
    """A picture: an arrow to a point, along the largest value of the element's first two quantities."""

    point: str
    turns: bool  #: whether the values are in axes of the point, which rotate with the link
    values: ClassVar[int] = 2


@dataclass(frozen=True)
class Turning:
    """A picture: an arrow around a joint, or a link's centre of mass, in the sense of the element's largest value."""

    joint: str | None
    link: str | None
    values: ClassVar[int] = 1


Picture = Between | Around | Arrow | Turning


@dataclass(frozen=True)
class Quantities:
    """The outputs of an element: the first one is characteristic, and its peak is in summaries."""

    label: str  #: of the kind, in the documentation
    texts: Mapping[str, str]  #: meaning and unit by name, in the order of the columns `VALUE`, `SECOND`
    size: Mapping[str, str] = field(default_factory=dict)  #: the same of the magnitude of both values, if it has one

    @property
    def effort(self) -> str:
        """Return the name of the characteristic output: the magnitude or the first value."""
        return next(iter(self.size or self.texts))


class Rotor(NamedTuple):
    """A moment of inertia that turns with a joint of the world [kg m2]."""

    joint: str
    inertia: float


class IdealEffort(NamedTuple):
    """Torque or force that moves the machine with ideal joints along a reference: a quantity over time."""

    quantity: str  # name of the quantity
    key: str  # of the element that asks for it
    joint: str  # whose coordinate the reference gives
    reference: str  # formula of the time


@dataclass(frozen=True)
class Applied:
    """Constants that act on the machine from outside: inputs of steps and of linear models.

    Attributes
    ----------
    key : str
        Key of the constants.
    field : str
        Field of the record with the index of the first function.
    units : mapping
        Units by the names of the functions' values.
    """

    key: str
    field: str
    units: Mapping[str, str]


K = TypeVar("K", bound=Table)

#: Kernels of a kind, without and with functions.
Acting = Callable[[np.record, Array, Array, Array], None] | Callable[[np.record, Given, Array, Array, Array], None]


@dataclass(frozen=True, kw_only=True)
class Element(Generic[K]):
    """A kind of element of a machine: it acts on bodies, defines quantities for formulas, or both.

    Attributes
    ----------
    table : str
        Its table in experiments.
    keys : type of Table
        The keys of one element.
    check : callable
        ``check(keys, checks)`` refuses what contradicts the machine.
    quantities : callable, optional
        ``quantities(keys, name)`` returns the quantities that it defines for formulas, by name: states, and formulas.
    own : mapping
        Meaning and unit of those that are outputs, by the last part of their names; ``value``: the one that has the
        element's own name.
    unit : callable, optional
        ``unit(keys)`` is the unit of these outputs, if the keys say it.
    ideal_efforts : callable
        ``ideal_efforts(keys, name)`` are the quantities that are computed from the ideal machine.
    unsupported : sequence of Refusal
        Analyses that cannot treat it.
    points : callable
        ``points(keys)`` are the points at which it acts on links.
    from_reference : callable
        ``from_reference(keys)`` tells whether it counts a coordinate or a direction from the reference configuration.
    rotor : callable
        ``rotor(keys)`` is the inertia that it adds to a joint.
    record : dtype, optional
        The numbers of its kernels, made by ``record_type``; None if it does not act on bodies.
    pack : callable
        ``pack(keys, places)`` returns the numbers of a record by field.
    functions : callable, optional
        ``functions(keys, name)`` returns the functions that its record refers to: components by the field that has the
        index of the first one. A kernel reads them by `linkages.mechanics.planar.functions.value_of`.
    act : kernel
        ``act(element, pose, vel, wrench)`` adds its forces to the bodies' wrenches. With functions it is
        ``act(element, given, pose, vel, wrench)``, where ``given`` has their inputs.
    tell : kernel
        ``tell(element, pose, vel, row)``, with functions ``tell(element, given, pose, vel, row)``, fills its row:
        value, second value, the power that it delivers to the bodies [W], the energy that it stores [J].
    outputs : sequence of Quantities
        Its outputs; one for each sort of element.
    sort : callable
        ``sort(keys, slides)`` is the index of its outputs; ``slides(joint)`` tells whether a joint is prismatic.
    force : callable
        ``force(keys, slides, extent)`` is a force that sets the machine in motion [N], for the scale of time.
    problem_at_start : callable
        ``problem_at_start(keys, row, closest)`` names the error of an element at t = 0, with its row;
        points that are closer than ``closest`` [m] coincide. Empty without an error.
    applied : Applied, optional
        Its constants that a step or a linear model changes.
    picture : callable
        ``picture(keys)`` is its shape in drawings, if it has one.
    """

    table: str
    keys: type[K]
    check: Callable[[K, Checks], None]
    quantities: Callable[[K, str], Mapping[str, Quantity]] | None = None
    own: Mapping[str, str] = field(default_factory=dict)
    unit: Callable[[K], str] | None = None
    ideal_efforts: Callable[[K, str], Iterable[IdealEffort]] = lambda keys, name: ()
    unsupported: tuple[Refusal, ...] = ()
    points: Callable[[K], Iterable[Point]] = lambda keys: ()
    from_reference: Callable[[K], bool] = lambda keys: False
    rotor: Callable[[K], Rotor | None] = lambda keys: None
    record: np.dtype[Any] | None = None
    pack: Callable[[K, Places], Mapping[str, Any]] = lambda keys, places: {}
    functions: Callable[[K, str], Mapping[str, Sequence[Function]]] | None = None
    act: Acting | None = None
    tell: Acting | None = None
    outputs: tuple[Quantities, ...] = ()
    sort: Callable[[K, Callable[[str], bool]], int] = lambda keys, slides: 0
    force: Callable[[K, Callable[[str], bool], float], float] = lambda keys, slides, extent: 0.0
    problem_at_start: Callable[[K, Array, float], str] = lambda keys, row, closest: ""
    applied: Applied | None = None
    picture: Callable[[K], Picture | None] = lambda keys: None

    @property
    def label(self) -> str:
        """Return its name in the documentation of outputs."""
        return self.outputs[0].label if self.outputs else self.table.removesuffix("s").upper()

    def outputs_of(self, keys: K, slides: Callable[[str], bool]) -> Quantities:
        """Return the outputs of an element."""
        return self.outputs[self.sort(keys, slides)]

    def functions_of(self, keys: K, name: str) -> Mapping[str, Sequence[Function]]:
        """Return the functions of an element by field; empty for a kind without functions."""
        return self.functions(keys, name) if self.functions is not None else {}
