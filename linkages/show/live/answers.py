"""Requests of the front end and their replies, the same for the page and for a notebook.

`linkages.show.live.server` has the list of requests and replies.
"""

from __future__ import annotations

import re
import threading
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from typing import Any

from linkages.base.errors import ARGUMENT, AssemblyError, InputError, RunError
from linkages.base.packages import check_installed
from linkages.base.palette import css, repainted
from linkages.show.live.controls import Control, controls, extended
from linkages.show.live.edits import parts, with_addition, with_model, without_determined
from linkages.show.live.exploring import (
    MOST_RUNS,
    Around,
    checked_paths,
    checked_spreads,
    is_number,
    outputs_of,
    sensitivities,
    sweep,
    tolerances,
    usual_spreads,
)  # fmt: skip
from linkages.show.live.keeping import code, export, notebook, save, target_of, write
from linkages.show.live.pinned import checked_runs, pinned_page
from linkages.show.live.session import Session, checked
from linkages.show.live.units import SYSTEMS
from linkages.show.live.watch import OutdatedError, TimeLimitError
from linkages.show.plots.pages import own_text, script, shared_style
from linkages.system import System

_PAGES = 20  # pages whose last run is kept


class Look:
    """Shows the progress of many runs to a page, and ends them where their request is outdated."""

    def __init__(self, answers: Answers, outdated: Callable[[], bool]) -> None:
        self.outdated, self._answers = outdated, answers

    def progress(self, what: str) -> Callable[[float], None]:
        """Return the progress function of some runs; OutdatedError where they are to end."""

        def show(part: float) -> None:
            self._answers.said = f"{what}: {100.0 * part:.0f} %" if part < 1.0 else ""
            if self.outdated():
                self._answers.said = ""
                raise OutdatedError

        return show


