"""``linkages continue``: branches of periodic motions over one value, with their stability and bifurcations."""

from __future__ import annotations

import argparse
import cmath
import math
import sys
from typing import TYPE_CHECKING, Any

from linkages.cli.folders import output_folder, results_folder
from linkages.cli.options import add_file, add_outputs, add_settings, load_system, output_names, written
from linkages.cli.progress import stages
from linkages.cli.ranges import path_and_range, value_of
from linkages.errors import InputError, Status
from linkages.files.writing import json_text

if TYPE_CHECKING:
    from linkages.explore.periodic.branches import Branch, Branches
    from linkages.explore.periodic.motion import PeriodicMotion

HELP = "branches of stable and unstable periodic motions over one value, and their bifurcations"

_EXAMPLES = """examples:
  linkages continue slider_crank_lubricated.toml --vary drives.O.speed=100:150 --transient 5 --output B.force
  linkages continue my.toml --vary drives.O.speed=100:600 --start 300 --periods 2 --output B.force --sweep 40
"""
_REMEDIES = {
    "most": "larger steps (--step) follow it further",
    "lost": "smaller steps (--step) and tighter runs (--accuracy) may follow it further",
}


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    from linkages.explore.periodic.settings import ACCURACY, STEP, TOLERANCE

    parser.epilog = _EXAMPLES
    add_file(parser)
    parser.add_argument("--vary", required=True, metavar="PATH=LO:HI", help="the value and its range")
    parser.add_argument("--start", metavar="VALUE", help="value of the first motion; default: LO")
    parser.add_argument(
        "--periods",
        type=int,
        default=1,
        metavar="K",
        help="drive periods in a period of the motion; default: %(default)s",
    )
    parser.add_argument(
        "--transient",
        type=int,
        default=50,
        metavar="M",
        help="drive periods from the experiment's start to the guess of the first motion; default: %(default)s",
    )
    parser.add_argument(
        "--doublings",
        type=int,
        default=2,
        metavar="N",
        help="period doublings in sequence at which branches are followed; default: %(default)s",
    )
    parser.add_argument(
        "--step", type=float, default=STEP, metavar="X", help="largest step over the range; default: %(default)s"
    )
    parser.add_argument(
        "--accuracy", type=float, default=ACCURACY, metavar="X", help="accuracy of the runs; default: %(default)s"
    )
    parser.add_argument(
        "--tolerance",
        type=float,
        default=TOLERANCE,
        metavar="X",
        help="tolerance of the residual; default: %(default)s",
    )
    add_outputs(parser)
    parser.add_argument(
        "--sweep", type=int, default=0, metavar="N", help="N values of a sweep in the same diagram; default: none"
    )
    add_settings(parser, lasting=False)
    parser.add_argument("--no-plots", action="store_true", help="write no figure")


def run(options: argparse.Namespace) -> int:
    """Follow the branches; return the exit status."""
    from linkages.explore.periodic.branches import branches
    from linkages.explore.sweep import sweep
    from linkages.model.experiment import value_unit
    from linkages.outputs.registry import unit

    _check(options)
    path, low, high = path_and_range(options.vary)
    start = None if options.start is None else value_of("--start", options.start, path)
    system = load_system(options)
    system.replaced({path: low}, "--vary")  # reports a wrong path before the folder of results is made
    out = output_folder(options, f"{system.experiment.source.stem}_branches", "continue")
    names = output_names(options, system.experiment)
    bars = stages(options, 1.0, "")
    keys = ("periods", "transient", "doublings", "step", "accuracy", "tolerance")
    settings = {key: getattr(options, key) for key in keys}
    found = branches(system, path, low, high, start, names, **settings, progress=bars("branches"), origin="--vary")
    points, whole = None, found.status is Status.OK
    if options.sweep and whole:
        values = [low + (high - low) * k / (options.sweep - 1) for k in range(options.sweep)]
        turns = (8 * options.periods, options.transient)
        points = sweep(system, path, values, names, *turns, progress=bars("sweep"), origin="--vary")
        whole = points.status is Status.OK
    units = {name: unit(system, name) for name in names}
    result = content(found, units)
    with (outputs := results_folder(out, "continue")) as folder:
        (folder / "branches.json").write_text(json_text(result), encoding="utf-8")
        if not options.no_plots:
            from linkages.plots.attractors import branches_figure
            from linkages.plots.style import axis_label, engineering, write_png

            shown, factor = engineering(value_unit(path), max(abs(low), abs(high)))
            figure = branches_figure(found, units, axis_label(path, shown), factor, points)
            write_png(figure, folder / "branches.png")
    if not options.quiet:
        print(format_branches(found, units))
        print(f"\n{written(out, outputs.names)}")
    if not whole:
        print("interrupted; the results up to then are written", file=sys.stderr)
    return 0 if whole else 130


