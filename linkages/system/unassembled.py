"""`Unassembled`: a mechanism and an experiment as the arrays that do not depend on the assembled pose."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.base.arrays import Array, Records
from linkages.base.brief import Brief, counted
from linkages.elements.analysis import Analysis
from linkages.elements.machine import all_elements_of
from linkages.input.functions.definitions import Quantity
from linkages.input.functions.recorded_tables import FromFile
from linkages.input.model.capabilities import check_analysis
from linkages.input.model.check import check
from linkages.input.model.drive_tables import Drive
from linkages.input.model.experiment import Experiment
from linkages.input.model.experiment_tables import JointModel
from linkages.input.model.mechanism import Frame, Link, Mechanism
from linkages.input.model.skeleton import colors_of
from linkages.mechanics.planar.loads import Loads
from linkages.mechanics.planar.motion import Motions
from linkages.mechanics.planar.record_types import ORIENTED, REMEMBERING, REVOLUTE, WORN
from linkages.system.assembly import start_offsets
from linkages.system.description import Description
from linkages.system.drive_travel import drive_travel
from linkages.system.facts import facts
from linkages.system.film_steps import film_steps, with_film_step
from linkages.system.flexible_link import flexible_link
from linkages.system.joints import SystemJoint, joints_of
from linkages.system.law_records import ContactLaws, LawStates, contact_laws
from linkages.system.lightness import negligible_inertials
from linkages.system.load_records import Packed, pack_loads, unilateral_ends, unilateral_models
from linkages.system.memory import Memory
from linkages.system.parts import NamedElements
from linkages.system.settings import Settings
from linkages.system.spanning import spanning_tree
from linkages.system.tree import Tree, chained

_UNKNOWN = 1.0  # rate for a linkage without motion and forces at the start [rad/s]
_LEAST_FORCE = 0.03  # force of a film whose errors count, over the forces that the drives need for all masses


@dataclass(frozen=True, eq=False, repr=False)
class Unassembled(Brief):
    """The part of a `System` from which its assembly is computed: tree, motions, loads, contacts and their laws.

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
    play, flexible : tuples of str
        Clearance joints and flexible links, in the order of the experiment.
    can_touch : bool
        Whether anything can be in contact: in dry or mixed joints, at limits, or of points with lines.
    values : mapping of str to float
        Numbers for formulas, in SI units.
    unread_states : collection of str
        Additional states that no formula reads, such as a motor's energy.
    recorded : mapping of str to FromFile
        Drives and loads that take their signal from a data file, by path.

    Raises
    ------
    InputError
        If mechanism and experiment are inconsistent.
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
    drives: Mapping[str, Drive] = field(init=False)
    actuators: Sequence[str] = field(init=False)
    functions_read: Collection[str] = field(init=False)
    ramp: float = field(init=False)
    play: tuple[str, ...] = field(init=False)
    flexible: tuple[str, ...] = field(init=False)
    can_touch: bool = field(init=False)
    values: Mapping[str, float] = field(init=False)
    unread_states: Collection[str] = field(init=False)
    recorded: Mapping[str, FromFile] = field(init=False)
    _memory: Memory = field(default_factory=Memory, kw_only=True)

    def _facts(self) -> tuple[str, dict[str, str]]:
        mechanism, experiment = self.mechanism._facts(), self.experiment._facts()
        title = self.experiment.title or self.experiment.source.stem
        parts = counted(len(self.mechanism.links), "link"), counted(len(self.mechanism.joints), "joint")
        return f"{title}; {', '.join(parts)}, {self.experiment.duration:g} s", {**experiment[1], **mechanism[1]}

    def __post_init__(self) -> None:
        check(self.mechanism, self.experiment)
        vars(self).update(facts(self.mechanism, self.experiment))  # the dataclass is frozen

    @cached_property
    def joints(self) -> dict[str, SystemJoint]:
        """Return the joints by name, with their places in the reference configuration, and clearances."""
        return joints_of(self.mechanism, self.experiment)

    @cached_property
    def colors(self) -> dict[str, str]:
        """Return the colours of links, frames and joints by name, as ``#rrggbb``."""
        return colors_of(self.mechanism)

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

    # -- the tree ----------------------------------------------------------------------------------

    @cached_property
    def tree(self) -> Tree:
        """Build the spanning tree: clearance joints are cut, driven joints stay."""
        drives = self.experiment.drives
        tree = spanning_tree(
            self.mechanism.with_inertial(self.inertials),
            self.experiment.play,
            tuple(name for name, drive in drives.items() if drive.prescribed),
            tuple(name for name, drive in drives.items() if not drive.prescribed),
            {name: partial(flexible_link, self.mechanism, self.experiment, name) for name in self.experiment.flexible},
            self.experiment.wheels,
        )
        return replace(tree, coupled=self.experiment.closed, loose=self.experiment.loose)

    @property
    def inertials(self) -> dict[str, float]:
        """Return inertias of links with rotors, and negligible masses of links without, by path."""
        return negligible_inertials(self.mechanism) | self.rotors

    @property
    def rotors(self) -> dict[str, float]:
        """Return the inertias of links with those of the rotors that turn with them, by path."""
        found: dict[str, float] = {}
        for kind, _, keys in all_elements_of(self.experiment.elements):
            rotor = kind.rotor(keys)
            if rotor is not None and rotor.inertia:
                joint = self.mechanism.joint[rotor.joint]
                link = self.mechanism.link[joint.child if joint.parent == "world" else joint.parent]
                path = f"links.{link.name}.inertia"
                found[path] = found.get(path, link.inertia) + rotor.inertia
        return found

    @cached_property
    def motions(self) -> Motions:
        """Return the prescribed motions of the tree's driven joints."""
        drives = tuple(self.experiment.drives[name] for name in self.tree.driven)
        return self._memory(_motions, drives, self.experiment.values)

    @cached_property
    def drive_rate(self) -> float:
        """Return the largest rate of a prescribed motion [rad/s or m/s]; zero without drives."""
        drives = [self.experiment.drives[name] for name in self.tree.driven]
        return max(
            (drive.largest_rate(self.experiment.duration, self.experiment.values) for drive in drives), default=0.0
        )

    @cached_property
    def drive_travel(self) -> float:
        """Return the fastest drive's travel at its largest rate [rad or m], see `linkages.system.drive_travel`."""
        return drive_travel(self.motions, self.settings.duration)

    @property
    def mass(self) -> float:
        """Return the mass of all links [kg]."""
        return sum(link.mass for link in self.mechanism.links)

    def swing_rate(self, rates: Array) -> float:
        """Estimate the rate of the motion of a linkage without prescribed motions, before the run [rad/s].

        It is the largest of the rates (n,) at the start [rad/s, m/s] or, if larger, the rate of a swing under the
        present forces: the square root of force over mass and length, for the weight, springs, constant loads and
        drives by torque or force. It does not depend on the duration, because the result of a run must not.
        """
        extent, experiment = self.tree.extent, self.experiment
        mass = sum(link.mass for link in self.mechanism.links)
        sliding = self.tree.bodies.records["type"] != REVOLUTE
        moved = self.tree.bodies.records["dof"][sliding]
        scale = np.ones(self.tree.size)
        scale[moved[moved >= 0]] = 1.0 / extent
        start = np.abs(rates * scale)[self.tree.joint_dofs]
        forces = [mass * float(np.linalg.norm(self.gravity))]
        parts = all_elements_of(experiment.elements)
        forces += [kind.force(keys, self.mechanism.slides, extent) for kind, _, keys in parts]
        for drive in experiment.drives.values():
            forces += [_magnitude(drive.torque) / extent, _magnitude(drive.torques) / extent]
            forces += [_magnitude(drive.force), _magnitude(drive.forces)]
        swing = float(np.sqrt(max(forces) / (mass * extent))) if mass > 0.0 else 0.0
        return max(float(start.max(initial=0.0)), swing) or _UNKNOWN

    @cached_property
    def torques(self) -> Motions:
        """Return the torque histories of the tree's powered joints."""
        return self._memory(_torques, tuple(self.experiment.drives[name] for name in self.tree.powered))

    @cached_property
    def packed(self) -> Packed:
        """Return elements and applied loads as records of the kernels."""
        return pack_loads(self.tree, self.experiment, self.experiment.quantities)

    @property
    def loads(self) -> Loads:
        """Return the applied loads as records of the kernels."""
        return self.packed.loads

    @property
    def elements(self) -> Any:
        """Return the elements as records of the kernels, `linkages.elements.machine.Elements`."""
        return self.packed.elements

    @property
    def start_states(self) -> Array:
        """Return the additional states at t = 0, (nz,)."""
        return np.array([one.start for one in self.own_states.values()], float)

    @property
    def state_scales(self) -> Array:
        """Return the magnitudes in parts of which their errors count, (nz,)."""
        return np.array([one.scale for one in self.own_states.values()], float)

    @cached_property
    def gravity(self) -> Array:
        """Return gravity in plane axes, (2,) [m/s2]."""
        return self.mechanism.basis[:, :2].T @ self.experiment.gravity

    @property
    def start_offsets(self) -> Array:
        """Return the values (nr,) of the closure rows at the start: journals' offsets, places in the backlash."""
        return start_offsets(self.tree, self.experiment)

    # -- contacts ----------------------------------------------------------------------------------

    @cached_property
    def contacts(self) -> tuple[tuple[str, str], ...]:
        """Return owner and label of each contact: clearance joints (`Tree.contacts`), limits, points at lines."""
        labels = ((label.rpartition(".")[0] or label, label) for label in self.experiment.touches)
        return (*self.tree.contacts, *labels)

    @cached_property
    def models(self) -> tuple[JointModel, ...]:
        """Return the joint model of each contact; a film with history has its longest step, and its accuracy if any."""
        play = tuple(with_film_step(self.experiment, self.film_steps, name) for name, _ in self.tree.contacts)
        return (*play, *unilateral_models(self.tree, self.experiment))

    @cached_property
    def film_steps(self) -> dict[str, float]:
        """Return the longest film step of each clearance joint whose film has a history [s]."""
        return film_steps(self.experiment, self.drive_rate)

    def check_analysis(self, analysis: Analysis) -> None:
        """Refuse an analysis that does not support a model of this system, see `linkages.input.model.capabilities`."""
        check_analysis(self.experiment, analysis)

    @cached_property
    def _contact_laws(self) -> ContactLaws:
        joints = self.mechanism.joint
        bearings = tuple(joints[name].bearing if name in joints else None for name, _ in self.contacts)
        return self._memory(contact_laws, bearings, self.models, self._least_force if self.film_steps else 0.0)

    @property
    def _least_force(self) -> float:
        """Return the force of a film below which its errors do not count [N]."""
        acceleration = self.tree.extent * self.drive_rate**2 + float(np.linalg.norm(self.gravity))
        return _LEAST_FORCE * acceleration * self.mass

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
    def largest_ratios(self) -> Array:
        """Return the eccentricity ratio at which a journal leaves its film, (nc,); infinite where bodies can touch.

        States with such a ratio are not valid: runs end there, and searches for states refuse them.
        """
        return np.where(self.touching, np.inf, self.film_limits)

    @property
    def reach(self) -> Array:
        """Return the eccentricity at which a journal leaves its film, (nc,) [m]; see `largest_ratios`."""
        return np.where(self.touching, np.inf, self.laws["clearance"] * self.film_limits)

    @property
    def law_states(self) -> LawStates:
        """Return the continuous states of the contacts' laws."""
        return self._contact_laws.states

    @cached_property
    def ends(self) -> Records:
        """Return both ends of each contact: `Tree.ends` with worn profiles, limits, points at lines."""
        ends = chained(self.tree.ends, unilateral_ends(self.tree, self.experiment))
        for k, model in enumerate(self.models):
            if model.feed or model.is_tilted or model.is_worn:  # the direction of the bearing matters
                ends["kind"][k] = WORN if model.is_worn else REMEMBERING if model.has_history else ORIENTED
        return ends


def _motions(drives: tuple[Drive, ...], values: Mapping[str, float]) -> Motions:
    return Motions([drive.motion(values) for drive in drives])


def _torques(drives: tuple[Drive, ...]) -> Motions:
    return Motions([drive.torque_history() for drive in drives])


def _magnitude(values: Any) -> float:
    """Return the largest magnitude of a number or list; zero for None."""
    return 0.0 if values is None else float(np.abs(values).max())
