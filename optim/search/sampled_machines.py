"""`SampledMachines`: machines of a study with ``[scatter]``, run until there are enough."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from linkages import InputError
from linkages.input.files.toml import Positive, Table, validate
from linkages.input.files.versions import versions
from optim.algorithms.derivatives import DIFFERENCES, SOURCES, Source
from optim.evaluate.evaluations import OK, Evaluations
from optim.evaluate.evaluator import Evaluator
from optim.evaluate.gradients import Gradients, check_sensitivities
from optim.evaluate.limits import Limit, in_units, limits
from optim.problem.scatter import Scatter
from optim.problem.schema import SAMPLING
from optim.problem.study import Array, Study
from optim.search import numerics
from optim.search.recorder import Recorder
from optim.search.tolerance_statistics import clopper_pearson


class Sampling(Table):
    """Settings of a study of tolerances."""

    samples: Annotated[int, Field(ge=2, le=10**6)] = Field(1024, description="machines, at most")
    sequence: Literal["sobol", "random"] = Field("sobol", description="points of a scrambled Sobol sequence, or random")
    confidence: Annotated[float, Field(gt=0.5, lt=1)] = Field(0.95, description="of the intervals")
    width: Positive | None = Field(None, description="stop where the interval of the yield is narrower [1]")
    derivatives: Source = Field(DIFFERENCES, description=SOURCES)


@dataclass(frozen=True)
class Sample:
    """Machines of a study: values (m, n), quantities (m, nq), NaN where a run failed, and which meet all limits.

    Their values are those of independent standard normal numbers (m, n).
    """

    normal: Array
    designs: Array
    values: Array
    good: NDArray[np.bool_]
    status: tuple[str, ...]

    @property
    def ran(self) -> NDArray[np.bool_]:
        """Tell which machines have values, (m,)."""
        return np.array([state == OK for state in self.status], dtype=bool)


def settings_of(study: Study, samples: int | None = None) -> Sampling:
    """Return the settings of a study of tolerances, with another number of machines; InputError if it is none."""
    if not study.file.sampled:
        raise InputError(study.source, "algorithm.name", f'must be "{SAMPLING}" for tolerances')
    given = {key: value for key, value in study.file.algorithm.items() if key != "name"}
    more = {} if samples is None else {"samples": samples}
    settings = validate(Sampling, given | more, Path(f"{study.source.name}: algorithm"))
    if settings.derivatives != DIFFERENCES:
        check_sensitivities(study)
    return settings


def identity_of(study: Study, settings: Sampling, seed: int) -> dict[str, Any]:
    """Return what tells the store of a study from others; the number of machines may grow."""
    algorithm = {"name": SAMPLING, "sequence": settings.sequence}
    return {
        "task": {"algorithm": algorithm, "seed": seed, "start": None} | study.description(),
        "versions": versions("scipy"),
        "variables": study.paths,
        "objectives": tuple(study.file.objectives),
        "constraints": tuple(study.file.constraints),
    }


class SampledMachines:
    """Machines of a study by their values, each run once."""

    def __init__(self, study: Study, settings: Sampling, seed: int, recorder: Recorder) -> None:
        assert study.scatter is not None  # as the study is sampled
        self.study, self.settings, self.seed, self.recorder = study, settings, seed, recorder
        self.scatter: Scatter = study.scatter
        self.nominal = recorder.evaluate(study.nominal[None])
        self.limits: list[Limit] = limits(study)
        names = [name for _, name, _ in study.quantities]
        self.columns = [names.index(limit.name) for limit in self.limits]
        self._gradients: Gradients | None = None
        if settings.derivatives != DIFFERENCES:
            self._gradients = Gradients(study, recorder.evaluate, self.nominal)

    def run(self, designs: Array) -> tuple[Array, Evaluations]:
        """Return quantities (m, nq) of machines (m, n), and how they ended."""
        return self._judged(self.recorder.evaluate(designs))

    def _judged(self, found: Evaluations) -> tuple[Array, Evaluations]:
        return np.hstack(in_units(self.study, found, self.nominal)), found

    def excess(self, values: Array) -> Array:
        """Return by how much quantities (m, nq) exceed each limit, (m, nl), relative to it; infinite if they failed."""
        table = np.column_stack(
            [
                np.empty((len(values), 0)),
                *(limit.excess(values[:, k]) for limit, k in zip(self.limits, self.columns, strict=True)),
            ]
        )
        return np.where(np.isnan(table), np.inf, table)

    def sample(self, evaluator: Evaluator, progress: Callable[[float], None]) -> Sample:
        """Run machines until there are enough."""
        settings = self.settings
        normal = self.scatter.points(settings.samples, self.seed, settings.sequence)
        points = self.scatter.values(normal)
        rows, goods, status = [np.empty((0, len(self.study.quantities)))], [np.zeros(0, dtype=bool)], list[str]()
        done = passed = 0
        for first, values, found in self._chunks(points, evaluator, progress):
            good = self._good(values)
            for end in range(
                numerics.SAMPLED_MACHINES_CHUNK,
                len(values) + numerics.SAMPLED_MACHINES_CHUNK,
                numerics.SAMPLED_MACHINES_CHUNK,
            ):
                part = good[end - numerics.SAMPLED_MACHINES_CHUNK : end]
                done, passed = done + len(part), passed + int(part.sum())
                if enough := self._enough(passed, done):
                    break
            rows.append(values[: done - first])
            goods.append(good[: done - first])
            status += found.status[: done - first]
            if enough:
                break
        evaluator.progress = None
        progress(1.0)
        return Sample(normal[:done], points[:done], np.concatenate(rows), np.concatenate(goods), tuple(status))

    def _chunks(
        self, points: Array, evaluator: Evaluator, progress: Callable[[float], None]
    ) -> Iterator[tuple[int, Array, Evaluations]]:
        """Run machines (m, n) in chunks, some at once; yield the place of a chunk's first one, quantities, ends."""
        begun: deque[tuple[int, int, Callable[[], Evaluations]]] = deque()
        next_one, most = 0, 1 if evaluator.executor is None else numerics.SAMPLED_MACHINES_UNDER_WAY
        while next_one < len(points) or begun:
            while next_one < len(points) and len(begun) < most:
                chunk = points[next_one : next_one + self._size(evaluator, len(points) - next_one)]
                begun.append((next_one, len(chunk), self.recorder.begin(chunk)))
                next_one += len(chunk)
            first, size, wait = begun.popleft()
            evaluator.progress = _part(progress, first, size, len(points), evaluator)
            yield first, *self._judged(wait())
            progress((first + size) / len(points))

    def _size(self, evaluator: Evaluator, left: int) -> int:
        """Return how many of the machines that are left make the next chunk, a multiple of the judged number.

        The last chunks halve: so all workers end at about the same time, and little is left to be stored then.
        """
        most, judged = evaluator.population(numerics.SAMPLED_MACHINES_CHUNK), numerics.SAMPLED_MACHINES_CHUNK
        return min(most, judged * math.ceil(left / (2 * judged)))

    def _enough(self, good: int, count: int) -> bool:
        """Tell whether the interval of the yield is as narrow as asked for."""
        if self.settings.width is None:
            return False
        lower, upper = clopper_pearson(good, count, self.settings.confidence)
        return upper - lower <= self.settings.width

    def _good(self, values: Array) -> NDArray[np.bool_]:
        return np.asarray(np.isfinite(values).all(axis=1) & (self.excess(values) <= 0.0).all(axis=1))

    def rates(self, design: Array) -> Array:
        """Differentiate the quantities with respect to the values of a machine (n,), (nq, n).

        Not finite where a machine beside it failed, or the deviation of a value is less than its rounding.
        """
        if self._gradients is not None:
            found = self._gradients.rates(design)
            if np.isfinite(found).all():
                return found
        steps = np.diag(numerics.SAMPLED_MACHINES_STEP * self.scatter.deviations)
        moved = np.concatenate([design + steps, design - steps])
        values, _ = self.run(moved)
        size = np.diag(moved[: len(design)] - moved[len(design) :])
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            return np.asarray((values[: len(design)] - values[len(design) :]).T / size)


def _part(
    progress: Callable[[float], None], start: int, size: int, total: int, evaluator: Evaluator
) -> Callable[[float], None] | None:
    """Return what a batch calls with its finished part; None where other processes run it."""
    return (lambda part: progress((start + size * part) / total)) if evaluator.executor is None else None
