"""What the press paper's missing data could be: guesses against all nine numbers of figures 8 and 10 at once."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from linkages import find_file, load, simulate_batch
from replication import press_paper as paper
from replication.claims import change
from replication.press_paper import DESIGNS, PRINTED, Array
from replication.verdicts import Claim, Number

OUTPUTS = ("A.force", "B.force", "slider7.ax")
#: omega_1, omega_4 [rad/s]; by how much both cranks turn until the start [s]; eps_0; m.
PATHS = ("drives.O1.speed", "drives.O4.speed", "start", "eps_0", "m")
ASSUMED = (2.0 * np.pi, 2.0 * np.pi, 0.0, 0.0, 0.0)
#: Guesses; the drives' speeds that meet both nominal forces are rounded.
FOUND: dict[str, tuple[float, ...]] = {"both nominal forces met": (-1.40, -12.2, 0.0, 0.0, 0.0)}


def overrides(guess: Sequence[float]) -> dict[str, Any]:
    """Values by path of a guess in the order of `PATHS`."""
    one, four, start, ratio, power = map(float, guess)
    found: dict[str, Any] = {"drives.O1.speed": one, "drives.O4.speed": four, "duration": paper.DURATION}
    if start:
        found |= {"drives.O1.angle": one * start, "drives.O4.angle": four * start}
    if ratio:
        found |= {f"joints.{j}.small_eccentricity": {"ratio": ratio, "power": power} for j in "AB"}
    return found


def outcome(guess: Sequence[float]) -> Array:
    """Compute forces A and B and the slider's largest acceleration, with its sign, of the three designs, (3, 3); NaN if one fails."""
    nominal = load(find_file("seven_bar.toml"), overrides(guess))
    paths = list(DESIGNS["paper 1"])
    values = [[design.get(path, nominal.value(path)) for path in paths] for design in DESIGNS.values()]
    batch = simulate_batch(nominal, paths, values, OUTPUTS)
    return np.asarray(batch.maximum[:, 0])


def mismatch(guess: Sequence[float]) -> float:
    """Root mean square of the logarithms of ours over printed, of all nine; a wrong sign counts as a factor of 10."""
    printed = np.array([[PRINTED[name][design] for name in OUTPUTS] for design in DESIGNS])
    with np.errstate(all="ignore"):
        apart = np.abs(np.log(outcome(guess) / printed))
    return float(np.sqrt(np.mean(np.minimum(np.nan_to_num(apart, nan=np.log(10.0)), np.log(10.0)) ** 2)))


def claims() -> list[Claim]:
    """Each guess as a row."""
    return list(_rows())


def _rows() -> Iterator[Claim]:
    for name, guess in {"as assumed here": ASSUMED, **FOUND}.items():
        found = outcome(guess)
        one, four, start, ratio, power = guess
        patch = f", ε₀ = {ratio:.2g}, m = {power:.2g}" if ratio else ""
        begun = f", started {start:.2f} s later" if start else ""
        changes = [[change(found[0, k], found[d, k]) for d in (1, 2)] for k in (0, 1)]
        text = [" / ".join(f"{value:.2f}" for value in column) for column in found.T]
        asked = [" / ".join(f"{value:g}" for value in PRINTED[output].values()) for output in OUTPUTS]
        yield Claim(
            f"all at once: ω₁ = {one:.2f}, ω₄ = {four:.2f} rad/s{begun}{patch} ({name})",
            f"F_A {asked[0]} N; F_B {asked[1]} N; a {asked[2]} m/s² (nominal / 1 / 2)",
            f"F_A {text[0]} N; F_B {text[1]} N; a {text[2]} m/s²",
            [Number(PRINTED[output][design], found[i, k]) for k, output in enumerate(OUTPUTS) for i, design in enumerate(DESIGNS)],
            f"design 1 changes F_A by {changes[0][0]:+.1f} % and F_B by {changes[1][0]:+.1f} %, design 2 by {changes[0][1]:+.1f} % and"
            f" {changes[1][1]:+.1f} %; root mean square of the misses, a factor of {np.exp(mismatch(guess)):.2f}",
            "other speeds, start, ε₀ or m",
        )  # fmt: skip
