"""``linkages export``: the trajectory of a run for other programs."""

from __future__ import annotations

import argparse
from pathlib import Path

from linkages.base.errors import InputError
from linkages.input.files.table_formats import FORMATS

HELP = "write a run's trajectory for other programs: csv, mat, parquet, netcdf"

EXAMPLES = """examples:
  linkages export results/seven_bar --to csv
  linkages export results/seven_bar --to mat --out press.mat
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.add_argument("folder", type=Path, metavar="DIR", help="folder that `linkages simulate` wrote")
    parser.add_argument("--to", choices=tuple(FORMATS), required=True, help="format")
    parser.add_argument("--out", type=Path, metavar="FILE", help="default: DIR/trajectory.csv, .mat, .parquet or .nc")


def run(options: argparse.Namespace) -> int:
    """Write the file; return the exit status."""
    from linkages.input.files.writing import whole
    from linkages.results.trajectory import load_trajectory

    source = options.folder / "trajectory.npz"
    if not source.exists():
        problem = "has no trajectory.npz" if options.folder.is_dir() else "is not a folder"
        raise InputError(str(options.folder), "", f"{problem}; give the --out folder of `linkages simulate`")
    run = load_trajectory(source)
    write, end = FORMATS[options.to]
    path = options.out or options.folder / f"trajectory{end}"
    with whole(path) as partial:
        write(partial, run.columns, run.units, run.about)
    print(f"written: {path}, {len(run.columns)} columns of {len(run.time)} steps, {path.stat().st_size / 1e6:.1f} MB")
    return 0
