"""``linkages overlay``: several runs, also of different machines, in one figure and one table of peaks."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from linkages.base.brief import cell
from linkages.base.errors import InputError, listed, nearest
from linkages.cli.options import (
    add_names,
    add_out,
    add_part,
    add_pictures,
    add_units,
    output_folder,
    part_of,
    print_results,
    record,
    stored_run,
)
from linkages.input.files.writing import write_json

if TYPE_CHECKING:
    from linkages.results.trajectory import Trajectory

HELP = "several runs, also of different machines, in one figure and one table of peaks"
WRITES = {"overlay": ("overlay.json", "overlay.png")}

EXAMPLES = """examples:
  linkages overlay results/dry results/lubricated --output B.force --output slider.ax
  linkages overlay results/press results/six_bar --output A.force --from 0.5 --format pdf --size 85x60mm --style print
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.add_argument("folders", nargs="+", type=Path, metavar="DIR", help="folder that `linkages simulate` wrote")
    add_names(parser, "--output", "output, see `linkages keys`; a panel of the figure; may be repeated")
    add_part(parser, "all")
    add_units(parser)
    add_pictures(parser)
    add_out(parser)


def run(options: argparse.Namespace) -> int:
    """Write the figure and the table; return the exit status."""
    from linkages.results.extremes import peaks

    names: list[str] = options.output or []
    if not names:
        raise InputError("--output", "", "is missing; name an output, such as B.force")
    folders = _labels(options.folders)
    runs = {label: part_of(stored_run(folder), folder, options) for label, folder in folders.items()}
    units = {name: _unit(name, runs) for name in names}
    unknown = {label: _valueless(folder) for label, folder in folders.items()}
    none: dict[str, float | None] = {"peak": None, "time": None}
    found = {
        name: {
            label: none if name in unknown[label] else {"peak": found.value, "time": found.time}
            for label, run in runs.items()
            if name in run
            for found in peaks(run, [name]).values()
        }
        for name in names
    }
    out = output_folder(options, "overlay", "overlay")
    with out as folder:
        write_json(folder / "overlay.json", {"units": units, "peaks": found})
        if not options.no_plots:
            from linkages.show.plots.overlaid import overlay_figure
            from linkages.show.plots.style import write_figure

            write_figure(overlay_figure(runs, names), folder / "overlay")
        table = format_peaks(found, units)
        question = f"What are the peaks of {listed(names)} in {listed(runs)}?"
        answer = [_answer(name, units[name], of_runs) for name, of_runs in found.items()]
        record(options, folder, "Runs in one figure", question, answer, table)
    print_results(options, table, out)
    return 0


def _labels(folders: list[Path]) -> dict[str, Path]:
    """Return the folders by their names, or where two have the same name by the ends of their paths that differ."""
    parts = [folder.resolve().parts for folder in folders]
    if len(set(parts)) < len(parts):
        raise InputError("DIR", "", "a folder is given twice")
    count = next(n for n in range(1, max(map(len, parts)) + 1) if len({part[-n:] for part in parts}) == len(parts))
    return {"/".join(part[-count:]): folder for part, folder in zip(parts, folders, strict=True)}


def _unit(name: str, runs: dict[str, Trajectory]) -> str:
    """Return the common unit of an output; InputError if no run has it, or two runs have other units."""
    units = {label: run.units.get(name, "") for label, run in runs.items() if name in run}
    if not units:
        from linkages.results.outputs.registry import LISTED

        known = {column for run in runs.values() for column in run}
        raise InputError("--output", name, f"is in none of the runs; {nearest(name, known, place=LISTED)}")
    if len(set(units.values())) > 1:
        said = ", ".join(f"[{unit}] in {label}" for label, unit in units.items())
        raise InputError("--output", name, f"is {said}; overlay runs where it has one unit")
    return next(iter(units.values()))


def _valueless(folder: Path) -> set[str]:
    """Name the columns whose peaks have no value in the summary of a folder: indeterminate or unbounded ones."""
    from linkages.results.shape import peaks_by_key
    from linkages.show.report.result_folder import load_results

    if not (folder / "summary.json").exists():
        return set()
    known = peaks_by_key(load_results(folder).summary)
    return {key.removesuffix(".peak") for key, peak in known.items() if peak is None}


def _answer(name: str, unit: str, found: dict[str, dict[str, Any]]) -> str:
    known = {run: one["peak"] for run, one in found.items() if one["peak"] is not None}
    if not known:
        return f"No run has a value of {name}."
    run = max(known, key=known.__getitem__)
    return f"The largest peak of {name} is {known[run]:.4g} {unit}, in {run}."


def format_peaks(peaks: dict[str, dict[str, Any]], units: dict[str, str]) -> str:
    """Format the peak of each output in each run as lines of text."""
    from linkages.show.plots.presentation import shown

    width = max(24, *(2 + len(label) for found in peaks.values() for label in found))
    lines = []
    for name, found in peaks.items():
        unit, factor = shown(units[name])
        label = f"{name} [{unit}]" if unit else name
        lines += [f"{label:{width}s}{'peak':>14s}{'at [s]':>14s}{'peak over first':>18s}"]
        first = next(iter(found.values()))["peak"]
        for run, one in found.items():
            peak = one["peak"]
            cells = cell(None if peak is None else factor * peak, 14, ".6g") + cell(one["time"], 14, ".6g")
            ratio = peak / first if first and peak is not None else None
            lines.append(f"  {run:{width - 2}s}{cells}{cell(ratio, 18, '.4g')}")
        lines.append("")
    return "\n".join(lines[:-1])
