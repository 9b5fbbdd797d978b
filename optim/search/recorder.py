"""Evaluations and iterations of an algorithm, kept in a store: it can be stopped at any moment and resumed.

Resuming is replaying: the algorithm starts from its seed again, and evaluations that the store holds are not computed
anew. Each iteration is compared with the stored one. So an interrupted study ends with the same bytes as any other.
"""

from __future__ import annotations

import dataclasses
import json
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from linkages import InputError, RunError
from linkages.input.files.toml import leaves
from linkages.input.files.writing import locked
from optim.algorithms.nlp import Problem, Progress, Report, Result, Values
from optim.evaluate.evaluations import Evaluations
from optim.problem.study import Array
from optim.search.known_designs import KnownDesigns
from optim.store.store import Iteration, Store, create, open_store


@contextmanager
def recording(
    path: Path, identity: Mapping[str, Any], evaluate: Callable[[Array], Evaluations], resume: bool = False
) -> Iterator[Recorder]:
    """Create a store, ``study.sqlite``, or with `resume` open it and check that it is of the same study.

    The identity has JSON types: ``task``, everything that determines the numbers, algorithm and seed among them;
    ``versions`` of the packages that determine them; ``variables``, ``objectives`` and ``constraints``, names of the
    store's columns. `evaluate` returns evaluations of designs (m, n), each independent of the other designs.

    InputError if the store is in use, damaged, of another study or version, or exists without `resume`; RunError if the
    disk is full.
    """
    with locked(path.with_name(path.name + ".lock"), path), _opened(path, identity, resume) as store:
        yield Recorder(store, evaluate)


def _opened(path: Path, identity: Mapping[str, Any], resume: bool) -> Store:
    """Create the store, or open it and check that it belongs to this study."""
    if not path.exists():
        return create(path, {**identity, "elapsed": 0.0})
    store = open_store(path)
    try:
        _check_same(store, identity)
        if not resume:
            problem = f"holds {store.count()[0]} evaluations of this study"
            raise InputError(path, "", f"{problem}; continue with --resume, or give another --out")
    except BaseException:
        store.close()
        raise
    return store


def _check_same(store: Store, identity: Mapping[str, Any]) -> None:
    """Refuse a store of another study, algorithm, seed or version, by an error that names the first difference."""
    old, new = dict(leaves(store.meta("task"))), dict(leaves(json.loads(json.dumps(identity["task"]))))
    for key in (*new, *old):
        if key not in old or key not in new or old[key] != new[key]:
            problem = f"belongs to another study: there {_short(old.get(key))}, here {_short(new.get(key))}"
            raise InputError(store.path, key, f"{problem}; give another --out")
    there, here = store.meta("versions"), identity["versions"]
    for package in sorted({*there, *here}):
        a, b = there.get(package, "not there"), here.get(package, "not there")
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


class Recorder:
    """Evaluates each design once, stores it, and compares the replay with the store."""

    def __init__(self, store: Store, evaluate: Callable[[Array], Evaluations]) -> None:
        self.store, self._compute = store, evaluate
        self._begin: Callable[[Array], Callable[[], Evaluations]]
        self._begin = getattr(evaluate, "begin", lambda designs: lambda: evaluate(designs))
        self._known = KnownDesigns(len(store.objectives), len(store.constraints))
        self._under_way: deque[tuple[set[bytes], Callable[[], None]]] = deque()
        self._asked: dict[bytes, None] = {}  # in the order of asking
        self._steps = 0
        self._since = time.monotonic() - store.meta("elapsed")
        self._known.add(*store.evaluations())

    @property
    def elapsed(self) -> float:
        """Time spent on the study, by this process and earlier ones [s]."""
        return time.monotonic() - self._since

    def asked(self, first: int) -> Array:
        """Return the designs (m, n) that were asked for, in this order, without the first ones."""
        return np.array([np.frombuffer(key) for key in [*self._asked][first:]])

    def evaluate(self, designs: Array) -> Evaluations:
        """Return evaluations of designs (m, n); unknown ones are computed in one population."""
        found = self.begin(designs)()
        self._asked |= dict.fromkeys(row.tobytes() for row in np.ascontiguousarray(designs, dtype=np.float64))
        return found

    def begin(self, designs: Array) -> Callable[[], Evaluations]:
        """Begin to compute designs (m, n); the returned function waits for their evaluations.

        Populations are stored in the order in which they were begun.
        """
        designs = np.ascontiguousarray(designs, dtype=np.float64)
        keys = [design.tobytes() for design in designs]
        begun = set().union(*(others for others, _ in self._under_way))
        fresh = {k: row for k, row in zip(keys, designs, strict=True) if k not in self._known and k not in begun}
        if fresh:
            rows = np.array(list(fresh.values()))
            answer = self._begin(rows)
            self._under_way.append((set(fresh), lambda: self._add(rows, answer())))

        def wait() -> Evaluations:
            while not all(key in self._known for key in keys):
                self._under_way[0][1]()
                self._under_way.popleft()
            return self._known.evaluations(keys)

        return wait

    def _add(self, designs: Array, found: Evaluations) -> None:
        """Store new evaluations."""
        self.store.add(designs, found, self.elapsed)
        self._known.add(designs, found)

    def minimise(
        self, problem: Problem, algorithm: Callable[[Problem, Report], Result], observe: Callable[[Iteration], None]
    ) -> Result:
        """Run an algorithm, with its settings and seed, whose problem evaluates through `evaluate`.

        `observe` is called after every iteration; what it raises ends the algorithm. RunError if the disk is full, or
        the replay differs from the store.
        """

        @_leaving()
        def values(designs: Array) -> Values:
            return problem.evaluate(designs)

        @_leaving()
        def report(at: Progress) -> None:
            observe(self._keep(at))

        try:
            result = algorithm(dataclasses.replace(problem, evaluate=values), report)
        except _Leave as leave:
            raise leave.args[0] from None
        if result.status == "interrupted":  # an algorithm may end so at a second Ctrl-C
            raise KeyboardInterrupt
        return result

    def _keep(self, at: Progress) -> Iteration:
        """Store an iteration, or compare it with the stored one."""
        self._steps += 1
        best, state = np.atleast_2d(at.best), json.dumps(at.state, sort_keys=True)
        asked, objectives, violation = self._known.asked, at.values.objectives, at.values.violation
        row = Iteration(self._steps, at.iteration, at.iterations, asked, best, objectives, violation, state)
        kept = self.store.iteration(row.step)
        if kept is None:
            self.store.add_iteration(row, self.elapsed)
        elif not kept.same(row):
            raise RunError(
                f"{self.store.path}: iteration {at.iteration} does not come out as it was stored: other code or another"
                " computer made it; the store is left as it is: give another --out"
            )
        return row
