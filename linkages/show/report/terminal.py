"""The summary as text for a terminal: the peaks in tables of at most 78 columns, errors and warnings.

Numbers are for people: four digits, a readable unit for each row; all digits are in ``summary.json``.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from linkages.input.files.magnitudes import rounded
from linkages.input.files.writing import content_of
from linkages.results.shape import RunWarning, Summary, peaks_by_key
from linkages.results.warnings import relative
from linkages.show.plots.quantities import number, quantity, share
from linkages.show.plots.style import engineering
from linkages.show.report import words
from linkages.show.report.units import output_unit

WIDTH = 78  # columns
_CELL, _LABEL = 9, 18  # width of a number, least width of a label
_LEAST = 1e-4  # relative error that is told
_MULTIPLE = 2.0  # ratio from which a change is a multiple
#: Columns of a heat balance, and their headings.
_HEAT = ("temperature", "viscosity", "power", "by_flow", "by_conduction")
_HEAT_HEAD = ("T [degC]", "mu [Pa s]", "power [W]", "flow [W]", "cond. [W]")

Row = tuple[str, Sequence[Any], str]  # label, numbers or texts, remark below


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
    >>> print(linkages.format_summary(summary).splitlines()[0])
    Seven-bar press with two lubricated clearance joints       ok, 0.1 s, compiled
    """
    content = content_of(summary)
    return "\n".join([format_heading(content), format_table(content), *format_judgement(content)])


def format_heading(summary: Mapping[str, Any]) -> str:
    """Write title, status, duration and engine in one line, or in two."""
    experiment = summary["provenance"]["experiment"]
    title = experiment.get("title") or Path(experiment["file"]).stem
    state = f"{summary['status']}, {summary['duration']:g} s, {summary['engine']}"
    room = WIDTH - len(title) - len(state)
    return f"{title}{' ' * room}{state}" if room > 1 else f"{title}\n{state:>{WIDTH}s}"


def format_table(summary: dict[str, Any]) -> str:
    """Format the numbers of a summary as tables, each after an empty line; "-" is an undefined value."""
    shown = words.reported(summary)
    play = any(joint["model"] != "ideal" for joint in summary["joints"].values())
    blocks = [
        _joints(summary, shown),
        _outputs(summary, shown, "with clearance" if play else "integrated"),
        *_effects(summary),
        _heats(summary),
        *(_efforts(summary, shown, kind) for kind in ("drives", "loads")),
        _fluctuations(shown),
        _links(summary, shown),
        _measured(summary),
    ]
    mechanism = summary["mechanism"]
    about = [
        f"mobility {mechanism['mobility']}, driven: {', '.join(mechanism['driven']) or 'none'}",
        *words.motion_lines(summary),
        *words.recorded_lines(summary),
    ]
    return "\n".join([line for block in blocks for line in _lines(*block)] + ["", *about])


def _lines(head: Sequence[str], rows: Sequence[Row]) -> Iterator[str]:
    """Write a table: a long label has a line of its own, a remark one below its row."""
    if not rows:
        return
    wide = max(len(label) for label, *_ in [(head[0], (), ""), *rows])
    cell = max(_CELL, *(1 + len(name) for name in head[1:]))
    first = min(max(wide + 1, _LABEL), WIDTH - cell * max(len(cells) for _, cells, _ in rows))
    yield ""
    yield f"{head[0]:{first}s}{''.join(f'{name:>{cell}s}' for name in head[1:])}".rstrip()
    for label, cells, remark in rows:
        texts = "".join(f"{one if isinstance(one, str) else number(one):>{cell}s}" for one in cells).rstrip()
        if len(label) >= first:
            yield label
            label = ""
        yield f"{label:{first}s}{texts}"
        if remark:
            yield f"    {remark}"


def _whole(summary: dict[str, Any], key: str, unit: str) -> str:
    """Tell the peak of the whole run where it exceeds the table's."""
    found = words.beyond(summary, key, unit)
    return f"whole run: {found}" if found else ""


def _scaled(values: Sequence[float | None], si: str) -> tuple[str, list[float | None]]:
    """Choose a unit for a row, and write its values in it."""
    unit, factor = engineering(si, max((abs(value) for value in values if value is not None), default=0.0))
    return unit or "1", [None if value is None else factor * value for value in values]


def _outputs(summary: dict[str, Any], shown: dict[str, Any], run: str) -> tuple[Sequence[str], list[Row]]:
    rows: list[Row] = []
    for name, value in shown["outputs"].items():
        exact, si = words.perfect(shown)["outputs"][name], output_unit(name, shown["drives"])
        unit, cells = _scaled([exact["min"], exact["max"], value["min"], value["max"]], si)
        rows.append((f"{name} [{unit}]", cells, _whole(summary, f"{name}.peak", si)))
    return (f"output: ideal, {run}", "min", "max", "min", "max"), rows


def _joints(summary: dict[str, Any], shown: dict[str, Any]) -> tuple[Sequence[str], list[Row]]:
    perfect = words.perfect(shown)["joints"]
    peaks = [value["force"]["peak"] for value in shown["joints"].values() if value["force"]["peak"] is not None]
    unit, factor = engineering("N", max(peaks, default=0.0))
    rows: list[Row] = []
    if peaks and not any(peaks) and len(peaks) == len(shown["joints"]):  # as in gear pairs
        return ("joint force",), rows
    for name, value in shown["joints"].items():
        label = f"{name} ({value['model']})" if value["model"] != "ideal" else name
        label += f": {links}" if (links := words.meeting(summary, name)) else ""
        exact, force = perfect[name]["force"]["peak"], value["force"]
        sizes = [None if peak is None else factor * peak for peak in (exact, force["peak"])]
        ratio = value.get("eccentricity_ratio", {}).get("peak")
        cells = (*sizes, _change(force["peak"], exact), _at(force["time"]), "" if ratio is None else number(ratio, 3))
        rows.append((label, cells, _whole(summary, f"{name}.force.peak", "N")))
    return (f"joint force [{unit}]: links", "ideal", "now", "change", "at", "e/c"), rows


