"""Page, style and script of the live page: one ES module of two files, for the page and for notebooks."""

from __future__ import annotations

from functools import cache

from linkages.plots.curves import script as curves_script
from linkages.plots.pages import own_text


@cache
def page() -> str:
    """Return the page."""
    return own_text("linkages.live", "page.html")


@cache
def style() -> str:
    """Return the style of the page."""
    return own_text("linkages.live", "live.css")


@cache
def script() -> str:
    """Return the ES module; it exports `mount` and, for anywidget, a default."""
    return f"{curves_script()}\n{own_text('linkages.live', 'live.js')}"