class Answers:
    """Answers the requests of the front end, which can be shown several times: in tabs, or below cells of a notebook.

    Each page has its own copy of the session. Files are saved in the folder, with the values `given` on the command
    line.
    """

    def __init__(
        self, session: Session, controls: Mapping[str, Control], folder: Path, given: Mapping[str, Any] | None = None
    ) -> None:
        self.session, self.controls, self.folder, self.given = session, controls, folder, given or {}
        self.said = ""  # stage of a computation of many runs
        self._pages: dict[str, Session] = {}
        self._choosing = threading.Lock()

    def answer(self, kind: str, request: Any, outdated: Callable[[], bool] = lambda: False) -> dict[str, Any]:
        """Answer a request from outside: everything in it is checked. `outdated` tells whether a newer one waits."""
        look = Look(self, outdated)
        known: dict[str, Callable[[Session, dict[str, Any]], dict[str, Any]]] = {
            "start": self._start,
            "edit": self._edit,
            "move": self._move,
            "run": partial(self._run, outdated),
            "picture": lambda session, request: session.picture(self._values(request)),
            "numbers": lambda session, _: session.numbers(),
            "warnings": lambda session, _: {"warnings": session.warnings()},
            "sweep": partial(self._sweep, look),
            "sensitivities": partial(self._sensitivities, look),
            "tolerances": partial(self._tolerances, look),
            "notebook": self._notebook,
            "report": self._report,
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
        except InputError as problem:
            return refusal(problem)
        except (AssemblyError, RunError) as problem:
            return {"error": str(problem)}
        except OSError as problem:
            return {"error": f"{problem.filename or self.folder}: {problem.strerror or problem}"}

    def _session_of(self, request: dict[str, Any]) -> Session:
        """Return the session of a request's page; the page that was used longest ago is forgotten."""
        with self._choosing:
            page = page_of(request)
            session = self._pages.pop(page, None) or self.session.for_page()
            self._pages[page] = session
            if len(self._pages) > _PAGES:
                self._pages.pop(next(iter(self._pages)))
            return session

    def _start(self, session: Session, request: dict[str, Any]) -> dict[str, Any]:
        described, known = session.system.description, self.controls
        if "values" in request:
            with suppress(InputError):  # the first run reports it
                known = self._known(request)
        return {
            "title": described.heading,
            "file": described.source.name,
            "name": f"{described.stem}_play",
            "folder": str(self.folder.resolve()),
            "controls": [control.content() for control in known.values()],
            "units": SYSTEMS,
            "parts": parts(session.system),
            "colors": dict(session.system.colors),
        }

    def _edit(self, session: Session, request: dict[str, Any]) -> dict[str, Any]:
        """Give a joint or a link another model, or a joint a groove or wear, with the values that it needs."""
        values, name = self._values(request), _text(request, "name")
        system = session.system.replaced(values)
        if "add" in request:
            values |= with_addition(system, name, _text(request, "add"))
        else:
            values |= with_model(system, _text(request, "part"), name, _text(request, "model"))
        values = without_determined(values, name)
        found, tables = self._known({"values": values}), ("joints", "links", "sdf.joints", "sdf.links")
        own = tuple(f"{table}.{name}." for table in tables)
        new = [one for path, one in found.items() if path.startswith(own)]
        sizes = {path for path in values if path.startswith("sdf.links.")}  # of a beam that the link gets
        shown = [replace(one, first=True) if one.value is None and one.path in sizes else one for one in new]
        return {"values": values, "controls": [one.content() for one in shown]}

    def _move(self, session: Session, request: dict[str, Any]) -> dict[str, Any]:
        to, phase = request.get("to"), request.get("phase")
        numbers: list[Any] = [phase, *to] if isinstance(to, list) else []
        finite = [float(one) for one in numbers if is_number(one)]
        if not len(numbers) == len(finite) == 3 or not 0.0 <= finite[0] <= 1.0:
            raise InputError("page", "to", "must be a place [x, y] in metres, with a phase from 0 to 1")
        return {"values": session.moved(self._values(request), _text(request, "joint"), finite[1:], finite[0])}

    def _run(self, outdated: Callable[[], bool], session: Session, request: dict[str, Any]) -> dict[str, Any]:
        values = self._values(request)
        if request.get("restart") is True:
            session.restart()
        return session.compute(values, outdated, request.get("refine") is True)

    def _sweep(self, look: Look, session: Session, request: dict[str, Any]) -> dict[str, Any]:
        known, path = self._known(request), _text(request, "path")
        control = known[checked_paths([path], known)[0]]
        return dict(sweep(self._around(look, session, request), control, request, look.progress("sweep")))

    def _sensitivities(self, look: Look, session: Session, request: dict[str, Any]) -> dict[str, Any]:
        paths = checked_paths(request.get("paths"), self._known(request))
        return sensitivities(self._around(look, session, request), paths, look.progress("sensitivities"))

    def _tolerances(self, look: Look, session: Session, request: dict[str, Any]) -> dict[str, Any]:
        known, runs = self._known(request), request.get("runs", 500)
        if not isinstance(runs, int) or not 2 <= runs <= MOST_RUNS:
            raise InputError("page", "runs", f"must be a number from 2 to {MOST_RUNS}")
        given = request.get("spreads") or usual_spreads(known, self._values(request))
        around = self._around(look, session, request)
        return tolerances(around, checked_spreads(given, known), runs, look.progress("tolerances"))

    def _around(self, look: Look, session: Session, request: dict[str, Any]) -> Around:
        return Around.of(session, self._values(request), look.outdated)

    def _save(self, session: Session, request: dict[str, Any]) -> dict[str, Any]:
        """Save a file with the values of the run that the page shows: it gives the same numbers."""
        target = target_of(self.folder, request.get("name"))
        values = {**self.given, **session.values_shown(self._values(request))}
        save(session.system.experiment, values, target, request.get("replace") is True)
        return {"written": str(target), "command": f"linkages simulate {target}"}

    def _export(self, session: Session, request: dict[str, Any]) -> dict[str, Any]:
        """Save the file, and let ``linkages simulate`` write its folder: the files are the same by construction."""
        out = export(Path(self._save(session, request)["written"]))
        return {"written": str(out), "command": f"linkages report {out}"}

    def _notebook(self, session: Session, request: dict[str, Any]) -> dict[str, Any]:
        """Write code that repeats the run that the page shows."""
        values = self._values(request)
        part, system = session.part_shown(values, lambda: False), session.system
        ran = {**self.given, **session.values_shown(values)}
        text = code(system.description.source, ran, part, outputs_of(system.replaced(values)))
        if "name" not in request:
            return {"code": text}
        target = target_of(self.folder, request["name"], ".ipynb")
        write(target, lambda: notebook(text), request.get("replace") is True)
        return {"code": text, "written": str(target), "command": f"jupyter lab {target}"}

    def _report(self, session: Session, request: dict[str, Any]) -> dict[str, Any]:
        """Return the page of runs that are pinned, with their peaks as the page has them."""
        runs, values = checked_runs(request.get("runs"), self._values), self._values(request)
        system, known = session.system.replaced(values), self._known(request)
        return {"page": pinned_page(system, runs, known, _text(request, "notes"), _text(request, "units"))}

    def _known(self, request: dict[str, Any]) -> Mapping[str, Control]:
        return extended(self.controls, self.session.system.replaced(self._values(request)))

    def _values(self, request: dict[str, Any]) -> dict[str, float | str]:
        return checked(request.get("values", {}), self.controls, self.session.system)


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
    check_installed("anywidget", "play")
    import anywidget

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


#: The modules of the front end, each after its imports; names at their top level are unique.
MODULES = (
    "curves.js", "dom.js", "panel.js", "layout.js", "machine.js", "controls.js", "numbers.js", "charts.js", "runs.js",
    "joints.js", "explore.js", "live.js",
)  # fmt: skip


#: Names of the scripts that all pages share.
_SHARED = ("drawCurves", "legend", "number", "placeShapes", "shapesOf", "svgElement", "valueAt")


@cache
def front_end(name: str) -> str:
    """Return the page, its style with its colours, or a module of its script; "widget.js" is one module of all.

    Modules import names of others, unchanged, by lines of the form ``import {NAME, NAME} from "./MODULE.js";``.
    """
    if name == "widget.js":
        lines = "\n".join(map(front_end, MODULES)).split("\n")
        kept = [line for line in lines if not line.startswith(("import {", "export {"))]
        return "\n".join(re.sub("^export (?!default)", "", line) for line in kept)
    if name == "curves.js":
        return f"{script()}\nexport {{{', '.join(_SHARED)}}};\n"
    if name == "live.css":
        page = ".linkages-live"
        own = own_text("linkages.show.live", name)
        return css(page, chosen=True) + repainted(f"{page} .picture ") + "\n" + shared_style(page) + own
    return own_text("linkages.show.live", name)


def refusal(problem: InputError) -> dict[str, Any]:
    """Return an error as the page shows it: `error`, and of a value its `path` and its `problem` beside its label."""
    if problem.source != ARGUMENT:
        return {"error": str(problem)}
    said = str(problem).removeprefix(f"{ARGUMENT}: ")
    return {"error": said, "path": problem.where, "problem": said.removeprefix(f"{problem.where}: ")}


def _text(request: Mapping[str, Any], key: str) -> str:
    """Return a text of a request; InputError if it is none."""
    if not isinstance(request.get(key), str):
        raise InputError("page", key, "must be a text")
    return str(request[key])


def page_of(request: Any) -> str:
    """Return the name of a request's page; empty without one."""
    return str(request.get("page", ""))[:40] if isinstance(request, dict) else ""
