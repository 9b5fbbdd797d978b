"""Warnings about the reliability of a summary's numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from linkages.base.errors import Status, listed_briefly
from linkages.elements.machine import KINDS, all_elements_of
from linkages.results import numerics
from linkages.results.assessment import Assessment
from linkages.results.films import heat_warnings
from linkages.results.impacts import Impact
from linkages.results.joint_validity import outside
from linkages.results.peak_errors import Peaks, largest_of_quantities, quantity
from linkages.results.shape import RunWarning
from linkages.results.soundness import BOUNDED, CHANGE_POINT, DEAD_POINT, ONE_BRANCH, SingularPosition, Soundness
from linkages.results.trajectory import Trajectory
from linkages.results.validity import warned, warning
from linkages.system import System
from linkages.system.assembly import locking_couplings
from linkages.system.rigid_segments import has_segments

ROUGH = 0.1  # error over a peak that gives a warning

_CONTINUATION = {
    DEAD_POINT: "no other branch starts there, but the drives cannot continue: velocities, accelerations, forces and "
    "torques are unbounded",
    CHANGE_POINT: "another branch crosses there, so that the continuation is not determined: the run continues with "
    "the same velocity; forces and torques are unbounded, and also accelerations if a length has an error",
    ONE_BRANCH: "to first order, but the redundant loops allow one branch only: it determines motion and drive "
    "torques, while forces in joints and gears are unbounded",
}


def warnings(assessment: Assessment, peaks: Peaks, error: Peaks) -> list[RunWarning]:
    """List the warnings of an assessment with these peaks and errors, both by the peaks' keys."""
    system, run, tighter = assessment.system, assessment.run, assessment.tighter
    sound, ideal = assessment.sound, assessment.ideal_sound
    estimated = tighter is not None and tighter.status is Status.OK
    unknown = [key for key in error if estimated and error[key] is None and peaks[key] is not None]
    segmented = has_segments(system, run.columns)
    finer, model = refinements(system, segmented), [*_of_substitutes(system, segmented), *_of_elements(system)]
    return [
        *_singular(sound.singular, () if ideal is None else ideal.singular),
        *_undetermined(sound.indeterminate, () if ideal is None else ideal.indeterminate),
        *rough(tighter, peaks, error, assessment.noise, finer),
        *_chaotic(assessment.apart, unknown, finer),
        *outside(system, run, assessment.contacts),
        *model,
        *heat_warnings(assessment.heat),
    ]


def warnings_of_run(system: System, sound: Soundness, contacts: Sequence[Impact]) -> list[RunWarning]:
    """List the warnings of one run: singular positions, indeterminate forces, laws outside their validity."""
    own = (*_singular(sound.singular, ()), *_undetermined(sound.indeterminate, ()))
    return [*own, *outside(system, sound.motion, contacts)]


def _singular(run: Sequence[SingularPosition], ideal: Sequence[SingularPosition]) -> list[RunWarning]:
    """Warn of singular positions on or near a run and its ideal motion, in one entry."""
    found = run or ideal
    if not found:
        return []
    which = "the run" if not ideal else "the run, like the ideal linkage," if run else "the ideal linkage"
    worst = min(found, key=lambda position: ([*BOUNDED].index(position.kind), position.quality))
    times, loose = listed_briefly([f"{position.time:.6g} s" for position in found]), listed_briefly(worst.joints)
    what = (
        f"{which} passes or nears singular positions at {times}: there {loose} can move although the "
        f"drives do not (ratio of singular values down to {worst.quality:.1g}); {_CONTINUATION[worst.kind]}"
    )
    remedy = "change the lengths or the range of the drives, or drive another joint"
    if worst.kind == ONE_BRANCH:
        remedy = "change the range of the drives, or give a joint of a redundant loop clearance"
    return [warning("singular", found[0].time, what, remedy)]


def _undetermined(run: Sequence[str], ideal: Sequence[str]) -> list[RunWarning]:
    """Warn of columns that are statically indeterminate in a run, or in the linkage with ideal joints."""
    found = [column for column in run or ideal if column.rpartition(".")[2] in ("force", "torque")]
    if not found:
        return []
    which = "" if run else " of the ideal linkage"
    what = (
        f"{', '.join(found)}{which} are statically indeterminate: loops or gears are redundant, and these forces and "
        "torques depend on assembly tolerances"
    )
    remedy = "give a joint of a redundant loop clearance, or remove a redundant link or gear"
    return [warning("indeterminate", None, what, remedy)]


