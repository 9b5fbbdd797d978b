"""Conditions that the press paper does not print, and the ten printed numbers that could determine them.

Unknown are gravity, the speeds of both cranks, the start, and eps_0 and m of eqs. (12)-(13). Given are six largest forces in their
windows, three accelerations at the start (figure 8) and the largest acceleration computed for the rig (figure 5). The rig is measured in
steady running over two complete periods: the speeds have a common period, and the rig's number is the largest one of a whole period.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from linkages import System, find_file, load, simulate_batch
from replication.computed import read
from replication.press_ideal import BAUMGARTE, FORCES, GRAVITY
from replication.press_paper import DESIGNS, PAPER, PRINTED, RIG, RIG_FILE, START, WINDOWS, Array
from replication.verdicts import Claim, Fitted

#: Printed numbers: forces as `FORCES` [N], sizes of the accelerations at the start, and the one of the rig [m/s2].
ASKED = np.array([*FORCES, *PRINTED["slider7.ax"].values(), RIG["computed"]])
UNITS = ("N",) * 6 + ("m/s²",) * 4
_WORST = np.log(10.0)  # a wrong sign counts as a factor of 10, and so does a run that fails
_SPIKE = (0.0, START)
#: Criteria of the scan: deviation of the six forces, and of the slider's largest acceleration over a period from the printed one.
NEAR_FORCES, NEAR_RIG = 0.10, 0.15


class Conditions(NamedTuple):
    """A guess at all that is not printed."""

    omega_1: float = np.pi  # rad/s
    omega_4: float = -2.0 * np.pi  # rad/s
    eps_0: float = 0.0  # of eqs. (12)-(13); 0: without them
    m: float = 0.0
    gravity: str = "-y"  # a key of `GRAVITY`
    start: str = "moving"  # "moving": ideal velocities; "at rest"; the journals are centred
    size: float = 9.81  # of gravity [m/s2]


#: Unknowns whose profiles are kept, as a reader knows them.
LABELS = {"omega_1": "ω₁ = -ω₄/2 [rad/s]", "eps_0": "ε₀", "m": "m", "size": "gravity along -y [m/s²]"}
#: A profile below this many times its least value does not tell values apart: the printed numbers themselves have three digits.
LOOSE = 1.5
#: Round speeds among the pairs that meet both criteria: 30 and -60 r/min.
CHOSEN = Conditions()
#: Conditions whose eps_0 and m are fitted, by name: the chosen ones, and two starts at rest.
FITTED = {
    "π and -2π rad/s": CHOSEN,
    "π and -2π rad/s, start at rest": CHOSEN._replace(start="at rest"),
    "2.3 and 4.6 rad/s, start at rest": Conditions(2.3, 4.6, start="at rest"),
}
#: A guess that meets none of the ten numbers: both cranks at 60 r/min, no gravity.
ASSUMED = Conditions(2.0 * np.pi, 2.0 * np.pi, gravity="none")
#: Four values fitted to the ten numbers while the rig ran for 2 s only.
FREE = Conditions(5.034, -6.555, 3.94e-6, 0.1225)


def period(guess: Conditions, limit: int = 6) -> float | None:
    """Compute the common period of both cranks [s] with at most `limit` turns of each; None if there is none."""
    one, four = abs(guess.omega_1), abs(guess.omega_4)
    ratio = Fraction(one / four).limit_denominator(limit)
    common = ratio.numerator <= limit and abs(float(ratio) * four - one) < 1e-9 * one
    return 2.0 * np.pi * ratio.numerator / one if common else None


def measured_time(guess: Conditions) -> float:
    """Compute the time of a rig run [s]: two periods; without a common period ten turns of the slower crank."""
    common = period(guess)
    return 2.0 * common if common else 20.0 * np.pi / min(abs(guess.omega_1), abs(guess.omega_4))


def overrides(guess: Conditions) -> dict[str, Any]:
    """Values of an experiment by path."""
    pull = GRAVITY[guess.gravity] * guess.size / 9.81
    found: dict[str, Any] = {"gravity": [pull.real, pull.imag, 0.0]}
    for drive, speed in (("O1", guess.omega_1), ("O4", guess.omega_4)):
        if guess.start == "at rest":
            found[f"drives.{drive}"] = {"formula": f"{float(speed)!r}*t*(1 - exp(-{BAUMGARTE:g}*t))"}
        else:
            found[f"drives.{drive}.speed"] = float(speed)
    patch = {"ratio": guess.eps_0, "power": guess.m} if guess.eps_0 else {"ratio": 1e-6, "power": 0.0}  # power 0: none
    return found | {f"joints.{j}.small_eccentricity": dict(patch) for j in "AB"}


@cache
def _machine(name: str, duration: float) -> System:
    return load(find_file(name), {"duration": duration})


def outcome(guess: Conditions) -> Array:
    """Compute what `ASKED` has, (10,); NaN of a run that fails.

    The acceleration at the start counts by its size, the rig's after the start by its largest value.
    """
    press = _machine(PAPER, max(WINDOWS.values())).replaced(overrides(guess))
    end = measured_time(guess)
    rig = _machine(RIG_FILE, 1.0).replaced({**overrides(guess), "duration": end})
    paths = list(DESIGNS["paper 1"])
    values = [[design.get(path, press.value(path)) for path in paths] for design in DESIGNS.values()]
    windows = [*((0.0, end) for end in WINDOWS.values()), _SPIKE]
    found = simulate_batch(press, paths, values, (*WINDOWS, "slider7.ax"), windows)
    settled = simulate_batch(rig, outputs=("slider7.ax",), windows=[(START, end)])
    return np.array([*found.maximum[:, 0, 0], *found.maximum[:, 1, 1], *found.peak[:, 2, 2], settled.maximum[0, 0, 0]])


def misses(found: Array) -> Array:
    """Logarithms of ours over the printed numbers, at most a factor of ten."""
    with np.errstate(all="ignore"):
        apart = np.log(found / ASKED)
    return np.clip(np.nan_to_num(apart, nan=_WORST), -_WORST, _WORST)


def mismatch(found: Array) -> float:
    """Root mean square of the logarithms of ours over printed."""
    return float(np.sqrt(np.mean(misses(found) ** 2)))


def met(found: Array) -> int:
    """Count the numbers that are met as a verdict means it."""
    return sum(Fitted(float(a), float(b)).grade == 0 for a, b in zip(ASKED, found, strict=True))


def guesses() -> dict[str, Conditions]:
    """Name guesses: the one of `PAPER` first, and others for comparison."""
    return {
        **{name: fitted(name) for name in FITTED},
        "π and -2π rad/s, without eqs. (12)-(13)": CHOSEN,
        "four fitted values": FREE,
        "2π and 2π rad/s without gravity": ASSUMED,
    }


def fitted(name: str) -> Conditions:
    """Give conditions of `FITTED` with eps_0 and m of the search that ended best."""
    return FITTED[name]._replace(**min(read("press_conditions")["fits"][name], key=lambda row: row["mismatch"])["end"])


def best() -> Conditions:
    """Give the conditions of `PAPER`."""
    return fitted(next(iter(FITTED)))


def survivors() -> Array:
    """Select the pairs along -y that meet both criteria, as rows of `press_ideal.scan`."""
    found = np.array(read("press_conditions")["scan"]["-y, moving"]["near"])
    return found[both(found)]


def both(found: Array) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """Tell which rows of a scan meet both criteria; the slider's acceleration counts by its size in either direction."""
    ratio = np.abs(found[:, 3:]).max(axis=1) / RIG["computed"]
    return (found[:, 2] < NEAR_FORCES) & (np.abs(ratio - 1.0) < NEAR_RIG)


