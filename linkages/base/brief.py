"""Short texts: an object in one line at a prompt or a small table in a notebook, counted nouns, cells of tables."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape


class Brief:
    """Base class of results and models whose full content is too long to print.

    A subclass returns its main facts from `_facts`; a dataclass that inherits from it is declared with ``repr=False``.
    """

    def _facts(self) -> tuple[str, Mapping[str, str]]:
        """Return one line of text, and the rows of a table: label and content."""
        raise NotImplementedError

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {self._facts()[0]}>"

    __str__ = __repr__

    def _repr_html_(self) -> str:
        line, rows = self._facts()
        cells = "".join(
            f'<tr><th style="text-align: left">{escape(label)}</th>'
            f'<td style="text-align: left">{escape(content)}</td></tr>'
            for label, content in rows.items()
        )
        title = f"<b>{escape(type(self).__name__)}</b>: {escape(line)}"
        return f'<div>{title}<table style="margin: 0.3em 0">{cells}</table></div>'


def counted(count: int, noun: str) -> str:
    """Write a number and its noun: ``1 run``, ``2 runs``."""
    return f"{count:,} {noun}{'' if count == 1 else 's'}"


def cell(value: float | str | None, width: int, form: str = ".5g") -> str:
    """Write a number or a text at the right of a column; ``-`` is an undefined value.

    Examples
    --------
    >>> cell(12.5, 6), cell(None, 6)
    ('  12.5', '     -')
    """
    shown = "-" if value is None else value
    return f"{shown:>{width}s}" if isinstance(shown, str) else f"{shown:{width}{form}}"
