"""`optimise`: solve a study; a result can start another one."""

from __future__ import annotations

import dataclasses
import json
import math
import tempfile
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np

from linkages import InputError
from linkages.base.arguments import Vector, Whole, validated
from linkages.base.errors import nearest
from optim.algorithms.nlp import Values
from optim.evaluate.evaluator import Evaluator, Screened
from optim.evaluate.gradients import Gradients
from optim.evaluate.limits import problem_of, values_of
from optim.problem.study import Array, Study
from optim.search.recorder import recording
from optim.search.result import Solution, StudyResult, result_of
from optim.search.task import task_of
from optim.store.store import Iteration


class Stopped(Exception):  # noqa: N818 (it is not an error)
    """The run was stopped after an iteration; the store holds all of it.

    Attributes
    ----------
    iteration : int
        Number of the iteration.
    """

    def __init__(self, iteration: int) -> None:
        super().__init__(f"stopped after iteration {iteration}")
        self.iteration = iteration


@validated
def optimise(
    study: Study,
    store: Path | None = None,
    *,
    algorithm: str | Mapping[str, Any] | None = None,
    seed: Whole | None = None,
    start: Vector | None = None,
    evaluator: Evaluator | None = None,
    resume: bool = False,
    observe: Callable[[Iteration, Values], None] | None = None,
    stop: Callable[[], bool] = lambda: False,
) -> StudyResult:
    """Solve a study.

    Parameters
    ----------
    study : Study
    store : Path, optional
        File that keeps every evaluation, ``study.sqlite``; default a temporary one.
    algorithm : str or mapping, optional
        Its name, or a table of its name and settings; default the study's.
    seed : int, optional
        Default the study's.
    start : (n,) array, optional
        Where the search begins; default the nominal design.
    evaluator : Evaluator, optional
        Default one that runs here, in all threads.
    resume : bool
        Whether the store may exist; it must be of the same study, algorithm, start and seed.
    observe : callable, optional
        Called after every iteration with an `Iteration` and the `Values` of the designs that were evaluated since the
        last call, in their order; the very first one is the nominal design.
    stop : callable, optional
        Asked after every iteration whether to stop.

    Returns
    -------
    StudyResult
        Attributes and keys of ``result.json``, SI units; relative quantities are multiples of the nominal design's. See
        docs/study_files.md.

    Raises
    ------
    InputError
        If the study's algorithm cannot solve it, or the store cannot be used.
    RunError
        If the disk is full, relative quantities have no nominal value, or a replay differs from the store.
    Stopped
        If `stop` said so.

    Examples
    --------
    >>> import optim
    >>> study = optim.load_study(optim.find_study("sevenbar_force"))
    >>> result = optim.optimise(study, algorithm={"name": "ga", "population": 6, "generations": 3})
    >>> result.best.objectives["force"] < result.nominal.objectives["force"]
    True
    """
    if algorithm is not None:
        table = {"name": algorithm} if isinstance(algorithm, str) else dict(algorithm)
        study = dataclasses.replace(study, file=study.file.model_copy(update={"algorithm": table}))
    task = task_of(study, seed, start)
    evaluator = Evaluator(study) if evaluator is None else evaluator
    screened = Screened(study, evaluator, task.step)

    told = 0

    def observed(row: Iteration) -> None:
        nonlocal told
        if observe is not None:
            fresh = recorder.asked(told)
            told += len(fresh)
            observe(row, values_of(study, recorder.evaluate(fresh.reshape(-1, len(study.names))), nominal))
        if stop():
            raise Stopped(row.iteration)

    with ExitStack() as stack:
        if store is None:
            store = Path(stack.enter_context(tempfile.TemporaryDirectory())) / "study.sqlite"
        recorder = stack.enter_context(recording(store, task.identity, screened, resume))
        nominal, jacobian = recorder.evaluate(study.nominal[None]), None
        if task.by_sensitivities:
            jacobian = Gradients(study, recorder.evaluate, nominal, evaluator.threads)
        problem = dataclasses.replace(problem_of(study, recorder.evaluate, nominal, start), jacobian=jacobian)
        found = recorder.minimise(problem, task.minimise, observed)
        solution = Solution(found, recorder.evaluate(np.atleast_2d(found.x)), *recorder.store.count(), recorder.elapsed)
    return result_of(study, task, solution, nominal, evaluator)


def start_of(study: Study, path: Path, source: str = "--start") -> Array:
    """Read the best design of a finished study as a start for this one.

    Parameters
    ----------
    study : Study
        The study that will be solved.
    path : Path
        A ``result.json`` of ``linkages optimise``, or the folder that holds it.
    source : str
        What errors name.

    Returns
    -------
    (n,) array
        Values of this study's variables, SI units; variables that only this study has are nominal.

    Raises
    ------
    InputError
        If there is no such result, it varies what this study does not, or its design is outside the bounds here.

    Examples
    --------
    >>> import json, pathlib, tempfile
    >>> import optim
    >>> study = optim.load_study(optim.find_study("sevenbar_force"))
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "result.json"
    >>> _ = file.write_text(json.dumps({"best": {"variables": {"joints.A.viscosity": 0.3}}}))
    >>> float(optim.start_of(study, file)[-1])
    0.3
    """
    file = path / "result.json" if path.is_dir() else path
    found = _variables(file, source)
    for key in found:
        if key not in study.paths:
            near = nearest(key, study.paths)
            raise InputError(source, str(file), f"varies {key}, {study.source.name} does not; {near}")
    start = np.array([found.get(key, x) for key, x in zip(study.paths, study.nominal, strict=True)])
    for key, x, lower, upper in zip(study.paths, start, study.lower, study.upper, strict=True):
        if not lower <= x <= upper:
            here = f"in {study.source.name} between {lower:g} and {upper:g}"
            raise InputError(source, str(file), f"{key} is {x:g}, {here}")
    return start


def _variables(file: Path, source: str) -> dict[str, float]:
    """Read the best design's variables by dotted path."""
    try:
        best: Any = json.loads(file.read_text(encoding="utf-8"))["best"]
        found = {key: float(value) for key, value in best["variables"].items()}
    except OSError:
        problem = "cannot be read; give the output folder of a finished linkages optimise"
        raise InputError(source, str(file), problem) from None
    except (ValueError, KeyError, TypeError, AttributeError):
        raise InputError(source, str(file), "is not a result.json of linkages optimise") from None
    if not all(map(math.isfinite, found.values())):
        raise InputError(source, str(file), "has a value that is not finite")
    return found
