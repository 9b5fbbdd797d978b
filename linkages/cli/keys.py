"""``linkages keys``: the keys of an experiment file, and the outputs that can be asked for."""

from __future__ import annotations

import argparse

HELP = "list the keys of an experiment file and the outputs of a run, with units and meanings"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add examples; the command takes no arguments."""
    parser.epilog = "examples:\n  linkages keys\n  linkages keys | grep friction\n"


def run(options: argparse.Namespace) -> int:
    """Print keys and outputs; returns the exit status."""
    from linkages.model.experiment import keys
    from linkages.outputs.registry import table

    for name, meaning in keys():
        print(f"{name:42s} {meaning}")
    print(
        "\nOutputs, in trajectories, sweeps and optimisation; `outputs` of an experiment takes those of POINTs:\n"
    )
    for name, meaning, unit in table():
        print(f"{name:42s} {meaning} [{unit}]")
    return 0
