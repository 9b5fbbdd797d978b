"""`Unassembled`: a mechanism and an experiment as the arrays that do not depend on the assembled pose."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from linkages.base.arrays import Array, Records
from linkages.base.brief import Brief, counted
from linkages.base.errors import InputError
from linkages.elements.machine import elements_of, pack_elements
from linkages.input.model.capabilities import Analysis, check_analysis
from linkages.input.model.check import check
from linkages.input.model.drive_tables import Drive
from linkages.input.model.experiment import Experiment
from linkages.input.model.experiment_tables import FILM_ACCURACY, FilmHistory, JointModel
from linkages.input.model.mechanism import Mechanism
from linkages.mechanics.planar.loads import Loads
from linkages.mechanics.planar.motion import Motions
from linkages.mechanics.planar.record_types import ORIENTED, REMEMBERING, REVOLUTE, WORN
from linkages.system.flexible_link import flexible_link
from linkages.system.law_records import ContactLaws, contact_laws
from linkages.system.lightness import negligible_inertials
from linkages.system.load_records import pack_loads, unilateral_ends, unilateral_models
from linkages.system.spanning import spanning_tree
from linkages.system.tree import Tree, chained

_UNKNOWN = 1.0  # rate for a linkage without motion and forces at the start [rad/s]
_FILM_STEPS = 200  # of a turn of the fastest drive
_LEAST_FORCE = 0.03  # force of a film whose errors count, over the forces that the drives need for all masses
_SAMPLED = 2000  # number of times at which the drives' rates are compared

T = TypeVar("T")


class Memory:
    """The two latest results of each function and their arguments, shared by variants of a system."""

    def __init__(self) -> None:
        self._kept: dict[Any, list[tuple[tuple[Any, ...], Any]]] = {}

    def __call__(self, function: Callable[..., T], *arguments: Any) -> T:
        """Return the result of a function for arguments that can be compared, which decide it alone."""
        kept = self._kept.get(function, [])
        for known, found in kept:
            if known == arguments:
                return cast(T, found)
        result = function(*arguments)
        self._kept[function] = [*kept[-1:], (arguments, result)]
        return result


@dataclass(frozen=True, eq=False, repr=False)
class Unassembled(Brief):
    """The part of a `System` from which its assembly is computed: tree, motions, loads, contacts and their laws.

    Raises
    ------
    InputError
        If mechanism and experiment are inconsistent.
    """

    mechanism: Mechanism
    experiment: Experiment
    _memory: Memory = field(default_factory=Memory, kw_only=True)

    def _facts(self) -> tuple[str, dict[str, str]]:
        mechanism, experiment = self.mechanism._facts(), self.experiment._facts()
        title = self.experiment.title or self.experiment.source.stem
        parts = counted(len(self.mechanism.links), "link"), counted(len(self.mechanism.joints), "joint")
        return f"{title}; {', '.join(parts)}, {self.experiment.duration:g} s", {**experiment[1], **mechanism[1]}

    def __post_init__(self) -> None:
        check(self.mechanism, self.experiment)

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
        """Return the inertias of links with those of the motors that turn them, by path."""
        found: dict[str, float] = {}
        for motor in self.experiment.motors.values():
            joint = self.mechanism.joint[motor.joint]
            link = self.mechanism.link[joint.child if joint.parent == "world" else joint.parent]
            path = f"links.{link.name}.inertia"
            if motor.rotor_inertia:
                found[path] = found.get(path, link.inertia) + motor.ratio**2 * motor.rotor_inertia
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
        """Compute the fastest drive's travel at its largest rate [rad or m]; an oscillation counts as 2 pi.

        The number of oscillations follows from the total variation of the rate: four times its largest value in each.
        """
        rates, accelerations = np.abs(self._drive_rates)
        largest = rates.max(axis=0, initial=0.0)
        turns = accelerations.mean(axis=0) / np.where(largest > 0.0, 4.0 * largest, np.inf)
        ways = self.experiment.duration * np.maximum(largest, 2.0 * np.pi * turns)
        return float(ways.max(initial=0.0))

    @cached_property
    def _drive_rates(self) -> tuple[Array, Array]:
        """Sample rates and accelerations (nt, nd) of the drives at irregular times, to avoid aliasing."""
        between = np.random.default_rng(0).random(_SAMPLED)
        return self.motions(self.experiment.duration * np.concatenate([[0.0], np.sort(between), [1.0]]))[1:]

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
        parts = elements_of(experiment.elements)
        forces += [kind.force(keys, self.mechanism.slides, extent) for kind, _, keys in parts]
        forces += [_magnitude(force.force) for force in experiment.forces.values()]
        forces += [_magnitude(torque.torque) / extent for torque in experiment.torques.values()]
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
    def loads(self) -> Loads:
        """Return the applied loads as records of the kernels."""
        return pack_loads(self.tree, self.experiment, self.experiment.quantities)

    @cached_property
    def elements(self) -> Any:
        """Return the elements as records of the kernels, `linkages.elements.machine.Elements`."""
        return pack_elements(self.experiment.elements, self.tree)

    @property
    def start_states(self) -> Array:
        """Return the additional states at t = 0, (nz,)."""
        return np.array([one.start for one in self.experiment.own_states.values()], float)

    @property
    def state_scales(self) -> Array:
        """Return the magnitudes in parts of which their errors count, (nz,)."""
        return np.array([one.scale for one in self.experiment.own_states.values()], float)

    @cached_property
    def gravity(self) -> Array:
        """Return gravity in plane axes, (2,) [m/s2]."""
        return self.mechanism.basis[:, :2].T @ self.experiment.gravity

    # -- contacts ----------------------------------------------------------------------------------

    @cached_property
    def contacts(self) -> tuple[tuple[str, str], ...]:
        """Return owner and label of each contact: clearance joints (`Tree.contacts`), limits, points at lines."""
        labels = ((label.rpartition(".")[0] or label, label) for label in self.experiment.touches)
        return (*self.tree.contacts, *labels)

    @cached_property
    def models(self) -> tuple[JointModel, ...]:
        """Return the joint model of each contact; a film with history has its longest step, and its accuracy if any."""
        play = tuple(self._with_film_step(name) for name, _ in self.tree.contacts)
        return (*play, *unilateral_models(self.tree, self.experiment))

    @cached_property
    def film_steps(self) -> dict[str, float]:
        """Return the longest film step of each clearance joint whose film has a history [s]."""
        joints = {name: self.experiment.joints[name] for name in self.experiment.play}
        histories = {name: joint.history for name, joint in joints.items() if joint.has_history}
        return {name: self._film_step(name, history) for name, history in histories.items() if history is not None}

    def _film_step(self, name: str, history: FilmHistory) -> float:
        if history.step is not None:
            return history.step
        if self.drive_rate == 0.0:
            problem = "is missing: without a prescribed speed it has no default; give 1/200 turn [s], and an accuracy"
            raise InputError(self.experiment.source, f"joints.{name}.history.step", problem)
        return 2.0 * np.pi / (_FILM_STEPS * self.drive_rate)

    def _with_film_step(self, name: str) -> JointModel:
        model = self.experiment.joints[name]
        if name not in self.film_steps or model.history is None:
            return model
        accuracy = FILM_ACCURACY if model.history.step is None else None
        chosen = {"step": self.film_steps[name], "accuracy": model.history.accuracy or accuracy}
        return model.model_copy(update={"history": model.history.model_copy(update=chosen)})

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
        return _LEAST_FORCE * acceleration * sum(link.mass for link in self.mechanism.links)

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
    def bristles(self) -> NDArray[np.int64]:
        """Return the contacts whose friction has a state (LuGre)."""
        return self._contact_laws.bristles

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
