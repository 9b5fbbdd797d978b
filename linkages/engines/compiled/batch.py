"""Many runs of one experiment that differ in some values: summaries, not trajectories."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.engines.compiled.runner import STATUS, Machine, join
from linkages.engines.compiled.statistics import STATISTICS
from linkages.errors import InputError, Status
from linkages.model.experiment import Experiment, check
from linkages.model.mechanism import Mechanism, load_mechanism
from linkages.outputs.signals import default_outputs, pack_signals
from linkages.planar.ideal import make_ideal
from linkages.system.assembly import Assembly, AssemblyError, assemble, tree_of, with_other_masses

Array = NDArray[np.float64]

_MOST_STEPS = 20_000_000  # of one run


@dataclass(frozen=True)
class Batch:
    """Summaries of m runs: nw windows, no outputs.

    Attributes
    ----------
    variables : tuple of str
        Dotted paths that differ between the runs.
    values : (m, nv) array
    outputs : tuple of str
        See `linkages.outputs.signals`.
    windows : (nw, 2) array
        Times [s].
    minimum, maximum, time_of_minimum, time_of_maximum, mean, rms : (m, nw, no) arrays
        Over continuous time within each window; NaN where the run failed.
    status : list of Status
    reason : list of str
        Why a run failed, empty otherwise.
    steps : (m,) array of int
    """

    variables: tuple[str, ...]
    values: Array
    outputs: tuple[str, ...]
    windows: Array
    minimum: Array
    maximum: Array
    time_of_minimum: Array
    time_of_maximum: Array
    mean: Array
    rms: Array
    status: list[Status]
    reason: list[str]
    steps: NDArray[np.int64]

    @property
    def peak(self) -> Array:
        """Largest magnitude, (m, nw, no)."""
        return np.maximum(np.abs(self.minimum), np.abs(self.maximum))


def simulate_batch(
    mechanism: Mechanism,
    experiment: Experiment,
    variables: Sequence[str] = (),
    values: Any = None,
    outputs: Sequence[str] | None = None,
    windows: Any = None,
    threads: int | None = None,
) -> Batch:
    """Run an experiment many times with different values, in parallel threads.

    Parameters
    ----------
    mechanism, experiment
        The nominal ones.
    variables : sequence of str
        Dotted paths of the experiment; of the mechanism with ``sdf.`` before them (``sdf.links.rod.mass``).
    values : (m, nv) array_like
        One line for each run; default a single run with the nominal values.
    outputs : sequence of str, optional
        Names of `linkages.outputs.signals`; default the experiment's outputs, forces and eccentricities of the
        contacts, torques of the drives.
    windows : (nw, 2) array_like, optional
        Times between which outputs are summarised [s]; default the whole run.
    threads : int, optional
        Default as many as there are processors. The results do not depend on it.

    Returns
    -------
    Batch
        A run that cannot start or does not reach its end has a status in its row, and NaN for results.

    Raises
    ------
    InputError
        If a path, an output or a window is not valid for the nominal experiment.
    """
    check(mechanism, experiment)
    table = np.zeros((1, 0)) if values is None else np.array(values, dtype=np.float64, ndmin=2)
    if table.shape[1] != len(variables):
        raise InputError(
            "argument",
            "values",
            f"have {table.shape[1]} columns for {len(variables)} variables; give as many",
        )
    nominal = tree_of(mechanism, experiment)
    names = tuple(outputs) if outputs is not None else default_outputs(nominal, experiment)
    pack_signals(nominal, experiment, names)
    spans = np.array([[0.0, experiment.duration]] if windows is None else windows, dtype=np.float64, ndmin=2)
    if spans.shape[1] != 2 or not np.all((spans[:, 0] >= 0) & (spans[:, 0] < spans[:, 1])):
        raise InputError(
            "argument", "windows", "must be pairs of times, each a start at or after 0 and a later end"
        )
    designs = _Designs(mechanism, experiment, tuple(variables))
    designs.check_paths(table)
    shape = (len(table), len(spans), len(names), len(STATISTICS))
    found = np.full(shape, np.nan)
    status = [Status.OK] * len(table)
    reason = [""] * len(table)
    steps = np.zeros(len(table), dtype=np.int64)

    def one(i: int) -> None:
        status[i], reason[i], steps[i] = designs.run(table[i], names, spans, found[i])

    if threads == 1 or len(table) == 1:
        for i in range(len(table)):
            one(i)
    else:
        with ThreadPoolExecutor(threads or os.cpu_count() or 1) as pool:
            list(pool.map(one, range(len(table))))
    statistics = {name: found[..., k] for k, name in enumerate(STATISTICS)}
    return Batch(
        variables=tuple(variables),
        values=table,
        outputs=names,
        windows=spans,
        status=status,
        reason=reason,
        steps=steps,
        **statistics,
    )


class _Designs:
    """Makes and runs the designs of a batch."""

    def __init__(self, mechanism: Mechanism, experiment: Experiment, variables: tuple[str, ...]) -> None:
        self.mechanism, self.experiment, self.variables = mechanism, experiment, variables
        self._same_positions = all(_keeps_positions(name) for name in variables)
        self._nominal: Assembly | None = None
        base = mechanism.source
        self._load = lru_cache(maxsize=256)(lambda items: load_mechanism(base, dict(items)))

    def check_paths(self, table: Array) -> None:
        """See that all paths exist: values out of range are the designs' own failures."""
        for name in self.variables:
            if name.startswith("sdf."):
                load_mechanism(
                    self.mechanism.source, {name.removeprefix("sdf."): _probe(table, self.variables, name)}
                )
            else:
                self.experiment.replaced({name: _probe(table, self.variables, name)})

    def variant(self, line: Array) -> tuple[Mechanism, Experiment]:
        """Return the mechanism and the experiment of one design."""
        given = dict(zip(self.variables, map(float, line), strict=True))
        inner = {name: value for name, value in given.items() if not name.startswith("sdf.")}
        experiment = self.experiment.replaced(inner) if inner else self.experiment
        sdf = {name.removeprefix("sdf."): value for name, value in given.items() if name.startswith("sdf.")}
        if not sdf:
            return self.mechanism, experiment
        inertial = {name: value for name, value in sdf.items() if _is_inertial(name, value)}
        rest = self.experiment.sdf_overrides | {k: v for k, v in sdf.items() if k not in inertial}
        mechanism: Mechanism = self._load(tuple(sorted(rest.items())))
        return _with_inertial(mechanism, inertial), experiment

    def _assembly(self, mechanism: Mechanism, experiment: Experiment) -> Assembly:
        if not self._same_positions:
            return assemble(mechanism, experiment)
        if self._nominal is None:
            self._nominal = assemble(self.mechanism, self.experiment)
        return with_other_masses(self._nominal, mechanism, experiment)

    def run(self, line: Array, names: tuple[str, ...], windows: Array, out: Array) -> tuple[Status, str, int]:
        """Run one design; fills the statistics (nw, no, ns)."""
        try:
            mechanism, experiment = self.variant(line)
            check(mechanism, experiment)
            if np.any(windows[:, 1] > experiment.duration * (1.0 + 1e-12)):
                return Status.BAD_INPUT, "a window ends after the run", 0
            assembly = self._assembly(mechanism, experiment)
            machine = Machine(assembly, experiment)
            signals = pack_signals(assembly.tree, experiment, names)
        except InputError as problem:
            return Status.BAD_INPUT, str(problem), 0
        except AssemblyError as problem:
            return problem.status, str(problem), 0
        record = machine.run(0.0, machine.start, machine.first_step, _MOST_STEPS)
        status = STATUS.get(record.status, Status.STEP_SIZE_COLLAPSE)
        if status is not Status.OK:
            where = f"ended at t = {record.times[-1]:.6g} s"
            return status, f"{status.value}: {where}; {status.remedy}", record.steps
        tree = assembly.tree
        ideal = make_ideal(tree.closure_rows, len(tree.bodies), tree.size)
        spans = np.minimum(windows, experiment.duration)
        if not machine.summarise(ideal, signals, join([record]), spans, out):
            out[...] = np.nan
            status = Status.NO_ASSEMBLY
            return status, f"{status.value}: the ideal linkage does not close; {status.remedy}", record.steps
        return status, "", record.steps


