"""``linkages simulate``: run an experiment; write numbers, figures and an animation."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from linkages.base.errors import InputError, Status
from linkages.cli.options import (
    add_data,
    add_file,
    add_pictures,
    add_settings,
    add_units,
    load_system,
    output_folder,
    written,
)
from linkages.cli.printing import show
from linkages.cli.progress import silence, stages
from linkages.engines import DEFAULT, ENGINES, check_engine, engine
from linkages.input.files.writing import write_json

if TYPE_CHECKING:
    from linkages.results.assessment import Assessment
    from linkages.results.shape import Summary
    from linkages.results.trajectory import Trajectory

HELP = "run an experiment; write numbers, figures and an animation"
WRITES = {
    "simulate": (
        "summary.json",
        "trajectory.npz",
        "ideal.npz",
        "trajectory.csv",
        "trajectory.mat",
        "trajectory.parquet",
        "trajectory.nc",
        "impacts.csv",
        "impacts_normal.csv",
        "output_*.png",
        "orbits.png",
        "guides.png",
        "impacts.png",
        "joint_forces.png",
        "drive_torques.png",
        "measured.png",
        "measured.npz",
        "animation.html",
        "animation.gif",
        "animation.mp4",
        "drawing.html",
        "drawing.png",
        "drawing.svg",
        "loads.csv",
    )
}

#: Short runs of this command that compile its code, see `linkages.cli.preparation`.
SHORT_RUNS = (
    "seven_bar.toml --duration 0.02",
    "seven_bar.toml --duration 0.002 --engine drake",
    "seven_bar_dry.toml --duration 0.02",
    "seven_bar_mixed.toml --duration 0.02",
    "slider_crank_dry.toml --duration 0.002",
    "slider_crank_dry.toml --duration 0.0002 --engine drake",
    "slider_crank_lubricated.toml --duration 0.002",
    "slider_crank_flexible.toml --duration 0.002",
    "slider_crank_guide.toml --duration 0.002",
    "slider_crank_motor.toml --duration 0.002",
    "slider_crank_main_bearing.toml --duration 0.0005",
    "four_bar_dry.toml --duration 0.002",
    "gear_rattle.toml --duration 0.002",
    "three_rrr_clearance.toml --duration 0.0005",
)

EXAMPLES = """examples:
  linkages simulate seven_bar.toml
  linkages simulate my.toml --data measured.csv
  linkages simulate my.toml --engine compiled --set joints.A.clearance=2e-4 --set drives.O1.speed=7 --out results/thin
  linkages simulate slider_crank_wear.toml --worn results/slider_crank_wear_wear/wear.json
"""


#: The first line of a run.
_ENGINE = {
    "compiled": "engine: compiled; --engine drake runs the same model on Drake, slowly",
    "drake": "engine: drake; --engine compiled integrates the same model fast",
}


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    add_file(parser)
    add_run_options(parser)


def add_run_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that ``linkages simulate`` and ``run_sevenbar.py`` share."""
    parser.add_argument("--engine", choices=tuple(ENGINES), default=DEFAULT, help="default: %(default)s")
    add_settings(parser)
    add_units(parser)
    add_data(parser)
    parser.add_argument("--ideal", action="store_true", help="make every joint ideal")
    parser.add_argument("--worn", type=Path, metavar="FILE", help="start with the worn joints of a wear.json")
    add_pictures(parser, animation=True)
    meaning = "enlarge clearances and deflections in the animation; default: deflections, until they are visible"
    parser.add_argument("--exaggerate", type=float, metavar="FACTOR", help=meaning)
    parser.add_argument("--compress", action="store_true", help="write small trajectory files, which takes longer")
    parser.add_argument("--no-error-estimate", action="store_true", help="do not repeat the run at a tighter tolerance")


