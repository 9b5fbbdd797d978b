"""Text on standard output: at most 78 columns, with marks and, on a terminal, colours; the same text in a pipe."""

from __future__ import annotations

import os
import sys
import textwrap

WIDTH = 78  # columns
#: Beginnings of lines that get a mark and a style, and their marks.
_MARKED = {"warning": "! ", "the motion is not settled": "! ", "Try ": "> ", "The film of joint": "> "}
_STYLES = {"! ": "yellow", "> ": "cyan"}


def show(text: str, bold: bool = False) -> None:
    """Print text: prose is wrapped, tables keep their lines; `bold` is for what answers."""
    for line in text.split("\n"):
        mark = next((mark for begin, mark in _MARKED.items() if line.startswith(begin)), "")
        for part in wrapped(mark + line):
            _put(part, "bold" if bold else _STYLES.get(mark, ""))
    sys.stdout.flush()


def wrapped(line: str) -> list[str]:
    """Break a line of prose; commands and tables, which have runs of spaces, stay whole."""
    if len(line) <= WIDTH or "  " in line.strip():
        return [line]
    said, _, command = line.partition(": linkages ")
    if command:
        return [*wrapped(f"{said}:"), *_command(f"linkages {command}")]
    indent = " " * (len(line) - len(line.lstrip(" !>")))
    look = {"subsequent_indent": indent, "break_long_words": False, "break_on_hyphens": False}
    return textwrap.wrap(line, WIDTH, **look)  # type: ignore[arg-type]


def _command(words: str) -> list[str]:
    """Break a command between its options so that a shell takes it."""
    lines = textwrap.wrap(words, WIDTH - 6, break_long_words=False, break_on_hyphens=False)
    return [f"    {line} \\" for line in lines[:-1]] + [f"    {lines[-1]}"]


def _put(line: str, style: str) -> None:
    """Print a line, in a style where a terminal shows it; `rich` is slow to import, and a pipe does not need it."""
    if not style or not sys.stdout.isatty() or "NO_COLOR" in os.environ:
        print(line)
        return
    from rich.console import Console

    Console(soft_wrap=True, highlight=False, markup=False, emoji=False).print(line, style=style)
