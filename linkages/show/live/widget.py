"""The live page in a notebook: the same front end as a widget (anywidget, an optional dependency)."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from linkages.base.errors import InputError
from linkages.show.live.answers import Answers, front_end
from linkages.show.live.controls import controls
from linkages.show.live.session import Session
from linkages.system import System


def play(system: System, vary: Mapping[str, tuple[float, float]] | None = None, folder: str | Path = ".") -> Any:
    """Show a machine whose values can be changed in a notebook; ``linkages play`` shows the same page in a browser.

    Parameters
    ----------
    system : System
    vary : mapping of str to (float, float), optional
        Values to show at the start, by dotted path, with their ranges in SI units; default: speeds of drives, and for
        each joint with clearance its model, clearance, viscosity and coefficients.
    folder : str or Path
        Where files are saved.

    Returns
    -------
    anywidget.AnyWidget
        Shown where it is the last value of a notebook's cell.

    Raises
    ------
    InputError
        If a path of `vary` is not the path of a number, the page does not support a model, or anywidget is missing.

    Examples
    --------
    >>> import linkages
    >>> system = linkages.load(linkages.find_file("seven_bar.toml"))
    >>> page = linkages.play(system, {"joints.A.clearance": (5e-5, 5e-4)})  # doctest: +SKIP
    """
    try:
        import anywidget
    except ImportError:
        problem = 'needs the package anywidget: pip install "linkages[play]"; in a browser: linkages play FILE.toml'
        raise InputError("play", "", problem) from None

    answers = Answers(Session(system), controls(system, vary), Path(folder))

    class Page(anywidget.AnyWidget):
        """The front end, and the answers to its requests."""

        _esm = front_end("live.js")
        _css = front_end("live.css")

    def reply(widget: Any, message: Any, _: Any) -> None:
        if isinstance(message, dict) and {"n", "kind", "request"} <= set(message):
            widget.send({"n": message["n"], "reply": answers.answer(message["kind"], message["request"])})

    page = Page()
    page.on_msg(reply)
    return page
