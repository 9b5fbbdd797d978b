"""The entry point: parses the command line, runs a subcommand of `linkages.cli`, turns errors into exit statuses.

Exit status: 0 success, 1 a run failed (its results up to then are written), 2 bad input, 130 interrupted by Ctrl-C, 143
by SIGTERM, 141 the reader of the output has ended.
"""

from __future__ import annotations

import argparse
import atexit
import errno
import gc
import importlib.metadata
import os
import re
import signal
import sys
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NoReturn

from linkages.base.errors import InputError, RunError, Status, nearest, shortened
from linkages.base.signals import interruptible
from linkages.cli import commands
from linkages.cli.options import as_presented
from linkages.cli.printing import wrapped
from linkages.cli.progress import be_quiet, heartbeat
from linkages.input.files.unit_conversion import decimal_comma

if TYPE_CHECKING:
    from linkages.results.trajectory import Trajectory

_EXAMPLES = """examples:
  linkages new my                 a mechanism and an experiment to start with
  linkages draw my.sdf            a labelled, movable picture
  linkages simulate my.toml       numbers, figures, animation in results/my
  linkages report results/my      all of them on one page
  linkages simulate seven_bar.toml --set joints.A.clearance=2e-4
  linkages doctor                 check of the installation

`linkages COMMAND --help` has more. Exit status: 0 success, 1 failed, 2 bad input, 130 interrupted.
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the ``linkages`` command with some arguments (default: the process's); return the exit status."""
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
    options.words = words
    be_quiet(options)
    return execute(known[options.command].run, options)


def execute(run: Callable[[argparse.Namespace], int], options: argparse.Namespace) -> int:
    """Run a command and show its results as its options say; return the exit status."""
    try:
        with as_presented(options):
            return run(options)
    except InputError as problem:
        for name in (problem.where, problem.where.removesuffix("s")):  # the argument inputs is the option --input
            if problem.source == "argument" and name in vars(options):
                raise InputError(f"--{name.replace('_', '-')}", "", problem.problem) from None
        raise


class _Help(argparse.RawDescriptionHelpFormatter):
    """Help that keeps the lines of examples, but those that are too wide."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        text = re.sub(r"(?<=\S)\n(?=\w)", " ", text)  # lines of one paragraph
        return "\n".join(part for line in text.splitlines() for part in wrapped(line)) + "\n"


class Parser(argparse.ArgumentParser):
    """An `argparse.ArgumentParser` that keeps the lines of examples and raises `InputError`."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**{"formatter_class": _Help} | settings)
        self._given: dict[argparse.Action, set[str]] = {}

    def error(self, message: str) -> NoReturn:
        """Raise an `InputError` for the command line."""
        wrong = re.search(r"value: '(.*)'$", message)
        comma = decimal_comma(wrong[1]) if wrong else ""
        raise InputError(self.prog, "", f"{message}{comma or f'; see {self.prog} --help'}")

    def parse_known_args(  # type: ignore[override]  # argparse tells namespaces of several types apart
        self, args: Sequence[str] | None = None, namespace: Any = None
    ) -> Any:
        """Parse; reject unknown words here, where the valid options are known."""
        self._given.clear()
        options, extra = super().parse_known_args(args, namespace)
        for word in extra:
            if word.startswith("-"):
                name = word.partition("=")[0]
                # argparse has no public list of its options
                known = [option for option in self._option_string_actions if option.startswith("--")]
                raise InputError(self.prog, name, f"is unknown; {nearest(name, known)}")
        if extra:
            raise InputError(self.prog, extra[0], f"is one argument too many; see {self.prog} --help")
        return options, extra

    def _get_values(self, action: argparse.Action, arg_strings: list[str]) -> Any:
        """Read the values of an option; refuse an option that is given twice (argparse calls this).

        An option that may be repeated is given twice if its value is, or the part of its value before "=".
        """
        if action.option_strings:
            several = isinstance(action, argparse._AppendAction)  # argparse has no public name for it
            assigns = several and "=" in str(action.metavar)
            name = (arg_strings[0].partition("=")[0] if assigns else arg_strings[0]).strip() if several else ""
            given = self._given.setdefault(action, set())
            if name in given:
                raise InputError(self.prog, " ".join([action.option_strings[0], name]).strip(), "is given twice")
            given.add(name)
        return super()._get_values(action, arg_strings)


def parser(known: Mapping[str, Any]) -> Parser:
    """Make the parser of the ``linkages`` command with these subcommands."""
    result = Parser(prog="linkages", description="Dynamics of planar linkages with clearance joints.", epilog=_EXAMPLES)
    result.add_argument("--version", action="version", version=f"linkages {_version()}")
    subparsers = result.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for name, command in known.items():
        epilog = getattr(command, "EXAMPLES", None)
        command.add_options(subparsers.add_parser(name, help=command.HELP, description=command.HELP, epilog=epilog))
    return result


def _version() -> str:
    try:
        return importlib.metadata.version("linkages")
    except importlib.metadata.PackageNotFoundError:
        return "not installed"


def exit_status(run: Callable[..., int], *arguments: object, alone: bool = False) -> int:
    """Run a command and return its exit status; bad input, failed runs and interruptions become one line of text.

    With `alone` the process has nothing else to do: see `linkages.base.signals.interruptible`.
    """
    atexit.register(gc.freeze)  # a process that ends need not search its objects for cycles: 0.2 s
    with interruptible(alone) as received:
        try:
            with heartbeat():
                status = run(*arguments)
            sys.stdout.flush()
            received.over = True
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
        case ImportError(name="numba"):  # its version is not supported
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


def report_failures(runs: Mapping[str, Trajectory]) -> int:
    """Print a line on standard error for each run, by its name in messages, that did not reach its end.

    Returns the exit status: 0 if all succeeded, 130 if one was interrupted, otherwise 1.
    """
    failed = {name: run for name, run in runs.items() if run.status is not Status.OK}
    for name, run in failed.items():
        text = f"{run.status.value}; {run.status.remedy}"
        print(f"{name} ended at t = {run.time[-1]:.6g} s{_drives(run)}: {text}", file=sys.stderr)
    if any(run.status is Status.INTERRUPTED for run in failed.values()):
        return 130
    return int(bool(failed))


def _drives(run: Trajectory) -> str:
    """Describe the positions of the drives for a run whose loops can no longer be closed."""
    if run.status not in (Status.NO_ASSEMBLY, Status.LOCKED):
        return ""
    drives = [name.removesuffix(".rate") for name in run.columns if name.endswith(".rate")]
    places = [f"{name} = {run[f'q.{name}'][-1]:.4g} {run.units.get(f'q.{name}', '')}".rstrip() for name in drives]
    return "".join(f", {place}" for place in places)


if __name__ == "__main__":
    sys.exit(main())
