"""``linkages tolerances``: which share of machines meets the limits, and which tolerance costs most."""

from __future__ import annotations

import argparse
import sys
import time

from linkages import InputError
from linkages.cli.options import add_cluster, add_out, add_pictures, output_folder, record, workers, written
from linkages.cli.printing import show
from linkages.cli.progress import progress_bar
from linkages.input.files.writing import errors_of_writing, write_json
from optim.cli.seeds import seeds_of

HELP = "share of machines that meet the limits, by their tolerances; can be stopped, resumed and extended"
WRITES = {"tolerances": ("tolerances.json", "study.sqlite", "histograms.png", "contributions.png", "influence.png")}

#: Short runs of this command that compile its code, see `linkages.cli.preparation`.
SHORT_RUNS = ("slidercrank_tolerances.toml --samples 2", "short_tolerances.toml")
SHORT_FILES = {
    "short_tolerances.toml": """experiment = "slider_crank_dry.toml"
[set]
duration = 0.002
[scatter.clearance]
path = "joints.B.clearance"
normal = ["0.5 mm", "0.02 mm"]
[scatter.mass]
path = "sdf.links.rod.mass"
normal = ["210 g", "2 g"]
[constraints.force]
unit = "N"
terms = [{ functional = "peak", output = "B.force" }]
at_most = 47000
[algorithm]
name = "scatter"
samples = 8
derivatives = "sensitivities"
"""
}

EXAMPLES = """examples:
  linkages tolerances slidercrank_tolerances.toml
  linkages tolerances mine.toml --samples 10000 --out results/mine --resume
"""

STORE, RESULT = "study.sqlite", "tolerances.json"
_REQUESTS = 4  # of a chunk for each worker: the last ones end at about the same time


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.add_argument(
        "file", metavar="FILE", help="study with [scatter] (.toml), a path or the name of a shipped one"
    )
    parser.add_argument("--seed", type=int, metavar="N", help="replaces the file's")
    parser.add_argument("--samples", type=int, metavar="N", help="number of machines; replaces the file's")
    parser.add_argument("--resume", action="store_true", help="continue or extend what is in the output folder")
    add_out(parser)
    parser.add_argument("--threads", type=int, metavar="N", help="threads of the compiled engine; default: all")
    add_cluster(parser)
    add_pictures(parser)
    parser.set_defaults(seeds=None)


def run(options: argparse.Namespace) -> int:
    """Run the machines of a study and judge them; returns the exit status."""
    from linkages.show.plots.quantities import share
    from optim.evaluate.evaluator import Evaluator
    from optim.problem.load import find_study, load_study
    from optim.report.tables import tolerated
    from optim.report.tolerance_text import format_tolerances
    from optim.search.sampled_machines import settings_of
    from optim.search.tolerances import sampled

    if options.threads is not None and options.threads < 1:
        raise InputError("--threads", str(options.threads), "must be at least 1")
    study = load_study(find_study(options.file))
    settings_of(study, options.samples)
    (seed,) = seeds_of(options, study)
    folder = output_folder(options, study.source.stem, "tolerances").path
    with errors_of_writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
    started = time.monotonic()
    with workers(options, "continue with --resume") as (executor, count):
        evaluator = Evaluator(study, executor, lambda: _REQUESTS * count(), options.threads)
        advance = progress_bar(f"{study.source.stem}: machines")
        try:
            result, sample = sampled(study, folder / STORE, seed, options.samples, evaluator, options.resume, advance)
        except KeyboardInterrupt:
            print("interrupted; what was computed is kept, continue with --resume", file=sys.stderr)
            return 130
    write_json(folder / RESULT, result)
    table, shares = format_tolerances(study, result), result["yield"]
    low, high = shares["interval"]
    answer = [f"{share(shares['value'])} of the machines meet all limits ({share(low)} to {share(high)})."]
    question = "Which share of the machines meets the limits?"
    record(options, folder, result["title"], question, answer, table, *tolerated(study, result)[::-1])
    names = [STORE, RESULT, "record.json"]
    if not options.no_plots:
        from optim.report.tolerance_figures import write_tolerances

        names += write_tolerances(study, result, sample, folder)
    show(f"{table}\n\n{time.monotonic() - started:.1f} s\n{written(folder, names)}")
    return 0
