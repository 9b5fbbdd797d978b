"""``linkages optimise``: solves design studies; can be stopped and resumed."""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from linkages import InputError
from linkages.base.errors import listed
from linkages.base.packages import check_installed
from linkages.cli.options import add_cluster, add_out, add_pictures, output_folder, record, workers, written
from linkages.cli.printing import show
from linkages.cli.progress import progress_bar
from linkages.input.files.writing import errors_of_writing, write_json
from linkages.show.plots.presentation import presentation
from optim.cli.seeds import seeds_of

if TYPE_CHECKING:
    from collections.abc import Callable
    from concurrent.futures import Executor

    from linkages.base.arrays import Array
    from optim.evaluate.evaluator import Evaluator
    from optim.problem.study import Study
    from optim.search.result import StudyResult

HELP = "find the best design of a linkage; can be stopped and resumed"
WRITES = {"optimise": ("study.sqlite", "result.json", "results.csv", "convergence.png", "front.png")}

#: Short runs of this command that compile its code, see `linkages.cli.preparation`.
SHORT_RUNS = ("short_search.toml", "short_gradient.toml")
_SHORT = """experiment = "seven_bar.toml"
[set]
duration = 0.02
[variables.oil]
path = "joints.A.viscosity"
lower = 0.05
upper = 0.6
[variables.length]
path = "sdf.frames.link2_C.pose.x"
lower = 0.179
upper = 0.181
[objectives.force]
unit = "N"
terms = [{ functional = "peak", output = "A.force" }]
[algorithm]
"""
SHORT_FILES = {
    "short_search.toml": f'{_SHORT}name = "ga"\npopulation = 4\ngenerations = 1\n',
    "short_gradient.toml": f'{_SHORT}name = "grg"\niterations = 1\nderivatives = "sensitivities"\n',
}

EXAMPLES = """examples:
  linkages optimise sevenbar_force.toml
  linkages optimise sevenbar_force.toml --seed 3 --out results/force --resume
  linkages optimise sevenbar_force.toml sevenbar_acceleration.toml --seeds 1:10 --out results/both
  linkages optimise fourbar_jitter_steady.toml --start results/fourbar_surrogate
  linkages optimise mine.toml --cluster tcp://host:8786
  linkages optimise mine.toml --check
"""

STORE, RESULT, TABLE = "study.sqlite", "result.json", "results.csv"
FIGURE, FRONT = "convergence", "front"


@dataclass(frozen=True)
class _Task:
    """One study with one seed, its start (n,) if that is not the nominal design, and its folder."""

    study: Study
    seed: int
    start: Array | None
    folder: Path


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.add_argument("files", nargs="+", metavar="FILE", help="study (.toml), a path or the name of a shipped one")
    seeds = parser.add_mutually_exclusive_group()
    seeds.add_argument("--seed", type=int, metavar="N", help="replaces the file's")
    seeds.add_argument("--seeds", metavar="A:B", help="run every seed from A to B")
    parser.add_argument("--resume", action="store_true", help="continue what was begun in the output folder")
    parser.add_argument(
        "--start", type=Path, metavar="RESULT", help="begin from the best design in this folder of another study"
    )
    add_out(parser)
    parser.add_argument("--threads", type=int, metavar="N", help="threads of the compiled engine; default: all")
    add_cluster(parser)
    parser.add_argument(
        "--verify",
        action=argparse.BooleanOptionalAction,
        default=False,
        help="run the optimum again on Drake; also with --resume, when all is computed",
    )
    parser.add_argument(
        "--check",
        action="store_true",
        help="compare derivatives by sensitivities with differences of designs, at the start and at the optimum",
    )
    add_pictures(parser)


def run(options: argparse.Namespace) -> int:
    """Solve every study with every seed; returns the exit status."""
    if options.threads is not None and options.threads < 1:
        raise InputError("--threads", str(options.threads), "must be at least 1")
    if options.verify:
        check_installed("pydrake", "--verify")
    if (code := _tolerances(options)) is not None:
        return code
    root, jobs = _jobs(options)
    results: list[StudyResult] = []
    with workers(options, "continue with --resume") as pool:
        try:
            for job in jobs:
                results.append(_solve(job, options, *pool))
        except KeyboardInterrupt:
            print("interrupted; what was computed is kept, continue with --resume", file=sys.stderr)
            return 130
    if len(jobs) > 1:
        from optim.report.result import format_table, write_table

        write_table(results, root / TABLE)
        table = format_table(results)
        record(options, root, "Several studies", "Which designs are best?", ["The table lists every run."], table)
        show(table + "\n")
    show(written(root, sorted(p.name for p in root.iterdir() if p.name[0] != "." and p.suffix != ".lock")))
    return 0


