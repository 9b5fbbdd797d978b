"""``linkages compare``: both engines on one experiment."""

from __future__ import annotations

import argparse
import json
import sys
from typing import TYPE_CHECKING

from linkages.cli.common import (
    add_out,
    add_overrides,
    add_verbosity,
    output_folder,
    overrides,
    stages,
    written,
)
from linkages.errors import Status
from linkages.files.writing import OutputFolder

if TYPE_CHECKING:
    from linkages.explore.compare import Comparison
    from linkages.model.experiment import Experiment
    from linkages.model.mechanism import Mechanism

HELP = "run both engines and print how far apart they are"

_EXAMPLES = """examples:
  linkages compare seven_bar.toml --duration 0.3
  linkages compare slider_crank_dry.toml --accuracy 1e-11 --out results/dry
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.epilog = _EXAMPLES
    parser.add_argument("file", help="experiment (.toml), a path or the name of a shipped one")
    add_overrides(parser)
    add_out(parser)
    add_verbosity(parser)
    parser.add_argument(
        "--accuracy",
        type=float,
        default=1e-11,
        metavar="X",
        help="of both engines, replaces solver.accuracy; default: %(default)s, so that the engines are compared and not"
        " their tolerances",
    )


def run(options: argparse.Namespace) -> int:
    """Compare the engines; returns the exit status."""
    from linkages.explore.compare import compare
    from linkages.files.shipped import find_file
    from linkages.model.experiment import COMMAND_LINE, load

    replaced = overrides(options)
    replaced.setdefault("solver.accuracy", options.accuracy)
    mechanism, experiment = load(find_file(options.file), replaced, COMMAND_LINE)
    out = output_folder(options, f"{experiment.source.stem}_compare")
    result = compare(mechanism, experiment, stages(options, experiment.duration, "s"))
    rows = {
        name: {"max_difference": row.max_difference, "relative": row.relative}
        for name, row in result.differences.items()
    }
    with OutputFolder(out) as folder:
        (folder / "compare.json").write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    if not options.quiet:
        print(format_comparison(result, mechanism, experiment))
        print(f"\n{written(out)}")
    failed = {name: run for name, run in result.runs.items() if run.status is not Status.OK}
    for name, run_of in failed.items():
        print(
            f"the {name} run ended at t = {run_of.time[-1]:.6g} s: {run_of.status.value}; {run_of.status.remedy}",
            file=sys.stderr,
        )
    interrupted = any(run_of.status is Status.INTERRUPTED for run_of in failed.values())
    return 130 if interrupted else int(bool(failed))


def format_comparison(result: Comparison, mechanism: Mechanism, experiment: Experiment) -> str:
    """Format a comparison as lines of text."""
    from linkages.explore.compare import PARTED, revolutions
    from linkages.outputs.units import unit

    turns = revolutions(experiment, result.until)
    after = f", revolutions: {turns:.3g}" if turns is not None else ""
    lines = [
        experiment.title or experiment.source.stem,
        f"compiled and drake engines, accuracy {experiment.solver.accuracy:g},"
        f" compared up to {result.until:.6g} s{after}",
    ]
    if result.parted:
        horizons = ", ".join(f"{name} {time:.6g} s" for name, time in result.horizons.items())
        lines += [
            f"horizon: runs of one engine at this and at a ten times looser accuracy part by {PARTED:g} clearances at",
            f"{horizons}; what follows is up to there: beyond, no difference means anything",
        ]
    lines += ["", f"{'':28s}{'largest difference':>20s}{'of peak':>11s}{'at [s]':>13s}{'peak':>13s}"]
    for name, row in result.differences.items():
        label = f"{name} [{unit(name, mechanism)}]"
        lines.append(
            f"{label:28s}{row.max_difference:20.3e}{row.relative:11.1e}{row.time:13.6g}{row.peak:13.6g}"
        )
    if result.contacts:
        lines += [
            "",
            "first contacts of each joint before the horizon: the compiled engine's, and drake's difference",
            f"{'':12s}{'start [s]':>24s}{'approach [m/s]':>22s}{'sliding [m/s]':>22s}{'peak force [N]':>22s}",
        ]
    for ours, other in result.contacts:
        line = f"{ours.joint:12s}{ours.start:15.9g}{other.start - ours.start:9.0e}"
        for field in ("approach_speed", "tangential_speed", "peak_force"):
            value = getattr(ours, field)
            line += f"{value:13.6g}{getattr(other, field) - value:9.0e}"
        lines.append(line)
    return "\n".join(lines)
