"""``linkages sweep`` over the values of two variables: tables, maps with the lines of limits."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from linkages.base.brief import counted
from linkages.base.errors import InputError, Status, listed, nearest
from linkages.cli.options import number, output_folder, output_names, print_results, record, workers
from linkages.cli.progress import stages
from linkages.cli.sweep_tables import entry, extremes_said, some, write_tables
from linkages.input.files.writing import file_name, write_json

if TYPE_CHECKING:
    from linkages.explore.grid import Grid
    from linkages.system import System

#: Subfolder of the finished rows in the folder of results.
ROWS = "rows"

_SHOWN = 12, 7  # most values of the first and of the second variable in the text

Ranges = Sequence[tuple[str, list[float]]]


def run_grid(options: argparse.Namespace, system: System, ranges: Ranges) -> int:
    """Run the sweep over two variables; return the exit status."""
    from linkages.explore.grid import sweep_grid
    from linkages.results.outputs.registry import unit

    (path, values), (other_path, other_values) = ranges
    system.replaced({path: values[0], other_path: other_values[0]}, "--vary")  # reports a wrong path before the folder
    names = output_names(options, system)
    units = {name: unit(system, name) for name in names}
    limits = read_limits(options.limit, units)
    out = output_folder(options, f"{system.description.stem}_sweep", "sweep", continued=("rows",))
    settings = (names, options.revolutions, options.transient, options.drive, options.threads, out.path / ROWS)
    with workers(options, "repeat the command") as (executor, _):
        bar = stages(options, 1.0, "")("sweep")
        found = sweep_grid(system, path, values, other_path, other_values, *settings, executor, bar, "--vary")
    pairs = [((a, point.value), point) for a, row in zip(values, found.rows, strict=True) for point in row]
    with out as folder:
        write_tables(dict(zip(found.paths, found.units, strict=True)), pairs, units, False, folder)
        write_json(folder / "sweep.json", _content(found, units, limits), None)
        if not options.no_plots:
            from linkages.show.plots.style import write_figure
            from linkages.show.plots.swept import map_figure

            for name in names:
                figure = map_figure(found, name, units[name], limits.get(name))
                write_figure(figure, folder / f"map_{file_name(name)}")
        table, title = format_grid(found, units, limits), system.description.heading
        question = f"How do the peaks of {listed(names)} change with {path} and {other_path}?"
        record(options, folder, title, question, [_answer(found, name, units[name]) for name in names], table)
    print_results(options, table, out)
    failed: dict[Status, list[tuple[float, float]]] = {}
    for pair, point in pairs:
        if point.status not in (Status.OK, Status.INTERRUPTED):
            failed.setdefault(point.status, []).append(pair)
    for status, those in failed.items():
        first = f"first {path} = {those[0][0]:g}, {other_path} = {those[0][1]:g}"
        print(f"{counted(len(those), 'pair')}, {first}: {status.value}; {status.remedy}", file=sys.stderr)
    if found.status is Status.INTERRUPTED:
        done = sum(point.status is not Status.INTERRUPTED for _, point in pairs)
        of = counted(len(pairs), "pair")
        print(f"interrupted; the sections of {done} of {of} are written; the same command continues", file=sys.stderr)
        return 130
    return int(bool(failed))


def _answer(found: Grid, name: str, unit: str) -> str:
    places = [f"{a:.5g} and {b:.5g}" for a in found.values[0] for b in found.values[1]]
    return extremes_said(name, unit, dict(zip(places, found.peaks(name).ravel().tolist(), strict=True)))


def read_limits(texts: Sequence[str], units: Mapping[str, str]) -> dict[str, float]:
    """Read ``NAME=VALUE`` of ``--limit``: limits of outputs, in SI units."""
    found = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not equals:
            raise InputError("--limit", text, "write NAME=VALUE, such as B.force=2kN")
        if name not in units:
            raise InputError("--limit", name, f"is no recorded output; {nearest(name, units)}")
        si = units[name]
        found[name] = number("--limit", value, "" if si == "1" else si)
    return found


def _content(found: Grid, units: Mapping[str, str], limits: Mapping[str, float]) -> dict[str, Any]:
    """Return the content of ``sweep.json``: every revolution of every pair of values."""
    variables = dict(zip(found.paths, found.values, strict=True))
    rows = [[entry(point) for point in row] for row in found.rows]
    about = {"paths": found.paths, "values": variables, "transient": found.transient, "units": units, "limits": limits}
    return {**about, "rows": rows}


def format_grid(found: Grid, units: Mapping[str, str], limits: Mapping[str, float]) -> str:
    """Format the mean peaks of at most a dozen times seven pairs of values as lines of text."""
    import numpy as np

    from linkages.show.plots.presentation import shown, shown_unit

    down, across = (
        f"{path} [{shown_unit(si)}]" if si else path for path, si in zip(found.paths, found.units, strict=True)
    )
    firsts, seconds = (some(len(those), most) for those, most in zip(found.values, _SHOWN, strict=True))
    size = " x ".join(str(len(those)) for those in found.values)
    ups, rights = (_scaled(si, those) for si, those in zip(found.units, found.values, strict=True))
    lines = [f"{down} downwards, {across} to the right: {size} values; mean of the revolutions' peaks"]
    for name in found.names:
        unit, factor = shown(units[name])
        peaks = factor * found.peaks(name)
        lines += ["", f"{name} [{unit}]", " " * 12 + "".join(f"{rights[k]:>11.5g}" for k in seconds)]
        for k in firsts:
            cells = "".join(f"{peaks[k, j]:>11.5g}" if peaks[k, j] == peaks[k, j] else f"{'-':>11s}" for j in seconds)
            lines.append(f"{ups[k]:>12.5g}{cells}")
        if not np.isnan(peaks).all():
            for what, at in (("largest", np.nanargmax(peaks)), ("smallest", np.nanargmin(peaks))):
                lines.append(_place(found, peaks, what, int(at)))
        if name in limits:
            limit = factor * limits[name]
            above, known = int((peaks > limit).sum()), int((~np.isnan(peaks)).sum())
            lines.append(f"above the limit of {limit:.5g}: {above} of {counted(known, 'pair')}")
    return "\n".join(lines)


def _place(found: Grid, peaks: Any, what: str, at: int) -> str:
    """Tell an extreme of the peaks and the pair of values where it is."""
    k, j = divmod(at, len(found.values[1]))
    path, other_path = found.paths
    values, other_values = map(_scaled, found.units, found.values)
    return f"{what}: {peaks[k, j]:.5g} at {path} = {values[k]:.5g}, {other_path} = {other_values[j]:.5g}"


def _scaled(si: str, values: Sequence[float]) -> list[float]:
    from linkages.show.plots.presentation import shown

    return [shown(si)[1] * value for value in values]
