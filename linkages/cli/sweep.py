"""``linkages sweep``: sections of each revolution over the values of one variable; `sweep_grid`: of two."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING, Any

from linkages.base.brief import counted
from linkages.base.errors import InputError, Status, listed
from linkages.cli.options import (
    add_cluster,
    add_drive,
    add_experiment,
    add_number,
    add_outputs,
    add_units,
    load_system,
    number,
    output_folder,
    output_names,
    path_and_parts,
    print_results,
    record,
    value_of,
)
from linkages.cli.progress import stages
from linkages.cli.sweep_grid import run_grid
from linkages.cli.sweep_tables import entry, extremes_said, some, statistics, write_tables
from linkages.input.files.writing import write_json

if TYPE_CHECKING:
    from pathlib import Path

    from linkages.explore.sweep import Sweep, SweepPoint
    from linkages.input.model.mechanism import Mechanism
    from linkages.system import System

HELP = "run over the values of one or two variables: peaks, bifurcation diagram, maps"
WRITES = {"sweep": ("sweep.json", "sweep.csv", "sweep.parquet", "sweep.png", "map_*.png", "rows")}

#: Short runs of this command that compile its code, see `linkages.cli.preparation`.
SHORT_RUNS = (
    "slider_crank_dry.toml --vary joints.B.clearance=1e-4:2e-4:2 --revolutions 1",
    "slider_crank_lubricated.toml --vary joints.B.clearance=1e-4:2e-4:2 --output B.force --revolutions 1 --transient 0",
)

EXAMPLES = """examples:
  linkages sweep seven_bar.toml --vary joints.A.clearance=0.1mm:0.4mm:31 --revolutions 2
  linkages sweep slider_crank_dry.toml --vary drives.O.speed=100:600:101 --output B.force --output B.ey
  linkages sweep seven_bar.toml --vary joints.A.clearance=0.1mm:0.4mm:9 --vary drives.O1.speed=2:8:7 --revolutions 2 \
      --output A.force --limit A.force=20N

