"""``linkages play``: the live page of an experiment."""

from __future__ import annotations

import argparse
import webbrowser
from pathlib import Path

from linkages.base.errors import InputError
from linkages.cli.options import add_file, add_set, load_system, path_and_range, possible_folder, set_values
from linkages.cli.progress import silence

HELP = "change values on a live page, and see motion, orbits and forces at once"

EXAMPLES = """examples:
  linkages play seven_bar.toml
  linkages play seven_bar.toml --vary joints.A.clearance=0.05mm:0.5mm --vary drives.O1.speed=3:9
  linkages play my.toml --port 8123 --no-browser

From another computer: ssh -L 8123:127.0.0.1:8123 HOST
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    add_file(parser)
    add_set(parser, lasting=True)
    slider = "show a slider with this range at the start, instead of the usual ones; may be repeated"
    parser.add_argument("--vary", action="append", default=[], metavar="PATH=LO:HI", help=slider)
    parser.add_argument("--port", type=int, default=0, metavar="N", help="default: a free one")
    parser.add_argument("--no-browser", action="store_true", help="open no browser")
    parser.add_argument(
        "--limit", type=float, default=20.0, metavar="SECONDS", help="longest time of a run; default: 20"
    )
    parser.add_argument("--allow-host", action="append", default=[], metavar="NAME", help="host name of a proxy")
    parser.add_argument("--out", type=Path, default=Path(), metavar="DIR", help="folder for saved files; default: here")


def run(options: argparse.Namespace) -> int:
    """Serve the page until Ctrl-C; returns the exit status."""
    from linkages.base.kernel.precompiled import tell
    from linkages.show.live.answers import Answers
    from linkages.show.live.controls import controls
    from linkages.show.live.server import LiveServer
    from linkages.show.live.session import Session

    if not 0 <= options.port <= 65535:
        raise InputError("--port", str(options.port), "must be from 0 to 65535")
    if not options.limit > 0.0:
        raise InputError("--limit", f"{options.limit:g}", "must be positive")
    folder = possible_folder(options.out)
    system = load_system(options)
    ranges = {path: (low, high) for path, low, high in (path_and_range(text, system) for text in options.vary)}
    answers = Answers(Session(system, options.limit), controls(system, ranges), folder, set_values(options))
    try:
        server = LiveServer(answers, options.port, tuple(options.allow_host))
    except OSError as problem:
        raise InputError("--port", str(options.port), f"cannot be used: {problem.strerror}") from None

    def say(ready: int, known: int) -> None:
        server.said = f"compiling, once after an installation: {ready} of at most {known} kernels"

    tell(say)
    print(f"live page of {system.description.source.name}: {server.address}\nCtrl-C ends it", flush=True)
    silence.quiet = True
    if not options.no_browser:
        webbrowser.open(server.address)
    with server:
        server.serve_forever(poll_interval=0.1)  # Ctrl-C ends it
    return 0
