"""``linkages sweep``: sections of each revolution over the values of one variable."""

from __future__ import annotations

import argparse
import csv
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from linkages.base.brief import counted
from linkages.base.errors import InputError, Status
from linkages.cli.options import (
    add_drive,
    add_experiment,
    add_number,
    add_outputs,
    load_system,
    output_folder,
    output_names,
    path_and_parts,
    print_results,
    value_of,
)
from linkages.cli.progress import stages
from linkages.input.files.writing import write_json

if TYPE_CHECKING:
    from linkages.explore.sections import Section
    from linkages.explore.sweep import Sweep, SweepPoint

HELP = "run over the values of one variable: bifurcation diagram, peaks with their spread"

EXAMPLES = """examples:
  linkages sweep seven_bar.toml --vary joints.A.clearance=0.1mm:0.4mm:31 --revolutions 2
  linkages sweep slider_crank_dry.toml --vary drives.O.speed=100:600:101 --output B.force --output B.ey
"""

_MOST = 1e6  # largest number of values
_STATISTICS = ("min", "max", "peak_mean", "peak_std", "peak_min", "peak_max")


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    add_experiment(parser, lasting=False)
    parser.add_argument("--vary", required=True, metavar="PATH=LO:HI:N", help="N values of a variable, evenly spaced")
    add_number(parser, "--revolutions", 20, "N", "recorded revolutions")
    add_number(parser, "--transient", 10, "M", "discarded revolutions before the recorded ones")
    add_drive(parser, "a revolution")
    add_outputs(parser)
    parser.add_argument("--threads", type=int, metavar="N", help="default: as many as processors")


def run(options: argparse.Namespace) -> int:
    """Run the sweep; return the exit status."""
    from linkages.explore.sweep import sweep
    from linkages.input.model.experiment import value_unit
    from linkages.results.outputs.registry import unit

    path, values = parse_range(options.vary)
    system = load_system(options)
    system.replaced({path: values[0]}, "--vary")  # reports a wrong path before the folder of results is made
    out = output_folder(options, f"{system.experiment.source.stem}_sweep", "sweep")
    names = output_names(options, system.experiment)
    turns = (options.revolutions, options.transient, options.drive)
    bar = stages(options, 1.0, "")("sweep")
    result = sweep(system, path, values, names, *turns, True, options.threads, bar, "--vary")
    units = {name: unit(system, name) for name in names}
    with out as folder:
        _write_table(result, folder / "sweep.csv")
        write_json(folder / "sweep.json", _content(result, units), None)
        if not options.no_plots:
            from linkages.show.plots.attractors import bifurcation_figure
            from linkages.show.plots.style import axis_label, engineering, write_png

            shown, factor = engineering(value_unit(path), max(map(abs, values)))
            write_png(bifurcation_figure(result, units, axis_label(path, shown), scale=factor), folder / "sweep.png")
    print_results(options, format_sweep(result, units), out)
    failed = [point for point in result.points if point.status not in (Status.OK, Status.INTERRUPTED)]
    for point in failed:
        print(f"{path} = {point.value:g}: {point.status.value}; {point.status.remedy}", file=sys.stderr)
    if result.status is Status.INTERRUPTED:
        done = sum(point.status is not Status.INTERRUPTED for point in result.points)
        print(f"interrupted; the sections of {done} of {counted(len(values), 'value')} are written", file=sys.stderr)
        return 130
    return int(bool(failed))


def parse_range(text: str) -> tuple[str, list[float]]:
    """Read ``PATH=LO:HI:N``: path and N values."""
    import numpy as np

    path, (*ends, number) = path_and_parts(text, "PATH=LO:HI:N")
    low, high = (value_of("--vary", end, path) for end in ends)
    count = value_of("--vary", number, "")
    if count != int(count) or not 2 <= count <= _MOST:
        raise InputError("--vary", text, "needs a whole number N from 2 to 1e6")
    return path, np.linspace(low, high, int(count)).tolist()


