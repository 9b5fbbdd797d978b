"""``linkages continue``: branches of periodic motions over one value, with their stability and bifurcations."""

from __future__ import annotations

import argparse
import cmath
import math
import sys
from typing import TYPE_CHECKING, Any

from linkages.base.brief import counted
from linkages.base.errors import InputError, Status, listed
from linkages.cli.options import (
    add_experiment,
    add_number,
    add_outputs,
    load_system,
    output_folder,
    output_names,
    path_and_range,
    print_results,
    record,
    value_of,
)
from linkages.cli.progress import stages
from linkages.cli.sweep_tables import columns
from linkages.input.files.writing import write_json

if TYPE_CHECKING:
    from linkages.explore.periodic.branches import Branches
    from linkages.explore.periodic.motion import PeriodicMotion

HELP = "branches of stable and unstable periodic motions over one value, and their bifurcations"
WRITES = {"continue": ("branches.json", "branches.png")}

#: Short runs of this command that compile its code, see `linkages.cli.preparation`.
SHORT_RUNS = ("slider_crank_lubricated.toml --vary drives.O.speed=510:515 --transient 1 --output B.force",)

EXAMPLES = """examples:
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

    add_experiment(parser, lasting=False)
    parser.add_argument("--vary", required=True, metavar="PATH=LO:HI", help="the value and its range")
    parser.add_argument("--start", metavar="VALUE", help="value of the first motion; default: LO")
    before = "drive periods from the experiment's start to the guess of the first motion"
    add_number(parser, "--periods", 1, "K", "drive periods in a period of the motion")
    add_number(parser, "--transient", 50, "M", before)
    add_number(parser, "--doublings", 2, "N", "period doublings in sequence at which branches are followed")
    add_number(parser, "--step", STEP, "X", "largest step over the range")
    add_number(parser, "--accuracy", ACCURACY, "X", "accuracy of the runs")
    add_number(parser, "--tolerance", TOLERANCE, "X", "tolerance of the residual")
    add_outputs(parser)
    add_number(parser, "--sweep", 0, "N", "values of a sweep in the same diagram")


def run(options: argparse.Namespace) -> int:
    """Follow the branches; return the exit status."""
    from linkages.explore.periodic.branches import branches
    from linkages.explore.sweep import sweep
    from linkages.results.outputs.registry import unit

    if options.sweep != 0 and options.sweep < 2:
        raise InputError("--sweep", str(options.sweep), "must be 2 or more")
    system = load_system(options)
    path, low, high = path_and_range(options.vary, system)
    start = None if options.start is None else value_of("--start", options.start, path, system)
    system.replaced({path: low}, "--vary")  # reports a wrong path before the folder of results is made
    out = output_folder(options, f"{system.description.stem}_branches", "continue")
    names = output_names(options, system)
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
    with out as folder:
        write_json(folder / "branches.json", content(found, units), None)
        if not options.no_plots:
            from linkages.show.plots.attractors import branches_figure
            from linkages.show.plots.style import axis_label, engineering, write_figure

            shown, factor = engineering(system.value_unit(path), max(abs(low), abs(high)))
            figure = branches_figure(found, units, axis_label(path, shown), factor, points)
            write_figure(figure, folder / "branches")
        table, title = format_branches(found, units), system.description.heading
        question = f"Which periodic motions exist for {path} from {low:g} to {high:g}, and where do they change?"
        record(options, folder, title, question, _answer(found), table)
    print_results(options, table, out)
    if not whole:
        print("interrupted; the results up to then are written", file=sys.stderr)
    return 0 if whole else 130


def _answer(found: Branches) -> list[str]:
    said = []
    for k, branch in enumerate(found.branches, 1):
        events = [f"{event.kind} at {event.motion.value:.6g}" for event in branch.events]
        stable = sum(motion.stable is True for motion in branch.motions)
        kinds = listed(events) if events else "no bifurcation"
        said.append(f"Branch {k}: {kinds}; {stable} of {counted(len(branch.motions), 'motion')} are stable.")
    return said


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
                    {"kind": event.kind, "multiplier": _pair(event.multiplier), **_motion(event.motion)}
                    for event in branch.events
                ],
            }
            for branch in found.branches
        ],
    }


def _motion(motion: PeriodicMotion) -> dict[str, Any]:
    section = motion.outputs
    return {
        "value": motion.value,
        "period": motion.period,
        "stable": motion.stable,
        "residual": motion.residual,
        "multipliers": [_pair(x) for x in motion.multipliers],
        "contacts": list(motion.passage.contacts),
        "state": motion.state,
        "outputs": {} if section is None else columns(section),
    }


def _pair(number: complex) -> list[float]:
    return [float(number.real), float(number.imag)]


def format_branches(found: Branches, units: dict[str, str]) -> str:
    """Format branches and bifurcations as lines of text."""
    from linkages.explore.periodic.tracing import CLOSED, ENDS, LOST, MOST

    lines = [f"{found.path} from {found.low:g} to {found.high:g}"]
    for k, branch in enumerate(found.branches):
        source = "" if branch.source is None else f", from a period doubling of branch {branch.source[0] + 1}"
        source += f"; {ENDS[CLOSED]}" if CLOSED in branch.ends else ""
        values = [motion.value or 0.0 for motion in branch.motions]
        extent = f"{len(values)} motions from {min(values):.6g} to {max(values):.6g}"
        stable = sum(motion.stable is True for motion in branch.motions)
        period = f"period of {branch.periods} drive period(s)"
        lines += ["", f"branch {k + 1}: {period}, {extent}, {stable} stable{source}"]
        for event in branch.events:
            line = f"  {event.kind:18s}{event.motion.value:14.8g}"
            if event.kind == "Neimark-Sacker":  # which turns by a share of the motion's period
                line += f"  turns by {abs(cmath.phase(event.multiplier)) / (2.0 * math.pi):.4f} in a period"
            lines.append(line)
    worst = max(motion.residual for branch in found.branches for motion in branch.motions)
    for k, branch in enumerate(found.branches):
        for end in sorted({MOST, LOST}.intersection(branch.ends)):
            lines += ["", f"branch {k + 1} ends because {ENDS[end]}: {_REMEDIES[end]}"]
    lines += ["", f"largest residual {worst:.1g}"]
    return "\n".join(lines)