Two --vary make a map of each output over the grid of values. Its finished points are kept in DIR/rows: repeat the
command to continue an interrupted sweep, with the same results. Remove the folder to start again.
"""

_REPEATS = 1e-3  # largest relative difference between revolutions of a motion that repeats
_MOST = 1e6  # largest number of values


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    add_experiment(parser, lasting=False)
    add_units(parser)
    meaning = "N values of a variable, evenly spaced; given twice: a grid of values"
    parser.add_argument("--vary", action="append", required=True, metavar="PATH=LO:HI:N", help=meaning)
    add_number(parser, "--revolutions", 20, "N", "recorded revolutions")
    add_number(parser, "--transient", 10, "M", "discarded revolutions before the recorded ones")
    add_drive(parser, "a revolution")
    add_outputs(parser)
    line = "draw the line of this peak into the map of an output; may be repeated"
    parser.add_argument("--limit", action="append", default=[], metavar="NAME=VALUE", help=line)
    add_cluster(parser)
    parser.add_argument("--threads", type=int, metavar="N", help="default: as many as processors")


def run(options: argparse.Namespace) -> int:
    """Run the sweep; return the exit status."""
    from linkages.explore.sweep import sweep
    from linkages.results.outputs.registry import unit

    if len(options.vary) > 2:
        raise InputError("--vary", options.vary[2], f"is number {len(options.vary)}; vary one or two values")
    system = load_system(options)
    ranges = [parse_range(text, system) for text in options.vary]
    if len(ranges) == 2:
        return run_grid(options, system, ranges)
    for option in ("limit", "cluster"):
        if getattr(options, option):
            raise InputError(f"--{option}", "", "is for two values; give --vary twice")
    ((path, values),) = ranges
    system.replaced({path: values[0]}, "--vary")  # reports a wrong path before the folder of results is made
    out = output_folder(options, f"{system.description.stem}_sweep", "sweep", continued=("rows",))
    names = output_names(options, system)
    turns = (options.revolutions, options.transient, options.drive)
    bar = stages(options, 1.0, "")("sweep")
    result = sweep(system, path, values, names, *turns, True, options.threads, bar, "--vary")
    units = {name: unit(system, name) for name in names}
    with out as folder:
        pairs = [((point.value,), point) for point in result.points]
        write_tables({path: result.unit}, pairs, units, True, folder)
        write_json(folder / "sweep.json", _content(result, units), None)
        if not options.no_plots:
            _draw(result, units, system.mechanism, folder / "sweep")
        from linkages.show.plots.names import name_of_output, name_of_value
        from linkages.show.plots.quantities import quantity
        from linkages.show.report.tables import sweep as peaks_of

        table, title = format_sweep(result, units), system.description.heading
        ends = f"from {quantity(values[0], result.unit)} to {quantity(values[-1], result.unit)}"
        outputs = listed(name_of_output(name) for name in names)
        question = f"How do the peaks of the {outputs} change with the {name_of_value(path)} {ends}?"
        record(options, folder, title, question, _answer(result, units), table, [peaks_of(result, units, statistics)])
    print_results(options, table, out)
    failed = [point for point in result.points if point.status not in (Status.OK, Status.INTERRUPTED)]
    for point in failed:
        print(f"{path} = {point.value:g}: {point.status.value}; {point.status.remedy}", file=sys.stderr)
    if result.status is Status.INTERRUPTED:
        done = sum(point.status is not Status.INTERRUPTED for point in result.points)
        print(f"interrupted; the sections of {done} of {counted(len(values), 'value')} are written", file=sys.stderr)
        return 130
    return int(bool(failed))


def parse_range(text: str, system: System) -> tuple[str, list[float]]:
    """Read ``PATH=LO:HI:N``: path and N values."""
    import numpy as np

    path, (*ends, many) = path_and_parts(text, "PATH=LO:HI:N")
    low, high = (value_of("--vary", end, path, system) for end in ends)
    count = number("--vary", many, "")
    if count != int(count) or not 2 <= count <= _MOST:
        raise InputError("--vary", text, "needs a whole number N from 2 to 1e6")
    return path, np.linspace(low, high, int(count)).tolist()


def _draw(result: Sweep, units: dict[str, str], mechanism: Mechanism, path: Path) -> None:
    """Draw small panels of the peaks where every motion repeats in each revolution, else the bifurcation diagram."""
    from linkages.show.plots.attractors import bifurcation_figure
    from linkages.show.plots.names import name_of_value
    from linkages.show.plots.style import axis_label, engineering, write_figure
    from linkages.show.plots.swept import peaks_figure

    if all(_repeats(point, name) for point in result.points for name in result.names):
        figure = peaks_figure(result, units, mechanism)
    else:
        shown, factor = engineering(result.unit, max(abs(point.value) for point in result.points))
        label = axis_label(name_of_value(result.path), shown)
        figure = bifurcation_figure(result, units, label, scale=factor, mechanism=mechanism)
    write_figure(figure, path)


def _answer(result: Sweep, units: dict[str, str]) -> list[str]:
    """Tell the extreme peaks of each output, and where the motion does not repeat in each revolution."""
    said = [
        extremes_said(name, units[name], {f"{point.value:.5g}": point.mean_peak(name) for point in result.points})
        for name in result.names
    ]
    other = [point.value for point in result.points if not all(_repeats(point, name) for name in result.names)]
    if other:
        where = f"at {counted(len(other), 'value')} from {min(other):.5g} to {max(other):.5g}"
        said.append(f"The motion does not repeat in each revolution {where}.")
    return said


def _repeats(point: SweepPoint, name: str) -> bool:
    """Whether the end and the peak of an output differ in no revolution by more than a small part of its peak."""
    import numpy as np

    section = point.section
    if section is None or not len(section.times):
        return True
    peaks = section.peaks(name)
    return bool(max(np.ptp(section.strobe[name]), np.ptp(peaks)) <= _REPEATS * peaks.max())


def _content(result: Sweep, units: dict[str, str]) -> dict[str, Any]:
    """Return the content of ``sweep.json``: every revolution of every value."""
    points = [entry(point) for point in result.points]
    return {"path": result.path, "transient": result.transient, "units": units, "points": points}


def format_sweep(result: Sweep, units: dict[str, str]) -> str:
    """Format the peaks of at most a dozen values as lines of text, with the horizon of reproducible digits."""
    from linkages.show.plots.presentation import shown, shown_unit

    count = len(result.points)
    few = some(count, 12)
    width = max(16, *(len(name) + len(units[name]) + 5 for name in result.names))
    heads = [f"{f'{name} [{shown_unit(units[name])}]':>{width + 12}s}" for name in result.names]
    several = any(point.section is not None and len(point.section.times) > 1 for point in result.points)
    spread = ": mean ± standard deviation over the revolutions" if several else ""
    si = result.unit
    unit, scale = shown(si)
    variable = f"{result.path} [{unit}]" if si else result.path
    first = max(22, len(variable) + 2)
    lines = [f"{result.path}: {counted(count, 'value')}; peak of a revolution{spread}", ""]
    lines.append("".join([f"{variable:{first}s}", *heads]))
    for k in few:
        point = result.points[k]
        line = f"{scale * point.value:<{first}.6g}"
        for name in result.names:
            factor = shown(units[name])[1]
            row = {key: factor * value for key, value in statistics(point, name).items()}
            spread = f"± {row['peak_std']:.2g}" if row["peak_std"] == row["peak_std"] else ""
            line += f"{row['peak_mean']:{width}.5g} {spread:11s}"
        lines.append(line + ("" if point.status is Status.OK else f"  {point.status.value}"))
    if horizons := [point.horizon for point in result.points if point.horizon is not None]:
        agree = f"agree for {min(horizons):g} to {max(horizons):g} revolutions from the start;"
        lines += ["", f"runs at this and a ten times looser accuracy {agree}"]
        lines.append("later only means and standard deviations are reproducible, not single revolutions")
    return "\n".join(lines)
