"""The command line: ``linkages simulate FILE.toml`` and its helpers.

Exit status: 0 success, 1 a run that failed (its results up to then are written), 2 bad input, 130 interrupted.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from tqdm import tqdm

from linkages.assembly import AssemblyError
from linkages.data import find_file
from linkages.errors import InputError, Status
from linkages.experiment import Experiment, keys, load
from linkages.flexible.command import add_options as add_modes_options
from linkages.flexible.command import modes_command
from linkages.folder import OutputFolder
from linkages.impacts import write_impacts
from linkages.mechanism import Mechanism
from linkages.run import ENGINES, Study, study, summarize, touching
from linkages.table import format_summary

_EXAMPLES = """examples:
  linkages simulate seven_bar.toml
  linkages simulate my.toml --set joints.A.clearance=2e-4 --set drives.O1.speed=7 --out results/thin
  linkages keys
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the ``linkages`` command; returns its exit status."""
    parser = argparse.ArgumentParser(
        prog="linkages",
        description="Dynamics of planar linkages with clearance joints.",
        epilog=_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    commands = parser.add_subparsers(dest="command", required=True)
    simulate = commands.add_parser("simulate", help="run an experiment; write numbers, figures, animation")
    simulate.add_argument("file", help="experiment (.toml), a path or the name of a shipped one")
    add_simulate_options(simulate)
    commands.add_parser("keys", help="list the keys of an experiment file with their units")
    add_modes_options(commands.add_parser("modes", help="flexible 3-RRR robot: kinematics, modes, stress"))
    options = parser.parse_args(arguments)
    if options.command == "modes":
        return modes_command(options)
    if options.command == "keys":
        for name, meaning in keys():
            print(f"{name:42s} {meaning}")
        return 0
    return simulate_command(options.file, options)


def add_simulate_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that ``linkages simulate`` and ``run_sevenbar.py`` share."""
    parser.add_argument("--engine", choices=ENGINES, default="drake", help="default: %(default)s")
    parser.add_argument(
        "--set", action="append", default=[], metavar="PATH=VALUE", help="replace a value; may be repeated"
    )
    parser.add_argument("--out", type=Path, metavar="DIR", help="default: results/NAME")
    parser.add_argument("--duration", type=float, metavar="SECONDS", help="replace the experiment's duration")
    parser.add_argument("--no-plots", action="store_true", help="write no figures")
    parser.add_argument("--no-animation", action="store_true", help="write no animation")
    parser.add_argument(
        "--exaggerate",
        type=float,
        default=1.0,
        metavar="FACTOR",
        help="show clearances enlarged in the animation",
    )
    parser.add_argument(
        "--no-error-estimate",
        action="store_true",
        help="do not repeat the run at a ten times tighter tolerance",
    )


def simulate_command(file: str, options: argparse.Namespace) -> int:
    """Run one experiment with parsed options; returns the exit status."""
    try:
        overrides = _overrides(options)
        path = find_file(file)
        mechanism, experiment = load(path, overrides)
        return _simulate(mechanism, experiment, options)
    except InputError as problem:
        print(f"error: {problem}", file=sys.stderr)
        return 2
    except AssemblyError as problem:
        print(f"failed: {problem}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("interrupted; nothing was written", file=sys.stderr)
        return 130


def _overrides(options: argparse.Namespace) -> dict[str, str | float]:
    result: dict[str, str | float] = {}
    for item in options.set:
        path, equals, value = item.partition("=")
        if not equals or not path or not value:
            raise InputError("--set", item, "write PATH=VALUE, for instance joints.A.clearance=2e-4")
        result[path.strip()] = value.strip()
    if options.duration is not None:
        result["duration"] = options.duration
    if not options.exaggerate >= 0.0:
        raise InputError("--exaggerate", str(options.exaggerate), "must be zero or positive")
    return result


def _simulate(mechanism: Mechanism, experiment: Experiment, options: argparse.Namespace) -> int:
    out = options.out or Path("results") / experiment.source.stem
    if out.exists() and not out.is_dir():
        raise InputError("--out", str(out), "is a file; give a folder")
    result = study(
        mechanism, experiment, options.engine, not options.no_error_estimate, _bars(experiment.duration)
    )
    summary = summarize(result, options.engine)
    with OutputFolder(out) as folder:
        (folder / "summary.json").write_text(json.dumps(summary, indent=1) + "\n", encoding="utf-8")
        result.run.save(folder / "trajectory.npz")
        if touching(experiment, result.run):
            write_impacts(result.contacts, folder / "impacts.csv")
        if not options.no_plots:
            from linkages.plots import write_figures

            write_figures(result, folder)
        if not options.no_animation:
            _animate(result, folder / "animation.html", options.exaggerate)
    print(format_summary(summary, experiment))
    print(f"\nwritten to {out}{os.sep}: {', '.join(sorted(p.name for p in out.iterdir()))}")
    status = result.run.status
    if status is not Status.OK:
        print(
            f"the run ended at t = {result.run.time[-1]:.6g} s: {status.value}; {status.remedy}",
            file=sys.stderr,
        )
    return {Status.OK: 0, Status.INTERRUPTED: 130}.get(status, 1)


def _animate(result: Study, path: Path, exaggerate: float) -> None:
    from linkages.drake.animate import write_animation

    try:
        write_animation(result, path, exaggerate)
    except ValueError as problem:
        if exaggerate == 1.0:
            raise
        raise InputError("--exaggerate", f"{exaggerate:g}", f"{problem}; choose a smaller factor") from None


def _bars(duration: float) -> Callable[[str], Callable[[float], None]]:
    """Progress bars, one for each stage, shown on a terminal when a stage takes more than two seconds."""

    def stage(name: str) -> Callable[[float], None]:
        bar = tqdm(
            total=duration,
            desc=name,
            delay=2.0,
            disable=None,
            leave=False,
            bar_format="{desc}: {percentage:3.0f}% |{bar}| {n:.3f}/{total:.3f} s [{elapsed}<{remaining}]",
        )

        def advance(time: float) -> None:
            bar.update(min(time, duration) - bar.n)
            if time >= duration:
                bar.close()

        return advance

    return stage


if __name__ == "__main__":
    sys.exit(main())
