"""Fit a machine to a record of a real one, and predict the rest: the numbers of measured.md.

    python docs/measured_machines.py slider_crank Test1_5pt5V.txt [--out DIR]
    python docs/measured_machines.py four_bar result.csv
    python docs/measured_machines.py double_pendulum record.csv

The records are not part of this project; measured.md names their sources. The folder gets the files of
``docs/measured/MACHINE``, the record in columns, and the results of ``linkages identify fit.toml``.
"""

from __future__ import annotations

import argparse
import csv
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

from linkages.cli.main import main as linkages

HERE = Path(__file__).parent / "measured"
Array = np.ndarray


def write(path: Path, **columns: Array) -> None:
    """Write columns with their names."""
    table = np.column_stack(list(columns.values()))
    np.savetxt(path, table, delimiter=",", header=",".join(columns), comments="", fmt="%.9g")


def slider_crank(record: Path, folder: Path) -> None:
    """Columns: time [s], angle of the wheel [deg], place of the slide [mm]; more are not read."""
    time, wheel, slide = np.loadtxt(record, skiprows=1, usecols=(0, 1, 2)).T
    write(folder / "record.csv", time=time, wheel=wheel, slide=slide)


def double_pendulum(record: Path, folder: Path) -> None:
    """Columns: time [s], angle of the upper link, that of the lower one relative to it [rad], both torques [N m]."""
    time, q1, q2, T1, T2 = np.loadtxt(record, delimiter=",", skiprows=1, usecols=range(5)).T
    write(folder / "record.csv", time=time, q1=q1, q2=q2, T1=T1, T2=T2)


def four_bar(record: Path, folder: Path) -> None:
    """Rates of crank and rocker about the joints' axis, and the time of the day at which each sample arrived.

    Samples arrive in bundles, but are taken at a constant rate: each sensor gets the line through its times. Samples of
    the rocker at the ends are left out, so that the crank's cover them. The crank turns clockwise: in one record its
    sensor was mounted the other way round.
    """
    with open(record, newline="", encoding="utf-8-sig") as file:
        head, *rows = csv.reader(file)
    (t, crank), (u, rocker) = (sensor(head, rows, name) for name in ("crank", "rocker"))
    inside = (u > t[0] + 0.2) & (u < t[-1] - 0.5)
    write(folder / "crank.csv", time=t - t[0], rate=-np.sign(crank.mean()) * crank)
    write(folder / "rocker.csv", time=u[inside] - t[0], rate=rocker[inside])


def sensor(head: list[str], rows: list[list[str]], name: str) -> tuple[Array, Array]:
    """Return times [s] and rates [deg/s] of a sensor."""
    device, rate = head.index("Device name"), next(k for k, x in enumerate(head) if x.startswith("Angular velocity Y"))
    own = [row for row in rows if row[device].strip() == name]
    arrivals = [[float(part) for part in row[0].split(":")] for row in own] @ np.array([3600.0, 60.0, 1.0])
    numbers = np.arange(len(own))
    return np.polyval(np.polyfit(numbers, arrivals, 1), numbers), np.array([float(row[rate]) for row in own])


MACHINES: dict[str, Callable[[Path, Path], None]] = {
    one.__name__: one for one in (slider_crank, four_bar, double_pendulum)
}


def main() -> int:
    """Write the files and fit; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("machine", choices=MACHINES)
    parser.add_argument("record", type=Path, help="your copy")
    parser.add_argument("--out", type=Path, help="default: a folder for temporary files")
    given = parser.parse_args()
    folder = given.out or Path(tempfile.mkdtemp(prefix=f"{given.machine}_"))
    shutil.copytree(HERE / given.machine, folder, dirs_exist_ok=True)
    MACHINES[given.machine](given.record, folder)
    return linkages(["identify", str(folder / "fit.toml"), "--out", str(folder / "result")])


if __name__ == "__main__":
    raise SystemExit(main())