def statistics(point: SweepPoint, name: str) -> dict[str, float]:
    """Compute a column's extremes over all revolutions; mean, deviation and range of the revolutions' peaks.

    Undefined values are NaN: all values of a run that failed at once, the deviation of one revolution.
    """
    import numpy as np

    section = point.section
    if section is None or not len(section.times):
        return dict.fromkeys(_STATISTICS, float("nan"))
    peaks = section.peaks(name)
    deviation = np.std(peaks, ddof=1) if len(peaks) > 1 else np.nan
    extremes = (section.low[name].min(), section.high[name].max())
    values = (*extremes, peaks.mean(), deviation, peaks.min(), peaks.max())
    return dict(zip(_STATISTICS, map(float, values), strict=True))


def _write_table(result: Sweep, path: Path) -> None:
    """Write ``sweep.csv``: one line for each value, undefined numbers are empty."""
    head = [f"{name}.{what}" for name in result.names for what in _STATISTICS]
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow([result.path, "status", "revolutions", "horizon", *head])
        for point in result.points:
            numbers = [value for name in result.names for value in statistics(point, name).values()]
            done = len(point.section.times) if point.section is not None else 0
            cells = ["" if number != number else number for number in numbers]
            writer.writerow([point.value, point.status.value, done, point.horizon, *cells])


def _content(result: Sweep, units: dict[str, str]) -> dict[str, Any]:
    """Return the content of ``sweep.json``: every revolution of every value."""
    points: list[dict[str, Any]] = []
    for point in result.points:
        entry: dict[str, Any] = {"value": point.value, "status": point.status.value, "horizon": point.horizon}
        if (section := point.section) is not None:
            entry |= {"period": section.period, "outputs": columns(section)}
        points.append(entry)
    return {"path": result.path, "transient": result.transient, "units": units, "points": points}


def columns(section: Section) -> dict[str, dict[str, list[float]]]:
    """Return strobes, minima and maxima of each period, by output."""
    kinds = {"strobe": section.strobe, "min": section.low, "max": section.high}
    return {name: {kind: values[name].tolist() for kind, values in kinds.items()} for name in section.strobe}


def format_sweep(result: Sweep, units: dict[str, str]) -> str:
    """Format the peaks of at most a dozen values as lines of text, with the horizon of reproducible digits."""
    from linkages.input.model.experiment import value_unit

    count = len(result.points)
    shown = sorted({round(k * (count - 1) / 11) for k in range(12)}) if count > 12 else range(count)
    width = max(16, *(len(name) + len(units[name]) + 5 for name in result.names))
    heads = [f"{f'{name} [{units[name]}]':>{width + 12}s}" for name in result.names]
    several = any(point.section is not None and len(point.section.times) > 1 for point in result.points)
    spread = ": mean ± standard deviation over the revolutions" if several else ""
    si = value_unit(result.path)
    variable = f"{result.path} [{si}]" if si else result.path
    first = max(22, len(variable) + 2)
    lines = [f"{result.path}: {counted(count, 'value')}; peak of a revolution{spread}", ""]
    lines.append("".join([f"{variable:{first}s}", *heads]))
    for k in shown:
        point = result.points[k]
        line = f"{point.value:<{first}.6g}"
        for name in result.names:
            row = statistics(point, name)
            spread = f"± {row['peak_std']:.2g}" if row["peak_std"] == row["peak_std"] else ""
            line += f"{row['peak_mean']:{width}.5g} {spread:11s}"
        lines.append(line + ("" if point.status is Status.OK else f"  {point.status.value}"))
    if horizons := [point.horizon for point in result.points if point.horizon is not None]:
        agree = f"agree for {min(horizons):g} to {max(horizons):g} revolutions from the start;"
        lines += ["", f"runs at this and a ten times looser accuracy {agree}"]
        lines.append("later only means and standard deviations are reproducible, not single revolutions")
    return "\n".join(lines)
