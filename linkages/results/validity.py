"""Validity of elements in a run, by their rules; warnings from what these find."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from linkages.elements.machine import all_elements_of
from linkages.elements.validity import Observed, Rules, Warned
from linkages.results.impacts import Impact
from linkages.results.link_loads import row_markers
from linkages.results.shape import RunWarning
from linkages.results.trajectory import Trajectory
from linkages.system import System


def warning(kind: str, time: float | None, what: str, remedy: str, changes: dict[str, Any] | None = None) -> RunWarning:
    """Make an entry of ``warnings`` in ``summary.json``; docs/warnings.md explains the kinds."""
    return RunWarning(kind=kind, time=time, what=what, remedy=remedy, changes=changes or {})


def warned(found: Iterable[Warned]) -> list[RunWarning]:
    """Make the entries of warnings that rules and elements give."""
    return [warning(one.kind, one.time, one.what, one.remedy, dict(one.changes)) for one in found]


def of_elements(system: System, run: Trajectory, impacts: Sequence[Impact]) -> list[RunWarning]:
    """Warn of elements that a run used outside their validity, one entry for each rule."""
    cases: dict[Rules[Observed], list[tuple[str, Observed]]] = {}
    for rules, one in _observed(system, run, impacts):
        cases.setdefault(rules, []).append((one.name, one))
    return [entry for rules, found in cases.items() for entry in warned(rules.broken(found))]


def _observed(system: System, run: Trajectory, impacts: Sequence[Impact]) -> Iterator[tuple[Rules[Observed], Observed]]:
    """Yield the rules and the data of the deformable links; none for runs with other models of them."""
    carried = _carriers(system)
    drives = [name for name in system.tree.driven if system.joints[name].type == "revolute"]
    for kind, name, _ in all_elements_of(system.parts):
        bodies = system.tree.deformable.get(name, ()) if kind.rules is not None else ()
        if kind.rules is not None and bodies and f"q.{bodies[0].coordinates[0]}" in run.columns:
            hits = [hit for hit in impacts if name in carried[hit.joint]]
            yield kind.rules, Observed(name, bodies, run, hits, [run[f"{drive}.rate"] for drive in drives])


def _carriers(system: System) -> dict[str, set[str]]:
    """Return the deformable links on which each contact acts, by its label."""
    found: dict[str, set[str]] = {}
    for (_, label), end in zip(system.contacts, system.ends, strict=True):
        markers = (end["bearing"], end["journal"], *row_markers(end["row"]))
        found[label] = {link for marker in markers if (link := system.tree.deformable_at(int(marker["body"])))}
    return found