def run(options: argparse.Namespace) -> int:
    """Run the experiment; return the exit status."""
    from linkages.cli.main import report_failures
    from linkages.engines.assessment import assess, estimate_error
    from linkages.input.model.plausibility import doubts
    from linkages.results.impacts import write_impacts
    from linkages.results.measured import save_measured
    from linkages.results.summary import judge, unjudged
    from linkages.show.plots.animation.animated import check_animation
    from linkages.show.report.answer import answer
    from linkages.show.report.terminal import format_heading, format_judgement, format_table

    if options.exaggerate is not None and not options.exaggerate >= 0.0:
        raise InputError("--exaggerate", str(options.exaggerate), "must be zero or positive")
    check_engine(options.engine)
    if not options.no_animation:
        check_animation(options.exaggerate)
    system = load_system(options)
    out = output_folder(options, system.description.stem, "simulate")
    progress = stages(options, system.settings.duration, "s")
    say = (lambda text, bold=False: None) if options.quiet else show
    for doubt in doubts(system.mechanism, system.tree.extent, system.experiment):
        say(f"warning: {doubt}")
    say(f"{_ENGINE[options.engine]}\n")
    result = assess(system, options.engine, False, progress)
    silence.stage = "results"
    summary = unjudged(result)
    say(format_heading(summary.content), bold=True)
    told = answer(summary.content | {"warnings": []}, str(options.file))
    say("\n".join(f"  {line}" for line in told[:-1]), bold=True)
    say(format_table(summary.content))
    with out as folder:
        if not options.no_error_estimate:
            result = estimate_error(result, progress)
        summary = judge(result, summary)
        for line in [*format_judgement(summary.content), "", told[-1]]:
            say(line)
        if options.verbose:
            say(f"\n{_details(result, summary)}")
        write_json(folder / "summary.json", summary)
        silence.stage = "writing the trajectories"
        result.run.save(folder / "trajectory.npz", options.compress)
        if result.ideal is not None:
            result.ideal.save(folder / "ideal.npz", options.compress)
        if result.measured:
            save_measured(result.measured, folder / "measured.npz")
        if system.can_touch:
            write_impacts(result.contacts, folder)
        failed = _failed(result)
        result = result.latest()  # figures of all cycles of a long run would show none
        if not options.no_plots:
            silence.stage = "figures"
            from linkages.show.plots.drawing import draw, svg
            from linkages.show.plots.histories import write_figures

            write_figures(result, folder, summary.error)
            (folder / "drawing.svg").write_text(svg(draw(system, spread=True)), encoding="utf-8")
        if not options.no_animation:
            silence.stage = "animation"
            _animate(result, folder / "animation.html", options.exaggerate)
    say(f"\n{written(out.path, out.names)}")
    run = failed.pop("the run", None)
    report_failures(failed)  # first, because the run usually fails if the ideal linkage does not close
    return report_failures({"the run": run} if run else {})


def _failed(result: Assessment) -> dict[str, Trajectory]:
    """Return the runs that did not reach their end, by their names in messages."""
    names = ("the run", "the ideal linkage", "the run that estimates the errors")
    runs = zip(names, (result.run, result.ideal, result.tighter), strict=True)
    return {name: run for name, run in runs if run is not None and run.status is not Status.OK}


def _details(result: Assessment, summary: Summary) -> str:
    described = result.system.description
    cut, made = summary.mechanism.cut, summary.provenance
    step = engine(result.engine).longest_step(result.system)  # limited in addition to the accuracy
    steps = f", steps of at most {step:g} s" if step else ""
    numbers = ", ".join(f"{key.replace('_', ' ')} {value}" for key, value in made.run.items())
    lines = [
        f"experiment {described.source}, mechanism {described.machine_source}",
        f"joints cut to get a tree: {', '.join(cut.play + cut.ideal) or 'none'}",
        f"accuracy {result.system.settings.accuracy:g}{steps}",
        f"{numbers}; {made.wall_time:.3g} s for the run alone",
        "versions: " + ", ".join(f"{name} {version}" for name, version in made.versions.items()),
    ]
    return "\n".join(lines)


def _animate(result: Assessment, path: Path, exaggerate: float | None) -> None:
    """Write the animation; reject an exaggeration for which the loops do not close."""
    from linkages.show.plots.animation.animated import write_animation

    try:
        write_animation(result, path, exaggerate)
    except ValueError as problem:
        if exaggerate is None or exaggerate == 1.0:
            raise
        raise InputError("--exaggerate", f"{exaggerate:g}", f"{problem}; choose a smaller factor") from None
