"""Requests of the front end and their replies, the same for the page and for a notebook.

`linkages.show.live.server` has the list of requests and replies.
"""

from __future__ import annotations

import math
import re
import subprocess
import sys
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import asdict
from functools import cache, partial
from pathlib import Path
from typing import Any

from linkages.base.errors import AssemblyError, InputError, RunError
from linkages.input.files.versions import versions
from linkages.input.files.writing import errors_of_writing, whole
from linkages.input.model.editing import edited
from linkages.input.model.experiment import Experiment
from linkages.show.live.controls import Control, controls, extended
from linkages.show.live.edits import parts, with_model
from linkages.show.live.session import Session, checked
from linkages.show.live.watch import OutdatedError, TimeLimitError
from linkages.show.plots.pages import own_text, script
from linkages.system import System

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,99}")
_EXPORT = 600.0  # longest time of an export [s]
_PAGES = 20  # pages whose last run is kept


class Answers:
    """Answers the requests of the front end, which can be shown several times: in tabs, or below cells of a notebook.

    Each page has its own copy of the session. Files are saved in the folder, with the values `given` on the command
    line.
    """

    def __init__(
        self, session: Session, controls: Mapping[str, Control], folder: Path, given: Mapping[str, Any] | None = None
    ) -> None:
        self.session, self.controls, self.folder, self.given = session, controls, folder, given or {}
        self._pages: dict[str, Session] = {}

    def answer(self, kind: str, request: Any, outdated: Callable[[], bool] = lambda: False) -> dict[str, Any]:
        """Answer a request from outside: everything in it is checked. `outdated` tells whether a newer one waits."""
        known: dict[str, Callable[[Session, dict[str, Any]], dict[str, Any]]] = {
            "start": self._start,
            "edit": self._edit,
            "move": self._move,
            "run": partial(self._run, outdated),
            "picture": lambda session, request: session.picture(self._values(request)),
            "numbers": lambda session, _: session.numbers(),
            "warnings": lambda session, _: {"warnings": session.warnings()},
            "save": self._save,
            "export": self._export,
        }
        try:
            if kind not in known or not isinstance(request, dict):
                raise InputError("page", str(kind)[:40], f"is no request; one of {', '.join(known)}")
            return known[kind](self._session_of(request), request)
        except OutdatedError:
            return {"outdated": True}
        except TimeLimitError:
            return {"error": f"the run takes longer than {self.session.limit:g} s and was given up"}
        except (InputError, AssemblyError, RunError) as problem:
            return {"error": str(problem)}
        except OSError as problem:
            return {"error": f"{problem.filename or self.folder}: {problem.strerror or problem}"}

    def _session_of(self, request: dict[str, Any]) -> Session:
        """Return the session of a request's page; the page that was used longest ago is forgotten."""
        page = page_of(request)
        session = self._pages.pop(page, None) or self.session.for_page()
        self._pages[page] = session
        if len(self._pages) > _PAGES:
            self._pages.pop(next(iter(self._pages)))
        return session

    def _start(self, session: Session, request: dict[str, Any]) -> dict[str, Any]:
        experiment, known = session.system.experiment, self.controls
        if "values" in request:
            with suppress(InputError):  # the first run reports it
                known = extended(known, session.system.replaced(self._values(request)))
        return {
            "title": experiment.title or experiment.source.stem,
            "file": experiment.source.name,
            "name": f"{experiment.source.stem}_play",
            "folder": str(self.folder.resolve()),
            "versions": versions(),
            "controls": [asdict(control) for control in known.values()],
            "parts": parts(session.system, known),
        }

    def _edit(self, session: Session, request: dict[str, Any]) -> dict[str, Any]:
        """Give a joint or a link another model, with the values that it needs."""
        values, name = self._values(request), _text(request, "name")
        system = session.system.replaced(values)
        values |= with_model(system, _text(request, "part"), name, _text(request, "model"))
        found, tables = extended(self.controls, session.system.replaced(values)), ("joints", "links", "sdf.joints")
        own = tuple(f"{table}.{name}." for table in tables)
        return {"values": values, "controls": [asdict(one) for path, one in found.items() if path.startswith(own)]}

    def _move(self, session: Session, request: dict[str, Any]) -> dict[str, Any]:
        to, phase = request.get("to"), request.get("phase")
        numbers: list[Any] = [phase, *to] if isinstance(to, list) else []
        finite = [float(one) for one in numbers if isinstance(one, int | float) and math.isfinite(one)]
        if not len(numbers) == len(finite) == 3 or not 0.0 <= finite[0] <= 1.0:
            raise InputError("page", "to", "must be a place [x, y] in metres, with a phase from 0 to 1")
        return {"values": session.moved(self._values(request), _text(request, "joint"), finite[1:], finite[0])}

    def _run(self, outdated: Callable[[], bool], session: Session, request: dict[str, Any]) -> dict[str, Any]:
        values = self._values(request)
        if request.get("restart") is True:
            session.restart()
        return session.compute(values, outdated, request.get("refine") is True)

    def _save(self, session: Session, request: dict[str, Any]) -> dict[str, Any]:
        """Save a file with the values of the run that the page shows: it gives the same numbers."""
        name = request.get("name")
        if not isinstance(name, str) or not _NAME.fullmatch(name.removesuffix(".toml")):
            problem = "is no name of a file here; use letters, digits, '_', '-' and '.', without a folder"
            raise InputError("page", repr(name)[:60], problem)
        target = self.folder / f"{name.removesuffix('.toml')}.toml"
        values = {**self.given, **session.values_shown(self._values(request))}
        save(session.system.experiment, values, target, request.get("replace") is True)
        return {"written": str(target), "command": f"linkages simulate {target}"}

    def _export(self, session: Session, request: dict[str, Any]) -> dict[str, Any]:
        """Save the file, and let ``linkages simulate`` write its folder: the files are the same by construction."""
        target = Path(self._save(session, request)["written"])
        out = target.with_suffix("")
        command = [sys.executable, "-m", "linkages.cli.main", "simulate", str(target), "--out", str(out), "--quiet"]
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=_EXPORT, check=False)
        except subprocess.TimeoutExpired:
            problem = f"takes longer than {_EXPORT:g} s; run: {' '.join(command[3:])}"
            raise InputError("export", target.name, problem) from None
        if done.returncode not in (0, 1):
            raise InputError("export", target.name, done.stderr.strip().rpartition("\n")[2] or "failed")
        return {"written": str(out), "command": f"linkages report {out}"}

    def _values(self, request: dict[str, Any]) -> dict[str, float | str]:
        return checked(request.get("values", {}), self.controls, self.session.system.mechanism)


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
        Shown where it is the last value of a notebook's cell. InputError if a path of `vary` is not the path of a
        number, the page does not support a model, or anywidget is missing.

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

        _esm = front_end("widget.js")
        _css = front_end("live.css")

    def reply(widget: Any, message: Any, _: Any) -> None:
        if isinstance(message, dict) and {"n", "kind", "request"} <= set(message):
            widget.send({"n": message["n"], "reply": answers.answer(message["kind"], message["request"])})

    page = Page()
    page.on_msg(reply)
    return page


