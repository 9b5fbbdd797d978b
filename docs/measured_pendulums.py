"""Fit a measured pendulum that swings down to rest, and predict the rest of its record: the numbers of measured.md.

    python docs/measured_pendulums.py FILE [--mass 0.2235] [--skip 10]

FILE has lines "time [s], angle from the upright position [rad]", and more columns, which are not read. The first half
of the record is fitted with each law of friction, the second half predicted.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

import linkages

GRAVITY = 9.82  # m/s2, as in the source
RADIUS = 0.004  # m; assumed: only its product with the coefficient matters
MACHINE = """<sdf version="1.9"><model name="pendulum">
<link name="arm"><inertial><pose>0 -{length} 0 0 0 0</pose><mass>{mass}</mass>
<inertia><ixx>1e-9</ixx><iyy>1e-9</iyy><izz>1e-9</izz></inertia></inertial></link>
<joint name="O" type="revolute"><parent>world</parent><child>arm</child><axis><xyz>0 0 1</xyz></axis></joint>
</model></sdf>"""
EXPERIMENT = """mechanism = "pendulum.sdf"
duration = {duration}
gravity = [0.0, -{gravity}, 0.0]
[drives.O]
torque = 0.0
angle = {angle}
speed = {rate}
[frictions.pin]
joint = "O"
speed = 0.01
constant = {constant}
viscous = {viscous}
coefficient = {coefficient}
radius = {radius}
[solver]
integrator = "dormand_prince_5_4"
accuracy = 1e-9
"""
LAWS = {"constant + viscous": ("constant", "viscous"), "constant + coefficient": ("constant", "coefficient")}
START = {"constant": 3e-3, "viscous": 5e-4, "coefficient": 0.1}


def fit(
    times: np.ndarray, angles: np.ndarray, mass: float, names: tuple[str, ...]
) -> tuple[dict[str, float], np.ndarray]:
    """Fit start, length and the named frictions to the first half of a record; return them, and all residuals [rad]."""
    rate = float(np.polyfit(times[:7], angles[:7], 1)[0])
    values = {"angle": float(angles[0]), "rate": rate, "length": 0.32 if mass < 0.24 else 0.2}
    values |= {name: START[name] for name in names}
    half = int(np.searchsorted(times, times[-1] / 2.0))
    with tempfile.TemporaryDirectory() as folder:

        def residuals(x: np.ndarray, count: int) -> np.ndarray:
            given = {"constant": 0.0, "viscous": 0.0, "coefficient": 0.0} | dict(zip(values, x, strict=True))
            (Path(folder) / "pendulum.sdf").write_text(MACHINE.format(mass=mass, **given))
            path = Path(folder) / "pendulum.toml"
            path.write_text(EXPERIMENT.format(duration=times[count - 1], gravity=GRAVITY, radius=RADIUS, **given))
            return linkages.simulate(linkages.load(path), "compiled").evaluate(times[:count])["q.O"] - angles[:count]

        found = np.array(list(values.values()))
        for count in (400, 1200, 2500, half):  # from a short record to the whole half: one minimum
            count = min(count, half)
            found = least_squares(
                residuals, found, x_scale=np.abs(found) + 1e-4, diff_step=1e-4, max_nfev=40, args=(count,),
                bounds=([-np.inf, -np.inf, *[0.0] * (len(found) - 2)], np.inf),
            ).x  # fmt: skip
        return dict(zip(values, found, strict=True)), residuals(found, len(times))


def crossings(angles: np.ndarray) -> np.ndarray:
    """Return the samples before the lowest position is passed; the next ones belong to another half swing."""
    return np.flatnonzero(angles[1:] * angles[:-1] < 0.0)


def main() -> None:
    """Print the root mean squares of fit and prediction."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", type=Path)
    parser.add_argument("--mass", type=float, required=True, help="[kg]")
    parser.add_argument("--skip", type=int, default=10, help="half swings that are left out")
    given = parser.parse_args()
    record = np.loadtxt(given.file, delimiter=",")
    angles = record[:, 1] - np.pi
    first = crossings(angles)[given.skip] if given.skip else int(np.argmax(np.abs(angles) < 2.9))
    times, angles = record[first:, 0] - record[first, 0], angles[first:]
    half = int(np.searchsorted(times, times[-1] / 2.0))
    for law, names in LAWS.items():
        values, left = fit(times, angles, given.mass, names)
        fitted, predicted = (np.sqrt(np.mean(part**2)) for part in (left[:half], left[half:]))
        print(f"{law}: fit {fitted:.5f} rad, prediction {predicted:.5f} rad;", end=" ")
        print(", ".join(f"{name} {value:.5g}" for name, value in values.items()), flush=True)


if __name__ == "__main__":
    main()
