"""``linkages identify``: the values that explain measurements, and how certain they are."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from linkages import InputError
from linkages.cli.options import add_cluster, add_out, add_pictures, output_folder, print_results, record, workers
from linkages.cli.progress import silence
from linkages.input.files.writing import write_json
from linkages.show.plots.presentation import presentation

if TYPE_CHECKING:
    from optim.identify.load import Identification
    from optim.identify.result import IdentificationResult

HELP = "find the clearances, frictions, oils and masses that explain measurements"
WRITES = {
    "identify": (
        "starts.json",
        "result.json",
        "fitted.toml",
        "fit.png",
        "correlation.png",
        "windows.png",
        "profiles.png",
        "posterior.png",
    ),
    "identify --plan": ("plan.json",),
}

#: Short runs of this command that compile its code, see `linkages.cli.preparation`.
SHORT_RUNS = ("short_film.toml", "short_dry.toml")
_SHORT = """experiment = "slider_crank_{kind}.toml"
[data.run]
file = "short.csv"
[data.run.columns.acceleration]
output = "slider.ax"
deviation = 1.0
[unknowns.clearance]
path = "joints.B.clearance"
lower = 1e-4
upper = 1e-3
[unknowns.mass]
path = "sdf.links.slider.mass"
lower = 0.1
upper = 0.3
[fit]
time = 1.0
"""
SHORT_FILES = {
    "short_film.toml": _SHORT.format(kind="lubricated"),
    "short_dry.toml": _SHORT.format(kind="dry"),
    "short.csv": "time,acceleration\n" + "".join(f"{1e-4 * k},{-260.0 - k}\n" for k in range(20)),
}

EXAMPLES = """examples:
  linkages identify press.toml --out results/press
  linkages identify press.toml --plan
  linkages identify press.toml --profile --posterior --resume
"""

CHECKPOINT, RESULT, FITTED = "starts.json", "result.json", "fitted.toml"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.add_argument("file", type=Path, metavar="FILE", help="identification file (.toml)")
    parser.add_argument("--plan", action="store_true", help="compare sensors before a measurement; fit nothing")
    parser.add_argument("--profile", action="store_true", help="compute the profile likelihood of each unknown")
    parser.add_argument("--posterior", action="store_true", help="sample the posterior by emcee, an optional package")
    parser.add_argument("--resume", action="store_true", help="continue what was begun in the output folder")
    parser.add_argument("--threads", type=int, metavar="N", help="threads in which starts run; default: all")
    add_cluster(parser)
    add_out(parser)
    add_pictures(parser)


def run(options: argparse.Namespace) -> int:
    """Fit, or plan; returns the exit status."""
    from optim.identify.load import load_identification

    if options.threads is not None and options.threads < 1:
        raise InputError("--threads", str(options.threads), "must be at least 1")
    task = load_identification(options.file)
    return _plan(task, options) if options.plan else _identify(task, options)


def _show(text: str) -> None:
    silence.stage = text


def _plan(task: Identification, options: argparse.Namespace) -> int:
    from optim.identify.plan import format_plan, plan

    out = output_folder(options, f"{task.source.stem}_plan", "identify --plan")
    with out as folder:
        found = plan(task, _show)
        write_json(folder / "plan.json", found)
        table = format_plan(found)
        question = "Which sensors would determine the unknowns best?"
        record(options, folder, found["title"], question, [table.splitlines()[-1].capitalize() + "."], table)
    print_results(options, table, out)
    return 0


def _identify(task: Identification, options: argparse.Namespace) -> int:
    from optim.identify.identify import identify
    from optim.identify.writing import fitted_experiment, format_identification

    out = output_folder(options, task.source.stem, "identify", continued=("starts.json",))
    out.path.mkdir(parents=True, exist_ok=True)
    try:
        with workers(options, "continue with --resume") as (executor, _):
            found = identify(
                task, out.path / CHECKPOINT, resume=options.resume, profiles=options.profile,
                samples=options.posterior, threads=options.threads, executor=executor, show=_show,
            )  # fmt: skip
    except KeyboardInterrupt:
        print(
            "interrupted; starts that have ended and samples of the posterior are kept, continue with --resume",
            file=sys.stderr,
        )
        return 130
    with out as folder:
        write_json(folder / RESULT, found)
        (folder / FITTED).write_text(fitted_experiment(task, found, out.path / FITTED), encoding="utf-8")
        if not options.no_plots:
            from optim.report.identification import write_identification

            write_identification(found, folder, presentation().format)
        from optim.report.tables import identified

        table = format_identification(found)
        question = "Which values explain the measurements, and how certain are they?"
        record(options, folder, found["title"], question, _answer(found), table, *identified(found)[::-1])
    print_results(options, table, out)
    return 0


def _answer(found: IdentificationResult) -> list[str]:
    from linkages.show.plots.names import name_of_value
    from linkages.show.plots.quantities import quantity

    said = []
    for one in found["parameters"].values():
        name, si = name_of_value(one["path"]), one["unit"] or "1"
        if one["interval"]:
            low, high = (quantity(end, si) for end in one["interval"])
            said.append(f"The {name} is {quantity(one['value'], si)}, in 95 % of cases {low} to {high}.")
        else:
            said.append(f"The {name} is not identifiable from these measurements.")
    said.append(f"{found['assumed'][0].upper()}{found['assumed'][1:]}.")
    return said + [f"{warning[0].upper()}{warning[1:]}." for warning in found["warnings"]]