def _change(now: float | None, before: float | None) -> str:
    """Write the change of a peak against the ideal one, for a column."""
    if now is None or not before or before < words.NOTHING * now:
        return "-"
    ratio = now / before
    if ratio >= _MULTIPLE or ratio == 1.0:
        return f"{number(ratio, 3)} x" if ratio > 1.0 else "0 %"
    part = share(abs(ratio - 1.0))
    return part if part.startswith("<") else f"{'+' if ratio > 1.0 else '−'}{part}"


def _part(part: float | None) -> str:
    """Write a part of a whole, or a multiple, for a column."""
    return "-" if part is None else f"{number(part, 3)} x" if part >= _MULTIPLE else share(part)


def _at(time: float | None) -> str:
    return "-" if time is None else quantity(time, "s", 3)


def _effects(summary: dict[str, Any]) -> Iterator[tuple[Sequence[str], list[Row]]]:
    """Yield the tables of differences from ideal joints and of oil films."""
    shown = words.reported(summary)
    apart: list[Row] = []
    for name, value in shown.get("difference", {}).items():
        unit, (peak,) = _scaled([value["peak"]], output_unit(name, shown["drives"]))
        apart.append((f"{name} [{unit}]", (peak, _at(value["time"]), _part(value["share"])), ""))
    yield ("difference from ideal joints", "largest", "at", "of ideal"), apart
    film: list[Row] = []
    for name, joint in shown["joints"].items():
        if found := joint.get("film_thickness"):
            unit, (least,) = _scaled([found["min"]], "m")
            film.append((f"{name} [{unit}]", (least, _at(found["time"]), _part(found["share"])), ""))
    yield ("oil film", "thinnest", "at", "of c"), film


def _heats(summary: dict[str, Any]) -> tuple[Sequence[str], list[Row]]:
    heats = {name: joint["heat"] for name, joint in summary["joints"].items() if "heat" in joint}
    rows: list[Row] = [(name, [heat[key] for key in _HEAT], "") for name, heat in heats.items()]
    return ("oil (lumped heat balance)", *_HEAT_HEAD), rows


def _efforts(summary: dict[str, Any], shown: dict[str, Any], kind: str) -> tuple[Sequence[str], list[Row]]:
    rows: list[Row] = []
    for label, key, value, exact, si in words.effort_rows(shown, kind):
        unit, cells = _scaled([exact["peak"], value["peak"]], si)
        work, (done,) = _scaled([value["work"]], "J")
        joules = "-" if done is None else f"{number(done, 3)} {work}"
        cells_ = (*cells, _change(value["peak"], exact["peak"]), joules)
        rows.append((f"{label} [{unit}]", cells_, _whole(summary, key, si)))
    return (kind.removesuffix("s"), "ideal", "now", "change", "work"), rows


def _fluctuations(shown: dict[str, Any]) -> tuple[Sequence[str], list[Row]]:
    ideal = words.perfect(shown)["drives"]
    rows: list[Row] = [
        (f"{name} speed fluctuation [1]", (ideal[name].get("fluctuation"), value["fluctuation"]), "")
        for name, value in shown["drives"].items()
        if value.get("fluctuation") is not None
    ]
    return ("coefficient", "ideal", "now"), rows


def _links(summary: dict[str, Any], shown: dict[str, Any]) -> tuple[Sequence[str], list[Row]]:
    rows: list[Row] = []
    for column, rigid, value in words.link_rows(shown):
        unit, cells = _scaled([rigid, value["peak"]], output_unit(column))
        place = value.get("place")
        along = "" if place is None else quantity(place, "m", 3)
        rows.append((f"{column} [{unit}]", (*cells, _at(value["time"]), along), _whole(summary, f"{column}.peak", "")))
    return ("flexible link", "rigid", "now", "at", "place"), rows


def _measured(summary: dict[str, Any]) -> tuple[Sequence[str], list[Row]]:
    rows: list[Row] = []
    for name, value in summary.get("measured", {}).items():
        unit, cells = _scaled([value[key] for key in ("peak", "rms", "largest")], output_unit(name, summary["drives"]))
        rows.append((f"{name} [{unit}]", (*cells, _at(value["time"])), ""))
    return ("measured less computed", "peak", "rms", "largest", "at"), rows


def format_judgement(summary: dict[str, Any]) -> list[str]:
    """Write the sizes of the errors, and all warnings, as lines of text."""
    smoothing = words.smoothing_lines(summary)
    lines = ["", *smoothing] if smoothing else []
    below = [found for found in relative(peaks_by_key(summary), summary["error"]) if found[1] < 1.0]
    for key, part in below[:1]:  # peaks below their errors are zero, or named in a warning
        line = f"errors of the peaks, estimated: at most {share(max(part, _LEAST))} ({key})"
        if (until := summary.get("error_until")) is not None:
            line += f"; the run that estimates them ends at {rounded(until)} s, because the motion repeats itself"
        lines += ["", line]
    return lines + format_warnings(summary["warnings"])


def format_warnings(warnings: Sequence[RunWarning | Mapping[str, Any]], whose: str = "") -> list[str]:
    """Write warnings as lines of text, each after an empty line."""
    return [
        line for one in warnings for line in ("", f"warning{whose} ({one['kind']}): {one['what']}; {one['remedy']}")
    ]
