"""A parser whose errors are one line and name the nearest valid word."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any, NoReturn

from linkages.errors import InputError, nearest


class Parser(argparse.ArgumentParser):
    """An `argparse.ArgumentParser` that keeps the lines of examples and raises `InputError`."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**{"formatter_class": argparse.RawDescriptionHelpFormatter} | settings)
        self._given: dict[argparse.Action, set[str]] = {}

    def error(self, message: str) -> NoReturn:
        """Raise an `InputError` for the command line."""
        raise InputError(self.prog, "", f"{message}; see {self.prog} --help")

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
