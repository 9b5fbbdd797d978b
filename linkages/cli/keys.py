"""``linkages keys``: the keys of an experiment file."""

from __future__ import annotations

import argparse

HELP = "list the keys of an experiment file with their units"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add examples; the command takes no arguments."""
    parser.epilog = "examples:\n  linkages keys\n  linkages keys | grep friction\n"


def run(options: argparse.Namespace) -> int:
    """Print the keys."""
    from linkages.model.experiment import keys

    for name, meaning in keys():
        print(f"{name:42s} {meaning}")
    return 0