#: The modules of the front end, each after those that it imports; names at their top level are unique.
MODULES = (
    "curves.js", "dom.js", "words.js", "layout.js", "machine.js", "controls.js", "numbers.js", "charts.js", "runs.js",
    "joints.js", "explore.js", "live.js",
)  # fmt: skip


@cache
def front_end(name: str) -> str:
    """Return the page, its style or a module of its script; "widget.js" is one module of all, for anywidget.

    Modules import names of others, unchanged, by lines of the form ``import {NAME, NAME} from "./MODULE.js";``.
    """
    if name == "widget.js":
        lines = "\n".join(map(front_end, MODULES)).split("\n")
        kept = [line for line in lines if not line.startswith(("import {", "export {"))]
        return "\n".join(re.sub("^export (?!default)", "", line) for line in kept)
    if name == "curves.js":
        return f"{script()}\nexport {{drawCurves, valueAt}};\n"
    return own_text("linkages.show.live", name)


def _text(request: Mapping[str, Any], key: str) -> str:
    """Return a text of a request; InputError if it is none."""
    if not isinstance(request.get(key), str):
        raise InputError("page", key, "must be a text")
    return str(request[key])


def page_of(request: Any) -> str:
    """Return the name of a request's page; empty without one."""
    return str(request.get("page", ""))[:40] if isinstance(request, dict) else ""


def save(experiment: Experiment, values: Mapping[str, Any], target: Path, replace: bool = False) -> None:
    """Write an experiment's file with other values, whole or not at all; see `edited`.

    InputError if the file exists and is not to be replaced, or cannot be written.
    """
    if target.exists() and not replace:
        raise InputError("page", target.name, f"exists in {target.parent.resolve()}; choose another name")
    text = edited(experiment, values, target, "live page")
    with errors_of_writing(target.parent):
        target.parent.mkdir(parents=True, exist_ok=True)
    with whole(target) as file:
        file.write_text(text, encoding="utf-8")
