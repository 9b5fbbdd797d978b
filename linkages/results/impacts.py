"""Individual contacts of a joint: time, speed, force, and kind (impact or sustained contact).

A contact is an *impact* if the journal approaches once, rebounds and separates. It is *sustained* if the journal
approaches again before separation, or if the contact lasts longer than `SUSTAINED` times a free elastic impact of the
same depth and approach speed, whose duration is `HERTZ` times depth over speed. See `phases`.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.base.arguments import Names, validated
from linkages.base.arrays import Array
from linkages.input.files.magnitudes import decimal
from linkages.results.extremes import Bracket, refine
from linkages.results.trajectory import Trajectory

#: Phases of a joint during a step, see `phases`.
FREE, IMPACT, SUSTAINED_CONTACT = 0, 1, 2

#: Duration of an impact between elastic bodies over depth/approach speed: Hertz's 2.9432, for an exponent of 1.5.
HERTZ = 2.9432

#: A contact that lasts longer than this many such impacts is sustained.
SUSTAINED = 2.0


@dataclass(frozen=True)
class Impact:
    """One contact of one joint, SI units; made by `impacts`.

    For a stop of a revolute joint, and a backlash given as an angle, lengths and forces are angles and torques. Peaks
    are over continuous time.

    Attributes
    ----------
    joint : str
    start : float
        Start of the contact.
    approach_speed : float
        Rate of the eccentricity at the start.
    tangential_speed : float
        Sliding speed at the start.
    duration : float
        Time until separation, or until the run ends.
    peak_force : float
        Peak of the resultant of normal force, friction and (mixed joint) film.
    peak_penetration : float
    separation_speed : float
        Rate of the eccentricity at separation; NaN if the run ends earlier.
    peak_normal_force : float
        Peak of the force along the line of centres (at a corner: along the wall's normal); NaN if unknown, in folders
        written by older versions.
    """

    joint: str
    start: float
    approach_speed: float
    tangential_speed: float
    duration: float
    peak_force: float
    peak_penetration: float
    separation_speed: float
    peak_normal_force: float = math.nan

    @property
    def owner(self) -> str:
        """Return the joint, stop, line or gear of a corner or flank."""
        return self.joint.rpartition(".")[0] or self.joint


class Shown(NamedTuple):
    """How people read a quantity of contacts."""

    label: str
    unit: str
    scale: float = 1.0  # from the SI unit

    @property
    def head(self) -> str:
        """Return the head of a column."""
        return f"{self.label} [{self.unit}]"


#: The quantities of a contact, in the order of their fields.
QUANTITIES = {
    "start": Shown("start", "s"),
    "approach_speed": Shown("approach", "m/s"),
    "tangential_speed": Shown("sliding", "m/s"),
    "duration": Shown("duration", "ms", 1e3),
    "peak_force": Shown("peak force", "N"),
    "peak_penetration": Shown("peak penetration", "µm", 1e6),
    "separation_speed": Shown("separation", "m/s"),
    "peak_normal_force": Shown("peak normal force", "N"),
}
#: Those that a comparison of two runs shows after the start.
COMPARED = ("approach_speed", "tangential_speed", "peak_force")

#: Files of contacts, with their columns.
FILES = {
    "impacts.csv": [field.name for field in fields(Impact) if field.name != "peak_normal_force"],
    "impacts_normal.csv": ["joint", "start", "peak_normal_force"],
}


@validated
def impacts(trajectory: Trajectory, joints: Names) -> list[Impact]:
    """Collect all contacts of joints in the order of their starts.

    The run's steps end at the start and end of each contact. A step is in contact if the penetration at its middle,
    from the cubic through its ends, is positive.

    Parameters
    ----------
    trajectory : Trajectory
    joints : sequence of str
        Joints that can touch, stops and points at lines; for a guide with clearance its corners, ``GUIDE.corner1``;
        for a gear with backlash its flanks, ``GEAR.upper`` and ``GEAR.lower``.

    Returns
    -------
    list of Impact
        All contacts, in SI units.

    Examples
    --------
    >>> import linkages
    >>> system = linkages.load(linkages.find_file("slider_crank_dry.toml"))
    >>> contacts = linkages.impacts(linkages.simulate(system, "compiled"), ["B"])
    >>> first = contacts[0]
    >>> round(first.start, 6), round(first.approach_speed, 3), round(first.peak_force, -2)  # s, m/s, N
    (0.000227, 4.386, 45900.0)
    """
    found: list[Impact] = []
    brackets: list[Bracket] = []
    closings = [trajectory[f"{name}.closing"] for name in joints]  # raises if a joint has no clearance
    trajectory = _with_forces(trajectory, joints)
    time = trajectory.time
    for name, closing in zip(joints, closings, strict=True):
        for first, last in _intervals(trajectory, name):
            sliding = float(trajectory[f"{name}.sliding"][first])
            apart = float(-closing[last]) if last < len(time) - 1 else math.nan
            start, lasts = float(time[first]), float(time[last] - time[first])
            found.append(Impact(name, start, float(closing[first]), sliding, lasts, math.nan, math.nan, apart))
            for column in ("force", "penetration", "normal_force"):
                values, times = trajectory[f"{name}.{column}"][first : last + 1], time[first : last + 1]
                best = int(np.argmax(values))
                window = slice(max(best - 1, 0), best + 2)
                brackets.append(Bracket(f"{name}.{column}", 1.0, times[window], values[window]))
    peaks = iter(value for _, value in refine(trajectory, brackets))
    rows = [
        replace(row, peak_force=next(peaks), peak_penetration=next(peaks), peak_normal_force=next(peaks))
        for row in found
    ]
    return sorted(rows, key=lambda row: (row.start, row.joint))


def write_impacts(rows: Sequence[Impact], folder: Path) -> None:
    """Write `FILES`: ``impacts.csv``, with fixed columns for other programs, and the normal forces."""
    for name, columns in FILES.items():
        with open(folder / name, "w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(columns)
            for row in map(asdict, rows):
                values = [row[column] for column in columns]
                writer.writerow(["" if isinstance(v, float) and math.isnan(v) else v for v in values])


def read_impacts(folder: Path) -> list[Impact]:
    """Read the files of `write_impacts`; normal forces are NaN if their file is missing.

    OSError, ValueError, KeyError or TypeError if the files do not have this form.
    """
    tables: list[list[dict[str, str]]] = []
    for name in FILES:
        if tables and not (folder / name).is_file():
            continue
        with open(folder / name, newline="", encoding="utf-8") as file:
            tables.append(list(csv.DictReader(file)))
    merged = [{key: value for part in parts for key, value in part.items()} for parts in zip(*tables, strict=True)]
    return [Impact(**{k: v if k == "joint" else decimal(v or "nan") for k, v in row.items()}) for row in merged]  # type: ignore[arg-type]


@validated
def phases(trajectory: Trajectory, name: str) -> NDArray[np.int64]:
    """Classify each step of a run as `FREE` flight, `IMPACT` or `SUSTAINED_CONTACT` of a joint.

    Parameters
    ----------
    trajectory : Trajectory
    name : str
        A joint that can touch.

    Returns
    -------
    (nt - 1,) array

    Examples
    --------
    >>> import linkages
    >>> system = linkages.load(linkages.find_file("slider_crank_dry.toml"))
    >>> run = linkages.simulate(system, "compiled")
    >>> phases = linkages.phases(run, "B")
    >>> phases.shape == (len(run.time) - 1,), sorted(set(phases.tolist()))
    (True, [0, 1, 2])
    """
    time, speed, depth = trajectory.time, trajectory[f"{name}.closing"], trajectory[f"{name}.penetration"]
    closing = speed > 0.0
    result = np.full(len(time) - 1, FREE, dtype=np.int64)
    for first, last in _intervals(trajectory, name):
        again = bool(np.any(closing[first + 1 : last + 1] & ~closing[first:last]))
        free = SUSTAINED * HERTZ * depth[first : last + 1].max()
        lasts = speed[first] * (time[last] - time[first]) > free
        result[first:last] = SUSTAINED_CONTACT if again or lasts else IMPACT
    return result


def _with_forces(trajectory: Trajectory, names: Sequence[str]) -> Trajectory:
    """Add ``NAME.normal_force`` of each contact; of revolute stops and flanks also ``force`` and ``sliding``."""
    turning = [name for name in names if f"{name}.sliding" not in trajectory]

    def effort(columns: Mapping[str, Array], name: str) -> Array:
        return columns[f"{name}.force" if f"{name}.force" in columns else f"{name}.torque"]

    def normal_force(columns: Mapping[str, Array], name: str) -> Array:
        if name in turning:
            return effort(columns, name)
        if f"{name}.ex" not in columns:
            return columns[f"{name}.load"]
        guide, corner, _ = name.rpartition(".corner")
        force = columns[f"{name}.fx"] + 1j * columns[f"{name}.fy"]
        if not corner:
            centres = columns[f"{name}.ex"] + 1j * columns[f"{name}.ey"]
            return -np.real(force * centres.conj()) / np.maximum(np.abs(centres), np.finfo(float).tiny)
        # direction across the slot: from corner 4 to corner 1 of the block, minus the tilt
        first, last = (columns[f"{guide}.corner{k}.ex"] + 1j * columns[f"{guide}.corner{k}.ey"] for k in (1, 4))
        across = (first - last) * np.exp(-1j * columns[f"{guide}.tilt"])
        return np.abs(np.real(force * across.conj())) / np.abs(across)

    def extended(columns: Mapping[str, Array]) -> dict[str, Array]:
        forces = {f"{name}.normal_force": normal_force(columns, name) for name in names}
        for name in turning:
            forces |= {f"{name}.force": effort(columns, name), f"{name}.sliding": np.zeros_like(columns["time"])}
        return {**columns, **forces}

    evaluate = trajectory.evaluate
    between = (lambda times: extended(evaluate(times))) if evaluate else None
    return replace(trajectory, columns=extended(trajectory.columns), evaluate=between)


def _intervals(trajectory: Trajectory, name: str) -> list[tuple[int, int]]:
    """Return the first and last sample of each contact."""
    delta, closing = trajectory[f"{name}.penetration"], trajectory[f"{name}.closing"]
    step = np.diff(trajectory.time)
    middle = 0.5 * (delta[:-1] + delta[1:]) + step * (closing[:-1] - closing[1:]) / 8.0
    touching = np.concatenate([[False], middle > 0.0, [False]])
    starts = np.flatnonzero(~touching[:-1] & touching[1:])
    ends = np.flatnonzero(touching[:-1] & ~touching[1:])
    return list(zip(starts.tolist(), ends.tolist(), strict=True))