def _tolerances(options: argparse.Namespace) -> int | None:
    """Run a study of tolerances, which is no search; returns the exit status, or None for other studies."""
    from linkages.input.files.toml import read_toml
    from optim.cli import tolerances
    from optim.problem.load import find_study
    from optim.problem.schema import SAMPLING

    tables = [read_toml(find_study(file))[0].get("algorithm") for file in options.files]
    sampling = [isinstance(table, dict) and table.get("name") == SAMPLING for table in tables]
    if not any(sampling):
        return None
    if len(sampling) > 1 or options.seeds or options.start or options.check or options.verify:
        problem = "is a study of tolerances; give it alone, without --seeds, --start, --check and --verify"
        raise InputError("command line", options.files[sampling.index(True)], problem)
    return tolerances.run(argparse.Namespace(**vars(options), file=options.files[0], samples=None))


def _jobs(options: argparse.Namespace) -> tuple[Path, list[_Task]]:
    """Output folder, and every study with every seed, checked before the first begins."""
    from optim.problem.load import find_study, load_study
    from optim.search.derivative_check import check_usable
    from optim.search.optimise import start_of
    from optim.search.task import settings_of

    studies = [load_study(find_study(file)) for file in options.files]
    for study in studies:
        settings_of(study)
        if options.check:
            check_usable(study)
    names = [study.source.stem for study in studies]
    if len(set(names)) < len(names):
        raise InputError("command line", names[0], "two studies have this name; rename a file")
    root = output_folder(options, names[0] if len(studies) == 1 else "optimise", "optimise").path
    jobs = []
    for study in studies:
        start = start_of(study, options.start) if options.start else None
        jobs += [_Task(study, seed, start, root / f"{study.source.stem}_{seed}") for seed in seeds_of(options, study)]
    if len(jobs) == 1:
        jobs = [replace(jobs[0], folder=root)]
    for job in jobs:
        store = job.folder / STORE
        if store.exists() and not options.resume:
            raise InputError("--out", str(store), "exists already; continue with --resume, or give another --out")
        with errors_of_writing(job.folder):
            job.folder.mkdir(parents=True, exist_ok=True)
    return root, jobs


def _solve(
    job: _Task, options: argparse.Namespace, executor: Executor | None, workers: Callable[[], int]
) -> StudyResult:
    """Solve one study with one seed; writes its folder and returns the content of ``result.json``."""
    import numpy as np

    from optim.evaluate.evaluator import Evaluator
    from optim.report.observe import Observer
    from optim.report.result import format_result, result_answer
    from optim.report.tables import optimised
    from optim.search.optimise import optimise

    study = job.study
    figure = None if options.no_plots else job.folder / f"{FIGURE}.{presentation().format}"
    observe = Observer(study, job.seed, figure)
    evaluator = Evaluator(study, executor, lambda: 2 * workers(), options.threads, progress=observe.runs)
    checks: dict[str, Any] = {}
    if options.check:
        checks["start"] = _check(study, study.nominal if job.start is None else job.start, evaluator, "start")
    with observe:
        result = optimise(
            study,
            job.folder / STORE,
            seed=job.seed,
            start=job.start,
            evaluator=evaluator,
            resume=options.resume,
            observe=observe,
        )
    if options.check:
        best = np.array([result.best.variables[path] for path in study.paths])
        checks["best"] = _check(study, best, evaluator, "optimum")
        result = result.model_copy(update={"derivatives": checks})
    write_json(job.folder / RESULT, result)
    if result.front and not options.no_plots:
        from optim.report.figures import write_pareto_front

        write_pareto_front(study, result, job.folder / f"{FRONT}.{presentation().format}")
    table = format_result(study, result)
    question = f"Which design is best: {listed(study.label(name) for name in result.best.objectives)}?"
    record(
        options, job.folder, study.title, question, result_answer(study, result), table, *optimised(study, result)[::-1]
    )
    show(table + "\n")
    if options.verify:
        from optim.search.verification import format_verification, verify

        print("running the optimum again on Drake ...", file=sys.stderr)
        verified = verify(study, result.best, options.threads, progress_bar("Drake"))
        result = result.model_copy(update={"verification": verified})
        write_json(job.folder / RESULT, result)
        show(format_verification(verified) + "\n")
    else:
        show("not yet run again on Drake: give --resume --verify\n")
    return result


def _check(study: Study, design: Array, evaluator: Evaluator, where: str) -> dict[str, Any]:
    """Check the derivatives at a design, print the table, and warn of derivatives that differ."""
    from optim.search.derivative_check import check_derivatives, format_derivative_check

    report = check_derivatives(study, design, evaluator)
    show(format_derivative_check(study, report, where) + "\n")
    if not report["agrees"]:
        print(f"warning: derivatives at the {where} differ from differences of designs", file=sys.stderr)
    return report
