"""``linkages report``: one HTML page from a folder of results."""

from __future__ import annotations

import argparse
from pathlib import Path

HELP = "make one self-contained HTML page from a folder of results"

EXAMPLES = """examples:
  linkages report results/seven_bar
  linkages report results/seven_bar --out press.html
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.add_argument("folder", type=Path, metavar="DIR", help="that `linkages simulate` or `linkages wear` wrote")
    parser.add_argument("--out", type=Path, metavar="FILE", help="the page; default: DIR/report.html")


def run(options: argparse.Namespace) -> int:
    """Write the page; return the exit status."""
    from linkages.show.report.page import CONTENT, write_report, write_wear_report
    from linkages.show.report.result_folder import load_results

    path = options.out or options.folder / "report.html"
    if (options.folder / CONTENT).is_file():
        write_wear_report(options.folder, path)
    else:
        write_report(load_results(options.folder), path)
    print(f"written: {path}, {path.stat().st_size / 1e6:.1f} MB, needs no network")
    return 0
