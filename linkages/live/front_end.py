"""Page, style and script of the live page: one ES module of two files, for the page and for notebooks."""

from __future__ import annotations

from functools import cache
from importlib.resources import files

from linkages.plots.curves import script as curves_script


@cache
def page() -> str:
    """Return the page."""
    return _read("page.html")


@cache
def style() -> str:
    """Return the style of the page."""
    return _read("live.css")


@cache
def script() -> str:
    """Return the ES module; it exports `mount` and, for anywidget, a default."""
    return f"{curves_script()}\n{_read('live.js')}"


def _read(name: str) -> str:
    return (files("linkages.live") / name).read_text(encoding="utf-8")
