"""The summary as a short table for a terminal."""

from __future__ import annotations

from typing import Any

from linkages.experiment import QUANTITIES, Experiment


def format_summary(summary: dict[str, Any], experiment: Experiment) -> str:
    """Format a summary (see `linkages.run.summarize`) as lines of text."""
    ideal, error = summary["ideal"], summary["error"]
    title = experiment.title or experiment.source.stem
    mechanism = summary["mechanism"]
    lines = [
        title,
        f"{summary['engine']} engine, {summary['duration']:g} s, status {summary['status']};"
        f" mobility {mechanism['mobility']}, driven: {', '.join(mechanism['driven']) or 'none'}",
        "",
        f"{'':18s}{'ideal joints':>24s}{'with clearance':>26s}{'error':>11s}",
        f"{'output':18s}{'min':>12s}{'max':>12s}{'min':>14s}{'max':>12s}{'of peak':>11s}",
    ]
    for name, value in summary["outputs"].items():
        unit = QUANTITIES[name.rpartition(".")[2]].split("[")[1].rstrip("]")
        exact = ideal["outputs"][name]
        lines.append(
            f"{f'{name} [{unit}]':18s}{exact['min']:12.5g}{exact['max']:12.5g}{value['min']:14.5g}{value['max']:12.5g}"
            f"{_error(error, f'{name}.peak')}"
        )
    lines += [
        "",
        f"{'joint force [N]':18s}{'ideal peak':>12s}{'peak':>12s}{'at [s]':>14s}{'eps peak':>12s}{'error':>11s}",
    ]
    for name, value in summary["joints"].items():
        eps = value.get("eccentricity_ratio")
        label = f"{name} ({value['model']})" if value["model"] != "ideal" else name
        lines.append(
            f"{label:18s}{ideal['joints'][name]['force']['peak']:12.5g}{value['force']['peak']:12.5g}"
            f"{value['force']['time']:14.5g}{eps['peak'] if eps else float('nan'):12.5g}"
            f"{_error(error, f'{name}.force.peak')}".replace("nan", "  -")
        )
    if summary["drives"]:
        lines += ["", f"{'drive':18s}{'ideal peak':>12s}{'peak':>12s}{'work [J]':>14s}{'':12s}{'error':>11s}"]
    for name, value in summary["drives"].items():
        lines.append(
            f"{f'{name} torque':18s}{ideal['drives'][name]['torque']['peak']:12.5g}{value['torque']['peak']:12.5g}"
            f"{value['work']:14.4g}{'':12s}{_error(error, f'{name}.torque.peak')}"
        )
    return "\n".join(lines)


def _error(error: dict[str, float], key: str) -> str:
    return f"{error[key]:11.1e}" if key in error else f"{'-':>11s}"
