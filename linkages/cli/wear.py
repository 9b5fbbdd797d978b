"""``linkages wear``: wear of journals and bearings over the service life."""

from __future__ import annotations

import argparse
import sys
from typing import Any

from linkages.base.errors import InputError, Status
from linkages.cli.options import add_drive, add_experiment, load_system, output_folder, print_results, record
from linkages.cli.progress import stages
from linkages.input.files.writing import write_json

HELP = "wear of journals and bearings over many revolutions: profiles, clearance, forces"
WRITES = {"wear": ("wear.json", "wear_*.png", "wear.html", "blocks")}

#: Subfolder of the blocks in the folder of results.
BLOCKS = "blocks"
#: Short runs of this command that compile its code, see `linkages.cli.preparation`.
SHORT_RUNS = ("slider_crank_wear.toml --cycles 2",)

EXAMPLES = """examples:
  linkages wear slider_crank_dry.toml --cycles 100000 --set joints.B.wear.coefficient=1e-15
  linkages wear my.toml --cycles 20000 --set joints.B.wear.coefficient=5e-14 --out results/soft

The blocks of simulated cycles are kept in DIR/blocks: an interrupted calculation continues from them, with the same
results. Remove the folder to start again.
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    add_experiment(parser, animation=True)
    parser.add_argument("--cycles", type=float, required=True, metavar="N", help="revolutions of the drive")
    add_drive(parser, "a cycle")
    depth = "largest difference of depth between first and second order in a jump"
    parser.add_argument("--tolerance", type=float, metavar="X", help=f"{depth}; default: smallest clearance / 100 [m]")
    error = "relative standard error of the mean work of a cycle at which a block ends; default: 0.02"
    parser.add_argument("--scatter", type=float, metavar="X", help=error)
    parser.add_argument("--every-cycle", action="store_true", help="simulate every cycle without jumps")


def run(options: argparse.Namespace) -> int:
    """Compute the wear; return the exit status."""
    from linkages.explore.wear.life import wear_life
    from linkages.explore.wear.stages import content

    cycles = int(options.cycles) if options.cycles == options.cycles and abs(options.cycles) < 1e15 else 0
    if cycles != options.cycles or cycles < 1:
        raise InputError("--cycles", f"{options.cycles:g}", "must be a whole number above zero")
    system = load_system(options)
    out = output_folder(options, f"{system.description.stem}_wear", "wear", continued=("blocks",))
    bar = stages(options, float(cycles), "cycles")("wear")
    limits = options.tolerance, options.scatter, options.drive
    life = wear_life(system, cycles, *limits, out.path / BLOCKS, options.every_cycle, progress=bar)
    found = content(life)
    with out as folder:
        write_json(folder / "wear.json", found, None)
        if not options.no_plots:
            from linkages.show.plots.worn import write_wear_figures

            write_wear_figures(found, folder)
        if not options.no_animation:
            from linkages.show.plots.worn import write_wear_animation

            write_wear_animation(found, folder / "wear.html")
        from linkages.show.report.result_page import WEAR_QUESTION, wear_answer

        table = format_life(found)
        record(options, folder, found["title"] or found["experiment"], WEAR_QUESTION, wear_answer(found), table)
    print_results(options, table, out)
    if life.status is Status.OK:
        return 0
    where = f"the calculation ended after {int(life.cycles[-1]):,} of {cycles:,} cycles"
    print(f"{where}: {life.status.value}; {life.status.remedy}", file=sys.stderr)
    return 130 if life.status is Status.INTERRUPTED else 1


def format_life(found: dict[str, Any]) -> str:
    """Format the content of ``wear.json`` as lines of text."""
    lines = [f"{found['title'] or found['experiment']}: wear over {found['cycles']:,} cycles"]
    lines += ["", f"{'joint':12s}{'volume [mm3]':>14s}{'depth [um]':>12s}{'clearance [um]':>16s}{'new [um]':>10s}"]
    for name, joint in found["joints"].items():
        lines.append(
            f"{name:12s}{1e9 * joint['volume']:14.5g}{1e6 * joint['depth']:12.5g}{1e6 * joint['play']:16.5g}"
            f"{1e6 * joint['clearance']:10.5g}"
        )
    first, last = found["blocks"][0]["peaks"], found["blocks"][-1]["peaks"]
    at = f"cycle {found['blocks'][-1]['middle']:,.0f}"
    lines += ["", f"{'mean peak of a cycle':24s}{'new':>14s}{at:>16s}"]
    lines += [
        f"{f'{name} [{unit}]' if (unit := found['units'][name]) else name:24s}{value:14.5g}{last[name]:16.5g}"
        for name, value in first.items()
    ]
    if len(found["blocks"]) > 1:
        lines.append(f"\n{at} is the middle of the last jump: its peaks belong to the profiles there")
    jumps, worst = len(found["blocks"]) - 1, max(block["error"] for block in found["blocks"])
    done = f"cycles simulated: {found['simulated_cycles']}; jumps: {jumps}, rejected: {found['rejected_jumps']}"
    depth = f"{1e6 * worst:.3g} um of {1e6 * found['tolerance']:.3g} um allowed"
    return "\n".join([*lines, "", f"{done}; largest difference of depth in a jump {depth}"])
