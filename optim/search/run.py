"""Runs an algorithm over a store, so that it can be stopped at any moment and resumed.

Resuming is replaying: the algorithm starts from its seed again, and evaluations that the store holds are not computed
anew. Each iteration is compared with the stored one. So an interrupted study ends with the same bytes as any other.
"""

from __future__ import annotations

import dataclasses
import json
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from linkages import InputError, RunError
from linkages.files.toml import leaves
from linkages.files.writing import locked
from optim.algorithms import nlp
from optim.evaluate.evaluations import Evaluations
from optim.problem.study import Array
from optim.store.store import Iteration, Store, create, open_store

Evaluate = Callable[[Array], Evaluations]
Observer = Callable[[Iteration, nlp.Values], None]


@dataclass(frozen=True)
class Task:
    """An optimisation over a store: the problem, and the evaluation of designs.

    Attributes
    ----------
    description : dict
        JSON types: everything that determines the numbers, algorithm and seed among them.
    versions : dict
        Versions of the packages that determine the numbers.
    variables, objectives, constraints : tuples of str
        Names of the store's columns.
    nominal : (n,) array
        Evaluated first: relative quantities are divided by its values.
    evaluate : callable
        Evaluations of designs (m, n); independent of the other designs.
    problem : callable
        From a function that evaluates through the store, and the evaluations of the nominal design, to the problem
        that the algorithm sees.
    minimise : callable
        The algorithm with its settings and seed.
    """

    description: dict[str, Any]
    versions: dict[str, str]
    variables: tuple[str, ...]
    objectives: tuple[str, ...]
    constraints: tuple[str, ...]
    nominal: Array
    evaluate: Evaluate
    problem: Callable[[Evaluate, Evaluations], nlp.Problem]
    minimise: Callable[[nlp.Problem, Callable[[nlp.Progress], None]], nlp.Result]


@dataclass(frozen=True)
class Outcome:
    """A finished run.

    Attributes
    ----------
    result : Result
        Output of the algorithm.
    found, nominal : Evaluations
        Evaluations of the designs that it found, and of the nominal design.
    evaluations : int
        Designs in the store.
    failures : dict
        Designs without values by status, infeasible ones that were not run among them.
    elapsed : float
        Time spent by this process and earlier ones [s].
    """

    result: nlp.Result
    found: Evaluations
    nominal: Evaluations
    evaluations: int
    failures: dict[str, int]
    elapsed: float


class Stopped(Exception):  # noqa: N818 (it is not an error)
    """The run was stopped after an iteration; the store holds all of it."""

    def __init__(self, iteration: int) -> None:
        super().__init__(f"stopped after iteration {iteration}")
        self.iteration = iteration


def run(
    task: Task,
    path: Path,
    resume: bool = False,
    observe: Observer | None = None,
    stop: Callable[[], bool] = lambda: False,
) -> Outcome:
    """Run a task, or resume it.

    Parameters
    ----------
    task : Task
    path : Path
        The store, ``study.sqlite``.
    resume, observe, stop
        As of `optim.optimise`.

    Raises
    ------
    InputError
        If the store is in use, damaged, of another task or version, or exists without `resume`.
    RunError
        If the disk is full, or the replay differs from the store.
    Stopped
        If `stop` said so.
    """
    with locked(path.with_name(path.name + ".lock"), path), _opened(task, path, resume) as store:
        recorder = _Recorder(task, store, observe, stop)
        nominal = recorder.evaluate(task.nominal[None])
        recorder.problem = task.problem(recorder.evaluate, nominal)
        seen = dataclasses.replace(recorder.problem, evaluate=recorder.values)
        try:
            result = task.minimise(seen, recorder.progress)
        except _Leave as leave:
            raise leave.args[0] from None
        if result.status == "interrupted":  # an algorithm may end so at a second Ctrl-C
            raise KeyboardInterrupt
        found = recorder.evaluate(np.atleast_2d(result.x))
        return Outcome(result, found, nominal, *store.count(), recorder.elapsed)


def _opened(task: Task, path: Path, resume: bool) -> Store:
    """Create the store, or open it and check that it belongs to this task."""
    if not path.exists():
        meta = {
            "task": task.description,
            "versions": task.versions,
            "variables": task.variables,
            "objectives": task.objectives,
            "constraints": task.constraints,
            "elapsed": 0.0,
        }
        return create(path, meta)
    store = open_store(path)
    try:
        _check_same(task, store)
        if not resume:
            problem = f"holds {store.count()[0]} evaluations of this study"
            raise InputError(path, "", f"{problem}; continue with --resume, or give another --out")
    except BaseException:
        store.close()
        raise
    return store


