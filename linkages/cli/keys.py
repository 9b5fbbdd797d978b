"""``linkages keys``: the keys of an experiment file, and the outputs that can be asked for."""

from __future__ import annotations

import argparse

HELP = "list the keys of an experiment file and the outputs of a run, with units and meanings"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add examples; the command takes no arguments."""
    parser.epilog = "examples:\n  linkages keys\n  linkages keys | grep friction\n"


def run(options: argparse.Namespace) -> int:
    """Print keys and outputs; returns the exit status."""
    from linkages.model.experiment import described
    from linkages.outputs.registry import table

    outputs = [(name, f"{meaning} [{unit}]") for name, meaning, unit in table()]
    width = max(len(name) for name, _ in (*described(), *outputs))
    for name, meaning in described():
        print(f"{name:{width}s}  {meaning}")
    print("\nOutputs of a run; `outputs` of an experiment takes those of POINTs, links and frames:\n")
    for name, meaning in outputs:
        print(f"{name:{width}s}  {meaning}")
    return 0
