"""`optimise`: solve a study; the content of ``result.json``."""

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
from linkages.base.arguments import Vector, Whole, fitting, validated
from linkages.base.errors import nearest
from linkages.input.files.toml import Table
from linkages.input.files.versions import versions
from linkages.input.files.writing import finite
from optim.algorithms import pareto
from optim.algorithms.derivatives import DIFFERENCES
from optim.algorithms.nlp import Values
from optim.algorithms.registry import ALGORITHMS, minimise, read_settings
from optim.evaluate.evaluations import INFEASIBLE, Evaluations
from optim.evaluate.evaluator import Evaluator, Screened
from optim.evaluate.gradients import Gradients, check_sensitivities
from optim.evaluate.limits import FEASIBLE, in_units, problem_of, values_of
from optim.problem.study import Array, Study
from optim.search.recorder import recording
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
) -> dict[str, Any]:
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
    dict
        The content of ``result.json``, SI units; relative quantities are multiples of the nominal design's. See
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
    >>> result["best"]["objectives"]["force"] < result["nominal"]["objectives"]["force"]
    True
    """
    if algorithm is not None:
        table = {"name": algorithm} if isinstance(algorithm, str) else dict(algorithm)
        study = dataclasses.replace(study, file=study.file.model_copy(update={"algorithm": table}))
    if start is not None:
        fitting(start, len(study.names), "start", "variables")
    seed = study.file.seed if seed is None else seed
    evaluator = Evaluator(study) if evaluator is None else evaluator
    name, settings = settings_of(study)
    by_sensitivities = getattr(settings, "derivatives", DIFFERENCES) != DIFFERENCES
    if by_sensitivities:
        check_sensitivities(study)
    identity = identity_of(study, seed, start)
    screened = Screened(study, evaluator, getattr(settings, "step", None))

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
        recorder = stack.enter_context(recording(store, identity, screened, resume))
        nominal = recorder.evaluate(study.nominal[None])
        problem = problem_of(study, recorder.evaluate, nominal, start)
        if by_sensitivities:
            gradients = Gradients(study, recorder.evaluate, nominal, evaluator.threads)
            problem = dataclasses.replace(problem, jacobian=gradients)
        found = recorder.minimise(problem, lambda seen, report: minimise(name, seen, settings, seed, report), observed)
        designs, elapsed = np.atleast_2d(found.x), recorder.elapsed
        evaluations, (count, failures) = recorder.evaluate(designs), recorder.store.count()
    unrun, several = failures.pop(INFEASIBLE, 0), len(study.file.objectives) > 1
    entries = _entries(study, designs, evaluations, nominal)
    references = np.array([*study.designs.values()])
    known = _entries(study, references, evaluator(references), nominal) if study.designs else []
    return {
        "study": study.source.stem,
        "title": study.title,
        "algorithm": {"name": name, **settings.model_dump(mode="json")},
        "labels": {name: study.label(name) for _, name, _ in study.quantities},
        "seed": seed,
        "start": None if start is None else dict(zip(study.paths, map(float, start), strict=True)),
        "status": found.status,
        "best": entries[compromise(values_of(study, evaluations, nominal).objectives) if several else 0],
        "front": entries if several else [],
        "nominal": _entries(study, study.nominal[None], nominal, nominal)[0],
        "designs": dict(zip(study.designs, known, strict=True)),
        "iterations": found.iterations,
        "evaluations": count,
        "unrun": unrun,
        "failed": sum(failures.values()),
        "failures": failures,
        "versions": identity["versions"],
        "wall_time": elapsed,
    }


def settings_of(study: Study) -> tuple[str, Table]:
    """Name and settings of a study's algorithm.

    InputError if there is no such algorithm, it has no such setting, or it cannot solve the problem.
    """
    given = dict(study.file.algorithm)
    name = given.pop("name", None)
    if not isinstance(name, str) or name not in ALGORITHMS:
        problem = "is missing" if name is None else f'"{name}" is unknown'
        near = nearest(str(name or ""), ALGORITHMS)
        raise InputError(study.source, "algorithm.name", f"{problem}; {near}")
    if len(study.file.objectives) > 1 and not ALGORITHMS[name].several:
        able = ", ".join(key for key, entry in ALGORITHMS.items() if entry.several)
        raise InputError(study.source, "algorithm.name", f'"{name}" takes one objective; of several: {able}')
    return name, read_settings(name, given, f"{study.source.name}: algorithm")


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


def identity_of(study: Study, seed: int, start: Array | None = None) -> dict[str, Any]:
    """Return what tells the store of a study from others, see `optim.search.recorder.recording`."""
    name, settings = settings_of(study)
    algorithm, revision = {"name": name, **settings.model_dump(mode="json")}, ALGORITHMS[name].revision
    if algorithm.get("derivatives") == DIFFERENCES:  # stores from before this setting have no such key
        del algorithm["derivatives"]
    task = {"algorithm": algorithm, "seed": seed, "start": None if start is None else start.tolist()}
    task |= study.description() | ({"revision": revision} if revision > 1 else {})
    return {
        "task": task,
        "versions": versions("pygad"),
        "variables": study.paths,
        "objectives": tuple(study.file.objectives),
        "constraints": tuple(study.file.constraints),
    }


def compromise(objectives: Array) -> int:
    """Index of the design to name first in a Pareto front (k, no), whose objectives are minimised.

    The knee, or, without one, the design nearest to the ideal point, each objective measured by its range.
    """
    if not np.isfinite(objectives).all():
        return 0
    found = pareto.knee(objectives)
    if found is not None:
        return found
    span = np.ptp(objectives, axis=0)
    scaled = (objectives - objectives.min(axis=0)) / np.where(span > 0.0, span, 1.0)
    return int(np.argmin(np.linalg.norm(scaled, axis=1)))


def _entries(study: Study, designs: Array, found: Evaluations, nominal: Evaluations) -> list[dict[str, Any]]:
    """Designs (m, n) as JSON types; None where one failed."""
    objectives, constraints = in_units(study, found, nominal)
    violation = values_of(study, found, nominal).violation
    point, n = study.points[0], len(study.usual)
    entries = []
    for k, design in enumerate(designs):
        row = study.row(design, point)
        entry: dict[str, Any] = {
            "variables": dict(zip(study.paths, map(float, design), strict=True)),
            "linked": dict(zip(point.paths[n:], row[n:], strict=True)),
            "objectives": dict(zip(study.file.objectives, map(finite, objectives[k]), strict=True)),
            "constraints": dict(zip(study.file.constraints, map(finite, constraints[k]), strict=True)),
            "feasible": bool(violation[k] <= FEASIBLE),
            "status": found.status[k],
        }
        entries.append(entry | ({"reason": found.reason[k]} if found.reason[k] else {}))
    return entries
