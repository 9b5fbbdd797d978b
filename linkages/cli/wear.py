"""``linkages wear``: how journals and bearings wear over a machine's life."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from linkages.cli.folders import output_folder, results_folder
from linkages.cli.options import add_file, add_settings, load_system, written
from linkages.cli.progress import stages
from linkages.errors import InputError, Status
from linkages.files.writing import json_text

if TYPE_CHECKING:
    from linkages.explore.wear.stages import Life

HELP = "wear of journals and bearings over many revolutions: profiles, play, forces"

#: Folder of the blocks, within that of the results.
BLOCKS = "blocks"
_EXAMPLES = """examples:
  linkages wear slider_crank_dry.toml --cycles 100000 --set joints.B.wear.coefficient=1e-15
  linkages wear my.toml --cycles 20000 --set joints.B.wear.coefficient=5e-14 --out results/soft

The blocks of simulated cycles are kept in DIR/blocks: a life that was interrupted goes on from them, and gives the
same numbers. Remove the folder to begin anew.
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.epilog = _EXAMPLES
    add_file(parser)
    parser.add_argument("--cycles", type=float, required=True, metavar="N", help="revolutions of the drive")
    parser.add_argument(
        "--drive",
        metavar="JOINT",
        help="whose revolutions, or periods; default: the first that turns at constant speed, else the first that"
        " repeats its motion",
    )
    parser.add_argument(
        "--tolerance",
        type=float,
        metavar="X",
        help="largest difference of depth between first and second order in a jump [m]; default: a hundredth of"
        " the smallest clearance",
    )
    parser.add_argument(
        "--scatter",
        type=float,
        metavar="X",
        help="relative standard error of the work of all cycles at which a block has cycles enough; default: 0.02",
    )
    parser.add_argument("--every-cycle", action="store_true", help="simulate every cycle and never jump")
    add_settings(parser)
    parser.add_argument("--no-plots", action="store_true", help="write no figures")
    parser.add_argument("--no-animation", action="store_true", help="write no animation")


def run(options: argparse.Namespace) -> int:
    """Wear the machine; returns the exit status."""
    from linkages.explore.wear.content import content
    from linkages.explore.wear.life import wear_life

    cycles = int(options.cycles) if options.cycles == options.cycles and abs(options.cycles) < 1e15 else 0
    if cycles != options.cycles or cycles < 1:
        raise InputError("--cycles", f"{options.cycles:g}", "must be a whole number above zero")
    system = load_system(options)
    out = output_folder(options, f"{system.experiment.source.stem}_wear", "wear")
    for name in ("tolerance", "scatter"):
        value = getattr(options, name)
        if value is not None and not 0.0 < value < float("inf"):
            raise InputError(f"--{name}", f"{value:g}", "must be above zero")
    life = wear_life(
        system,
        cycles,
        options.tolerance,
        options.scatter,
        options.drive,
        out / BLOCKS,
        options.every_cycle,
        progress=stages(options, float(cycles), "cycles")("wear"),
    )
    found = content(life)
    with (results := results_folder(out, "wear")) as folder:
        (folder / "wear.json").write_text(json_text(found), encoding="utf-8")
        if not options.no_plots:
            from linkages.plots.wear_figures import write_figures

            write_figures(found, folder)
        if not options.no_animation:
            from linkages.plots.wear_animation import write_animation

            write_animation(found, folder / "wear.html")
    if not options.quiet:
        print(format_life(found))
        print(f"\n{written(out, results.names)}")
    return _ending(life, cycles)


def format_life(found: dict[str, Any]) -> str:
    """Format the content of ``wear.json`` as lines of text."""
    lines = [f"{found['title'] or found['experiment']}: wear over {found['cycles']:,} cycles"]
    lines += ["", f"{'joint':12s}{'volume [mm3]':>14s}{'depth [um]':>12s}{'play [um]':>12s}{'new [um]':>10s}"]
    for name, joint in found["joints"].items():
        lines.append(
            f"{name:12s}{1e9 * joint['volume']:14.5g}{1e6 * joint['depth']:12.5g}{1e6 * joint['play']:12.5g}"
            f"{1e6 * joint['clearance']:10.5g}"
        )
    first, last = found["blocks"][0]["peaks"], found["blocks"][-1]["peaks"]
    at = f"cycle {found['blocks'][-1]['middle']:,.0f}"
    lines += ["", f"{'mean peak of a cycle':24s}{'new':>14s}{at:>16s}"]
    lines += [
        f"{f'{name} [{unit}]' if (unit := found['units'][name]) else name:24s}{value:14.5g}{last[name]:16.5g}"
        for name, value in first.items()
    ]
    jumps, worst = len(found["blocks"]) - 1, max(block["error"] for block in found["blocks"])
    lines += [
        "",
        f"cycles simulated: {found['simulated_cycles']}; jumps: {jumps}, rejected: {found['rejected_jumps']};"
        f" largest difference of depth in a jump {1e6 * worst:.3g} um of {1e6 * found['tolerance']:.3g} um allowed",
    ]
    return "\n".join(lines)


def _ending(life: Life, cycles: int) -> int:
    """Say how a life ended that did not reach its cycles; returns the exit status."""
    import sys

    if life.status is Status.OK:
        return 0
    where = f"the life ended after {int(life.cycles[-1]):,} of {cycles:,} cycles"
    print(f"{where}: {life.status.value}; {life.status.remedy}", file=sys.stderr)
    return 130 if life.status is Status.INTERRUPTED else 1
