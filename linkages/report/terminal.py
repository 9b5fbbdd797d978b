"""The summary as a short table for a terminal."""

from __future__ import annotations

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
    ideal, mechanism, experiment = summary["ideal"], summary["mechanism"], summary["provenance"]["experiment"]
    play = any(joint["model"] != "ideal" for joint in summary["joints"].values())
    run = "with clearance" if play else "integrated"

    def error(key: str) -> str:
        found = summary["error"].get(key)
        return f"{found:11.1e}" if found is not None else f"{'-':>11s}"

    rows = [
        ("", f"{'ideal joints':>24s}{run:>26s}{'error':>11s}"),
        ("output", f"{'min':>12s}{'max':>12s}{'min':>14s}{'max':>12s}{'of peak':>11s}"),
    ]
    for name, value in summary["outputs"].items():
        exact = ideal["outputs"][name]
        extremes = f"{exact['min']:12.5g}{exact['max']:12.5g}{value['min']:14.5g}{value['max']:12.5g}"
        rows.append((f"{name} [{output_unit(name)}]", extremes + error(f"{name}.peak")))
    rows += [
        ("", ""),
        (
            "joint force [N]",
            f"{'ideal peak':>12s}{'peak':>12s}{'at [s]':>14s}{'eps peak':>12s}{'error':>11s}",
        ),
    ]
    for name, value in summary["joints"].items():
        label = f"{name} ({value['model']})" if value["model"] != "ideal" else name
        eps = value.get("eccentricity_ratio")
        ratio = f"{eps['peak']:12.5g}" if eps else f"{'-':>12s}"
        exact, force = ideal["joints"][name]["force"], value["force"]
        peaks = f"{exact['peak']:12.5g}{force['peak']:12.5g}{force['time']:14.5g}{ratio}"
        rows.append((label, peaks + error(f"{name}.force.peak")))
    for kind in ("drives", "loads"):
        found = summary.get(kind, {})
        if found:
            head = f"{'ideal peak':>12s}{'peak':>12s}{'work [J]':>14s}{'':12s}{'error':>11s}"
            rows += [("", ""), (kind.removesuffix("s"), head)]
        for name, value in found.items():
            effort = "torque" if "torque" in value else "force"
            exact, peak = ideal[kind][name][effort]["peak"], value[effort]["peak"]
            numbers = f"{exact:12.5g}{peak:12.5g}{value['work']:14.4g}{'':12s}"
            rows.append((f"{name} {effort}", numbers + error(f"{name}.{effort}.peak")))
    width = max(18, *(1 + len(label) for label, _ in rows))
    lines = [
        experiment.get("title") or Path(experiment["file"]).stem,
        f"{summary['engine']} engine, {summary['duration']:g} s, status {summary['status']};"
        f" mobility {mechanism['mobility']}, driven: {', '.join(mechanism['driven']) or 'none'}",
        "",
    ]
    return "\n".join(lines + [f"{label:{width}s}{cells}".rstrip() for label, cells in rows])
