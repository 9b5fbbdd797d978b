"""Runs the seven-bar press mechanism with lubricated play in joints A and B: ``python run_sevenbar.py --help``."""

import argparse
import sys

from linkages.cli import add_simulate_options, simulate_command

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.split(":")[0])
    add_simulate_options(parser)
    sys.exit(simulate_command("seven_bar.toml", parser.parse_args()))
