"""The summary as a short table for a terminal."""

from __future__ import annotations

from typing import Any

from linkages.model.experiment import QUANTITIES, Experiment


def format_summary(summary: dict[str, Any], experiment: Experiment) -> str:
    """Format a summary (see `linkages.engines.study.summarize`) as lines of text."""
    ideal, error = summary["ideal"], summary["error"]
    title = experiment.title or experiment.source.stem
    mechanism = summary["mechanism"]
    width = max(18, 1 + max(map(len, _labels(summary)), default=0))
    run = "with clearance" if experiment.play else "integrated"
    lines = [
        title,
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
    if summary["drives"]:
        lines += [
            "",
            f"{'drive':{width}s}{'ideal peak':>12s}{'peak':>12s}{'work [J]':>14s}{'':12s}{'error':>11s}",
        ]
    for name, value in summary["drives"].items():
        lines.append(
            f"{f'{name} torque':{width}s}{ideal['drives'][name]['torque']['peak']:12.5g}{value['torque']['peak']:12.5g}"
            f"{value['work']:14.4g}{'':12s}{_error(error, f'{name}.torque.peak')}"
        )
    if "loads" in summary:
        lines += [
            "",
            f"{'load':{width}s}{'ideal peak':>12s}{'peak':>12s}{'work [J]':>14s}{'':12s}{'error':>11s}",
        ]
    for name, value in summary.get("loads", {}).items():
        effort = "torque" if "torque" in value else "force"
        lines.append(
            f"{f'{name} {effort}':{width}s}{ideal['loads'][name][effort]['peak']:12.5g}{value[effort]['peak']:12.5g}"
            f"{value['work']:14.4g}{'':12s}{_error(error, f'{name}.{effort}.peak')}"
        )
    return "\n".join(lines)


def _labels(summary: dict[str, Any]) -> list[str]:
    """List what stands in the first column."""
    return [
        *map(_output, summary["outputs"]),
        *(_joint(name, value) for name, value in summary["joints"].items()),
        *(f"{name} torque" for name in (*summary["drives"], *summary.get("loads", ()))),
    ]


def _output(name: str) -> str:
    unit = QUANTITIES[name.rpartition(".")[2]].split("[")[1].rstrip("]")
    return f"{name} [{unit}]"


def _joint(name: str, value: dict[str, Any]) -> str:
    return f"{name} ({value['model']})" if value["model"] != "ideal" else name


def _error(error: dict[str, float], key: str) -> str:
    return f"{error[key]:11.1e}" if key in error else f"{'-':>11s}"
