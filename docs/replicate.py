"""Repeat rows of the replication pages: ``python docs/replicate.py robot.modes``; without a name, list the names."""

from __future__ import annotations

import sys
from importlib import import_module

from replication.verdicts import HEAD, SOURCES, rows

from linkages.base.errors import nearest


def main(names: list[str]) -> int:
    """Compute the named sections and print their rows; returns the exit status."""
    known = [f"{source}.{section}" for source, module in SOURCES.items() for section in import_module(module).SECTIONS]
    if unknown := [name for name in names if name not in known]:
        print(f'docs/replicate.py: "{unknown[0]}" is no section; {nearest(unknown[0], known)}', file=sys.stderr)
        return 2
    if not names:
        print("\n".join(known))
    for name in names:
        source, _, section = name.partition(".")
        for row in rows(source, [section]):
            print("\n".join(f"{head:30s}{cell}" for head, cell in zip(HEAD, row, strict=True)), end="\n\n")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
