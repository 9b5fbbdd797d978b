"""The duties of a kind of element, in the order in which a run needs them.

A kind is one module of `linkages.elements`, and one `Element`. It knows bodies as markers and closure terms, never the
system: see `Places` and `Checks` for what it may ask.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Generic, NamedTuple, NoReturn, Protocol, TypeVar

import numpy as np

from linkages.base.arrays import Array
from linkages.elements.analysis import Refusal
from linkages.elements.contact_tables import ContactTable
from linkages.elements.coordinates import Barrier, Coupled, Edge, Push
from linkages.elements.outputs import Quantities
from linkages.elements.pictures import Around, Between, Picture, Point, Scene
from linkages.elements.validity import Rules, Warned
from linkages.input.files.toml import Table
from linkages.input.functions.definitions import Function, Quantity
from linkages.input.functions.smoothing import SmoothSignal
from linkages.mechanics.planar.functions import Given
from linkages.mechanics.planar.loads import ENERGY, POWER, SECOND, VALUE

# columns of `Element.tell`, and what most kinds need
__all__ = ["ENERGY", "POWER", "SECOND", "VALUE", "Around", "Between", "Point", "Quantities", "Warned"]

K = TypeVar("K", bound=Table)

Marker = tuple[int, float, float]  #: body, and place in its frame [m]; a `MARKER`


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

    @property
    def name(self) -> str:
        """Return the name of the element."""

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

    def same_kind(self, key: str, text: str, unit: str) -> None:
        """Refuse a unit of another kind than an SI unit."""

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

    def interfaces(self, link: str) -> int:
        """Return the largest number of interfaces of a substructure of a link with a beam."""

    def in_file(self, kind: str) -> str:
        """Return where the part with the element's name is in the machine's file."""

    def joint(self, key: str, name: str) -> Any:
        """Return a joint, a `linkages.elements.pictures.Jointed`; refuse an unknown one."""

    def has_clearance(self, joint: str) -> bool:
        """Tell whether a joint has clearance."""

    def meet(self, one: str, other: str) -> bool:
        """Tell whether two joints share a link, or have links that fixed joints make one body."""

    def bends(self, link: str) -> bool:
        """Tell whether a link is flexible."""

    def plain(self, contact: ContactTable) -> None:
        """Refuse the law of a contact that needs a journal in a bearing."""

    def within(self, key: str) -> Checks:
        """Return the checks of the table at a key."""


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


@dataclass(frozen=True)
class Substitute:
    """What the Drake engine runs instead of elements that it does not have.

    Attributes
    ----------
    key : str
        Key of the number that makes it finer.
    refined : callable
        ``refined(keys)`` are values by key that make it about twice as fine.
    warns : callable
        ``warns(named)`` are warnings about a run with it, for elements by name.
    compared : callable
        ``compared(named)`` are lines that explain a comparison of both engines.
    """

    key: str
    refined: Callable[[Any], Mapping[str, float]]
    warns: Callable[[Mapping[str, Any]], Iterable[Warned]]
    compared: Callable[[Mapping[str, Any]], Sequence[str]]


class Modelled(NamedTuple):
    """A joint or link that can have a model, for the live page."""

    name: str
    part: Any  # `linkages.input.model.mechanism.Link`
    ends: Sequence[Array]  # different places of joints on a link, (2,) [m]


@dataclass(frozen=True)
class Choice:
    """Models of a joint or link that the live page offers.

    Attributes
    ----------
    chosen : callable
        ``chosen(keys)`` is the present model; the keys are None for a part without a table.
    offered : callable
        ``offered(modelled)`` are the models that the part can have.
    values : callable
        ``values(modelled, model)`` are the values by path that give it a model, data that it lacks included; ValueError
        for an unknown one, and a part that cannot have it.
    determines : callable
        ``determines(name, values)`` are the beginnings of paths that such values make meaningless.
    """

    chosen: Callable[[Any], str]
    offered: Callable[[Modelled], Sequence[str]]
    values: Callable[[Modelled, str], dict[str, Any]]
    determines: Callable[[str, Mapping[str, Any]], tuple[str, ...]]


Slides = Callable[[str], bool]  #: whether a joint, by name, is prismatic

#: Kernels of a kind, without and with functions.
Acting = Callable[[np.record, Array, Array, Array], None] | Callable[[np.record, Given, Array, Array, Array], None]


@dataclass(frozen=True, kw_only=True)
class Element(Generic[K]):
    """A kind of element of a machine: it acts on bodies, defines quantities for formulas, or both.

    A kind has the duties that it names; the others have defaults: no points, no forces, no contacts, no picture.

    Attributes
    ----------
    table : str
        Its table in experiments.
    part : str
        What names its elements: "joint" or "link" if they are models of these parts of a machine; empty: own names.
    keys : type of Table
        The keys of one element. Its `imperfections` name the keys that the linkage with ideal joints lacks.
    derived : callable
        ``derived(tables)`` makes its elements, by name, from the tables of `home`; default: they have their own table.
    home : str
        Where derived elements have their keys: their paths are ``home.name``.
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
    points : callable
        ``points(keys)`` are the points at which it acts on links.
    from_reference : callable
        ``from_reference(keys)`` tells whether it counts a coordinate or a direction from the reference configuration.
    deforms : callable
        ``deforms(keys)`` tells whether it makes its link a deformable body, a body with shape coordinates.
    idle : callable
        ``idle(keys, name)`` says why none of its keys acts; empty if they act. A part without a table has no keys.
    absent : callable
        ``absent(name)`` says what a part without this model lacks for its outputs, and the remedy.
    rotor : callable
        ``rotor(keys)`` is the inertia that it adds to a joint.
    record : dtype, optional
        The numbers of its kernels, made by ``record_type``; default: it has no kernels.
    values : mapping
        Keys whose values the record has as they are, by its fields.
    pack : callable
        ``pack(keys, places)`` returns the other numbers of a record by field.
    functions : callable, optional
        ``functions(keys, name)`` returns the functions that its record refers to: components by the field that has the
        index of the first one. A kernel reads them by `linkages.mechanics.planar.functions.value_of`.
    act : kernel
        ``act(element, pose, vel, wrench)`` adds its forces to the bodies' wrenches. With functions it is
        ``act(element, given, pose, vel, wrench)``, where ``given`` has their inputs.
    tell : kernel
        ``tell(element, pose, vel, row)``, with functions ``tell(element, given, pose, vel, row)``, fills its row:
        value, second value, the power that it delivers to the bodies [W], the energy that it stores [J].
    couples : callable
        ``couples(keys)`` are the joints whose coordinates it couples; None without any.
    contacts : callable
        ``contacts(keys)`` are its contacts, by the ends of their names: "" or ".upper".
    push : callable
        ``push(keys)`` is its push along a joint's coordinate; its kernels are those of loads. Default: none.
    outputs : sequence of Quantities
        All outputs of the kind.
    sort : callable
        ``sort(keys, slides)`` is the index of an element's outputs, or several, the characteristic ones first;
        ``slides(joint)`` tells whether a joint is prismatic.
    force : callable
        ``force(keys, slides, extent)`` is a force that sets the machine in motion [N], for the scale of time.
    problem_at_start : callable
        ``problem_at_start(keys, row, closest)`` names the error of an element at t = 0, with its row;
        points that are closer than ``closest`` [m] coincide. Empty without an error.
    applied : Applied, optional
        Its constants that a step or a linear model changes.
    controls : sequence of str
        Its keys that the live page shows first.
    choice : Choice, optional
        Models of its part that the live page offers.
    picture : callable
        ``picture(keys, scene)`` are its shapes in drawings.
    warns : callable
        ``warns(named, locked)`` are warnings about a run of a machine with these elements by name, some of whose
        couplings lock each other. Kinds with the same function are warned about together.
    rules : Rules, optional
        Rules on its validity in a run.
    substitute : Substitute, optional
        What the Drake engine runs instead.
    unsupported : sequence of Refusal
        Models that some analyses cannot treat.
    linear : bool
        Whether linear models include it.
    completed : callable
        ``completed(keys, meet)`` adds to the keys of an imported element what the machine decides, see `Checks.meet`.
    """

    table: str
    part: str = ""
    keys: type[K]
    derived: Callable[[Mapping[str, Any]], Mapping[str, K]] | None = None
    home: str = ""
    check: Callable[[K, Checks], None] = lambda keys, checks: None
    quantities: Callable[[K, str], Mapping[str, Quantity]] | None = None
    own: Mapping[str, str] = field(default_factory=dict)
    unit: Callable[[K], str] | None = None
    ideal_efforts: Callable[[K, str], Iterable[IdealEffort]] = lambda keys, name: ()
    points: Callable[[K], Iterable[Point]] = lambda keys: ()
    from_reference: Callable[[K], bool] = lambda keys: False
    deforms: Callable[[K], bool] = lambda keys: False
    idle: Callable[[K | None, str], str] = lambda keys, name: ""
    absent: Callable[[str], str] = lambda name: ""
    rotor: Callable[[K], Rotor | None] = lambda keys: None
    record: np.dtype[Any] | None = None
    values: Mapping[str, str] = field(default_factory=dict)
    pack: Callable[[K, Places], Mapping[str, Any]] = lambda keys, places: {}
    functions: Callable[[K, str], Mapping[str, Sequence[Function]]] | None = None
    act: Acting | None = None
    tell: Acting | None = None
    applied: Applied | None = None
    couples: Callable[[K], Coupled | None] = lambda keys: None
    contacts: Callable[[K], Mapping[str, Barrier | Edge]] = lambda keys: {}
    push: Callable[[K], Push] | None = None
    outputs: tuple[Quantities, ...] = ()
    sort: Callable[[K, Slides], int | Sequence[int]] = lambda keys, slides: 0
    force: Callable[[K, Slides, float], float] = lambda keys, slides, extent: 0.0
    problem_at_start: Callable[[K, Array, float], str] = lambda keys, row, closest: ""
    controls: tuple[str, ...] = ()
    choice: Choice | None = None
    picture: Callable[[K, Scene], Iterable[Picture]] = lambda keys, scene: ()
    warns: Callable[[Mapping[str, K], Sequence[str]], Iterable[Warned]] | None = None
    rules: Rules[Any] | None = None
    substitute: Substitute | None = None
    unsupported: tuple[Refusal, ...] = ()
    linear: bool = True
    completed: Callable[[Mapping[str, Any], Callable[[str, str], bool]], Mapping[str, Any]] = lambda keys, meet: keys

    @property
    def label(self) -> str:
        """Return its name in the documentation of outputs."""
        return self.outputs[0].label if self.outputs else self.table.removesuffix("s").upper()

    @property
    def acts(self) -> bool:
        """Whether it acts on the machine; a kind without kernels may define quantities only."""
        return self.record is not None or self.quantities is None

    def functions_of(self, keys: K, name: str) -> Mapping[str, Sequence[Function]]:
        """Return the functions of an element by field; empty for a kind without functions."""
        return self.functions(keys, name) if self.functions is not None else {}

    def outputs_of(self, keys: K, slides: Slides) -> tuple[Quantities, ...]:
        """Return the outputs of an element, the characteristic ones first; none of a kind that has none."""
        found = self.sort(keys, slides) if self.outputs else ()
        return tuple(self.outputs[k] for k in ((found,) if isinstance(found, int) else found))

    def path(self, name: str) -> str:
        """Return the path of an element's keys in the experiment."""
        return f"{self.home or self.table}.{name}"
