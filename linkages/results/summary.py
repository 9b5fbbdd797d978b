"""The summary of an assessment: contents of ``summary.json``, with errors and warnings."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from linkages.base.arguments import validated
from linkages.base.errors import Status
from linkages.input.files.versions import versions
from linkages.input.model.skeleton import color_of
from linkages.results.assessment import Assessment
from linkages.results.characteristics import numbers, peaks_by_key
from linkages.results.extremes import peaks
from linkages.results.peak_errors import errors
from linkages.results.trajectory import Trajectory
from linkages.results.warnings import warnings

_ZERO = 1e-9  # relative to the largest force or torque: smaller peaks are rounding errors
_NOTHING = 1e-9  # ratio of an ideal range to a difference below which the range is rounding


@validated
def summarize(assessment: Assessment) -> dict[str, Any]:
    """Make the contents of ``summary.json`` in SI units; see docs/outputs.md.

    Parameters
    ----------
    assessment : Assessment
        From `linkages.assess`.

    Returns
    -------
    dict
        Numbers, texts, lists and dicts, ready for JSON.

    Examples
    --------
    >>> import linkages
    >>> system = linkages.load(linkages.find_file("seven_bar.toml"), {"duration": 0.1})
    >>> summary = linkages.summarize(linkages.assess(system, "compiled"))
    >>> summary["status"], round(summary["joints"]["A"]["force"]["peak"], 2)
    ('ok', 6.96)
    """
    summary = unjudged(assessment)
    return summary | judge(assessment, summary)


def unjudged(assessment: Assessment) -> dict[str, Any]:
    """Make the contents of ``summary.json`` without errors and warnings, which `judge` adds."""
    system, run, ideal_run = assessment.system, assessment.run, assessment.ideal
    whole = numbers(system, run, assessment.meaningless, assessment.contacts)
    for name, heat in assessment.heat.items():
        whole["joints"][name]["heat"] = heat.content
    ideal = None if ideal_run is None else numbers(system, ideal_run, assessment.ideal_meaningless)
    whole["difference"] = _differences(assessment, ideal, 0.0, float(run.time[-1]))
    windows = {}
    for name, (start, end) in assessment.windows.items():
        found = numbers(system, run.within(start, end), assessment.meaningless, assessment.contacts)
        exact = ideal  # of the whole motion with ideal joints, if that ends earlier
        if ideal_run is not None and ideal_run.time[-1] >= end:
            exact = numbers(system, ideal_run.within(start, end), assessment.ideal_meaningless)
        found["difference"] = _differences(assessment, exact, start, end)
        windows[name] = {"from": start, "to": end, **found, "ideal": exact}
    quality, experiment, tree = system.assembly.quality, system.experiment, system.tree
    carrying = {edge.joint for edge in tree.edges.values()}
    return {
        "engine": assessment.engine,
        "duration": float(run.time[-1]),
        "status": run.status.value,
        "mechanism": {
            "name": system.mechanism.name,
            "mobility": system.assembly.mobility,
            "driven": [*tree.driven, *tree.powered],
            "joints": {joint.name: [joint.parent, joint.child] for joint in system.mechanism.joints},
            "colors": {name: color_of(system.mechanism, name) for name in system.mechanism.place},
            "cut": {"play": [name for name in tree.play if name not in carrying], "ideal": list(tree.loops)},
            "quality": None if np.isnan(quality) else quality,
            "loop_error": run.provenance.get("loop_error", 0.0),
        },
        **whole,
        "ideal": None if ideal_run is None or ideal is None else {"status": ideal_run.status.value, **ideal},
        **({"no_ideal": assessment.no_ideal} if ideal_run is None else {}),
        **({"recorded": _recorded(assessment)} if experiment.from_files else {}),
        **({"measured": {k: one.content for k, one in assessment.measured.items()}} if experiment.data else {}),
        "motion": assessment.motion.content,
        "start_up": assessment.start_up,
        "report": assessment.reported,
        "error": {},
        "error_until": None,
        "warnings": [],
        "windows": windows,
        "provenance": {
            "versions": versions(),
            "experiment": experiment.model_dump(exclude_unset=True, exclude_none=True)
            | {"file": experiment.source.name},
            "folder": str(experiment.source.resolve().parent),
            "sources": experiment.sources,
            "run": {key: value for key, value in run.provenance.items() if key != "wall_time"},
            "wall_time": run.provenance["wall_time"],
        },
    }


def _differences(
    assessment: Assessment, ideal: dict[str, Any] | None, start: float, end: float
) -> dict[str, dict[str, Any]]:
    """Find the largest difference of outputs and forces of clearance joints from the ideal motion, after the start.

    Its share is the part of the ideal output's range or of the ideal force's peak, None if that is rounding.
    Differences that are rounding are left out.
    """
    experiment = assessment.system.experiment
    if ideal is None or not (experiment.play or experiment.flexible):
        return {}
    apart, unknown = assessment.difference, assessment.meaningless | assessment.ideal_meaningless
    names = [*experiment.outputs, *(f"{name}.force" for name in experiment.play)]
    begin = max(start, assessment.taken_up)
    if begin >= (last := min(end, float(apart.time[-1]))):
        return {}
    found = peaks(apart.within(begin, last), [name for name in names if name in apart and name not in unknown])
    wholes = {name: value["max"] - value["min"] for name, value in ideal["outputs"].items() if value["max"] is not None}
    wholes |= {f"{name}.force": value["force"]["peak"] for name, value in ideal["joints"].items()}
    return {
        name: {"peak": peak.value, "time": peak.time, "share": _share(peak.value, wholes[name])}
        for name, peak in found.items()
        if peak.value > assessment.noise[name]
    }


def _share(part: float, whole: float) -> float | None:
    return part / whole if whole > _NOTHING * part else None


def judge(assessment: Assessment, whole: dict[str, Any]) -> dict[str, Any]:
    """Make ``error`` and ``warnings`` of a summary from `unjudged`, and its ``windows`` with their errors.

    ``error`` has the error of each peak by the peak's key (``slider7.ax.peak``), None without an estimate, and is empty
    without a tighter run; see `linkages.results.peak_errors`.
    """
    error = _errors(assessment, (0.0, whole["duration"]), whole)
    windows = {}
    for name, window in whole.get("windows", {}).items():
        windows[name] = window | {"error": _errors(assessment, (window["from"], window["to"]), window)}
    return {
        "error": error,
        "error_until": assessment.repeating and assessment.repeating.settled if error else None,
        "warnings": warnings(assessment, peaks_by_key(whole), error),
        "windows": windows,
        **({"smoothing": _smoothing(assessment, whole)} if assessment.resmoothed else {}),
    }


def _recorded(assessment: Assessment) -> dict[str, Any]:
    """Describe the signals from data files, by dotted path."""
    return {
        path: {
            "file": table.file,
            "fits": [
                {"text": fit.text, "rows": fit.rows, "residual": fit.residual, "deviation": fit.deviation}
                for fit in table.fitted
            ],
        }
        for path, table in assessment.system.experiment.from_files.items()
    }


def _smoothing(assessment: Assessment, whole: Mapping[str, Any]) -> dict[str, dict[str, float]]:
    """Return the peak forces and torques with other smoothing, relative to the run's, by name and key."""
    result: dict[str, dict[str, float]] = {}
    forces = {key: peak for key, peak in peaks_by_key(whole).items() if key.endswith((".force.peak", ".torque.peak"))}
    largest = max((abs(peak) for peak in forces.values() if peak), default=0.0)
    for name, run in assessment.resmoothed.items():
        other = peaks_by_key(numbers(assessment.system, run, assessment.meaningless))
        pairs = {key: (peak, other.get(key)) for key, peak in forces.items() if peak and abs(peak) > _ZERO * largest}
        result[name] = {key: abs(b / a) for key, (a, b) in pairs.items() if b is not None}
    return result