def refinements(system: System, segmented: bool) -> tuple[str, ...]:
    """Name the settings beside solver.accuracy that reduce the errors of a run, most effective ones first."""
    found = list[str]()
    for name in system.film_steps:
        history = system.joints[name].history
        if history is None or (history.step is not None and history.accuracy is None):
            found.append(f"shorten joints.{name}.history.step, or leave it out: the run then chooses the film step")
        else:
            found.append(f"reduce joints.{name}.history.accuracy")
        found.append(f"increase joints.{name}.history.cells")
    if segmented:
        found += [
            f"increase {kind.path(name)}.{kind.substitute.key}"
            for kind, name, keys in all_elements_of(system.parts)
            if kind.substitute is not None and kind.deforms(keys)
        ]
    return tuple(found)


def rough(
    tighter: Trajectory | None, peaks: Peaks, errors: Peaks, noise: Mapping[str, float], refinements: Sequence[str] = ()
) -> list[RunWarning]:
    """Warn of peaks whose errors exceed a tenth of them, and of errors that could not be estimated.

    Peaks below the rounding level of their columns count as zero and give no warning. `refinements` name settings
    that reduce the errors beside the accuracy.
    """
    if tighter is not None and tighter.status is not Status.OK:
        time = float(tighter.time[-1])
        what = f"the run that estimates the errors ended at t = {time:.6g} s: {tighter.status.value}"
        return [warning("rough", time, what, tighter.status.remedy)]
    zero = {key for key, peak in peaks.items() if (peak or 0.0) <= noise[key.removesuffix(".peak")]}
    changed = [(key, part) for key, part in relative(peaks, errors) if part > ROUGH and key not in zero]
    if not changed:
        return []
    names = listed_briefly([f"{100.0 * part:.0f} % of {key}" for key, part in changed])
    settings = "; ".join([*refinements, "tighten solver.accuracy"])
    remedy = (
        f"{settings}; if that does not reduce them, the motion is too sensitive to its start: "
        "compare statistics of many runs, not peaks"
    )
    return [warning("rough", None, f"the estimated errors are {names}", remedy)]


def _chaotic(apart: tuple[float, float] | None, unknown: Sequence[str], refinements: Sequence[str]) -> list[RunWarning]:
    """Warn of peaks without error estimate because a run and its repetition diverge."""
    if apart is None or not unknown:
        return []
    what = (
        f"the run and its repetition at a ten times tighter tolerance differ from t = {apart[0]:.6g} s to "
        f"{apart[1]:.6g} s: the run is one of many motions there, and the peaks of "
        f"{listed_briefly(unknown)} are lower bounds without errors"
    )
    remedy = "compare statistics of many runs, not peaks; or define a window that ends before"
    if refinements:
        remedy = f"{'; '.join(refinements)}; if the runs still differ, {remedy}"
    return [warning("rough", apart[0], what, remedy)]


def _of_elements(system: System) -> list[RunWarning]:
    """List the warnings about the elements of a machine, such as couplings that lock each other."""
    closed = [*system.tree.coupled]
    together: dict[Any, dict[str, Any]] = {}
    for kind, name, keys in all_elements_of(system.parts):
        if kind.warns is not None:
            together.setdefault(kind.warns, {})[name] = keys
    tree = system.tree
    locking = locking_couplings(tree, tree.loop_rows, system.assembly.q) if closed else []
    return warned(
        one
        for warns, named in together.items()
        for one in warns(named, [closed[k] for k in locking if closed[k] in named])
    )


def _of_substitutes(system: System, segmented: bool) -> list[RunWarning]:
    """List the warnings about what a run had instead of elements that the engine lacks."""
    kinds = [kind for kind in KINDS if kind.substitute is not None] if segmented else []
    return warned(one for kind in kinds if kind.substitute for one in kind.substitute.warns(system.parts[kind.table]))


def relative(peaks: Peaks, errors: Peaks) -> list[tuple[str, float]]:
    """Return the relative errors of peaks, largest first, without peaks below the rounding level."""
    largest, found = largest_of_quantities(peaks), []
    for key, error in errors.items():
        peak = peaks[key]
        if error is not None and peak is not None and peak > numerics.WARNINGS_NOTHING * largest[quantity(key)]:
            found.append((key, error / peak))
    return sorted(found, key=lambda item: -item[1])
