"""``linkages keys``: keys of an experiment file, and available outputs."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Sequence

from linkages.base.errors import InputError, nearest
from linkages.cli.printing import show, show_pairs

HELP = "list the keys of an experiment file and the outputs of a run, with units and meanings"

EXAMPLES = """examples:
  linkages keys
  linkages keys joints.A.friction
  linkages keys friction
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    meaning = "list only keys and outputs at and below this path, or with this word in their paths"
    parser.add_argument("path", nargs="?", default="", metavar="PATH", help=meaning)


def run(options: argparse.Namespace) -> int:
    """Print keys and outputs; return the exit status."""
    from linkages.input.files.table_keys import described_keys
    from linkages.input.model.experiment import Experiment
    from linkages.results.outputs.registry import table

    keys, outputs = [*described_keys(Experiment)], [(name, f"{meaning} [{unit}]") for name, meaning, unit in table()]
    if options.path:
        found = [row for row in (*keys, *outputs) if _has(options.path.split("."), row[0].split("."))]
        if not found:
            words = {word for name, _ in (*keys, *outputs) for word in (name, *name.split("."))}
            near = nearest(options.path, words, "`linkages keys` lists them all")
            raise InputError("keys", options.path, f"is no key and no output; {near}")
        keys, outputs = found, []
    show_pairs(_spaced(keys))
    if outputs:
        show(
            "\nOutputs of a run; the key `outputs` of an experiment allows outputs of POINTs (links or frames), also"
            " positions of JOINTs:\n"
        )
        show_pairs(_spaced(outputs))
    return 0


def _spaced(rows: Iterable[tuple[str, str]]) -> list[tuple[str, str]]:
    """Let lines break between alternatives."""
    return [(name, meaning.replace("|", " | ")) for name, meaning in rows]


def _has(wanted: Sequence[str], parts: Sequence[str]) -> bool:
    """Check whether a path has these consecutive parts; capitals, such as NAME, match any name."""
    for start in range(len(parts) - len(wanted) + 1):
        same = [word == part for word, part in zip(wanted, parts[start:], strict=False)]
        named = [part.partition(" ")[0].isupper() for part in parts[start:]]
        if any(same) and all(map(max, same, named)):
            return True
    return False
