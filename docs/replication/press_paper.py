"""Results that the press paper prints, and the same runs of ours.

Chen, Wang and Wang, China Mechanical Engineering 36(1), 2025, 87-95.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from linkages import RunError, Status, Trajectory, extremes, find_file, ideal, impacts, load, simulate
from linkages.results.extremes import Extremes
from optim import Evaluator, find_study, load_study
from replication.claims import change
from replication.recorded import Array, load_record

ENGINE = "compiled"
PAPER = "seven_bar_paper.toml"
RIG_FILE = "seven_bar_rig.toml"
CLEARANCE = 0.3e-3  # m, section 3.3
DURATION = 1.0  # s: figures 6-10, the text of figure 10b ends there
PERIOD = 2.0  # s: one turn of crank 1, two of crank 4
START = 0.05  # s: the acceleration's peak of figure 8 lies in it
OUTPUTS = (
    "slider7.x", "slider7.vx", "slider7.ax", "A.force", "B.force", "A.eccentricity_ratio", "B.eccentricity_ratio",
)  # fmt: skip
_VARIABLES = (
    "sdf.links.link2.mass", "sdf.links.link2.inertia", "sdf.links.crank4.mass", "sdf.links.crank4.inertia",
    "sdf.links.slider7.mass", "joints.A.viscosity", "joints.B.viscosity",
)  # fmt: skip
_TABLE_6 = {
    "paper 1": (0.39752, 17.975e-4, 0.10391, 18.874e-5, 0.069825, 0.24241, 0.24241),
    "paper 2": (0.12678, 96.731e-5, 0.16064, 21.717e-5, 0.073186, 0.41749, 0.41749),
}
#: Design variables (25) by path [kg, kg m2, Pa s]; the nominal design is in Tables 3 and 5.
DESIGNS: dict[str, dict[str, float]] = {
    "nominal": {},
    **{name: dict(zip(_VARIABLES, values, strict=True)) for name, values in _TABLE_6.items()},
}
#: Section 3.4: largest forces [N] and the slider's acceleration at the start [m/s2].
PRINTED = {
    "A.force": {"nominal": 7.446, "paper 1": 8.383, "paper 2": 6.345},
    "B.force": {"nominal": 13.26, "paper 1": 14.66, "paper 2": 10.84},
    "slider7.ax": {"nominal": 5.434, "paper 1": 4.290, "paper 2": 5.485},
}
#: Windows of the printed largest forces, from the start [s]: section 3.4.
WINDOWS = {"A.force": 0.8, "B.force": 0.2}
#: Section 3.2: "largest values" of the slider's acceleration, with the printed signs [m/s2].
RIG = {"measured": -13.72, "computed": 4.366}
#: Speed at which friction in the guide is three quarters of its full value, assumed [m/s].
SLIDING = 1e-4
POSITION = 0.560  # m, Table 2: S_0


@dataclass(frozen=True)
class Optimum:
    """Our answer to a shipped study: values by path, the objective there and of the nominal design."""

    design: dict[str, float]
    objective: float
    nominal: float


def run(overrides: Mapping[str, Any], duration: float = DURATION, name: str = PAPER) -> Trajectory:
    """Run the press with some values replaced.

    Raises
    ------
    RunError
        If it does not reach its end.
    """
    found = simulate(load(find_file(name), {"duration": duration, **overrides}), ENGINE)
    if found.status is not Status.OK:
        raise RunError(f"{name} with {dict(overrides)}: {found.status.value}; {found.status.remedy}")
    return found


@cache
def design_run(name: str) -> Trajectory:
    """Run a design of `DESIGNS`, or "ours" for our optimum of the forces."""
    return run(optimum("sevenbar_paper_force").design if name == "ours" else DESIGNS[name])


@cache
def design_extremes(name: str) -> dict[str, Extremes]:
    """Extremes of `OUTPUTS`: of the forces in `WINDOWS`, of others in the whole run."""
    whole = design_run(name)
    return {output: extremes(whole.within(0.0, WINDOWS.get(output, DURATION)), [output])[output] for output in OUTPUTS}


def peak(name: str, output: str) -> float:
    """Largest magnitude of one of `OUTPUTS` in a design's run, of a force in its window."""
    return design_extremes(name)[output].peak


