"""``linkages compare``: both engines on one experiment."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from linkages.base.brief import counted
from linkages.cli.options import add_experiment, add_number, load_system, output_folder, print_results, record, seconds
from linkages.cli.progress import stages
from linkages.input.files.writing import write_json

if TYPE_CHECKING:
    from linkages.explore.compare import Comparison
    from linkages.system import System

HELP = "run both engines and print their differences"
WRITES = {"compare": ("compare.json", "warnings.json")}

EXAMPLES = """examples:
  linkages compare seven_bar.toml --duration 0.3
  linkages compare slider_crank_dry.toml --accuracy 1e-11 --out results/dry
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    add_experiment(parser, pictures=False)
    meaning = "accuracy of both engines, small so that they are compared and not their tolerances"
    add_number(parser, "--accuracy", 1e-11, "X", meaning)
    meaning = "longest time of the runs, of which Drake's take minutes; what they reach by then is compared"
    parser.add_argument("--limit", type=seconds, default=120.0, metavar="SECONDS", help=f"{meaning}; default: 120")


def run(options: argparse.Namespace) -> int:
    """Compare the engines; return the exit status."""
    from linkages.base.errors import InputError, Status
    from linkages.cli.main import report_failures
    from linkages.explore.compare import compare

    if not options.limit > 0.0:
        raise InputError("--limit", f"{options.limit:g}", "must be positive")
    system = load_system(options, {"solver.accuracy": options.accuracy})
    out = output_folder(options, f"{system.description.stem}_compare", "compare")
    result = compare(system, stages(options, system.settings.duration, "s"), options.limit)
    with out as folder:
        write_json(folder / "compare.json", _rows(result))
        write_json(folder / "warnings.json", result.warnings)
        table = format_comparison(result, system)
        title = system.description.heading
        record(options, folder, title, "Do both engines agree?", _answer(result), table)
    print_results(options, table, out)
    ended = {name: run for name, run in result.runs.items() if run.status is not Status.TIME_OVER}
    return report_failures({f"the {engine} run": run for engine, run in ended.items()})


def _rows(result: Comparison) -> dict[str, dict[str, float | None]]:
    """Return the differences of each output; null without a value. With flexible links also what segments change."""
    rows: dict[str, dict[str, float | None]] = {}
    for name in (*result.differences, *sorted(result.meaningless)):
        row, other = result.differences.get(name), result.segments.get(name)
        rows[name] = {key: getattr(row, key, None) for key in ("max_difference", "relative")}
        rows[name] |= {"segments": other.relative} if other else {}
    return rows


def _answer(result: Comparison) -> list[str]:
    if not result.differences:
        return ["No output can be compared."]
    name, row = max(result.differences.items(), key=lambda one: one[1].relative)
    most = f"at most {row.relative:.1e} of their peaks ({name})"
    said = [f"Up to {result.until:.6g} s, outputs of both engines differ by {most}."]
    if none := len(result.meaningless):
        said.append(f"{counted(none, 'output')} without a value cannot be compared.")
    if result.segments:
        name, row = max(result.segments.items(), key=lambda one: one[1].relative)
        said.append(f"Drake's rigid segments change them by at most {row.relative:.1e} of their peaks ({name}).")
    said += ["The limit of time ended the comparison there."] if result.late else []
    return [*said, *(["Later the motion is chaotic."] if result.parted else [])]


def format_comparison(result: Comparison, system: System) -> str:
    """Format a comparison as lines of text."""
    from linkages.elements.machine import KINDS
    from linkages.explore.compare import revolutions
    from linkages.results.divergence import PARTED
    from linkages.results.impacts import COMPARED, QUANTITIES
    from linkages.results.outputs.registry import unit
    from linkages.show.report.terminal import format_warnings

    turns = revolutions(system, result.until)
    after = f", revolutions: {turns:.3g}" if turns is not None else ""
    lines = [
        system.description.heading,
        f"compiled and drake engines, accuracy {system.settings.accuracy:g},"
        f" compared up to {result.until:.6g} s{after}",
    ]
    if result.parted:
        horizons = ", ".join(f"{name} {time:.6g} s" for name, time in result.horizons.items())
        lines += [
            f"horizon: runs of one engine at this and a ten times looser accuracy diverge by {PARTED:g} clearances at",
            f"{horizons}; differences are computed up to there; later ones are meaningless",
        ]
    if result.late:
        lines.append(
            f"the limit of time ended the runs at {result.until:.6g} s of {system.settings.duration:g} s;"
            " more with --limit SECONDS or a looser --accuracy"
        )
    if result.segments:
        for kind in KINDS:
            lines += kind.substitute.compared(system.parts[kind.table]) if kind.substitute is not None else []
    of_segments = f"{'segments':>13s}" if result.segments else ""
    lines += ["", f"{'':28s}{'largest difference':>20s}{'of peak':>11s}{'at [s]':>13s}{'peak':>13s}{of_segments}"]
    for name, row in result.differences.items():
        label = f"{name} [{unit(system, name)}]"
        line = f"{label:28s}{row.max_difference:20.3e}{row.relative:11.1e}{row.time:13.6g}{row.peak:13.6g}"
        lines.append(line + (f"{result.segments[name].relative:13.1e}" if name in result.segments else ""))
    lines += [f"{f'{name} [{unit(system, name)}]':28s}{'-':>20s}{'-':>11s}" for name in sorted(result.meaningless)]
    if result.contacts:
        lines += [
            "",
            "first contacts of each joint before the horizon: the compiled engine's, and Drake's differences from them",
            f"{'':12s}{'start [s]':>24s}" + "".join(f"{QUANTITIES[field].head:>22s}" for field in COMPARED),
        ]
    for ours, other in result.contacts:
        line = f"{ours.joint:12s}{ours.start:15.9g}{other.start - ours.start:9.0e}"
        for field in COMPARED:
            value = getattr(ours, field)
            line += f"{value:13.6g}{getattr(other, field) - value:9.0e}"
        lines.append(line)
    compiled, drake = result.warnings["compiled"], result.warnings["drake"]
    alike = {" of both engines": compiled} if compiled == drake else {" of compiled": compiled, " of drake": drake}
    lines += [line for whose, found in alike.items() for line in format_warnings(found, whose)]
    return "\n".join(lines)
