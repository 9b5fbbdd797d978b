"""The entry point: parses the command line, runs a subcommand of `linkages.cli`, turns errors into exit statuses.

Exit status: 0 success, 1 a run failed (its results up to then are written), 2 bad input, 130 interrupted by Ctrl-C, 143
by SIGTERM, 141 the reader of the output has ended.
"""

from __future__ import annotations

import atexit
import errno
import gc
import importlib.metadata
import os
import signal
import sys
from collections.abc import Callable, Mapping, Sequence

from linkages.cli import Command, commands
from linkages.cli.parsing import Parser
from linkages.cli.progress import be_quiet, heartbeat
from linkages.errors import InputError, RunError, nearest, shortened
from linkages.signals import interruptible

_EXAMPLES = """examples:
  linkages new my_linkage                                 a mechanism and an experiment to start with
  linkages draw my_linkage.sdf                            a labelled, movable picture
  linkages simulate my_linkage.toml                       numbers, figures and an animation in results/my_linkage
  linkages report results/my_linkage                      all of them on one page
  linkages simulate seven_bar.toml --set joints.A.clearance=2e-4
  linkages doctor                                         check of the installation

linkages COMMAND --help has more. Exit status: 0 success, 1 failed, 2 bad input, 130 interrupted.
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the ``linkages`` command.

    Parameters
    ----------
    arguments : sequence of str, optional
        Default: the arguments of the process.

    Returns
    -------
    int
        Exit status.
    """
    if arguments is not None:
        return exit_status(_run, list(arguments))
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:  # no message while Python ends
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    return exit_status(_run, sys.argv[1:], alone=True)


def _run(words: list[str]) -> int:
    known = commands(*words[:1])
    command_line = parser(known)
    if not words:
        command_line.print_help(sys.stderr)
        return 2
    first = (*known, "--help", "-h", "--version")
    if words[0] not in first:
        raise InputError("linkages", words[0], f"is unknown; {nearest(words[0], first)}")
    options = command_line.parse_args(words)
    be_quiet(options)
    try:
        return known[options.command].run(options)
    except InputError as problem:
        for name in (problem.where, problem.where.removesuffix("s")):  # the argument inputs is the option --input
            if problem.source == "argument" and name in vars(options):
                raise InputError(f"--{name.replace('_', '-')}", "", problem.problem) from None
        raise


def parser(known: Mapping[str, Command]) -> Parser:
    """Make the parser of the ``linkages`` command with these subcommands."""
    result = Parser(prog="linkages", description="Dynamics of planar linkages with clearance joints.", epilog=_EXAMPLES)
    result.add_argument("--version", action="version", version=f"linkages {_version()}")
    subparsers = result.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for name, command in known.items():
        command.add_options(subparsers.add_parser(name, help=command.HELP, description=command.HELP))
    return result


def _version() -> str:
    try:
        return importlib.metadata.version("linkages")
    except importlib.metadata.PackageNotFoundError:
        return "not installed"


def exit_status(run: Callable[..., int], *arguments: object, alone: bool = False) -> int:
    """Run a command and return its exit status; bad input, failed runs and interruptions become one line of text.

    With `alone` the process has nothing else to do: see `linkages.signals.interruptible`.
    """
    atexit.register(gc.freeze)  # a process that ends need not search its objects for cycles: 0.2 s
    with interruptible(alone) as received:
        try:
            with heartbeat():
                status = run(*arguments)
            sys.stdout.flush()
        except BaseException as problem:  # interrupted code may raise another exception
            received.over = True
            if received or isinstance(problem, KeyboardInterrupt):
                print("interrupted", file=sys.stderr)
                status = 130
            else:
                status = _said(problem)
    if received and status == 0:  # a signal that came too late, or whose exception was dropped
        print("interrupted", file=sys.stderr)
        status = 130
    return 143 if signal.SIGTERM in received and status == 130 else status


def _said(problem: BaseException) -> int:
    """Print one line about an error and return the exit status; re-raise unexpected exceptions."""
    match problem:
        case InputError():
            print(f"error: {problem}", file=sys.stderr)
            return 2
        case RunError():
            print(f"failed: {problem}", file=sys.stderr)
        case BrokenPipeError():  # the reader has ended: `linkages keys | head`
            _drop_output()
            return 141
        case OSError(errno=errno.ENAMETOOLONG):
            print(f"error: {shortened(str(problem.filename))}: {problem.strerror}", file=sys.stderr)
            return 2
        case OSError():  # system error, such as a full disk of the output
            print(f"failed: {problem.filename or 'output'}: {problem.strerror or problem}", file=sys.stderr)
            _drop_output()
        case MemoryError():
            print("failed: there is not enough memory; give a shorter duration, or fewer values", file=sys.stderr)
        case _:
            raise problem
    return 1


def _drop_output() -> None:
    """Discard the buffer of standard output if it cannot be written."""
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


if __name__ == "__main__":
    sys.exit(main())
