"""The summary as a short table for a terminal, with errors and warnings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from linkages.base.brief import cell
from linkages.input.files.entry import content_of
from linkages.input.files.magnitudes import rounded
from linkages.results.shape import RunWarning, Summary, peaks_by_key
from linkages.results.warnings import relative
from linkages.show.plots.presentation import shown_unit
from linkages.show.report import words
from linkages.show.report.units import as_shown, output_unit

#: Columns of a heat balance, and their headings.
_HEAT = ("temperature", "viscosity", "power", "by_flow", "by_conduction")
_HEAT_HEAD = ("T [degC]", "mu [Pa s]", "power [W]", "flow [W]", "cond. [W]")


def format_summary(summary: Summary | Mapping[str, Any]) -> str:
    """Format a summary as lines of text: extremes with clearance and with ideal joints, errors, warnings.

    Parameters
    ----------
    summary : Summary or dict
        From `linkages.summarize`, or the content of ``summary.json``.

    Examples
    --------
    >>> import linkages
    >>> system = linkages.load(linkages.find_file("seven_bar.toml"), {"duration": 0.1})
    >>> summary = linkages.summarize(linkages.assess(system, "compiled", error_estimate=False))
    >>> print(linkages.format_summary(summary).splitlines()[1])
    compiled engine, 0.1 s, status ok; mobility 2, driven: O1, O4
    """
    content = content_of(summary)
    return "\n".join([format_table(content), *format_judgement(content)])


def format_table(summary: dict[str, Any]) -> str:
    """Format the numbers of a summary; with errors, if estimated; "-" is an undefined value."""
    summary = as_shown(summary)
    mechanism, experiment, shown = summary["mechanism"], summary["provenance"]["experiment"], words.reported(summary)
    ideal, errors = words.perfect(shown), shown.get("error", {})
    play = any(joint["model"] != "ideal" for joint in summary["joints"].values())
    run, more = "with clearance" if play else "integrated", words.exceeded(summary)

    def row(label: str, values: tuple[Any, ...], key: str | None = None) -> tuple[str, str]:
        """Return label and cells; the key of a peak, empty for numbers of another kind; None in a heading."""
        cells = "".join(cell(value, width) for value, width in zip(values, (12, 12, 14, 12), strict=True))
        error = "error" if key is None else errors.get(key)
        before = f"  {'whole run' if key is None else words.beyond(summary, key)}" if more else ""
        return label, cells + (cell(error, 11, ".1e") if errors else "") + before

    rows = [("", f"{'ideal joints':>24s}{run:>26s}"), row("output", ("min", "max", "min", "max"))]
    for name, value in shown["outputs"].items():
        exact = ideal["outputs"][name]
        extremes = exact["min"], exact["max"], value["min"], value["max"]
        rows.append(row(f"{name} [{shown_unit(output_unit(name, shown['drives']))}]", extremes, f"{name}.peak"))
    rows += [("", ""), row(f"joint force [{shown_unit('N')}]: links", ("ideal peak", "peak", "at [s]", "e/c peak"))]
    for name, value in shown["joints"].items():
        label = f"{name} ({value['model']})" if value["model"] != "ideal" else name
        label += f": {links}" if (links := words.meeting(summary, name)) else ""
        exact, force, ratio = (ideal["joints"][name]["force"], value["force"], value.get("eccentricity_ratio", {}))
        peaks = exact["peak"], force["peak"], force["time"], ratio.get("peak")
        rows.append(row(label, peaks, f"{name}.force.peak"))
    for (heading, *names), effects in words.effects(summary):
        rows += [("", ""), (heading, "".join(cell(name, 14) for name in names))]
        rows += [(label, cell(value, 14) + cell(time, 14) + cell(part, 14)) for label, value, time, part in effects]
    heats = {name: joint["heat"] for name, joint in summary["joints"].items() if "heat" in joint}
    if heats:
        rows += [("", ""), ("oil (lumped heat balance)", "".join(f"{name:>12s}" for name in _HEAT_HEAD))]
        rows += [(name, "".join(cell(heat[key], 12) for key in _HEAT)) for name, heat in heats.items()]
    for kind in ("drives", "loads"):
        efforts = list(words.effort_rows(shown, kind))
        if efforts:
            rows += [("", ""), row(kind.removesuffix("s"), ("ideal peak", "peak", f"work [{shown_unit('J')}]", ""))]
        for label, key, value, exact in efforts:
            rows.append(row(label, (exact["peak"], value["peak"], value["work"], ""), key))
    for name, value in shown["drives"].items():
        if value.get("fluctuation") is not None:
            exact = ideal["drives"][name].get("fluctuation")
            rows.append(row(f"{name} speed fluctuation [1]", (exact, value["fluctuation"], "", ""), ""))
    if "links" in shown:
        rows += [("", ""), row("flexible link", ("rigid peak", "peak", "at [s]", f"place [{shown_unit('m')}]"))]
    for column, rigid, value in words.link_rows(shown):
        cells = rigid, value["peak"], value["time"], value.get("place", "")
        rows.append(row(f"{column} [{shown_unit(output_unit(column))}]", cells, f"{column}.peak"))
    if "measured" in summary:
        rows += [("", ""), row("measured less computed", ("peak", "rms", "largest", "at [s]"))]
    for name, value in summary.get("measured", {}).items():
        rows.append(row(name, tuple(value[key] for key in ("peak", "rms", "largest", "time")), ""))
    width = max(18, *(1 + len(label) for label, _ in rows))
    lines = [
        experiment.get("title") or Path(experiment["file"]).stem,
        f"{summary['engine']} engine, {summary['duration']:g} s, status {summary['status']};"
        f" mobility {mechanism['mobility']}, driven: {', '.join(mechanism['driven']) or 'none'}",
        *words.motion_lines(summary),
        *words.recorded_lines(summary),
        "",
    ]
    return "\n".join(lines + [f"{label:{width}s}{cells}".rstrip() for label, cells in rows])


def format_judgement(summary: dict[str, Any]) -> list[str]:
    """Write the sizes of the errors, and all warnings, as lines of text."""
    smoothing = words.smoothing_lines(summary)
    lines = ["", *smoothing] if smoothing else []
    below = [found for found in relative(peaks_by_key(summary), summary["error"]) if found[1] < 1.0]
    for key, part in below[:1]:  # peaks below their errors are zero, or named in a warning
        line = f"the estimated errors of the peaks are at most {part:.1e} of their values ({key})"
        if (until := summary.get("error_until")) is not None:
            line += f"; the run that estimates them ends at {rounded(until)} s, because the motion repeats itself"
        lines += ["", line]
    return lines + format_warnings(summary["warnings"])


def format_warnings(warnings: Sequence[RunWarning | Mapping[str, Any]], whose: str = "") -> list[str]:
    """Write warnings as lines of text, each after an empty line."""
    return [
        line for one in warnings for line in ("", f"warning{whose} ({one['kind']}): {one['what']}; {one['remedy']}")
    ]