def _check_same(task: Task, store: Store) -> None:
    """Refuse a store of another study, algorithm, seed or version, by an error that names the first difference."""
    here = json.loads(json.dumps(task.description))
    old, new = dict(leaves(store.meta("task"))), dict(leaves(here))
    for key in (*new, *old):
        if key not in old or key not in new or old[key] != new[key]:
            problem = f"belongs to another study: there {_short(old.get(key))}, here {_short(new.get(key))}"
            raise InputError(store.path, key, f"{problem}; give another --out")
    there = store.meta("versions")
    for package in sorted({*there, *task.versions}):
        a, b = there.get(package, "not there"), task.versions.get(package, "not there")
        if a != b and package != "python":
            problem = f"was written with {package} {a}, this is {b}, and the numbers would be mixed"
            raise InputError(store.path, "", f"{problem}; install that version, or give another --out")


def _short(value: Any) -> str:
    text = "nothing" if value is None else json.dumps(value)
    return text if len(text) < 60 else text[:57] + "..."


class _Leave(BaseException):
    """Carries an exception through algorithms and libraries that catch every `Exception`."""


@contextmanager
def _leaving() -> Iterator[None]:
    try:
        yield
    except Exception as why:
        raise _Leave(why) from why


@dataclass
class _Recorder:
    """Evaluates each design once, stores it, and compares the replay with the store."""

    task: Task
    store: Store
    observe: Observer | None
    stop: Callable[[], bool]
    problem: nlp.Problem = field(init=False)
    _known: dict[bytes, tuple[Array, Array, str, str]] = field(default_factory=dict)
    _asked: set[bytes] = field(default_factory=set)
    _steps: int = 0

    def __post_init__(self) -> None:
        self._since = time.monotonic() - self.store.meta("elapsed")
        self._remember(*self.store.evaluations())

    @property
    def elapsed(self) -> float:
        """Time spent on the study, by this process and earlier ones [s]."""
        return time.monotonic() - self._since

    def evaluate(self, designs: Array) -> Evaluations:
        """Return evaluations of designs (m, n); unknown ones are computed in one population."""
        designs = np.ascontiguousarray(designs, dtype=np.float64)
        keys = [design.tobytes() for design in designs]
        fresh = {key: row for key, row in zip(keys, designs, strict=True) if key not in self._known}
        if fresh:
            rows = np.array(list(fresh.values()))
            found = self.task.evaluate(rows)
            self.store.add(rows, found, self.elapsed)
            self._remember(rows, found)
        self._asked.update(keys)
        f, g, status, reason = zip(*(self._known[key] for key in keys), strict=True)
        return Evaluations(np.array(f), np.array(g).reshape(len(keys), -1), status, reason)

    @_leaving()
    def values(self, designs: Array) -> nlp.Values:
        """Evaluate for the algorithm."""
        return self.problem.evaluate(designs)

    @_leaving()
    def progress(self, at: nlp.Progress) -> None:
        """Store an iteration, or compare it with the stored one."""
        self._steps += 1
        best, state = np.atleast_2d(at.best), json.dumps(at.state, sort_keys=True)
        asked, objectives, violation = len(self._asked), at.values.objectives, at.values.violation
        row = Iteration(self._steps, at.iteration, at.iterations, asked, best, objectives, violation, state)
        kept = self.store.iteration(row.step)
        if kept is None:
            self.store.add_iteration(row, self.elapsed)
        elif not kept.same(row):
            raise RunError(
                f"{self.store.path}: iteration {at.iteration} does not come out as it was stored: other code or another"
                " computer made it; the store is left as it is: give another --out"
            )
        if self.observe is not None:
            self.observe(row, self.problem.evaluate(self.task.nominal[None]))
        if self.stop():
            raise Stopped(at.iteration)

    def _remember(self, designs: Array, found: Evaluations) -> None:
        rows = zip(found.objectives, found.constraints, found.status, found.reason, strict=True)
        self._known |= {design.tobytes(): row for design, row in zip(designs, rows, strict=True)}
