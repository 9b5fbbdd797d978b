"""Runs the seven-bar press mechanism with lubricated clearance in joints A and B: ``python run_sevenbar.py --help``."""

import sys

from linkages.cli.main import Parser, execute, exit_status
from linkages.cli.simulate import add_run_options, run

if __name__ == "__main__":
    parser = Parser(description=__doc__.split(":")[0])
    add_run_options(parser)
    parser.set_defaults(file="seven_bar.toml", engine="drake")
    sys.exit(exit_status(lambda: execute(run, parser.parse_args()), alone=True))