def determined(name: str) -> str:
    """Say between which held values of an unknown the others reach less than `LOOSE` times the least mismatch."""
    found = read("press_conditions")["profiles"][name]
    values, least = found["values"], min(found["mismatch"])
    near = [n for n, miss in enumerate(found["mismatch"]) if miss < LOOSE * least]
    ends = [f"above {values[near[0] - 1]:g}"] if near[0] else []
    ends += [f"below {values[near[-1] + 1]:g}"] if near[-1] + 1 < len(values) else []
    return " and ".join(ends)


def scan_table() -> tuple[list[str], list[list[str]]]:
    """Head and rows of the scan of the ideal press, by gravity and start."""
    head = [
        "gravity, start",
        "forces within 10 %",
        "and acceleration within 15 %",
        "best",
        "at ω₁, ω₄ [rad/s]",
        "slider there [m/s²]",
    ]
    rows = []
    for name, found in read("press_conditions")["scan"].items():
        if not found["near"]:
            continue
        one, four, apart, high, low = found["best"]
        counts = [str(len(found["near"])), str(int(both(np.array(found["near"]).reshape(-1, 5)).sum()))]
        rows.append([name, *counts, f"{100.0 * apart:.1f} %", f"{one:g}, {four:g}", f"{low:.1f} to {high:.1f}"])
    return head, rows


