"""``linkages modes`` of a linkage: natural frequencies and mode shapes at rest, with fixed drives."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from linkages.base.brief import cell
from linkages.cli.options import output_folder, print_results, record, set_values
from linkages.cli.progress import progress_bar
from linkages.input.files.writing import write_json

if TYPE_CHECKING:
    from linkages.explore.modes import Modes, ModesOver
    from linkages.system import System


def run_linkage(options: argparse.Namespace, path: Path) -> int:
    """Compute the modes of an experiment's linkage; return the exit status."""
    import numpy as np

    from linkages.base.errors import COMMAND_LINE
    from linkages.explore.modes import modes, modes_over
    from linkages.results.steady_state import common_period
    from linkages.system import load

    system = load(path, set_values(options), COMMAND_LINE)
    out = output_folder(options, f"{path.stem}_modes", "modes")
    found = modes(system)
    count = min(options.count, len(found.squares))
    over = None
    if options.cycle is not None:
        times = np.linspace(0.0, common_period(system) or system.settings.duration, options.cycle + 1).tolist()
        over = modes_over(system, times, count, progress_bar("modes over the cycle"))
    result = content(system, found, over, count)
    with out as folder:
        write_json(folder / "modes.json", result)
        if not options.no_plots:
            from linkages.show.plots.linear_figures import frequencies_figure, shapes_figure
            from linkages.show.plots.style import write_figure

            write_figure(shapes_figure(found, count), folder / "mode_shapes")
            if over is not None:
                write_figure(frequencies_figure(over), folder / "mode_frequencies")
        from linkages.show.report.tables import modes as modes_table

        table = format_modes(result)
        record(
            options,
            folder,
            result["title"],
            "At which frequencies does it vibrate?",
            _answer(result),
            table,
            modes_table(result),
        )
    print_results(options, table, out)
    return 0


def content(system: System, found: Modes, over: ModesOver | None, count: int) -> dict[str, Any]:
    """Return the content of ``modes.json``: SI units, frequencies in Hz; docs/modes.md explains it."""
    from linkages.explore.modes import ModeShapes
    from linkages.input.files.versions import versions
    from linkages.system.identity import input_record
    from linkages.system.linear_systems import LEFT_OUT

    pose = found.system
    shapes, strain = ModeShapes(found), found.strain()
    points = shapes.points()
    drives = zip(pose.tree.driven, pose.tree.driven_dofs, strict=True)
    modes = [
        {
            "frequency": _number(found.frequencies[k]),
            "square": float(found.squares[k]),
            "damping": _number(found.damping[k]),
            "modal_mass": float(shapes.scale[k] ** 2),
            "strain": {link: round(float(share[k]), 6) for link, share in strain.items()},
            "points": {name: values[:, k].tolist() for name, values in points.items()},
        }
        for k in range(count)
    ]
    result = {
        "title": system.description.heading,
        "held": {name: float(pose.assembly.q[dof]) for name, dof in drives},
        "ideal": list(system.play),
        "left_out": [name for table in LEFT_OUT for name in system.parts[table]],
        "at_rest": found.at_rest,
        "conservative": found.conservative,
        "modes": modes,
    }
    if over is not None:
        result["over"] = {
            "times": over.times.tolist(),
            "frequencies": [[_number(value) for value in line] for line in over.frequencies],
            "mac": float(over.mac.min()),
        }
    return result | {"provenance": {"versions": versions(), "experiment": input_record(system)["experiment"]}}


def _answer(result: dict[str, Any]) -> list[str]:
    known = [mode["frequency"] for mode in result["modes"] if mode["frequency"] is not None]
    said = [f"Its lowest natural frequency is {min(known):.5g} Hz."] if known else []
    if unstable := len(result["modes"]) - len(known):
        said.append(f"{unstable} of {len(result['modes'])} modes are unstable.")
    return said


def format_modes(result: dict[str, Any]) -> str:
    """Format the content of ``modes.json`` as lines of text."""
    from linkages.system.linear_systems import LEFT_OUT

    lines = [result["title"], f"modes at rest in the pose at t = 0; drives held: {_names(result['held'])}"]
    if result["ideal"]:
        lines.append(f"clearance joints that are ideal here: {_names(result['ideal'])}")
    if result["left_out"]:
        lines.append(f"omitted ({', '.join(LEFT_OUT)}): {_names(result['left_out'])}")
    head = f"{'':10s}{'frequency [Hz]':>16s}{'damping [1]':>13s}"
    over = result.get("over")
    lines += ["", f"{head}{'lowest':>11s}{'highest':>11s}  strain energy" if over else f"{head}  strain energy"]
    for k, mode in enumerate(result["modes"]):
        line = f"{f'mode {k + 1}':10s}{_shown(mode['frequency']):>16s}{cell(mode['damping'], 13, '.4g')}"
        if over:
            values = [row[k] for row in over["frequencies"] if row[k] is not None]
            line += "".join(f"{_shown(pick(values)) if values else '-':>11s}" for pick in (min, max))
        shares = sorted(mode["strain"].items(), key=lambda item: -item[1])
        lines.append(line + "  " + ", ".join(f"{link} {share:.0%}" for link, share in shares[:3] if share >= 0.005))
    return "\n".join([*lines, *_warnings(result)])


def _warnings(result: dict[str, Any]) -> list[str]:
    said = []
    if not result["at_rest"]:
        advice = 'hold its free joints by drives; links start at rest with start = "quasi-static"'
        said.append(f"the pose is not an equilibrium, and the frequencies neglect part of its loads: {advice}")
    elif not result["conservative"]:
        said.append("some loads have no potential: for complex eigenvalues the real parts are given")
    for k, mode in enumerate(result["modes"]):
        if mode["frequency"] is None:
            time = 1.0 / math.sqrt(-mode["square"])
            said.append(f"mode {k + 1} is unstable: a disturbance grows by e in {time:.3g} s")
    return [line for text in said for line in ("", f"warning: {text}")]


def _number(value: float) -> float | None:
    return None if math.isnan(value) else float(value)


def _shown(value: float | None) -> str:
    return "unstable" if value is None else f"{value:.5g}"


def _names(names: Any) -> str:
    return ", ".join(names) or "none"