def peaks(output: str) -> dict[str, float]:
    """Largest magnitude of one of `OUTPUTS` for each of `DESIGNS`."""
    return {name: peak(name, output) for name in DESIGNS}


def columns(name: str, times: Array) -> dict[str, Array]:
    """All columns of a design's run, or of the "ideal" motion, at some times."""
    return (ideal_run() if name == "ideal" else design_run(name)).evaluate(times)


@cache
def ideal_run() -> Trajectory:
    """Motion of the press without clearance."""
    return ideal(load(find_file(PAPER), {"duration": DURATION}), ENGINE)


def conditions() -> dict[str, Any]:
    """Gravity, speeds and film correction of `PAPER` by path, for other experiments of the press."""
    found = load(find_file(PAPER)).experiment
    drives = {f"drives.{name}.speed": drive.speed for name, drive in found.drives.items()}
    patches = {f"joints.{name}.small_eccentricity": joint.small_eccentricity for name, joint in found.joints.items()}
    return {"gravity": list(found.gravity), **drives, **{k: dict(p) for k, p in patches.items() if p is not None}}


def patch() -> tuple[float, float]:
    """Give eps_0 and m of eqs. (12)-(13) in `PAPER`."""
    value = load(find_file(PAPER)).value
    return value("joints.A.small_eccentricity.ratio"), value("joints.A.small_eccentricity.power")


@cache
def rig_run(friction: float = 0.0, clearance: float | None = None) -> Trajectory:
    """Run the test rig, two periods, with a Coulomb friction in the guide [N] and, if given, another clearance [m]."""
    more: dict[str, Any] = {} if clearance is None else {f"joints.{j}.clearance": clearance for j in "AB"}
    if friction:
        more["forces.friction"] = {"point": "slider7", "formula": [f"-{friction!r}*tanh(slider7.vx/{SLIDING})", "0"]}
    return run({**conditions(), **more}, 2.0 * PERIOD, RIG_FILE)


def rig_ideal(times: Array) -> dict[str, Array]:
    """Columns of the ideal press over the rig's two periods."""
    return ideal(load(find_file(RIG_FILE), {"duration": 2.0 * PERIOD, **conditions()}), ENGINE).evaluate(times)


@cache
def contacts(name: str) -> int:
    """Count the contacts of a design whose joints can touch: eq. (15), with the finite film and the paper's oil."""
    oil = {f"joints.{j}.viscosity": 0.4 for j in "AB"}
    found = {key: value for key, value in conditions().items() if not key.startswith("joints.")}
    return len(impacts(run(oil | found | DESIGNS[name], name="seven_bar_mixed.toml"), ["A", "B"]))


@cache
def optimum(study_name: str) -> Optimum:
    """Evaluate the recorded answer of a shipped study of the press."""
    study = load_study(find_study(study_name))
    x = load_record(study_name).design(study)
    nominal, best = map(float, Evaluator(study)(np.array([study.nominal, x])).objectives[:, 0])
    point = study.points[0]
    return Optimum(dict(zip(point.paths, study.row(x, point), strict=True)), best, nominal)


def objective(name: str) -> float:
    """Evaluate eq. (24): half the sum of the largest forces [N]."""
    return 0.5 * (peak(name, "A.force") + peak(name, "B.force"))


def least_film(name: str, joint: str) -> float:
    """Least thickness of a joint's film, c - |e| [m]."""
    return CLEARANCE * (1.0 - peak(name, f"{joint}.eccentricity_ratio"))


# -- inert variables -----------------------------------------------------------------------------------


@cache
def doubled(path: str) -> tuple[float, float, float]:
    """Double a value of Table 3: changes of acceleration, sum of the forces and crank 4's torque [%]."""
    value = load(find_file(PAPER)).value(path)
    outputs = ("slider7.ax", "A.force", "B.force", "O4.torque")
    found = (extremes(x, outputs) for x in (design_run("nominal"), run({path: 2.0 * value})))
    before, after = ([x[name].peak for name in outputs] for x in found)
    forces = change(sum(before[1:3]), sum(after[1:3]))
    return change(before[0], after[0]), forces, change(before[3], after[3])


def share_below(output: str, name: str, other: str, start: float, end: float) -> float:
    """Part of an interval in which one design's output is below another's [%]."""
    times = np.linspace(start, end, 2001)
    return float(100.0 * np.mean(columns(name, times)[output] < columns(other, times)[output]))
