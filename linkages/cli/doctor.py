"""``linkages doctor``: check of the installation."""

from __future__ import annotations

import argparse

HELP = "check the installation: versions, caches, data, a self-check"

_EXAMPLES = """examples:
  linkages doctor
  linkages doctor > installation.txt        to send with a question or a bug report
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add examples; the command takes no arguments."""
    parser.epilog = _EXAMPLES


def run(options: argparse.Namespace) -> int:
    """Print the findings; return 1 if a check fails."""
    from linkages.cli.installation import examine
    from linkages.cli.progress import announce_compilation

    announce_compilation()
    wrong = 0
    for finding in examine():
        print(f"{'ok   ' if finding.sound else 'WRONG'} {finding.name:22s} {finding.text}", flush=True)
        if not finding.sound:
            wrong += 1
            print(f"      {'':22s} {finding.remedy}")
    needs = "needs" if wrong == 1 else "need"
    print(f"\n{wrong} of these {needs} a remedy" if wrong else "\nall is well")
    return 1 if wrong else 0
