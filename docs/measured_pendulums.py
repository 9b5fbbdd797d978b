"""Fit a measured pendulum that swings down to rest, and predict the rest of its record: the numbers of measured.md.

    python docs/measured_pendulums.py FILE --mass 0.2235 [--skip 10] [--out FOLDER]

FILE has lines "time [s], angle from the upright position [rad]", and more columns, which are not read. The first half
of the record is fitted with each law of friction, the second half predicted. The folder keeps the files of
``linkages identify``: an identification for each law.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

import numpy as np

from linkages.cli.main import main as linkages

MACHINE = """<sdf version="1.9"><model name="pendulum">
<link name="arm"><inertial><pose>0 -0.25 0 0 0 0</pose><mass>{mass}</mass>
<inertia><ixx>1e-9</ixx><iyy>1e-9</iyy><izz>1e-9</izz></inertia></inertial></link>
<joint name="O" type="revolute"><parent>world</parent><child>arm</child><axis><xyz>0 0 1</xyz></axis></joint>
</model></sdf>
"""
#: Gravity as in the source. The radius is assumed: only its product with the coefficient matters.
EXPERIMENT = """mechanism = "pendulum.sdf"
duration = {duration}
gravity = [0.0, -9.82, 0.0]
[drives.O]
torque = 0.0
angle = {angle}
speed = {rate}
[frictions.pin]
joint = "O"
speed = 0.01
constant = 3e-3
radius = 0.004
[solver]
integrator = "dormand_prince_5_4"
accuracy = 1e-9
"""
TASK = """experiment = "pendulum.toml"
[data.swing]
file = "swing.csv"
columns.angle.output = "q.O"
[fit]
windows = "grow"  # from a short record to the whole half: one minimum
predict = 0.5
time = 300
[unknowns]
length = {{ path = "sdf.links.arm.com.y", lower = -0.5, upper = -0.1, start = {length} }}
angle = {{ path = "drives.O.angle", lower = -3.15, upper = 3.15 }}
rate = {{ path = "drives.O.speed", lower = -20.0, upper = 20.0 }}
constant = {{ path = "frictions.pin.constant", lower = 3e-4, upper = 3e-2 }}
"""
LAWS = {
    "viscous": 'viscous = { path = "frictions.pin.viscous", lower = 1e-6, upper = 1e-2, start = 5e-4 }',
    "joint_force": 'coefficient = { path = "frictions.pin.coefficient", lower = 1e-3, upper = 1.0, start = 0.1 }',
}


def write_files(record: np.ndarray, mass: float, skip: int, folder: Path) -> None:
    """Write machine, experiment, the samples from a half swing on, and an identification for each law."""
    angles = record[:, 1] - np.pi
    passed = np.flatnonzero(angles[1:] * angles[:-1] < 0.0)  # samples before the lowest position
    first = passed[skip] if skip else int(np.argmax(np.abs(angles) < 2.9))
    times, angles = record[first:, 0] - record[first, 0], angles[first:]
    start = {"angle": angles[0], "rate": np.polyfit(times[:7], angles[:7], 1)[0]}
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "pendulum.sdf").write_text(MACHINE.format(mass=mass))
    (folder / "pendulum.toml").write_text(EXPERIMENT.format(duration=times[-1], **start))
    np.savetxt(folder / "swing.csv", np.column_stack([times, angles]), delimiter=",", header="time,angle", comments="")
    period = np.diff(passed)[-10:].mean() * 2.0 * np.diff(times).mean()  # of the last, small swings
    for law, line in LAWS.items():
        (folder / f"{law}.toml").write_text(TASK.format(length=-9.82 * (period / (2.0 * np.pi)) ** 2) + line)


def main() -> None:
    """Print the result of each law: values, root mean squares of fit and prediction."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", type=Path)
    parser.add_argument("--mass", type=float, required=True, help="[kg]")
    parser.add_argument("--skip", type=int, default=10, help="half swings that are left out")
    parser.add_argument("--out", type=Path, default=Path(tempfile.gettempdir()) / "pendulum")
    given = parser.parse_args()
    write_files(np.loadtxt(given.file, delimiter=","), given.mass, given.skip, given.out)
    for law in LAWS:
        linkages(["identify", str(given.out / f"{law}.toml"), "--out", str(given.out / law)])


if __name__ == "__main__":
    main()
