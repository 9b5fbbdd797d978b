"""``linkages completion``: a script for the shell's completion of commands and options."""

from __future__ import annotations

import argparse
from pathlib import Path

HELP = "print a script that completes commands, options and files in your shell"

EXAMPLES = """examples:
  linkages completion bash > ~/.local/share/bash-completion/completions/linkages
  linkages completion zsh > "${fpath[1]}/_linkages"
  linkages completion fish > ~/.config/fish/completions/linkages.fish
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.add_argument("shell", choices=("bash", "zsh", "fish", "tcsh"))


def run(options: argparse.Namespace) -> int:
    """Print the script; return the exit status."""
    import shtab

    from linkages.cli import commands
    from linkages.cli.main import parser

    whole = parser(commands())
    _mark_files(whole)
    print(shtab.complete(whole, options.shell))
    return 0


def _mark_files(parser: argparse.ArgumentParser) -> None:
    """Mark file arguments for shtab: paths, and arguments named ``file``."""
    import shtab

    for action in parser._actions:  # argparse has no public list of them; shtab reads this one too
        if isinstance(action.choices, dict):
            for command in action.choices.values():
                _mark_files(command)
        elif action.type is Path or action.dest == "file":
            action.complete = shtab.FILE  # type: ignore[attr-defined]
