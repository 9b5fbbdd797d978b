"""``linkages modes``: modes of a linkage; numbers, figures and an animation of the 3-RRR robot with flexible links."""

from __future__ import annotations

import argparse
import sys
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from linkages.base.errors import InputError, Status
from linkages.base.packages import check_installed
from linkages.cli.options import add_out, add_pictures, add_set, output_folder, print_results, record
from linkages.cli.progress import progress_bar
from linkages.input.files.writing import write_json

if TYPE_CHECKING:
    from linkages.three_rrr.analysis import RobotResults

HELP = "natural frequencies and mode shapes of a linkage at rest, or of the 3-RRR robot"
WRITES = {"modes": ("modes.json", "animation.html", "*.png")}

#: Options only for robots, and only for experiments.
_OF_ROBOT, _OF_LINKAGE = ("verify", "dynamic", "branch", "elements", "no_animation"), ("count", "cycle", "set")
_COUNT, _MOST = 6, 10_000  # default number of modes; largest number of modes and poses

#: Short runs of this command that compile its code, see `linkages.cli.preparation`.
SHORT_RUNS = ("slider_crank_flexible.toml",)

EXAMPLES = """examples:
  linkages modes slider_crank_flexible.toml
  linkages modes my.toml --count 4 --cycle 72 --set links.rod.bending=8
  linkages modes three_rrr.toml
  linkages modes three_rrr.toml --verify --branch 98 --out results/robot
  linkages modes three_rrr.toml --dynamic rest
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.add_argument("file", help="experiment or 3-RRR robot (.toml), a path or the name of a shipped one")
    parser.add_argument("--count", type=int, metavar="N", help=f"modes of a linkage; default: {_COUNT}")
    parser.add_argument("--cycle", type=int, metavar="N", help="linkage: also in N + 1 poses of the drives' period")
    add_set(parser)
    parser.add_argument("--verify", action="store_true", help="robot: compare with Drake's rigid plant (exit status 1)")
    vibration = "robot: add the response with vibration over the whole motion, with stress, from rest or quasi-static"
    parser.add_argument("--dynamic", choices=("rest", "quasi-static"), metavar="START", help=vibration)
    parser.add_argument("--branch", type=float, metavar="DEG", help="robot: platform angle at t = 0 of its assembly")
    add_out(parser)
    parser.add_argument("--elements", type=int, metavar="N", help="robot: beam elements of each link")
    add_pictures(parser, animation=True)


def run(options: argparse.Namespace) -> int:
    """Analyse the linkage or the robot; return the exit status."""
    from linkages.cli.linkage_modes import run_linkage
    from linkages.input.files.shipped import find_file
    from linkages.input.files.toml import read_toml
    from linkages.input.model.experiment import Experiment
    from linkages.three_rrr.robot import Robot

    path = find_file(options.file, ".toml")
    is_robot = bool(set(read_toml(path)[0]) & (set(Robot.model_fields) - set(Experiment.model_fields)))
    for key in _OF_LINKAGE if is_robot else _OF_ROBOT:
        given = getattr(options, key)
        if not (given is None or given is False or given == []):
            whose = "linkages" if is_robot else "the 3-RRR robot"
            raise InputError(f"--{key.replace('_', '-')}", options.file, f"is only for {whose}; remove it")
    if is_robot:
        return _run_robot(options, path)
    options.count = _COUNT if options.count is None else options.count
    for key in ("count", "cycle"):
        value, least = getattr(options, key), 1 + (key == "cycle")
        if value is not None and not least <= value <= _MOST:
            raise InputError(f"--{key}", str(value), f"must be from {least} to {_MOST}")
    return run_linkage(options, path)


def _run_robot(options: argparse.Namespace, path: Path) -> int:
    from linkages.three_rrr.analysis import analyse
    from linkages.three_rrr.robot import changed, load_robot

    if options.verify:
        check_installed("pydrake", "--verify")
    robot = load_robot(path)
    if options.elements is not None:
        robot = changed(robot, model={"elements": options.elements})
    if options.branch is not None:
        robot = changed(robot, branch=options.branch)
    out = output_folder(options, path.stem, "modes")
    results = analyse(robot, progress_bar("modes"))
    if options.dynamic is not None:
        from linkages.three_rrr.vibration import vibrate

        shaken = vibrate(results.model, results.branch, options.dynamic, progress=progress_bar("dynamic"))
        results = replace(results, dynamic=shaken)
    summary = summarize(results)
    if options.verify:
        import numpy as np

        from linkages.three_rrr.verify import verify

        poses = results.branch.motion(np.linspace(0.0, results.branch.times[-1], 25))
        summary["verify"] = asdict(verify(robot, poses))
    with out as folder:
        write_json(folder / "modes.json", summary)
        if not options.no_plots:
            from linkages.show.plots.three_rrr.figures import write_figures

            write_figures(results, folder, progress_bar("figures"))
        if not options.no_animation:
            from linkages.show.plots.three_rrr.robot_lines import write_animation

            write_animation(results, folder / "animation.html")
        table, lowest = format_table(summary), min((low for low, _ in summary["ranges"]), default=0.0)
        question = "How stiff is the robot over its motion: frequencies, elastic displacements, stresses?"
        answer = [f"With held crank roots its lowest natural frequency over the motion is {lowest:.5g} Hz."]
        record(options, folder, summary["title"], question, answer, table)
    print_results(options, table, out)
    problems = [f"the comparison with Drake fails: {line}" for line in summary.get("verify", {}).get("failed", ())]
    if results.branch.status is not Status.OK:
        fold, end = results.branch.singularities[-1].time, results.branch.times[-1]
        ends = f"at t = {fold:.6g} s, analysed up to {end:.6g} s; shorten the duration or follow another branch"
        problems.append(f"the branch ends at a fold (singularity of type 2) {ends}")
    for line in problems:
        print(line, file=sys.stderr)
    return int(bool(problems))


def summarize(results: RobotResults) -> dict[str, Any]:
    """Return the content of ``modes.json``, SI units."""
    import numpy as np

    from linkages.input.files.versions import versions
    from linkages.three_rrr.branch import travel

    robot, branch, shaken = results.robot, results.branch, results.dynamic
    metrics = ("path", "rotation", "pivots")

    def displacement(platform: Any) -> dict[str, float]:
        peak = np.max(np.abs(platform), axis=tuple(range(platform.ndim - 1)))
        return dict(zip(("x", "y", "angle"), map(float, peak), strict=True))

    dynamic = {}
    if shaken is not None:
        plate = {} if shaken.plate is None else {"platform": float(np.max(np.abs(shaken.plate)))}
        dynamic["dynamic"] = {"steps": shaken.steps, "elastic_displacement": displacement(shaken.platform)}
        dynamic["dynamic"]["stress"] = shaken.largest | plate
    return {
        "title": robot.title,
        "status": branch.status.value,
        "duration": float(branch.times[-1]),
        "assemblies": [{"theta": float(t), "x": float(x), "y": float(y)} for t, x, y in results.assemblies.x],
        "assemblies_certified": results.assemblies.certified,
        "loop_error": results.loop_error,
        "branch": {"theta": float(branch.x[0, 0]), "travel": {m: travel(branch, m) for m in metrics}},  # type: ignore[arg-type]
        "singularities": [asdict(s) for s in branch.singularities],
        "elements": robot.model.elements,
        "locked_frequencies": results.frequencies[0].tolist(),
        "free_frequencies": results.free[0].tolist(),
        "ranges": [[float(f.min()), float(f.max())] for f in results.frequencies.T],
        "free_ranges": [[float(f.min()), float(f.max())] for f in results.free.T],
        "tracked_ranges": [[float(f.min()), float(f.max())] for f in results.tracked.T],
        "elastic_displacement": displacement(results.static.platform),
        "stress": {s.name: float(s.largest.max()) for s in results.stress},
        **dynamic,
        "provenance": {"robot": robot.model_dump(), "versions": versions()},
    }


def format_table(result: dict[str, Any]) -> str:
    """Format the summary as lines of text."""
    from math import degrees

    travel = result["branch"]["travel"]
    lines = [
        result["title"],
        f"branch theta(0) = {degrees(result['branch']['theta']):.2f} deg, {result['duration']:.6g} s,"
        f" status {result['status']}; {result['elements']} element(s) in each link",
        "",
        f"{'assembly at t = 0':20s}{'theta [deg]':>14s}{'x [mm]':>12s}{'y [mm]':>12s}",
    ]
    for n, a in enumerate(result["assemblies"], 1):
        lines.append(f"{n:<20d}{degrees(a['theta']):14.4f}{1e3 * a['x']:12.4f}{1e3 * a['y']:12.4f}")
    lines += ["", f"{'frequency [Hz]':20s}{'t = 0':>14s}{'lowest':>12s}{'highest':>12s}{'free roots':>12s}"]
    rows = zip(result["locked_frequencies"], result["ranges"], result["free_frequencies"], strict=False)
    for n, (now, (low, high), free) in enumerate(list(rows)[:8], 1):
        lines.append(f"mode {n:<15d}{now:14.2f}{low:12.2f}{high:12.2f}{free:12.2f}")
    ways = f"path {travel['path']:.4f} m, rotation {travel['rotation']:.4f} rad, pivots {travel['pivots']:.4f} m"
    lines += ["", f"travel: {ways}"]
    parts = {"quasi-static": result} | ({"with vibration": result["dynamic"]} if "dynamic" in result else {})
    for name, part in parts.items():
        x, y, angle = (1e6 * value for value in part["elastic_displacement"].values())
        lines += [
            f"{name}: elastic platform displacement x {x:.4f} um, y {y:.4f} um, rotation {angle:.4f} urad;"
            " largest stress [MPa]:",
            "  " + ", ".join(f"{k} {1e-6 * v:.4g}" for k, v in part["stress"].items()),
        ]
    if "verify" in result:
        check = result["verify"]
        lines += ["", f"against Drake's rigid plant: {'FAILED' if check['failed'] else 'passed'}"]
        lines += [f"  {key:18s} {value:.3g}" for key, value in check.items() if key != "failed"]
    return "\n".join(lines)