def content(found: Branches, units: dict[str, str]) -> dict[str, Any]:
    """Return the content of ``branches.json``, SI units; docs/periodic.md explains it."""
    return {
        "path": found.path,
        "range": [found.low, found.high],
        "units": units,
        "branches": [
            {
                "periods": branch.periods,
                "source": None if branch.source is None else list(branch.source),
                "ends": list(branch.ends),
                "motions": [_motion(motion) for motion in branch.motions],
                "bifurcations": [
                    {
                        "kind": event.kind,
                        "multiplier": [event.multiplier.real, event.multiplier.imag],
                        **_motion(event.motion),
                    }
                    for event in branch.events
                ],
            }
            for branch in found.branches
        ],
    }


def _motion(motion: PeriodicMotion) -> dict[str, Any]:
    section = motion.outputs
    shown = {} if section is None else {
        name: {
            "strobe": section.strobe[name].tolist(),
            "min": section.low[name].tolist(),
            "max": section.high[name].tolist(),
        }
        for name in section.strobe
    }  # fmt: skip
    return {
        "value": motion.value,
        "period": motion.period,
        "stable": motion.stable,
        "residual": motion.residual,
        "multipliers": [[float(x.real), float(x.imag)] for x in motion.multipliers],
        "contacts": list(motion.passage.contacts),
        "state": motion.state,
        "outputs": shown,
    }


def format_branches(found: Branches, units: dict[str, str]) -> str:
    """Format branches and bifurcations as lines of text."""
    from linkages.explore.periodic.tracing import CLOSED, ENDS, LOST, MOST

    lines = [f"{found.path} from {found.low:g} to {found.high:g}"]
    for k, branch in enumerate(found.branches):
        source = "" if branch.source is None else f", from a period doubling of branch {branch.source[0] + 1}"
        source += f"; {ENDS[CLOSED]}" if CLOSED in branch.ends else ""
        lines += ["", f"branch {k + 1}: period of {branch.periods} drive period(s), {_extent(branch)}{source}"]
        lines += [f"  {_line(event.kind, event.motion, event.multiplier)}" for event in branch.events]
    worst = max(motion.residual for branch in found.branches for motion in branch.motions)
    for k, branch in enumerate(found.branches):
        for end in sorted({MOST, LOST}.intersection(branch.ends)):
            lines += ["", f"branch {k + 1} ends because {ENDS[end]}: {_REMEDIES[end]}"]
    lines += ["", f"largest residual {worst:.1g}"]
    return "\n".join(lines)


def _extent(branch: Branch) -> str:
    values = [motion.value or 0.0 for motion in branch.motions]
    stable = sum(motion.stable is True for motion in branch.motions)
    return f"{len(values)} motions from {min(values):.6g} to {max(values):.6g}, {stable} stable"


def _line(kind: str, motion: PeriodicMotion, multiplier: complex) -> str:
    """Describe a bifurcation; the turn of a Neimark-Sacker point is a share of the motion's period."""
    text = f"{kind:18s}{motion.value:14.8g}"
    if kind == "Neimark-Sacker":
        text += f"  turns by {abs(cmath.phase(multiplier)) / (2.0 * math.pi):.4f} in a period"
    return text


def _check(options: argparse.Namespace) -> None:
    """Reject numbers out of range."""
    from linkages.explore.periodic.settings import fault

    for key in ("periods", "transient", "doublings", "step", "accuracy", "tolerance"):
        if problem := fault(key, getattr(options, key)):
            raise InputError(f"--{key}", f"{getattr(options, key):g}", problem)
    if options.sweep != 0 and options.sweep < 2:
        raise InputError("--sweep", str(options.sweep), "must be 2 or more")
