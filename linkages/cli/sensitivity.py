"""``linkages sensitivity``: derivatives of peaks, means and works with respect to values."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from linkages.base.brief import cell
from linkages.base.errors import listed
from linkages.cli.options import add_experiment, add_names, load_system, output_folder, print_results, record
from linkages.cli.progress import stages
from linkages.input.files.writing import write_json

if TYPE_CHECKING:
    from linkages.explore.sensitivity import Sensitivities
    from linkages.system import System

HELP = "derivatives of peaks, means and works of a run with respect to values"
WRITES = {"sensitivity": ("sensitivity.json", "details.json", "matrix.png")}

#: Short runs of this command that compile its code, see `linkages.cli.preparation`.
SHORT_RUNS = (
    "seven_bar.toml --wrt joints.A.clearance sdf.links.link6.mass --duration 0.01",
    "slider_crank_dry.toml --wrt joints.B.clearance --duration 0.001",
    "slider_crank_lubricated.toml --wrt joints.B.clearance drives.O.speed --duration 0.002 --check",
)

EXAMPLES = """examples:
  linkages sensitivity seven_bar.toml --wrt joints.A.clearance joints.A.viscosity sdf.links.link6.mass
  linkages sensitivity my.toml --wrt drives.O.speed gravity.y --output slider.ax --check
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    add_experiment(parser)
    values = "values; of the machine with sdf."
    parser.add_argument("--wrt", nargs="+", action="extend", required=True, metavar="PATH", help=values)
    default = "the experiment's, forces and eccentricities of clearance joints, torques of drives"
    add_names(parser, "--output", f"an output; may be repeated; default: {default}")
    parser.add_argument("--check", action="store_true", help="compare derivatives of peaks with differences of runs")
    parser.add_argument("--no-error-estimate", action="store_true", help="do not repeat the run at a tighter accuracy")


def run(options: argparse.Namespace) -> int:
    """Compute the derivatives; return the exit status."""
    from linkages.engines.assessment import assess
    from linkages.explore.sensitivity import NEEDED, sensitivities
    from linkages.results.warnings import warning

    system, notes = load_system(options), []
    progress = stages(options, system.settings.duration, "s")
    system.value(options.wrt[0])  # a wrong path ends the command before the first run
    window = assess(system, error_estimate=False, progress=progress).reported_span
    if (accuracy := system.settings.accuracy) > NEEDED:
        what = f"solver.accuracy is {NEEDED:g} in this run instead of {accuracy:g}, which derivatives need"
        notes.append(warning("accuracy", None, what, "give a tighter one, if the stated errors are too large"))
        system = system.replaced({"solver.accuracy": NEEDED})
    out = output_folder(options, f"{system.description.stem}_sensitivity", "sensitivity")
    asked = options.wrt, options.output, not options.no_error_estimate, options.check
    found = sensitivities(system, *asked, progress, window)
    found.warnings.extend(notes)
    with out as folder:
        write_json(folder / "sensitivity.json", found.derivatives)
        details = {"values": found.values, "numbers": found.numbers, "errors": found.errors}
        details |= {"window": found.window, "times": found.times, "reach": found.reach}
        details |= {"differences": found.checks, "warnings": found.warnings, "run": found.run.provenance}
        write_json(folder / "details.json", details)
        if not options.no_plots:
            from linkages.show.plots.matrix import matrix_figure
            from linkages.show.plots.style import write_figure

            write_figure(matrix_figure(found), folder / "matrix")
        from linkages.show.plots.changes import strongest
        from linkages.show.plots.names import name_of_value
        from linkages.show.report.tables import matrix

        table, title = format_sensitivities(found, system), system.description.heading
        question = f"How do the peaks change with the {listed(map(name_of_value, options.wrt))}?"
        record(
            options,
            folder,
            title,
            question,
            [f"{one}." for one in strongest(found)],
            table,
            matrix(found, system.value_unit),
        )
    print_results(options, table, out)
    return 0


def format_sensitivities(found: Sensitivities, system: System) -> str:
    """Format the derivatives of peaks: for each output the values, the strongest first."""
    from linkages.results.outputs.registry import unit
    from linkages.show.report.terminal import format_warnings

    part = f"of the run from {found.window[0]:.6g} to {found.window[1]:.6g} s"
    lines = [system.description.heading, f"derivatives {part}, and changes by 1 %"]
    for key in _shown(found):
        label = unit(system, key.rpartition(".")[0]).removeprefix("1")
        lines += ["", f"{key}: {found.numbers[key]:.6g} {label}".rstrip()]
        if key in found.times:
            lines[-1] += f" at {found.times[key]:.6g} s"
        head = f"  {'value':44s}{'derivative':>14s}{'error':>10s}{'predicts to':>13s}{'per 1 %':>12s}"
        lines.append(head + (f"{'differences':>14s}" if found.checks else ""))
        for path in sorted(found.values, key=lambda path: -abs(found.per_cent(path, key) or 0.0)):
            lines.append(_row(found, path, key, system.value_unit(path)))
    return "\n".join([*lines, *format_warnings(found.warnings)])


def _shown(found: Sensitivities) -> list[str]:
    """Name the peaks, and after a peak without a statement the mean and root mean square with one."""
    from linkages.explore.prediction import STATED

    keys = []
    for key in found.times:
        averages = [f"{key.removesuffix('.peak')}.{kind}" for kind in ("mean", "rms")]
        lacking = [path for path in found.values if found.reaches(path, key) < STATED]
        known = [
            one
            for one in averages
            if any(found.per_cent(path, one) is not None for path in lacking if one in found.numbers)
        ]
        keys += [key, *known]
    return keys


def _row(found: Sensitivities, path: str, key: str, unit: str) -> str:
    """Write the derivative of a number by a value: its error, how far it predicts, the change by 1 %."""
    from linkages.explore.prediction import extent

    rate, error, share = found.derivatives[path][key], found.errors[path][key], found.per_cent(path, key)
    line = (
        f"  {f'{path} = {found.values[path]:.5g} {unit}'.rstrip():44s}{cell(rate, 14, '.6g')}{cell(error, 10, '.1e')}"
    )
    reach = found.reach.get(path, {}).get(key)
    line += cell(None if reach is None else extent(reach), 13)
    line += f"{'-' if share is None else f'{100.0 * share:+.3g} %':>12s}"
    return line + (cell(found.checks[path].get(key), 14, ".6g") if found.checks else "")
