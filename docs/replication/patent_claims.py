"""The patent's claims beside our numbers: CN106055749A (Bai, Zhao and Sun, 2016)."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from linkages import Trajectory, ideal, simulate
from optim import Evaluator, Study, find_study, load_study
from replication.claims import NOT, Claim, change, grade, verdict_of_gain
from replication.recorded import Array, load_record

PRINTED = -77.5  # %, [0087]: largest departure of the acceleration
#: Start angles that no search has seen [rad].
UNSEEN = 0.2 + 2.0 * np.pi * np.arange(10) / 10.0
RESOLUTION = 1e-5  # s: a contact takes five times as long
SETTLED = 0.05  # s: half a revolution, after the ramp of the drive


@cache
def _study() -> Study:
    return load_study(find_study("fourbar_jitter"))


@cache
def optimum() -> Array:
    """Return the recorded design of the study: lengths (n,) [m]."""
    return load_record(_study().source.stem).design(_study())


def unseen_change() -> float:
    """Change of the objective's mean over start angles that no search has seen [%]."""
    return change(*np.mean([_objectives(started_at(_study(), angle)) for angle in UNSEEN], axis=0))


def change_after_the_start() -> float:
    """Change of the largest departure from `SETTLED` on [%]."""
    point = _study().points[0]
    later = np.array([[SETTLED, point.system.experiment.duration]])
    point = replace(point, windows={**point.windows, "run": later})
    return change(*_objectives(replace(_study(), points=(point,))))


def started_at(study: Study, angle: float) -> Study:
    """Return the study with another start angle of the crank [rad]."""
    return study.replaced(lambda system: {"drives.O.angle": angle})


def _objectives(study: Study) -> Array:
    """Objective of the nominal and of the optimised design in a variant of the study, (2,)."""
    return Evaluator(study)(np.array([study.nominal, optimum()])).objectives[:, 0]


@cache
def _runs(optimised: bool) -> tuple[Trajectory, Trajectory]:
    """Run with clearance, and ideal; nominal or optimised lengths."""
    study = _study()
    system = study.system(optimum() if optimised else study.nominal)
    return simulate(system, "compiled"), ideal(system, "compiled")


def motions(optimised: bool) -> tuple[dict[str, Array], dict[str, Array]]:
    """Columns with clearance, and ideal, at the same times; nominal or optimised lengths."""
    run, perfect = _runs(optimised)
    return run.columns, perfect.evaluate(run.time)


def claims() -> list[Claim]:
    """All claims of the patent that have a number or a figure."""
    found, unseen, later = change(*_objectives(_study())), unseen_change(), change_after_the_start()
    lengths = ", ".join(f"{1e3 * value:.0f}" for value in optimum())
    before, after = _shares_above()
    return [
        Claim(
            "largest departure of the acceleration, [0087]", f"{PRINTED} %", f"{found:+.0f} %",
            verdict_of_gain(PRINTED, found),
            "tables 1 and 2 (lengths, bounds), material and friction are missing; what is reached depends on bounds,"
            " a third to thrice here ([others](fourbar_landscape.md)), and less on [the method](fourbar_methods.md)",
        ),
        Claim(
            "the same from ten other start angles", "not asked", f"{unseen:+.0f} %",
            verdict_of_gain(PRINTED, unseen), "the objective sees two revolutions from one start",
        ),
        Claim(
            f"the same after the start, from {SETTLED:g} s", "not asked", f"{later:+.0f} %",
            verdict_of_gain(PRINTED, later),
            "the objective's largest departure is that of the first flight across the clearance",
        ),
        Claim(
            "fewer and lower peaks, fig. 4", "clearly",
            f"departure above half of the nominal largest during {before:.2f} % of the time before,"
            f" {after:.2f} % after",
            grade(after < 0.5 * before), "the follower's angular acceleration is compared",
        ),
        Claim(
            "optimised lengths, table 2", "lost", f"{lengths} mm (ground, crank, coupler, follower)", NOT,
            "the table is not in the text",
        ),
    ]  # fmt: skip


def _shares_above() -> list[float]:
    """Part of the time, before and after [%], in which the departure is above half of the largest before.

    Seen at the middle of each of equal parts of a run.
    """
    departures = []
    for run, perfect in map(_runs, (False, True)):
        times = RESOLUTION * (np.arange(round(float(run.time[-1]) / RESOLUTION)) + 0.5)
        real, exact = (motion.evaluate(times)["follower.alpha"] for motion in (run, perfect))
        departures.append(np.abs(real - exact))
    return [100.0 * float(np.mean(departure > 0.5 * departures[0].max())) for departure in departures]
