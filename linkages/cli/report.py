"""``linkages report``: one HTML page from a folder of results."""

from __future__ import annotations

import argparse
from pathlib import Path

from linkages.cli.options import add_units
from linkages.cli.printing import show

HELP = "make one self-contained HTML page from a folder of results"

EXAMPLES = """examples:
  linkages report results/seven_bar
  linkages report results/seven_bar --out press.html
  linkages report results/seven_bar_sweep
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.add_argument("folder", type=Path, metavar="DIR", help="the --out folder of a command")
    add_units(parser)
    parser.add_argument("--out", type=Path, metavar="FILE", help="the page; default: DIR/report.html")


def run(options: argparse.Namespace) -> int:
    """Write the page; return the exit status."""
    from linkages.show.plots.presentation import show_in
    from linkages.show.report.page import write_report
    from linkages.show.report.result_folder import load_results
    from linkages.show.report.result_page import RECORD, is_worn, write_result_report

    path = options.out or options.folder / "report.html"
    if (options.folder / RECORD).is_file() or is_worn(options.folder):
        write_result_report(options.folder, path)
    else:
        results = load_results(options.folder)
        if options.units is None:
            show_in(results.experiment.get("units"), (results.source, "units"))
        write_report(results, path)
    show(f"written: {path}, {path.stat().st_size / 1e6:.1f} MB, needs no network")
    return 0
