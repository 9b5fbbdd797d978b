"""`System`: a mechanism and an experiment as the arrays that every engine reads, each computed once."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.base.arrays import Array, Records
from linkages.base.brief import Brief, counted
from linkages.base.errors import ARGUMENT
from linkages.elements.analysis import Analysis
from linkages.input.files.toml import Table, leaves
from linkages.input.functions.definitions import Quantity
from linkages.input.functions.recorded_tables import FromFile
from linkages.input.model.capabilities import check_analysis
from linkages.input.model.check import check
from linkages.input.model.experiment import Experiment
from linkages.input.model.experiment_tables import JointModel
from linkages.input.model.mechanism import Frame, Link, Mechanism
from linkages.input.model.skeleton import colors_of
from linkages.laws import Registered, registered, restore
from linkages.mechanics.planar.arrays import Arrays
from linkages.mechanics.planar.loads import Loads
from linkages.mechanics.planar.motion import Motions
from linkages.system.assembly import Assembly, assemble, start_offsets
from linkages.system.contacts import Contacts, contact_ends, contact_labels, contact_models
from linkages.system.deflection import deflected
from linkages.system.description import Description
from linkages.system.drive_travel import drive_travel
from linkages.system.equilibrium import resting_offsets
from linkages.system.facts import facts
from linkages.system.feedforward import with_feedforward
from linkages.system.film_steps import film_steps, least_force
from linkages.system.flexible_link import beam_records
from linkages.system.ideal_linkage import IdealLinkage, motions_of, torques_of, tree_of
from linkages.system.joints import SystemJoint, joints_of
from linkages.system.law_records import ContactLaws, LawStates, contact_laws
from linkages.system.lightness import check_lightness, first_alone
from linkages.system.load_records import Packed, pack_loads
from linkages.system.masses import with_rotors
from linkages.system.memory import Memory
from linkages.system.model_arrays import make_arrays, with_contacts, with_ideal_joints
from linkages.system.parts import NamedElements
from linkages.system.rates import drive_rate, swing_rate
from linkages.system.replacing import same_start, unit_of, with_values
from linkages.system.settings import Settings
from linkages.system.tree import Tree


@dataclass(frozen=True, eq=False, repr=False)
class System(Brief):
    """A mechanism and an experiment that fit each other, as plain arrays.

    Use `load` to make one from files and `replaced` to vary values. Each property is computed at its first use, by one
    function of those before it, and then kept. nc is the number of contacts: a journal with clearance is one, a guide
    with clearance has four.

    Attributes
    ----------
    mechanism, experiment
        The input. All other fields are made of it (`linkages.system.facts`): later steps ask them, not the input.
    settings : Settings
        Of a run.
    description : Description
        Names and files.
    links : mapping of str to Link
        In the reference configuration, as all geometry here.
    frames, points, places : tuple or mappings of str to Frame
        Named frames; these and the links' frames; everything with a position: points and joints.
    basis : (3, 3) array
        x_P, y_P and normal of the plane in world axes, as columns.
    machine_values : mapping of str to float
        Replaceable numbers of the machine by path without ``sdf.``, in SI units.
    parts : mapping of str to dicts
        Named elements by table and name, see `linkages.system.parts`.
    named_loads, acting : tuples of (str, str)
        Table and name of the applied loads, in the order of their records; of all elements that act, those that are
        derived from other tables included.
    wheels : mapping of str to float
        Moments of inertia of wheels that drives turn before their joints, by the joint [kg m2].
    drives : mapping of str to Drive
        By joint.
    actuators : sequence of str
        The drives that act, see `Drive.acts`, and the motors.
    functions_read : collection of str
        Names that functions of elements read.
    ramp : float
        Longest time of a drive's smooth start [s]; zero without one.
    play : tuple of str
        Clearance joints, in the order of the experiment.
    imperfect : bool
        Whether the linkage differs from the ideal one: by clearance, backlash or deformation.
    can_touch : bool
        Whether anything can be in contact: in dry or mixed joints, at limits, or of points with lines.
    values : mapping of str to float
        Numbers for formulas, in SI units.
    unread_states : collection of str
        Additional states that no formula reads, such as a motor's energy.
    recorded : mapping of str to FromFile
        Drives and loads that take their signal from a data file, by path.
    start_states, state_scales : (nz,) arrays
        Additional states at t = 0; magnitudes in parts of which their errors count.
    mass : float
        Of all links [kg].
    gravity : (2,) array
        In plane axes [m/s2].

    Raises
    ------
    InputError
        If they do not fit each other.

    Examples
    --------
    >>> import linkages
    >>> system = linkages.load(linkages.find_file("seven_bar.toml"))
    >>> system.tree.play
    ('A', 'B')
    >>> thin = system.replaced({"joints.A.clearance": 1e-4})
    >>> float(thin.laws["clearance"][0])
    0.0001
    """

    mechanism: Mechanism
    experiment: Experiment
    settings: Settings = field(init=False)
    description: Description = field(init=False)
    links: Mapping[str, Link] = field(init=False)
    frames: tuple[Frame, ...] = field(init=False)
    points: Mapping[str, Frame] = field(init=False)
    places: Mapping[str, Frame] = field(init=False)
    basis: Array = field(init=False)
    machine_values: Mapping[str, float] = field(init=False)
    parts: NamedElements = field(init=False)
    named_loads: tuple[tuple[str, str], ...] = field(init=False)
    acting: tuple[tuple[str, str], ...] = field(init=False)
    wheels: Mapping[str, float] = field(init=False)
    drives: Mapping[str, Any] = field(init=False)
    actuators: Sequence[str] = field(init=False)
    functions_read: Collection[str] = field(init=False)
    ramp: float = field(init=False)
    play: tuple[str, ...] = field(init=False)
    imperfect: bool = field(init=False)
    can_touch: bool = field(init=False)
    values: Mapping[str, float] = field(init=False)
    unread_states: Collection[str] = field(init=False)
    recorded: Mapping[str, FromFile] = field(init=False)
    start_states: Array = field(init=False)
    state_scales: Array = field(init=False)
    mass: float = field(init=False)
    gravity: Array = field(init=False)
    _twin: System | None = None
    _memory: Memory = field(default_factory=Memory, kw_only=True)

    def _facts(self) -> tuple[str, dict[str, str]]:
        mechanism, experiment = self.mechanism._facts(), self.experiment._facts()
        title = self.experiment.title or self.experiment.source.stem
        parts = counted(len(self.mechanism.links), "link"), counted(len(self.mechanism.joints), "joint")
        return f"{title}; {', '.join(parts)}, {self.experiment.duration:g} s", {**experiment[1], **mechanism[1]}

    def __post_init__(self) -> None:
        check(self.mechanism, self.experiment)
        vars(self).update(facts(self.mechanism, self.experiment))  # the dataclass is frozen

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the input and user-defined laws; another process computes its own arrays."""
        experiment = self.experiment
        named: list[Mapping[str, Table]] = [experiment.joints, *experiment.elements.values()]
        tables = [table for kind in named for table in kind.values()]
        texts = [text for table in tables for _, text in leaves(table.model_dump()) if isinstance(text, str)]
        return _restored, (self.mechanism, experiment, registered(texts))

    # -- another system ----------------------------------------------------------------------------

    def replaced(self, values: Mapping[str, Any], origin: str = ARGUMENT) -> System:
        """Return the system with values replaced by dotted path.

        Parameters
        ----------
        values : mapping
            Paths of the experiment (``joints.A.clearance``), and of the machine with ``sdf.`` before them
            (``sdf.links.rod.mass``); strings are read as TOML values. Outputs of the clearance
            of joints that become ideal, and of the deformation of links that become rigid, are dropped.
        origin : str
            Origin of the values, named in errors and as their source.

        Returns
        -------
        System
            A new system; this one is unchanged.

        Raises
        ------
        InputError
            If a path or a value is not valid.

        Examples
        --------
        >>> import linkages
        >>> system = linkages.load(linkages.find_file("seven_bar.toml"))
        >>> other = system.replaced({"joints.A.clearance": 1e-4, "sdf.links.link2.mass": 0.3})
        >>> other.value("joints.A.clearance"), other.value("sdf.links.link2.mass")
        (0.0001, 0.3)
        """
        if not values:
            return self
        mechanism, experiment = with_values(self.mechanism, self.experiment, values, origin)
        twin = (self._twin or self) if same_start(self.experiment, experiment, values) else None
        return System(mechanism, experiment, twin, _memory=self._memory)

    def ideal(self) -> System:
        """Return the system with every joint and element ideal: without clearance, backlash and deformation.

        Examples
        --------
        >>> import linkages
        >>> linkages.load(linkages.find_file("seven_bar.toml")).ideal().tree.play
        ()
        """
        return System(self.mechanism, self.experiment.ideal())

    def value(self, path: str) -> float:
        """Return the number at a dotted path, see `replaced`.

        Returns
        -------
        float
            In SI units.

        Raises
        ------
        InputError
            If no number has this path.

        Examples
        --------
        >>> import linkages
        >>> linkages.load(linkages.find_file("seven_bar.toml")).value("drives.O1.speed")  # rad/s
        3.141592653589793
        """
        if path.startswith("sdf."):
            return self.mechanism.value(path.removeprefix("sdf."))
        return self.experiment.value(path)

    def value_unit(self, path: str) -> str:
        """Return the SI unit of the number at a dotted path; empty if it is unknown, or a pure number.

        Unlike `linkages.input.model.experiment.value_unit` it knows the parameters of a described machine, the texts of
        `[values]`, and the prismatic joints.

        Examples
        --------
        >>> import linkages
        >>> linkages.load(linkages.find_file("seven_bar.toml")).value_unit("drives.O1.speed")
        'rad/s'
        """
        return unit_of(self.mechanism, self.experiment, path)

    def check_analysis(self, analysis: Analysis) -> None:
        """Refuse an analysis that does not support a model of this system, see `linkages.input.model.capabilities`."""
        check_analysis(self.experiment, analysis)

    @property
    def quantities(self) -> Mapping[str, Quantity]:
        """Return states, formulas of motors and controllers, and values, by their names in formulas."""
        return self.experiment.quantities

    @property
    def own_states(self) -> Mapping[str, Quantity]:
        """Return the additional states by name, in the order of the state vector."""
        return self.experiment.own_states

    def sampling_times(self, end: float) -> Array:
        """Return the times after t = 0 and up to an end at which states are sampled [s]."""
        return self.experiment.sampling_times(end)

    def slides(self, joint: str) -> bool:
        """Tell whether a joint is prismatic."""
        return self.mechanism.slides(joint)

    # -- names and places ------------------------------------------------------------------------------

    @cached_property
    def joints(self) -> dict[str, SystemJoint]:
        """Return the joints by name, with their places in the reference configuration, and clearances."""
        return joints_of(self.mechanism, self.experiment)

    @cached_property
    def colors(self) -> dict[str, str]:
        """Return the colours of links, frames and joints by name, as ``#rrggbb``."""
        return colors_of(self.mechanism)

    # -- the linkage with ideal joints -----------------------------------------------------------------

    @cached_property
    def tree(self) -> Tree:
        """Build the spanning tree, or take the tree of a system that differs in the laws of joints alone."""
        twin = self._twin
        if twin is not None and twin.mechanism is self.mechanism:
            return twin.tree
        return tree_of(self.mechanism, self.experiment)

    @cached_property
    def motions(self) -> Motions:
        """Return the prescribed motions of the tree's driven joints."""
        drives = tuple(self.drives[name] for name in self.tree.driven)
        return self._memory(motions_of, drives, self.values)

    @cached_property
    def torques(self) -> Motions:
        """Return the torque histories of the tree's powered joints."""
        return self._memory(torques_of, tuple(self.drives[name] for name in self.tree.powered))

    @cached_property
    def packed(self) -> Packed:
        """Return elements and applied loads as records of the kernels."""
        return pack_loads(self.tree, self.experiment, with_feedforward(self.mechanism, self.experiment))

    @property
    def loads(self) -> Loads:
        """Return the applied loads as records of the kernels."""
        return self.packed.loads

    @property
    def elements(self) -> Any:
        """Return the elements as records of the kernels, `linkages.elements.machine.Elements`."""
        return self.packed.elements

    @property
    def ideal_linkage(self) -> IdealLinkage:
        """Return the linkage with ideal joints, and what moves it."""
        return IdealLinkage(self.tree, self.motions, self.torques, self.packed, self.start_states, self.gravity)

    # -- contacts --------------------------------------------------------------------------------------

    @cached_property
    def contacts(self) -> tuple[tuple[str, str], ...]:
        """Return owner and label of each contact: clearance joints (`Tree.contacts`), limits, points at lines."""
        return contact_labels(self.tree, self.experiment)

    @cached_property
    def film_steps(self) -> dict[str, float]:
        """Return the longest film step of each clearance joint whose film has a history [s]."""
        return film_steps(self.experiment, self.drive_rate)

    @cached_property
    def models(self) -> tuple[JointModel, ...]:
        """Return the joint model of each contact; a film with history has its longest step, and its accuracy if any."""
        return contact_models(self.tree, self.experiment, self.film_steps)

    @cached_property
    def ends(self) -> Records:
        """Return both ends of each contact: `Tree.ends` with worn profiles, limits, points at lines."""
        return contact_ends(self.tree, self.experiment, self.models)

    @cached_property
    def _contact_laws(self) -> ContactLaws:
        joints = self.mechanism.joint
        bearings = tuple(joints[name].bearing if name in joints else None for name, _ in self.contacts)
        way = self.tree.extent, self.drive_rate, self.gravity, self.mass
        return self._memory(contact_laws, bearings, self.models, least_force(*way) if self.film_steps else 0.0)

    @property
    def _contact_records(self) -> Contacts:
        return Contacts(self.ends, self._contact_laws)

    @property
    def laws(self) -> Records:
        """Return the law records (`linkages.laws.PARAMETERS`) of the contacts, (nc,)."""
        return self._contact_laws.records

    @property
    def tables(self) -> Array:
        """Return one line per contact: the map of its finite film, or its cells; the profiles of a worn joint last."""
        return self._contact_laws.tables

    @property
    def film_limits(self) -> Array:
        """Return the largest eccentricity ratio that the film of each contact covers, (nc,)."""
        return self._contact_laws.film_limits

    @property
    def touching(self) -> NDArray[np.bool_]:
        """Return which contacts can touch, (nc,)."""
        return self._contact_laws.touching

    @property
    def reach(self) -> Array:
        """Return the eccentricity at which a journal leaves its film, (nc,) [m], see `Contacts.reach`."""
        return self._contact_records.reach

    @property
    def rods(self) -> tuple[Records, Records, Records]:
        """Return the deformable bodies as records of their internal forces, their stations, and the shapes at these."""
        return beam_records(self.tree)

    @property
    def law_states(self) -> LawStates:
        """Return the continuous states of the contacts' laws."""
        return self._contact_laws.states

    @property
    def stiff(self) -> bool:
        """Check whether films, states of laws or shapes make the equations stiff; dry contact does not."""
        return (
            any(model.has_film for model in self.models) or len(self.law_states.names) > 0 or bool(self.tree.deformable)
        )

    @property
    def starts_unloaded(self) -> bool:
        """Whether the start follows from lengths and motions alone: no equilibrium, no deformation under loads."""
        return self.experiment.start == "centred" and not self.experiment.deforming

    # -- the start, and rates before a run -------------------------------------------------------------

    @cached_property
    def drive_rate(self) -> float:
        """Return the largest rate of a prescribed motion [rad/s or m/s]; zero without drives."""
        return drive_rate(self.tree, self.experiment)

    @cached_property
    def drive_travel(self) -> float:
        """Return the fastest drive's travel at its largest rate [rad or m], see `linkages.system.drive_travel`."""
        return drive_travel(self.motions, self.settings.duration)

    @cached_property
    def motion_rate(self) -> float:
        """Estimate the rate of the motion before a run [rad/s]."""
        if self.drive_rate > 0.0:
            return self.drive_rate
        return swing_rate(self.tree, self.experiment, self.mass, self.gravity, self.assembly.v)

    @property
    def start_offsets(self) -> Array:
        """Return the values (nr,) of the closure rows at the start: journals' offsets, places in the backlash."""
        return start_offsets(self.tree, self.experiment)

    @cached_property
    def assembly(self) -> Assembly:
        """Assemble the ideal linkage at t = 0, with consistent velocities; AssemblyError if this is impossible."""
        if self._twin is not None:
            return self._twin.assembly
        linkage, experiment = self.ideal_linkage, self.experiment
        whole = partial(assemble, linkage.tree, experiment, linkage.motions, linkage.packed)
        resting = experiment.start == "equilibrium" and linkage.tree.play
        start = whole(resting_offsets(linkage, self._contact_records, experiment.source, whole)) if resting else whole()
        check_lightness(linkage.tree, self._given_masses, start.q)
        return deflected(linkage, start, experiment.source)

    @property
    def determinate(self) -> bool:
        """Check whether the prescribed drives alone determine the ideal motion, and no states its forces."""
        return self.assembly.mobility == len(self.tree.driven) and not self.own_states

    @property
    def has_light_links(self) -> bool:
        """Check for links without mass or moment of inertia, which may become free of all masses on the way."""
        return any(link.mass == 0.0 or link.inertia == 0.0 for link in self._given_masses.links)

    def first_alone(self, q: Array) -> int | None:
        """Return the first of some coordinates (nt, n) at which a link without mass can move alone, None if none is."""
        return first_alone(self.tree, self._given_masses, q[:, : self.tree.size])

    @cached_property
    def _given_masses(self) -> Mechanism:
        """Return the mechanism with the masses of the file, without negligible ones."""
        return with_rotors(self.mechanism, self.experiment)

    # -- arrays of the kernels -------------------------------------------------------------------------

    @cached_property
    def arrays(self) -> Arrays:
        """Return all arrays that kernels read; systems that differ in the laws of joints alone share the others."""
        if self._twin is not None and self._differs_in_laws_alone:
            return with_contacts(self._twin.arrays, self._contact_records)
        return make_arrays(self.ideal_linkage, self._contact_records, self.assembly.q, self.motion_rate)

    @property
    def _differs_in_laws_alone(self) -> bool:
        """Whether nothing but the laws of joints differs from the twin."""
        return self._twin is not None and self._twin.tree is self.tree

    @cached_property
    def ideal_arrays(self) -> Arrays:
        """Return the same arrays with every joint ideal, closed by `Tree.closure_rows`."""
        return with_ideal_joints(self.arrays, self.tree, self.assembly.q)


def _restored(mechanism: Mechanism, experiment: Experiment, laws: tuple[Registered, ...]) -> System:
    restore(laws)
    return System(mechanism, experiment)
