"""``linkages simulate``: run an experiment; write numbers, figures, animation."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from linkages.cli.common import (
    add_out,
    add_overrides,
    add_verbosity,
    output_folder,
    overrides,
    stages,
    written,
)
from linkages.engines import ENGINES
from linkages.errors import InputError, Status
from linkages.files.writing import OutputFolder

if TYPE_CHECKING:
    from linkages.engines.study import Study
    from linkages.model.experiment import Experiment

HELP = "run an experiment; write numbers, figures, animation"

_EXAMPLES = """examples:
  linkages simulate seven_bar.toml
  linkages simulate my.toml --engine compiled --set joints.A.clearance=2e-4 --set drives.O1.speed=7 --out results/thin
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.epilog = _EXAMPLES
    parser.add_argument("file", help="experiment (.toml), a path or the name of a shipped one")
    add_run_options(parser)


def add_run_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that ``linkages simulate`` and ``run_sevenbar.py`` share."""
    parser.add_argument("--engine", choices=tuple(ENGINES), default="drake", help="default: %(default)s")
    add_overrides(parser)
    add_out(parser)
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
    add_verbosity(parser)


def run(options: argparse.Namespace) -> int:
    """Run the experiment; returns the exit status."""
    from linkages.engines.study import study, summarize, touching
    from linkages.files.shipped import find_file
    from linkages.model.experiment import COMMAND_LINE, load
    from linkages.report.terminal import format_summary
    from linkages.results.impacts import write_impacts

    if not options.exaggerate >= 0.0:
        raise InputError("--exaggerate", str(options.exaggerate), "must be zero or positive")
    mechanism, experiment = load(find_file(options.file), overrides(options), COMMAND_LINE)
    out = output_folder(options, experiment.source.stem)
    result = study(
        mechanism,
        experiment,
        options.engine,
        not options.no_error_estimate,
        stages(options, experiment.duration, "s"),
    )
    summary = summarize(result, options.engine)
    with OutputFolder(out) as folder:
        (folder / "summary.json").write_text(json.dumps(summary, indent=1) + "\n", encoding="utf-8")
        result.run.save(folder / "trajectory.npz")
        if touching(experiment, result.run):
            write_impacts(result.contacts, folder / "impacts.csv")
        if not options.no_plots:
            from linkages.plots.figures import write_figures

            write_figures(result, folder)
        if not options.no_animation:
            _animate(result, folder / "animation.html", options.exaggerate)
    if not options.quiet:
        print(format_summary(summary, experiment))
        if options.verbose:
            print(f"\n{_details(summary, experiment)}")
        print(f"\n{written(out)}")
    status = result.run.status
    for name, part in (("the run", result.run), ("the ideal linkage", result.ideal)):
        if part.status is not Status.OK:
            print(
                f"{name} ended at t = {part.time[-1]:.6g} s: {part.status.value}; {part.status.remedy}",
                file=sys.stderr,
            )
    return {Status.OK: 0, Status.INTERRUPTED: 130}.get(status, 1)


def _details(summary: dict[str, Any], experiment: Experiment) -> str:
    """Tell how the run was made."""
    mechanism, made = summary["mechanism"], summary["provenance"]
    cut = ", ".join(mechanism["cut"]["play"] + mechanism["cut"]["ideal"])
    numbers = ", ".join(f"{key.replace('_', ' ')} {value}" for key, value in made["run"].items())
    return "\n".join(
        [
            f"experiment {experiment.source}, mechanism {experiment.mechanism_path}",
            f"joints cut to get a tree: {cut or 'none'}",
            f"accuracy {experiment.solver.accuracy:g}, steps of at most {experiment.max_step:g} s",
            f"{numbers}; {made['wall_time']:.3g} s for the run alone",
            "versions: " + ", ".join(f"{name} {version}" for name, version in made["versions"].items()),
        ]
    )


def _animate(result: Study, path: Path, exaggerate: float) -> None:
    from linkages.plots.animation.animate import write_animation

    try:
        write_animation(result, path, exaggerate)
    except ValueError as problem:
        if exaggerate == 1.0:
            raise
        raise InputError("--exaggerate", f"{exaggerate:g}", f"{problem}; choose a smaller factor") from None