def _errors(assessment: Assessment, span: tuple[float, float], of: Mapping[str, Any]) -> dict[str, float | None]:
    """Estimate the error of each peak of a part of the run; empty without the tighter run.

    If the tighter run ends before a part that repeats an earlier one, the errors are those of the earlier one.
    """
    if assessment.tighter is None:
        return {}
    error = _changes(assessment, assessment.tighter, span, of)
    if assessment.remeshed is None:
        return error
    of_cells = _changes(assessment, assessment.remeshed, span, of)
    both = {key: (error[key], of_cells.get(key)) for key in error}
    return {key: None if one is None or other is None else one + other for key, (one, other) in both.items()}


def _changes(
    assessment: Assessment, tighter: Trajectory, span: tuple[float, float], of: Mapping[str, Any]
) -> dict[str, float | None]:
    """Estimate the errors of the peaks of a part of the run that a finer run shows."""
    repeating = assessment.repeating
    if tighter.status is not Status.OK:
        return dict.fromkeys(peaks_by_key(of))
    early = span if repeating is None else repeating.earlier(*span)
    run, finer = _part(assessment.run, early), _part(tighter, early)
    if early != span:
        of = numbers(assessment.system, run, assessment.meaningless)
    found = peaks_by_key(numbers(assessment.system, finer, assessment.meaningless))
    return errors(
        run, finer, peaks_by_key(of), found, assessment.apart, assessment.noise, bool(assessment.system.film_steps)
    )


def _part(run: Trajectory, span: tuple[float, float]) -> Trajectory:
    """Return the part of a run between two times [s]; the run itself if it has no other part."""
    return run if span == (run.time[0], run.time[-1]) else run.within(*span)
