"""`System`: a mechanism and an experiment as the arrays that every engine reads, each computed once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.base.arrays import Array, Records
from linkages.base.errors import ARGUMENT
from linkages.input.files.toml import Table, leaves, read_toml
from linkages.input.files.unit_conversion import SLIDING, si_unit
from linkages.input.model.check import names_first, without_lost_outputs
from linkages.input.model.experiment import Experiment, load_experiment, value_unit
from linkages.input.model.mechanism import Mechanism, faults_of_values, is_inertial, load_mechanism
from linkages.laws import Registered, registered, restore
from linkages.mechanics.planar.arrays import Arrays
from linkages.mechanics.planar.elimination import Elimination, elimination_of
from linkages.system.assembly import Assembly, assemble, balanced, independent, locking_couplings
from linkages.system.beam_records import beam_records
from linkages.system.deflection import deflected
from linkages.system.equilibrium import resting_offsets
from linkages.system.feedforward import with_feedforward
from linkages.system.lightness import check_lightness, first_alone
from linkages.system.load_records import Packed, pack_loads
from linkages.system.tree import Tree
from linkages.system.unassembled import Unassembled


@dataclass(frozen=True, eq=False, repr=False)
class System(Unassembled):
    """A mechanism and an experiment that fit each other, as plain arrays.

    Use `load` to make one from files and `replaced` to vary values. Each property is computed at its first use and then
    kept. nc is the number of contacts: a journal with clearance is one, a guide with clearance has four.

    Attributes
    ----------
    mechanism : Mechanism
    experiment : Experiment

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

    _twin: System | None = field(default=None, repr=False)

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
        with names_first(lambda: self.mechanism):
            experiment = self.experiment.replaced(values, origin)
        machine = [path.removeprefix("sdf.") for path in values if path.partition(".")[0] == "sdf"]
        with faults_of_values(experiment):
            if "mechanism" in values:
                mechanism = load_mechanism(experiment.mechanism_path, experiment.sdf_overrides)
            else:
                mechanism = self.mechanism.replaced(experiment.sdf_overrides, machine)
        offsets = [{name: e.joints[name].offset for name in e.play} for e in (experiment, self.experiment)]
        experiment = without_lost_outputs(mechanism, experiment, values)
        same_start = all(map(keeps_start, values)) and offsets[0] == offsets[1] and experiment.start == "centred"
        same_start = same_start and not experiment.flexible
        return System(mechanism, experiment, (self._twin or self) if same_start else None, _memory=self._memory)

    def ideal(self) -> System:
        """Return the system with every joint ideal and every link rigid.

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
        unit = value_unit(path) or self.mechanism.units.get(path.removeprefix("sdf."), "")
        if path.startswith("values."):
            return si_unit(str(self.experiment.texts.get(path)))
        kind, _, rest = path.partition(".")
        name = rest.partition(".")[0]
        tables = getattr(self.experiment, kind, None)
        table = tables.get(name) if isinstance(tables, Mapping) else None
        joint = self.mechanism.joint.get(getattr(table, "joint", None) or name) if table is not None else None
        return SLIDING.get(unit, unit) if joint is not None and joint.type == "prismatic" else unit

    @cached_property
    def tree(self) -> Tree:
        """Build the spanning tree, or take the tree of a system that differs in the laws of joints alone."""
        twin = self._twin
        return twin.tree if twin is not None and twin.mechanism is self.mechanism else super().tree

    # -- assembly ----------------------------------------------------------------------------------

    @cached_property
    def motion_rate(self) -> float:
        """Estimate the rate of the motion before a run [rad/s]."""
        return self.drive_rate if self.drive_rate > 0.0 else self.swing_rate(self.assembly.v)

    @cached_property
    def assembly(self) -> Assembly:
        """Assemble the ideal linkage at t = 0, with consistent velocities; AssemblyError if this is impossible."""
        if self._twin is not None:
            return self._twin.assembly
        whole = partial(assemble, self.tree, self.experiment, self.motions, self.packed)
        resting = self.experiment.start == "equilibrium" and self.tree.play
        straight = whole(resting_offsets(self, whole)) if resting else whole()
        check_lightness(self.tree, self._given_masses, straight.q)
        return deflected(self, straight) if self.tree.flexible else straight

    @cached_property
    def locking_couplings(self) -> list[int]:
        """Find the couplings, by index, that contradict each other or the loops; see `assembly.locking_couplings`."""
        return locking_couplings(self.tree, self.tree.loop_rows, self.assembly.q)

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
        return self.mechanism.with_inertial(self.rotors)

    @property
    def determinate(self) -> bool:
        """Check whether the prescribed drives alone determine the ideal motion, and no states its forces."""
        return self.assembly.mobility == len(self.tree.driven) and not self.experiment.own_states

    @cached_property
    def packed(self) -> Packed:
        """Return elements and applied loads as records of the kernels."""
        return pack_loads(self.tree, self.experiment, with_feedforward(self))

    # -- arrays of the kernels ---------------------------------------------------------------------------------

    @cached_property
    def arrays(self) -> Arrays:
        """Return all arrays that kernels read; systems that differ in the laws of joints alone share the others."""
        tree, twin = self.tree, self._twin
        joints = self.laws, self.tables, self.largest_ratios, self.touching.astype(np.int64), self.law_states.places
        if twin is not None and self._differs_in_laws_alone:
            names = "ends", "laws", "tables", "limits", "touching", "law_states"
            own: dict[str, Any] = dict(zip(names, map(np.ascontiguousarray, (self.ends, *joints)), strict=True))
            return twin.arrays._replace(**own)
        moved = tree.driven_dofs, tree.powered_dofs
        dofs = tree.free_dofs, *moved, *map(tree.bodies_of, moved)
        applied = *self.motions.arrays, *self.torques.arrays, *self.loads, *beam_records(tree), self.gravity
        # calls by address assume contiguous arrays without a check
        rest = map(np.ascontiguousarray, (self.ends, tree.joint_records(), *joints, *dofs, *applied))
        bodies = tree.bodies, tree.stiff_bodies(self.motion_rate) if tree.flexible else tree.bodies
        return Arrays._make(
            [*bodies, *self._closed_by(tree.loop_rows, tree.free_dofs), *rest, self.elements, tree.extent]
        )

    @property
    def _differs_in_laws_alone(self) -> bool:
        """Whether nothing but the laws of joints differs from the twin."""
        return self._twin is not None and self._twin.tree is self.tree

    def _closed_by(self, rows: Records, free: NDArray[np.int64]) -> tuple[Records, Elimination]:
        """Return the rows, and how their reactions are eliminated in free coordinates."""
        if not len(rows):
            return rows, elimination_of(self.tree.bodies, rows, 0, free)
        rank = independent(self.tree, rows, self.assembly.q, free)
        elimination = elimination_of(self.tree.bodies, rows, rank, free)
        return np.ascontiguousarray(balanced(self.tree, rows, self.assembly.q)), elimination

    @cached_property
    def ideal_arrays(self) -> Arrays:
        """Return the same arrays with every joint ideal, closed by `Tree.closure_rows`."""
        tree = self.tree
        rows, elimination = self._closed_by(tree.closure_rows, tree.closing_dofs)
        return self.arrays._replace(
            rows=rows,
            elimination=elimination,
            ends=self.ends[:0],
            joints=tree.joint_records(ideal=True),
            free=tree.closing_dofs,
        )

    @property
    def stiff(self) -> bool:
        """Check whether films, states of laws or modes make the equations stiff; dry contact does not."""
        return (
            any(model.has_film for model in self.models) or len(self.law_states.names) > 0 or bool(self.tree.flexible)
        )


def load(path: str | Path, overrides: Mapping[str, Any] | None = None, origin: str = ARGUMENT) -> System:
    """Read an experiment and its mechanism, and check their consistency.

    Parameters
    ----------
    path : str or Path
        The TOML file.
    overrides : mapping, optional
        Values by dotted path that override the files; see `System.replaced`.
    origin : str
        Origin of the overrides, named in errors and as the source of their values.

    Raises
    ------
    InputError
        If the input is invalid: one line with file, element or key, and reason.

    Examples
    --------
    >>> import linkages
    >>> system = linkages.load(linkages.find_file("seven_bar.toml"), {"duration": 0.5})
    >>> system.experiment.duration
    0.5
    """
    with names_first(lambda: _mechanism_of(Path(path), overrides or {})):
        experiment = load_experiment(path, overrides, origin)
    with faults_of_values(experiment):
        mechanism = load_mechanism(experiment.mechanism_path, experiment.sdf_overrides)
    return System(mechanism, without_lost_outputs(mechanism, experiment, overrides or ()))


def _mechanism_of(path: Path, overrides: Mapping[str, Any]) -> Mechanism:
    """Return the mechanism of an experiment's file that may be faulty."""
    data = read_toml(path)[0] | dict(overrides)
    return load_mechanism(path.parent / str(data.get("mechanism", "")))


def _restored(mechanism: Mechanism, experiment: Experiment, laws: tuple[Registered, ...]) -> System:
    restore(laws)
    return System(mechanism, experiment)


def keeps_start(path: str) -> bool:
    """Check whether a path names a mass or a joint's law, which do not affect the start."""
    if path.startswith("sdf."):
        return is_inertial(path.removeprefix("sdf."))
    return path.startswith("joints.") and ".offset" not in path