def fits_table() -> tuple[list[str], list[list[str]]]:
    """Head and rows of the searches for eps_0 and m: the best one, and how many others reach it within 1 %."""
    rows = []
    for name, found in read("press_conditions")["fits"].items():
        least = min(found, key=lambda row: row["mismatch"])
        near = sum(row["mismatch"] < 1.01 * least["mismatch"] for row in found)
        end = "{eps_0:.3g}, {m:.3g}".format(**least["end"])
        rows.append([name, end, f"{100.0 * least['mismatch']:.2f} %", f"{near} of {len(found)}"])
    return ["press", "ε₀, m", "deviation of ten numbers", "searches that end there"], rows


def profiles_table() -> tuple[list[str], list[list[str]]]:
    """Head and rows of the profiles: the least mismatch with one unknown held."""
    head = ["unknown", "best", "least deviation of all ten numbers, held at", f"within {LOOSE:g} times the least"]
    at = best()._asdict()
    rows = []
    for name, label in LABELS.items():
        found = read("press_conditions")["profiles"][name]
        pairs = zip(found["values"], found["mismatch"], strict=True)
        rows.append(
            [label, f"{at[name]:.4g}", ", ".join(f"{v:g}: {100.0 * miss:.1f} %" for v, miss in pairs), determined(name)]
        )
    return head, rows


def conclusion() -> str:
    """Describe the conditions, what determines them, and what does not."""
    found, free, names = outcome(best()), outcome(FREE), list(FITTED)
    speeds = read("press_conditions")["profiles"]["omega_1"]
    at = speeds["values"][int(np.argmin(speeds["mismatch"]))]
    rest = mismatch(outcome(fitted(names[2])))
    return f"""At π and -2π rad/s (30 and -60 r/min) with two fitted values, {met(found)} of ten printed numbers are met within 5 % and all within
{100.0 * np.abs(np.expm1(misses(found))).max():.0f} %; the root mean square of the deviations is {100.0 * mismatch(found):.1f} %. Four values fitted without a common period (ω₁ = {FREE.omega_1:g},
ω₄ = {FREE.omega_4:g} rad/s, ε₀ = {FREE.eps_0:g}, m = {FREE.m:g}) meet nine numbers better, but the slider of the rig then reaches {free[-1]:.1f} m/s² within ten turns
of the slower crank instead of {RIG["computed"]:g}.

*Determined*, if the press starts in motion: the direction of gravity, its magnitude within about 10 %, the ratio ω₄ = -2 ω₁, and ω₁ within about
10 %.

*Not determined*: the exact speeds (ω₁ = {at:g} rad/s gives {100.0 * min(speeds["mismatch"]):.1f} %); the paper's ε₀ and m, because two values describe three
numbers only; and the start. A press that starts at rest at 2.3 and 4.6 rad/s, ω₄ = 2 ω₁, reaches {100.0 * rest:.1f} % with as many fitted values; its largest forces
then occur at t = 0. The time of the largest F_A, one drive speed, or the sign of the acceleration at the start would decide."""


def claims() -> list[Claim]:
    """Each guess as a row."""
    return list(_rows())


def _rows() -> Iterator[Claim]:
    for name, guess in guesses().items():
        found = outcome(guess)
        yield Claim(
            f"all ten numbers at once: {name}", "the ten numbers", _text(found, ".2f"),
            [Fitted(*both) for both in zip(map(float, ASKED), map(float, found), UNITS, strict=True)],
            f"{_said(guess)}{met(found)} of 10 within 5 %; root mean square {100.0 * mismatch(found):.1f} %",
            stored="python docs/make_conditions.py", trial=True,
        )  # fmt: skip


def _said(guess: Conditions) -> str:
    return f"ε₀ = {guess.eps_0:.3g}, m = {guess.m:.3g}; " if guess.eps_0 else ""


def _text(values: Array, digits: str) -> str:
    cells = [f"{value:{digits}}" for value in values]
    parts = (" / ".join(cells[k : k + 3]) for k in (0, 3, 6))
    return "F_A {} N; F_B {} N; start {} m/s² (nominal / 1 / 2); rig {} m/s²".format(*parts, cells[9])
