"""Requests of the front end and their replies, the same for the page and for a notebook.

| kind     | request                       | reply                                                                 |
|----------|-------------------------------|-----------------------------------------------------------------------|
| start    |                               | title, versions, controls, names of the file and of the folder        |
| run      | values, restart               | see `linkages.live.session.Session.compute`                           |
| picture  | values                        | see `linkages.live.session.Session.picture`                           |
| numbers  |                               | the table of that run, see `linkages.live.view.numbers_for`           |
| warnings |                               | warnings about that run                                               |
| save     | values, name, replace         | the file that was written, and the command that runs it               |
| export   | values, name, replace         | the folder that was written, by ``linkages simulate``                 |

A request that cannot be answered gets ``{"error": TEXT}``, and a request for a run that a newer one has overtaken
``{"outdated": true}``.
"""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from linkages.errors import AssemblyError, InputError, RunError
from linkages.files.versions import versions
from linkages.live.controls import Control
from linkages.live.edit import save
from linkages.live.session import OutdatedError, Session, TimeLimitError, checked

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,99}")
_EXPORT = 600.0  # longest time of an export [s]


class Answers:
    """Answers the requests of one front end.

    Parameters
    ----------
    session : Session
    controls : mapping of str to Control
        The values that may be changed.
    folder : Path
        Where files are saved.
    given : mapping
        Values that were replaced on the command line; they are saved with the others.
    """

    def __init__(
        self, session: Session, controls: Mapping[str, Control], folder: Path, given: Mapping[str, Any] | None = None
    ) -> None:
        self.session, self.controls, self.folder, self.given = session, controls, folder, dict(given or {})

    def answer(self, kind: str, request: Any, outdated: Callable[[], bool] = lambda: False) -> dict[str, Any]:
        """Answer a request.

        Parameters
        ----------
        kind : str
        request : dict
            From outside: everything in it is checked.
        outdated : callable
            Whether a newer request waits.
        """
        known = {"start": self._start, "run": self._run, "picture": self._picture}
        known |= {"numbers": self._numbers, "warnings": self._warnings}
        known |= {"save": self._save, "export": self._export}
        try:
            if kind not in known or not isinstance(request, dict):
                raise InputError("page", str(kind)[:40], f"is no request; one of {', '.join(known)}")
            return known[kind](request, outdated)
        except OutdatedError:
            return {"outdated": True}
        except TimeLimitError:
            return {"error": f"the run takes longer than {self.session.limit:g} s and was given up"}
        except (InputError, AssemblyError, RunError) as problem:
            return {"error": str(problem)}

    def _start(self, _: dict[str, Any], __: Callable[[], bool]) -> dict[str, Any]:
        experiment = self.session.system.experiment
        return {
            "title": experiment.title or experiment.source.stem,
            "file": experiment.source.name,
            "name": f"{experiment.source.stem}_play",
            "folder": str(self.folder.resolve()),
            "versions": versions(),
            "controls": [control.as_json() for control in self.controls.values()],
        }

    def _run(self, request: dict[str, Any], outdated: Callable[[], bool]) -> dict[str, Any]:
        values = self._values(request)
        if request.get("restart") is True:
            self.session.restart()
        return self.session.compute(values, outdated)

    def _picture(self, request: dict[str, Any], _: Callable[[], bool]) -> dict[str, Any]:
        return self.session.picture(self._values(request))

    def _numbers(self, _: dict[str, Any], __: Callable[[], bool]) -> dict[str, Any]:
        return self.session.numbers()

    def _warnings(self, _: dict[str, Any], __: Callable[[], bool]) -> dict[str, Any]:
        return {"warnings": self.session.warnings()}

    def _save(self, request: dict[str, Any], _: Callable[[], bool]) -> dict[str, Any]:
        target = self._target(request, ".toml")
        written = save(self.session.system.experiment, self._ran(request), target, request.get("replace") is True)
        return {"written": str(written), "command": f"linkages simulate {written}"}

    def _export(self, request: dict[str, Any], _: Callable[[], bool]) -> dict[str, Any]:
        """Save the file, and let ``linkages simulate`` write its folder: the files are the same by construction."""
        target = self._target(request, ".toml")
        save(self.session.system.experiment, self._ran(request), target, request.get("replace") is True)
        out = target.with_suffix("")
        command = [sys.executable, "-m", "linkages.cli.main", "simulate", str(target), "--out", str(out), "--quiet"]
        done = subprocess.run(command, capture_output=True, text=True, timeout=_EXPORT, check=False)
        if done.returncode not in (0, 1):
            raise InputError("export", target.name, done.stderr.strip().rpartition("\n")[2] or "failed")
        return {"written": str(out), "command": f"linkages report {out}"}

    def _values(self, request: dict[str, Any]) -> dict[str, float | str]:
        return checked(request.get("values", {}), self.controls)

    def _ran(self, request: dict[str, Any]) -> dict[str, Any]:
        """Values of the run that the page shows: a file with them gives the same numbers."""
        return {**self.given, **self.session.values_shown(self._values(request))}

    def _target(self, request: dict[str, Any], suffix: str) -> Path:
        name = request.get("name")
        if not isinstance(name, str) or not _NAME.fullmatch(name.removesuffix(suffix)):
            problem = "is no name of a file here; use letters, digits, '_', '-' and '.', without a folder"
            raise InputError("page", repr(name)[:60], problem)
        return self.folder / f"{name.removesuffix(suffix)}{suffix}"
