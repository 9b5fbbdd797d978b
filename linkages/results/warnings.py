"""What must be known before the numbers of a summary are trusted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from linkages.errors import Status
from linkages.results.singular import Passage
from linkages.results.trajectory import Trajectory

ROUGH = 0.1  # of a peak: a change at the tighter tolerance that makes it rough
_NOTHING = 1e-6  # of the largest peak of its kind: below it a peak is rounding or residue, and its change says nothing
_NAMED = 4  # most peaks, joints or times in a sentence

#: Outputs that stay bounded in a singular position: positions and velocities.
_BOUNDED = frozenset({"x", "y", "angle", "vx", "vy", "omega", "rate"})


def warning(kind: str, time: float | None, what: str, remedy: str) -> dict[str, Any]:
    """Make an entry of ``warnings`` in ``summary.json``; docs/outputs.md explains the kinds."""
    return {"kind": kind, "time": time, "what": what, "remedy": remedy}


def singular(run: Sequence[Passage], ideal: Sequence[Passage]) -> list[dict[str, Any]]:
    """Warn of the singular positions that a run and the ideal motion beside it pass or near, in one entry."""
    found = run or ideal
    if not found:
        return []
    which = "the run" if not ideal else "the run, like the ideal linkage," if run else "the ideal linkage"
    worst = min(found, key=lambda passage: passage.quality)
    times = _listed([f"{passage.time:.6g} s" for passage in found])
    what = (
        f"{which} passes or nears singular positions at {times}: there {_listed(worst.joints)} can move although the "
        f"drives stand still (ratio of singular values down to {worst.quality:.1g}), the branch that follows is not "
        "determined, and forces, torques and accelerations have no bound"
    )
    remedy = "change the lengths or the range of the drives, or drive another joint"
    return [warning("singular", found[0].time, what, remedy)]


def rough(
    tighter: Trajectory | None, peaks: Mapping[str, float | None], errors: Mapping[str, float | None]
) -> list[dict[str, Any]]:
    """Warn of peaks that another tolerance changes by more than a tenth, and where errors could not be estimated."""
    if tighter is not None and tighter.status is not Status.OK:
        time = float(tighter.time[-1])
        what = f"the run that estimates the errors ended at t = {time:.6g} s: {tighter.status.value}"
        return [warning("rough", time, what, tighter.status.remedy)]
    changed = [(key, part) for key, part in relative(peaks, errors) if part > ROUGH]
    if not changed:
        return []
    names = _listed([f"{key} by {100.0 * part:.0f} %" for key, part in changed])
    remedy = (
        "tighten solver.accuracy; where that does not settle them, the motion depends on its start beyond any digits: "
        "compare statistics of many runs, not peaks"
    )
    return [warning("rough", None, f"a ten times tighter tolerance changes {names}", remedy)]


def chaotic(parted: float | None, later: Sequence[str]) -> list[dict[str, Any]]:
    """Warn of peaks that come after a run and its repetition have parted: their errors mean nothing."""
    if parted is None or not later:
        return []
    what = (
        f"the run and the one at a ten times tighter tolerance part at t = {parted:.6g} s; what comes later is that of "
        f"one of many motions, and says nothing of the others: {_listed(later)}, whose errors are left out"
    )
    return [warning("rough", parted, what, "compare statistics of many runs, not peaks; or end the run before")]


def relative(peaks: Mapping[str, float | None], errors: Mapping[str, float | None]) -> list[tuple[str, float]]:
    """Errors in parts of their peaks, the largest first; without those of peaks that are nothing but rounding."""
    largest: dict[str, float] = {}
    for key, peak in peaks.items():
        largest[_kind(key)] = max(largest.get(_kind(key), 0.0), peak or 0.0)
    found = []
    for key, error in errors.items():
        peak = peaks[key]
        if error is not None and peak is not None and peak > _NOTHING * largest[_kind(key)]:
            found.append((key, error / peak))
    return sorted(found, key=lambda item: -item[1])


def without_unbounded(numbers: dict[str, Any]) -> dict[str, Any]:
    """Replace what has no bound in a singular position by None: forces, torques, accelerations, work."""
    for name, value in numbers["outputs"].items():
        if not (name.startswith("q.") or name.rpartition(".")[2] in _BOUNDED):
            value.update(dict.fromkeys(value))
    for value in numbers["joints"].values():
        value["force"] = dict.fromkeys(value["force"])
    for value in numbers["drives"].values():
        value.update(torque={"peak": None}, work=None)
    return numbers


def _kind(key: str) -> str:
    """Quantity of a peak's key: ``force`` of ``A.force.peak``."""
    return key.split(".")[-2]


def _listed(words: Sequence[str]) -> str:
    more = len(words) - _NAMED
    return ", ".join(words[:_NAMED]) + (f" and {more} more" if more > 0 else "")
