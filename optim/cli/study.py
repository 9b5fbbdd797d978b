"""``linkages study``: shows and exports the store of a study, also while it runs; finds out which variables matter."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from linkages import InputError
from linkages.cli.options import add_out, add_pictures, output_folder, print_results, record
from linkages.cli.printing import show
from linkages.input.files.writing import write_json
from linkages.show.plots.presentation import presentation
from optim.cli.seeds import seeds_of

if TYPE_CHECKING:
    from optim.problem.study import Study

HELP = "show or export what an optimisation has computed; which variables matter"
WRITES = {"study sensitivity": ("sensitivity.json", "sobol.png", "one_at_a_time.png")}

EXAMPLES = """examples:
  linkages study show results/sevenbar_force/study.sqlite
  linkages study export results/sevenbar_force/study.sqlite --out designs.csv
  linkages study sensitivity sevenbar_force.toml --samples 512
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION")
    show = actions.add_parser("show", help="print a summary of a store")
    export = actions.add_parser("export", help="write every design of a store to a table")
    for action in (show, export):
        action.add_argument("file", type=Path, metavar="FILE", help="a study.sqlite")
    export.add_argument(
        "--out", type=Path, metavar="TABLE", help=".csv or .parquet; default: evaluations.csv in the folder of FILE"
    )
    sensitivity = actions.add_parser("sensitivity", help="Sobol's indices over the bounds, and one variable at a time")
    sensitivity.add_argument("file", metavar="FILE", help="study (.toml), a path or the name of a shipped one")
    sensitivity.add_argument(
        "--samples",
        type=int,
        default=256,
        metavar="N",
        help="a power of two; N (variables + 2) designs are run; default: %(default)s",
    )
    sensitivity.add_argument("--seed", type=int, metavar="N", help="replaces the file's")
    sensitivity.set_defaults(seeds=None)
    sensitivity.add_argument("--threads", type=int, metavar="N", help="threads of the compiled engine; default: all")
    add_out(sensitivity)
    add_pictures(sensitivity)


def run(options: argparse.Namespace) -> int:
    """Run the action that was chosen; returns the exit status."""
    if options.action == "sensitivity":
        return _sensitivity(options)
    from optim.report.export import export, format_store
    from optim.store.store import read_store

    with read_store(options.file) as store:
        if options.action == "show":
            show(format_store(store))
            return 0
        out = options.out or options.file.with_name("evaluations.csv")
        rows = export(store, out)
    show(f"{rows} designs written to {out}")
    return 0


def _sensitivity(options: argparse.Namespace) -> int:
    from optim.evaluate.evaluator import Evaluator
    from optim.problem.load import find_study, load_study
    from optim.search.sensitivity import check_samples, format_sensitivity, sensitivity

    check_samples(options.samples, "--samples")
    if options.threads is not None and options.threads < 1:
        raise InputError("--threads", str(options.threads), "must be at least 1")
    study = load_study(find_study(options.file))
    (seed,) = seeds_of(options, study)
    out = output_folder(options, f"{study.source.stem}_sensitivity", "study sensitivity")
    with out as folder:
        report = sensitivity(study, options.samples, seed, Evaluator(study, threads=options.threads))
        write_json(folder / "sensitivity.json", report)
        if not options.no_plots:
            from optim.report.shares import write_indices, write_one_at_a_time

            write_indices(study, report, folder / f"sobol.{presentation().format}")
            write_one_at_a_time(study, report, folder / f"one_at_a_time.{presentation().format}")
        question = "Which variables change the objectives and constraints over their bounds?"
        from optim.report.tables import explained

        table = format_sensitivity(study, report)
        record(
            options, folder, report["title"], question, _answer(study, report), table, *explained(study, report)[::-1]
        )
    print_results(options, table, out)
    return 0


def _answer(study: Study, report: dict[str, Any]) -> list[str]:
    """Tell for each quantity the variable with the largest share of the variance, or that it does not vary."""
    from linkages.show.plots.names import name_of_value
    from linkages.show.plots.quantities import share

    said = []
    for name, entry in report["quantities"].items():
        shares = {path: one["total"] for path, one in entry["variables"].items() if one["total"] is not None}
        if not shares:
            said.append(f"{name} does not vary over the bounds.")
            continue
        path = max(shares, key=shares.__getitem__)
        said.append(
            f"{name} depends most on the {name_of_value(path)}: {share(min(shares[path], 1.0))} of the variance,"
            " with interactions."
        )
    return said
