"""The summary as a short table for a terminal."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from linkages.report.words import output_unit


def format_summary(summary: dict[str, Any]) -> str:
    """Format a summary as lines of text: extremes beside those of ideal joints, and the errors of the peaks.

    Parameters
    ----------
    summary : dict
        From `linkages.summarize`, or the content of ``summary.json``.

    Returns
    -------
    str

    Examples
    --------
    >>> import linkages
    >>> system = linkages.load(linkages.find_file("seven_bar.toml"), {"duration": 0.1})
    >>> summary = linkages.summarize(linkages.study(system, "compiled", error_estimate=False))
    >>> print(linkages.format_summary(summary).splitlines()[1])
    compiled engine, 0.1 s, status ok; mobility 2, driven: O1, O4
    """
    ideal, error, mechanism = summary["ideal"], summary["error"], summary["mechanism"]
    experiment = summary["provenance"]["experiment"]
    width = max(18, 1 + max(map(len, _labels(summary)), default=0))
    run = (
        "with clearance"
        if any(joint["model"] != "ideal" for joint in summary["joints"].values())
        else "integrated"
    )
    lines = [
        experiment.get("title") or Path(experiment["file"]).stem,
        f"{summary['engine']} engine, {summary['duration']:g} s, status {summary['status']};"
        f" mobility {mechanism['mobility']}, driven: {', '.join(mechanism['driven']) or 'none'}",
        "",
        f"{'':{width}s}{'ideal joints':>24s}{run:>26s}{'error':>11s}",
        f"{'output':{width}s}{'min':>12s}{'max':>12s}{'min':>14s}{'max':>12s}{'of peak':>11s}",
    ]
    for name, value in summary["outputs"].items():
        exact = ideal["outputs"][name]
        lines.append(
            f"{_output(name):{width}s}{exact['min']:12.5g}{exact['max']:12.5g}{value['min']:14.5g}{value['max']:12.5g}"
            f"{_error(error, f'{name}.peak')}"
        )
    lines += [
        "",
        f"{'joint force [N]':{width}s}{'ideal peak':>12s}{'peak':>12s}{'at [s]':>14s}{'eps peak':>12s}{'error':>11s}",
    ]
    for name, value in summary["joints"].items():
        eps = value.get("eccentricity_ratio")
        ratio = f"{eps['peak']:12.5g}" if eps else f"{'-':>12s}"
        exact, force = ideal["joints"][name]["force"], value["force"]
        lines.append(
            f"{_joint(name, value):{width}s}{exact['peak']:12.5g}{force['peak']:12.5g}{force['time']:14.5g}{ratio}"
            f"{_error(error, f'{name}.force.peak')}"
        )
    for kind in ("drive", "load"):
        found = summary.get(f"{kind}s")
        if found:
            lines += [
                "",
                f"{kind:{width}s}{'ideal peak':>12s}{'peak':>12s}{'work [J]':>14s}{'':12s}{'error':>11s}",
            ]
            for name, value in found.items():
                effort = _effort(value)
                lines.append(
                    f"{f'{name} {effort}':{width}s}{ideal[f'{kind}s'][name][effort]['peak']:12.5g}"
                    f"{value[effort]['peak']:12.5g}{value['work']:14.4g}{'':12s}"
                    f"{_error(error, f'{name}.{effort}.peak')}"
                )
    return "\n".join(lines)


def _labels(summary: dict[str, Any]) -> Iterable[str]:
    """Yield what stands in the first column."""
    yield from map(_output, summary["outputs"])
    yield from (_joint(name, value) for name, value in summary["joints"].items())
    actuated = {**summary["drives"], **summary.get("loads", {})}
    yield from (f"{name} {_effort(value)}" for name, value in actuated.items())


def _output(name: str) -> str:
    return f"{name} [{output_unit(name)}]"


def _joint(name: str, value: dict[str, Any]) -> str:
    return f"{name} ({value['model']})" if value["model"] != "ideal" else name


def _effort(value: dict[str, Any]) -> str:
    """Name what a drive or a load is judged by."""
    return "torque" if "torque" in value else "force"


def _error(error: dict[str, float | None], key: str) -> str:
    found = error.get(key)
    return f"{found:11.1e}" if found is not None else f"{'-':>11s}"
