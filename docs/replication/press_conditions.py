"""Conditions that the press paper does not print, and the ten printed numbers that could determine them.

Unknown are gravity, the speeds of both cranks, the start, and eps_0 and m of eqs. (12)-(13). Given are six largest forces in their
windows, three accelerations at the start (figure 8) and the largest acceleration computed for the rig (figure 5).
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from linkages import System, extremes, find_file, load, simulate, simulate_batch
from replication import press_paper as paper
from replication.measured import read
from replication.press_ideal import BAUMGARTE, FORCES, GRAVITY
from replication.press_paper import DESIGNS, PRINTED, RIG, START, WINDOWS, Array
from replication.verdicts import Claim, Fitted

#: Printed numbers: forces as `FORCES` [N], sizes of the accelerations at the start, and the one of the rig [m/s2].
ASKED = np.array([*FORCES, *PRINTED["slider7.ax"].values(), RIG["computed"]])
UNITS = ("N",) * 6 + ("m/s²",) * 4
_WORST = np.log(10.0)  # a wrong sign counts as a factor of 10, and so does a run that fails
_SPIKE, _LATER = (0.0, START), (START, paper.DURATION)


class Conditions(NamedTuple):
    """A guess at all that is not printed."""

    omega_1: float = 2.0 * np.pi  # rad/s
    omega_4: float = 2.0 * np.pi  # rad/s
    eps_0: float = 0.0  # of eqs. (12)-(13); 0: without them
    m: float = 0.0
    gravity: str = "none"  # a key of `GRAVITY`
    start: str = (
        "moving"  # "moving": ideal velocities, centred; "at rest"; "offset": B as far off as eq. (17) leaves it
    )
    size: float = 9.81  # of gravity [m/s2]


#: Unknowns whose profiles are kept, as a reader knows them.
LABELS = {"omega_1": "ω₁ [rad/s]", "omega_4": "ω₄ [rad/s]", "eps_0": "ε₀", "m": "m", "size": "gravity along -y [m/s²]"}
#: A profile below this many times its least value does not tell values apart: the printed numbers themselves have three digits.
LOOSE = 1.5
#: The scenario of other senses of rotation.
SAME_SENSE = "gravity -y, start moving, (12)-(13), both speeds positive"
#: What `seven_bar.toml` assumes.
ASSUMED = Conditions()


def overrides(guess: Conditions) -> dict[str, Any]:
    """Values of an experiment by path."""
    pull = GRAVITY[guess.gravity] * guess.size / 9.81
    found: dict[str, Any] = {"gravity": [pull.real, pull.imag, 0.0]}
    for drive, speed in (("O1", guess.omega_1), ("O4", guess.omega_4)):
        if guess.start == "at rest":
            found[f"drives.{drive}"] = {"formula": f"{float(speed)!r}*t*(1 - exp(-{BAUMGARTE:g}*t))"}
        else:
            found[f"drives.{drive}.speed"] = float(speed)
    if guess.start == "offset":
        found["joints.B.offset"] = offset()
    if guess.eps_0:
        found |= {f"joints.{j}.small_eccentricity": {"ratio": guess.eps_0, "power": guess.m} for j in "AB"}
    return found


def offset() -> list[float]:
    """Give the eccentricity that the rounded angles of eq. (17) leave in joint B [m].

    With A centred, link 2 along x and the slider at S_0 = 560 mm, C is at (260, 0) mm and link 3 too long by 0.25 mm.
    """
    value = load(find_file("seven_bar.toml")).value
    crank, rod = value("sdf.frames.crank4_B.pose.x"), value("sdf.frames.link3_C.pose.x")
    pin = value("sdf.frames.crank1_A.pose.x") + value("sdf.frames.link2_C.pose.x")
    across = crank * np.exp(1j * np.radians(310.79)) + 1j * value("sdf.frames.ground_O4.pose.y") - pin
    left = across * (rod / abs(across) - 1.0)
    return [float(left.real), float(left.imag)]


@cache
def _machine(name: str, duration: float) -> System:
    return load(find_file(name), {"duration": duration})


def outcome(guess: Conditions) -> Array:
    """Compute what `ASKED` has, (10,); NaN of a run that fails.

    The acceleration at the start counts by its size; for the rig the paper measures two periods after the start.
    """
    press = _machine("seven_bar.toml", paper.DURATION).replaced(overrides(guess))
    centred = guess._replace(start="moving") if guess.start == "offset" else guess  # the rig's clearance is smaller
    rig = _machine("seven_bar_rig.toml", 2.0 * paper.DURATION).replaced(overrides(centred))
    paths = list(DESIGNS["paper 1"])
    values = [[design.get(path, press.value(path)) for path in paths] for design in DESIGNS.values()]
    windows = [*((0.0, end) for end in WINDOWS.values()), _SPIKE]
    found = simulate_batch(press, paths, values, (*WINDOWS, "slider7.ax"), windows)
    settled = simulate_batch(rig, outputs=("slider7.ax",), windows=[(START, 2.0 * paper.DURATION)])
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
    """Name guesses: what is assumed, and the best of each scenario."""
    fits = read("press_conditions").get("fits", {})
    return {"as seven_bar.toml assumes": ASSUMED, **{name: Conditions(*fit["guess"]) for name, fit in fits.items()}}


def best() -> Conditions:
    """Give the conditions that miss least of all scenarios: those of `PAPER`."""
    fits = read("press_conditions")["fits"]
    return Conditions(*min(fits.values(), key=lambda fit: fit["mismatch"])["guess"])


def determined(name: str) -> str:
    """Say between which held values of an unknown the others reach less than `LOOSE` times the least mismatch."""
    found = read("press_conditions")["profiles"][name]
    values, least = found["values"], min(found["mismatch"])
    near = [n for n, miss in enumerate(found["mismatch"]) if miss < LOOSE * least]
    ends = [f"above {values[near[0] - 1]:g}"] if near[0] else []
    ends += [f"below {values[near[-1] + 1]:g}"] if near[-1] + 1 < len(values) else []
    return " and ".join(ends)


def maps_table() -> tuple[list[str], list[list[str]]]:
    """Head and rows of the maps of the ideal press, by gravity and start."""
    head = ["gravity, start", "points below 5 %", "below 10 %", "best", "at ω₁, ω₄ [rad/s]", "slider there [m/s²]"]
    rows = []
    for name, found in read("press_conditions")["maps"].items():
        low, high = sorted(found["acceleration"])
        cells = [*map(str, found["below"]), f"{100.0 * found['best']:.1f} %", "{:g}, {:g}".format(*found["speeds"])]
        rows.append([name, *cells, f"{low:.1f} to {high:.1f}"])
    return head, rows


def profiles_table() -> tuple[list[str], list[list[str]]]:
    """Head and rows of the profiles: the least mismatch with one unknown held."""
    head = ["unknown", "best", "least miss of all ten numbers, held at", f"within {LOOSE:g} times the least"]
    at = best()._asdict()
    rows = []
    for name, label in LABELS.items():
        found = read("press_conditions")["profiles"][name]
        pairs = zip(found["values"], found["mismatch"], strict=True)
        rows.append(
            [label, f"{at[name]:.4g}", ", ".join(f"{v:g}: {100.0 * miss:.1f} %" for v, miss in pairs), determined(name)]
        )
    return head, rows


def natural_table() -> tuple[list[str], list[list[str]]]:
    """Head and rows of the best round speeds, without eqs. (12)-(13)."""
    found = [(Conditions(*row["guess"]), row) for row in read("press_conditions")["natural"]]
    rows = [[row["kind"], f"{c.omega_1:.3f}, {c.omega_4:.3f}", f"{100.0 * row['mismatch']:.1f} %"] for c, row in found]
    return ["speeds", "ω₁, ω₄ [rad/s]", "miss of all ten numbers"], rows


def conclusion() -> str:
    """Describe the determined conditions and the numbers that determine them."""
    fits, one = read("press_conditions")["fits"], best()
    found, others = outcome(one), sorted(((fit["mismatch"], name) for name, fit in fits.items()))[1:]
    ranges = ", ".join(f"{label} {determined(name)}" for name, label in LABELS.items())
    return f"""With four fitted values and the direction of gravity {met(found)} of ten printed numbers are met within 5 % and all within
{100.0 * np.abs(misses(found)).max():.1f} %. The root mean square of the deviations is {100.0 * mismatch(found):.1f} %; the next best scenario ({others[0][1]}) has {100.0 * others[0][0]:.1f} %. Four of the
numbers, the accelerations at the start and on the rig, are met by four fitted values: this alone is no evidence. Only the six forces can contradict
the fit; they differ by at most 7 %. The fit does not meet the small changes of the forces from design to design.
All unknowns with a deviation of at most {LOOSE:g} times the smallest lie in these ranges: {ranges}. The magnitude of gravity is thus determined correctly; m is only known to be
positive. A start at rest, or gravity in another direction, gives larger deviations with as many unknowns. Speeds of equal sign give
{100.0 * fits[SAME_SENSE]["mismatch"]:.1f} %; there the largest F_A is at {_time_of_a(Conditions(*fits[SAME_SENSE]["guess"])):.2f} s, here at {_time_of_a(one):.2f} s. Any one of three numbers would decide between the scenarios:
the time of the largest F_A, a drive speed, or the sign of the acceleration at the start."""


def _time_of_a(guess: Conditions) -> float:
    """Time of the largest F_A in its window [s]."""
    run = simulate(_machine("seven_bar.toml", WINDOWS["A.force"]).replaced(overrides(guess)), paper.ENGINE)
    return extremes(run, ["A.force"])["A.force"].time


def claims() -> list[Claim]:
    """Each guess as a row."""
    return list(_rows())


def _rows() -> Iterator[Claim]:
    for name, guess in guesses().items():
        found = outcome(guess)
        yield Claim(
            f"all ten numbers at once: {name}", _text(ASKED, "g"), _text(found, ".2f"),
            [Fitted(*both) for both in zip(map(float, ASKED), map(float, found), UNITS, strict=True)],
            f"{_said(guess)}. {met(found)} of 10 within 5 %; root mean square {100.0 * mismatch(found):.1f} %", "other conditions",
            stored="python docs/make_conditions.py", trial=True,
        )  # fmt: skip


def _said(guess: Conditions) -> str:
    patch = f", ε₀ = {guess.eps_0:.3g}, m = {guess.m:.3g}" if guess.eps_0 else ""
    return (
        f"Gravity {guess.gravity}, ω₁ = {guess.omega_1:.3f}, ω₄ = {guess.omega_4:.3f} rad/s, start {guess.start}{patch}"
    )


def _text(values: Array, digits: str) -> str:
    cells = [f"{value:{digits}}" for value in values]
    parts = (" / ".join(cells[k : k + 3]) for k in (0, 3, 6))
    return "F_A {} N; F_B {} N; start {} m/s² (nominal / 1 / 2); rig {} m/s²".format(*parts, cells[9])
