"""What the press paper's missing data could be: guesses against the nine numbers of figures 8 and 10 and the rig's, at once."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache
from typing import Any

import numpy as np

from linkages import System, find_file, load, simulate_batch
from replication import press_paper as paper
from replication.claims import change
from replication.measured import read
from replication.press_paper import DESIGNS, PRINTED, RIG, Array
from replication.verdicts import Claim, Number

OUTPUTS = ("A.force", "B.force", "slider7.ax")
#: Printed numbers, signs and all: each output's of the three designs, and the acceleration computed for the rig.
ASKED = np.array([*(PRINTED[name][design] for name in OUTPUTS for design in DESIGNS), RIG["computed"]])
UNITS = ("N",) * 6 + ("m/s²",) * 4
#: Drives' speeds [rad/s]; by how long both cranks have turned when the run starts [s]; eps_0 and m of eqs. (12)-(13).
MISSING = ("omega_1", "omega_4", "start", "eps_0", "m")
ASSUMED = (2.0 * np.pi, 2.0 * np.pi, 0.0, 0.0, 0.0)
#: Speeds that meet the nominal forces, rounded.
FORCES_MET = (-1.40, -12.2, 0.0, 0.0, 0.0)
_WORST = np.log(10.0)  # a wrong sign counts as a factor of 10, and so does a run that fails


def overrides(guess: Sequence[float]) -> dict[str, Any]:
    """Values by path of a guess in the order of `MISSING`."""
    one, four, start, ratio, power = map(float, guess)
    found: dict[str, Any] = {"drives.O1.speed": one, "drives.O4.speed": four}
    if start:
        found |= {"drives.O1.angle": one * start, "drives.O4.angle": four * start}
    if ratio:
        found |= {f"joints.{j}.small_eccentricity": {"ratio": ratio, "power": power} for j in "AB"}
    return found


@cache
def _machine(name: str, duration: float) -> System:
    return load(find_file(name), {"duration": duration})


def outcome(guess: Sequence[float]) -> Array:
    """Compute what `ASKED` has: largest forces, largest accelerations along +x, (10,); NaN of a run that fails."""
    press, rig = (
        _machine(name, periods * paper.DURATION).replaced(overrides(guess))
        for name, periods in (("seven_bar.toml", 1.0), ("seven_bar_rig.toml", 2.0))
    )
    paths = list(DESIGNS["paper 1"])
    values = [[design.get(path, press.value(path)) for path in paths] for design in DESIGNS.values()]
    designs = simulate_batch(press, paths, values, OUTPUTS).maximum[:, 0]
    return np.append(designs.T.ravel(), simulate_batch(rig, outputs=OUTPUTS[2:]).maximum[0, 0])


def mismatch(found: Array) -> float:
    """Root mean square of the logarithms of ours over printed."""
    with np.errstate(all="ignore"):
        apart = np.abs(np.log(found / ASKED))
    return float(np.sqrt(np.mean(np.minimum(np.nan_to_num(apart, nan=_WORST), _WORST) ** 2)))


def guesses() -> dict[str, Sequence[float]]:
    """Name guesses: what is assumed, what meets the nominal forces, and what scans have found."""
    scans = read("press_missing")["scans"]
    found = {f"best of {scan['evaluations']} guesses, {name}": scan["guess"] for name, scan in scans.items()}
    return {"as assumed here": ASSUMED, "both nominal forces met": FORCES_MET, **found}


def marked() -> dict[str, tuple[float, float]]:
    """Both speeds of the guesses that the map of speeds has: all else as assumed."""
    return {name: (one, four) for name, (one, four, *rest) in guesses().items() if tuple(rest) == ASSUMED[2:]}


def claims() -> list[Claim]:
    """Each guess as a row."""
    return list(_rows())


def _rows() -> Iterator[Claim]:
    for name, guess in guesses().items():
        found = outcome(guess)
        one, four, start, ratio, power = guess
        patch = f", ε₀ = {ratio:.2g}, m = {power:.2g}" if ratio else ""
        patch += " (no correction)" if ratio and not power else ""
        begun = f", start {start:.2f} s on" if start else ""
        of_a, of_b = ([change(row[0], row[d]) for d in (1, 2)] for row in (found[:3], found[3:6]))
        yield Claim(
            f"all at once: ω₁ = {one:.2f}, ω₄ = {four:.2f} rad/s{begun}{patch} ({name})", _text(ASKED, "g"), _text(found, ".2f"),
            [Number(*both) for both in zip(map(float, ASKED), map(float, found), UNITS, strict=True)],
            f"design 1 changes F_A by {of_a[0]:+.1f} % and F_B by {of_b[0]:+.1f} %, design 2 by {of_a[1]:+.1f} % and"
            f" {of_b[1]:+.1f} %; root mean square of the misses, a factor of {np.exp(mismatch(found)):.2f}",
            "other speeds, start, ε₀ or m",
        )  # fmt: skip


def _text(values: Array, digits: str) -> str:
    cells = [f"{value:{digits}}" for value in values]
    parts = (" / ".join(cells[k : k + 3]) for k in (0, 3, 6))
    return "F_A {} N; F_B {} N; a {} m/s² (nominal / 1 / 2); rig {} m/s²".format(*parts, cells[9])
