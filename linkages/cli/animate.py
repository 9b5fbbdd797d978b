"""``linkages animate``: a run as a GIF or MP4 file."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from linkages.base.errors import InputError
from linkages.cli.options import add_part, part_of, stored_run
from linkages.cli.printing import show

if TYPE_CHECKING:
    from linkages.system import System

HELP = "write a run as a GIF or MP4 file"

EXAMPLES = """examples:
  linkages animate results/seven_bar
  linkages animate results/seven_bar --format mp4 --seconds 10 --from 0.2 --to 0.8
"""
_MOST = 120.0  # seconds of an animation


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.add_argument("folder", type=Path, metavar="DIR", help="folder that `linkages simulate` wrote")
    parser.add_argument("--format", dest="kind", choices=("gif", "mp4"), default="gif", help="default: gif")
    meaning = "duration of the animation; default: 4 s"
    parser.add_argument("--seconds", type=float, default=4.0, metavar="SECONDS", help=meaning)
    add_part(parser, "the last period of a periodic motion, else all")
    parser.add_argument("--out", type=Path, metavar="FILE", help="default: DIR/animation.gif or .mp4")


def run(options: argparse.Namespace) -> int:
    """Write the animation; return the exit status."""
    from linkages.input.files.writing import whole
    from linkages.show.plots.drawing import draw
    from linkages.show.plots.drawing.moving import write_moving
    from linkages.show.report.result_folder import load_results, recorded_system

    if not 0.0 < options.seconds <= _MOST:
        raise InputError("--seconds", f"{options.seconds:g}", f"must be above 0 and at most {_MOST:g}")
    results = load_results(options.folder)
    steady = results.summary.get("windows", {}).get("steady", {})
    if getattr(options, "from") is options.to is None:
        setattr(options, "from", steady.get("from"))
        options.to = steady.get("to")
    run, system = stored_run(options.folder), recorded_system(results)
    if not steady and getattr(options, "from") is options.to is None:
        setattr(options, "from", _last_period(system, float(run.time[-1])))
    trajectory = part_of(run, options.folder, options)
    path = options.out or options.folder / f"animation.{options.kind}"
    with whole(path) as partial:
        count = write_moving(draw(system), system, trajectory, partial, options.kind, options.seconds)
    show(f"written: {path}, {count} frames, {path.stat().st_size / 1e6:.1f} MB")
    return 0


def _last_period(system: System, end: float) -> float | None:
    """Return when the last period of a linkage with ideal joints and rigid links begins, whose motion repeats [s]."""
    from linkages.results.steady_state import common_period

    if system.imperfect or not system.drives or any(not one.prescribed for one in system.drives.values()):
        return None
    period = common_period(system)
    return end - period if period is not None and period <= end else None
