"""The summary of an assessment, with errors and warnings."""

from __future__ import annotations

from typing import Any

import numpy as np

from linkages.base.arguments import validated
from linkages.input.files.versions import versions
from linkages.results import numerics
from linkages.results.assessment import Assessment
from linkages.results.characteristics import numbers
from linkages.results.parts import Part
from linkages.results.shape import Cut, Fit, Ideal, Machine, Numbers, Provenance, Recorded, Summary, Window
from linkages.results.warnings import warnings
from linkages.system.identity import input_record


@validated
def summarize(assessment: Assessment) -> Summary:
    """Summarize an assessment in SI units; see docs/summary_json.md.

    Parameters
    ----------
    assessment : Assessment
        From `linkages.assess`.

    Returns
    -------
    Summary
        Numbers, texts, lists and tables as attributes and by key; its `content` is that of ``summary.json``.

    Examples
    --------
    >>> import linkages
    >>> system = linkages.load(linkages.find_file("seven_bar.toml"), {"duration": 0.1})
    >>> summary = linkages.summarize(linkages.assess(system, "compiled"))
    >>> summary.status, round(summary.joints["A"].force.peak, 2)
    ('ok', 6.96)
    >>> round(summary["joints"]["A"]["force"]["peak"], 2)
    6.96
    """
    whole = unjudged(assessment)
    return judge(assessment, whole)


def unjudged(assessment: Assessment) -> Summary:
    """Summarize an assessment without errors and warnings, which `judge` adds."""
    own, run = _own(assessment), assessment.run
    whole = Part(assessment, float(run.time[0]), float(run.time[-1]))
    return Summary(
        engine=assessment.engine,
        duration=float(run.time[-1]),
        status=run.status.value,
        **dict(whole.numbers),
        ideal=_ideal(assessment, whole.ideal),
        motion=assessment.motion.summary,
        start_up=assessment.start_up,
        report=assessment.reported,
        error={},
        error_until=None,
        warnings=[],
        windows={name: _window(Part(assessment, *span, whole)) for name, span in assessment.windows.items()},
        **own,
    )


def _ideal(assessment: Assessment, found: Numbers | None) -> Ideal | None:
    """Add the status of the ideal motion to its numbers."""
    if assessment.ideal is None or found is None:
        return None
    return Ideal(status=assessment.ideal.status.value, **dict(found))


def _own(assessment: Assessment) -> dict[str, Any]:
    """Collect what does not depend on a part of the run; not every run has every key."""
    found: dict[str, Any] = {"provenance": _provenance(assessment), "mechanism": _machine(assessment)}
    if assessment.ideal is None:
        found["no_ideal"] = assessment.no_ideal
    if assessment.system.recorded:
        found["recorded"] = _recorded(assessment)
    if assessment.system.settings.data:
        found["measured"] = {name: one.comparison for name, one in assessment.measured.items()}
    return found


def _window(part: Part) -> Window:
    """Describe a part of the run."""
    own: dict[str, Any] = {"from": part.start, "to": part.end, "ideal": part.ideal}
    return Window(**dict(part.numbers) | own)


def _machine(assessment: Assessment) -> Machine:
    """Describe the linkage."""
    system, run = assessment.system, assessment.run
    tree, quality = system.tree, system.assembly.quality
    carrying = {edge.joint for edge in tree.edges.values()}
    return Machine(
        name=system.description.machine,
        mobility=system.assembly.mobility,
        driven=[*tree.driven, *tree.powered],
        joints={joint.name: [joint.parent, joint.child] for joint in system.joints.values()},
        colors=dict(system.colors),
        cut=Cut(play=[name for name in tree.play if name not in carrying], ideal=list(tree.loops)),
        quality=None if np.isnan(quality) else quality,
        loop_error=run.provenance.get("loop_error", 0.0),
    )


def _provenance(assessment: Assessment) -> Provenance:
    """Tell what ran, and where it came from."""
    run = assessment.run
    return Provenance(
        versions=dict(versions()),
        **input_record(assessment.system),
        run={key: value for key, value in run.provenance.items() if key != "wall_time"},
        wall_time=run.provenance["wall_time"],
    )


def judge(assessment: Assessment, whole: Summary) -> Summary:
    """Add ``error`` and ``warnings`` to a summary from `unjudged`, and their errors to its ``windows``.

    ``error`` has the error of each peak by the peak's key (``slider7.ax.peak``), None without an estimate, and is empty
    without a tighter run; see `linkages.results.peak_errors`.
    """
    windows, repeating = {}, assessment.repeating
    for name, window in whole.windows.items():
        part = Part(assessment, window.start, window.to)
        windows[name] = window.model_copy(update={"error": part.errors(window.peaks)})
    error = Part(assessment, float(assessment.run.time[0]), whole.duration).errors(whole.peaks)
    judged = {
        "error": error,
        "error_until": repeating and repeating.settled if error else None,
        "warnings": warnings(assessment, whole.peaks, error),
        "windows": windows,
        **({"smoothing": _smoothing(assessment, whole)} if assessment.resmoothed else {}),
    }
    return whole.model_copy(update=judged)


def _recorded(assessment: Assessment) -> dict[str, Recorded]:
    """Describe the signals from data files, by dotted path."""
    return {
        path: Recorded(
            file=table.file or "",
            fits=[
                Fit(text=fit.text, rows=fit.rows, residual=fit.residual, deviation=fit.deviation)
                for fit in table.fitted
            ],
        )
        for path, table in assessment.system.recorded.items()
    }


def _smoothing(assessment: Assessment, whole: Summary) -> dict[str, dict[str, float]]:
    """Return the peak forces and torques with other smoothing, relative to the run's, by name and key."""
    result: dict[str, dict[str, float]] = {}
    forces = {key: peak for key, peak in whole.peaks.items() if key.endswith((".force.peak", ".torque.peak"))}
    largest = max((abs(peak) for peak in forces.values() if peak), default=0.0)
    for name, run in assessment.resmoothed.items():
        other = numbers(assessment.system, run, assessment.meaningless).peaks
        pairs = {
            key: (peak, other.get(key))
            for key, peak in forces.items()
            if peak and abs(peak) > numerics.ROUNDED * largest
        }
        result[name] = {key: abs(b / a) for key, (a, b) in pairs.items() if b is not None}
    return result
