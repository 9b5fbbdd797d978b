"""Text on standard output: at most 78 columns, with marks and, on a terminal, colours; the same text in a pipe."""

from __future__ import annotations

import os
import re
import sys
import textwrap
from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby

WIDTH = 78  # columns
#: Beginnings of lines that get a mark and a style, and their marks.
_MARKED = {"warning": "! ", "the motion is not settled": "! ", "Try ": "> ", "The film of joint": "> "}
_STYLES = {"! ": "yellow", "> ": "cyan"}
_GAP = 2  # blanks between the columns of a table that is narrowed
_TIED = "\0"  # blank at which no line breaks
_NAMES = 34  # widest column of names beside their meanings


def show(text: str, bold: bool = False) -> None:
    """Print text: prose is wrapped, tables are narrowed; `bold` is for what answers."""
    for tabular, lines in groupby(text.split("\n"), _tabular):
        for line in narrowed(list(lines)) if tabular else lines:
            mark = next((mark for begin, mark in _MARKED.items() if line.startswith(begin)), "")
            for part in wrapped(mark + line):
                _put(part, "bold" if bold else _STYLES.get(mark, ""))
    sys.stdout.flush()


def show_pairs(rows: Iterable[tuple[str, str]], widest: int | None = None) -> None:
    """Print names with their meanings beside them, wrapped; a long name has a line of its own."""
    pairs = list(rows)
    indent = min(widest or max(len(name) for name, _ in pairs), _NAMES) + _GAP
    for name, meaning in pairs:
        lines = textwrap.wrap(meaning, WIDTH - indent, break_long_words=False, break_on_hyphens=False) or [""]
        if len(name) > indent - _GAP:
            print(name)
            name = ""
        print(f"{name:{indent}s}{lines[0]}".rstrip())
        for line in lines[1:]:
            print(" " * indent + line)
    sys.stdout.flush()


def wrapped(line: str) -> list[str]:
    """Break a line of prose; a command breaks between its options."""
    if len(line) <= WIDTH:
        return [line]
    said, _, command = line.partition(": linkages ")
    if command:
        return [*wrapped(f"{said}:"), *_command(f"linkages {command}")]
    if line.lstrip().startswith("linkages "):
        return _command(line.strip())
    indent = " " * (len(line) - len(line.lstrip(" !>")))
    look = {"subsequent_indent": indent, "break_long_words": False, "break_on_hyphens": False}
    return textwrap.wrap(line, WIDTH, **look)  # type: ignore[arg-type]


def narrowed(lines: Sequence[str]) -> list[str]:
    """Narrow a table that is too wide: less room between its columns, then its columns below one another."""
    if max(map(len, lines)) <= WIDTH:
        return list(lines)
    columns = [_column(lines, *ends) for ends in _columns(lines)]
    kept, found = columns[:1], []
    for column in columns[1:]:
        if len(kept) > 1 and _width([*kept, column]) > WIDTH:
            found += [*_rows(kept), ""]
            kept = columns[:1]
        kept.append(column)
    return found + _rows(kept)


def _columns(lines: Sequence[str]) -> Iterator[tuple[int, int]]:
    """Find the ends of the columns of a table: blanks in all lines separate them."""
    width = max(map(len, lines))
    filled = "".join("x" if any(line[k : k + 1].strip() for line in lines) else " " for k in range(width))
    begin = 0
    for found in re.finditer(rf"(?<=x) {{{_GAP},}}", filled):
        yield begin, found.end()
        begin = found.end()
    yield begin, width


def _column(lines: Sequence[str], begin: int, end: int) -> list[str]:
    """Cut a column out of a table; numbers, which end in the column, lose the blanks before them."""
    cells = [line[begin:end].rstrip() for line in lines]
    spare = min((len(cell) - len(cell.lstrip()) for cell in cells if cell), default=0) if begin else 0
    width = max(map(len, cells))
    return [f"{cell:{width}s}"[spare:] for cell in cells]


def _width(columns: Sequence[Sequence[str]]) -> int:
    return sum(len(column[0]) for column in columns) + _GAP * (len(columns) - 1)


def _rows(columns: Sequence[Sequence[str]]) -> list[str]:
    return [(" " * _GAP).join(cells).rstrip() for cells in zip(*columns, strict=True)]


def _tabular(line: str) -> bool:
    """Check whether a line belongs to a table, which has runs of blanks."""
    return "  " in line.strip()


def _command(words: str) -> list[str]:
    """Break a command between its options so that a shell takes it."""
    whole = re.sub(r"( --?[a-z][\w-]*) (?!-)", rf"\1{_TIED}", " ".join(words.split()))  # an option keeps its value
    lines = textwrap.wrap(whole, WIDTH - 10, break_long_words=False, break_on_hyphens=False)
    return ("    " + " \\\n        ".join(lines)).replace(_TIED, " ").split("\n")


def _put(line: str, style: str) -> None:
    """Print a line, in a style where a terminal shows it; `rich` is slow to import, and a pipe does not need it."""
    if not style or not sys.stdout.isatty() or "NO_COLOR" in os.environ:
        print(line)
        return
    from rich.console import Console

    Console(soft_wrap=True, highlight=False, markup=False, emoji=False).print(line, style=style)