def _probe(table: Array, variables: tuple[str, ...], name: str) -> float:
    """Return a finite value of a variable, to see whether its path exists."""
    column = table[:, variables.index(name)]
    finite = column[np.isfinite(column)]
    return float(finite[0]) if len(finite) else 1.0


def _keeps_positions(name: str) -> bool:
    """Whether a variable changes masses or joint laws, and not where the linkage is at t = 0."""
    if name.startswith("sdf."):
        return name.endswith((".mass", ".inertia"))
    return name.startswith("joints.") and ".offset" not in name


def _is_inertial(name: str, value: float) -> bool:
    """Whether an override changes the mass or the inertia of a link to a value that needs no further check."""
    return name.startswith("links.") and name.endswith((".mass", ".inertia")) and 0.0 < value < np.inf


def _with_inertial(mechanism: Mechanism, overrides: Mapping[str, float]) -> Mechanism:
    """Return the mechanism with masses and inertias replaced: without reading its file again."""
    if not overrides:
        return mechanism
    links = []
    for link in mechanism.links:
        mass = overrides.get(f"links.{link.name}.mass", link.mass)
        inertia = overrides.get(f"links.{link.name}.inertia", link.inertia)
        links.append(replace(link, mass=mass, inertia=inertia))
    return replace(mechanism, links=tuple(links))
