"""The tables of a report: captions, headings, cells; numbers as text."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import astuple
from typing import Any

from linkages.elements.element import Element
from linkages.elements.machine import KINDS, TABLES, all_elements_of
from linkages.elements.outputs import Source
from linkages.input.files.magnitudes import rounded
from linkages.input.files.table_keys import bracketed, table_keys
from linkages.input.files.toml import leaves
from linkages.input.files.unit_conversion import SLIDING
from linkages.input.model.experiment import Experiment, value_unit
from linkages.results.impacts import QUANTITIES
from linkages.show.plots.names import name_of_output, sentence
from linkages.show.plots.presentation import shown_unit
from linkages.show.plots.style import typeset
from linkages.show.report import words
from linkages.show.report.result_folder import Results
from linkages.show.report.tables import PageTable

_SHOWN = 40  # most contacts in the table
_FILES = {
    "summary.json": "the numbers of this page, SI units",
    "trajectory.npz": "every quantity at every step; read with linkages.load_trajectory",
    "ideal.npz": "every quantity at every step with ideal joints",
    "impacts.csv": "all contacts",
    "impacts_normal.csv": "normal part of the peak force of all contacts",
    "drawing.svg": "the mechanism with labels; linkages draw makes a movable one",
    "animation.html": "the animation on a separate page",
}


def numbers(results: Results) -> list[PageTable]:
    """Tabulate all numbers of a run."""
    first, *others = (
        table for make in (_outputs, _joints, _heats, _drives, _links, _measured) if (table := make(results))
    )
    return [first, *_effects(results), *others]


def _effects(results: Results) -> list[PageTable]:
    """Tabulate the differences from ideal joints, and the films where they are thinnest."""
    return [
        PageTable(
            f"{heading[0].upper()}{heading[1:]}",
            ("where", *names),
            [(name, number(value), number(time), share) for name, value, time, share in rows],
        )
        for (heading, *names), rows in words.effects(results.summary)
    ]


def _outputs(results: Results) -> PageTable:
    rows, shown = [], words.reported(results.summary)
    ideal = words.perfect(shown)
    for name, value in shown["outputs"].items():
        exact = ideal["outputs"][name]
        extremes = (exact["min"], exact["max"], value["min"], value["max"])
        judged = (words.change(value["peak"], exact["peak"]), error(results, f"{name}.peak"))
        label = f"{sentence(name_of_output(name))} [{words.unit(name, shown['drives'])}]"
        rows.append((label, *map(number, extremes), *judged, *_whole(results, f"{name}.peak")))
    head = (
        "output", "ideal min", "ideal max", "with clearance min", "with clearance max", "change of peak",
        "error of peak", *_whole(results),
    )  # fmt: skip
    return PageTable("Outputs", head, rows)


def _joints(results: Results) -> PageTable:
    rows, shown = [], words.reported(results.summary)
    ideal = words.perfect(shown)
    for name, value in shown["joints"].items():
        exact, force = ideal["joints"][name]["force"]["peak"], value["force"]
        ratio, inside = value.get("eccentricity_ratio"), value.get("contact_fraction")
        model = results.play.get(name, {}).get("model", "ideal")
        peaks = map(number, (exact, force["peak"], force["time"]))
        judged = (words.change(force["peak"], exact), error(results, f"{name}.force.peak"))
        most = number(ratio["peak"]) if ratio else words.NONE
        share = f"{100.0 * inside:.3g}" if inside is not None else words.NONE
        named = name, words.meeting(results.summary, name) or words.NONE, model
        rows.append((*named, *peaks, *judged, most, share, *_whole(results, f"{name}.force.peak")))
    head = (
        "joint", "links", "model", *(f"{kind} [{shown_unit('N')}]" for kind in ("ideal peak", "peak")), "at [s]",
        "change of peak", f"error of peak [{shown_unit('N')}]",
        "largest e/c", "in contact [% of time]", *_whole(results),
    )  # fmt: skip
    return PageTable("Joint forces and journals", head, rows, frozenset({0, 1, 2}))


def _drives(results: Results) -> PageTable | None:
    """Tabulate the drives that act; None without any."""
    rows, shown = [], words.reported(results.summary)
    for label, key, value, exact, si in words.effort_rows(shown, "drives"):
        judged = (words.change(value["peak"], exact["peak"]), error(results, key))
        peaks, work = (map(number, (exact[one], value[one])) for one in ("peak", "work"))
        rows.append((f"{label} [{shown_unit(si)}]", *peaks, *judged, *work, *_whole(results, key)))
    head = (
        "drive",
        "ideal peak",
        "peak",
        "change of peak",
        "error of peak",
        *(f"{kind} [{shown_unit('J')}]" for kind in ("ideal work", "work")),
    )
    return PageTable("Drives", (*head, *_whole(results)), rows) if rows else None


def _heats(results: Results) -> PageTable | None:
    """Tabulate the heat balances of the oil; None without any."""
    found = {name: joint["heat"] for name, joint in results.summary["joints"].items() if "heat" in joint}
    names = ("temperature", "viscosity", "power", "flow", "by_flow", "by_conduction")
    rows = [(name, *(number(heat[key]) for key in names)) for name, heat in found.items()]
    head = (
        "joint", "temperature [°C]", "viscosity [Pa s]", "power of the film [W]", "flow out of the ends [m³/s]",
        "heat by flow [W]", "heat by conduction [W]",
    )  # fmt: skip
    return PageTable("Oil temperature: lumped heat balance of a cycle", head, rows) if rows else None


def _links(results: Results) -> PageTable | None:
    """Tabulate deflections, bending moments and stresses of flexible links; None without any."""
    rows, shown = [], words.reported(results.summary)
    for column, rigid, value in words.link_rows(shown):
        key, values = f"{column}.peak", map(number, (rigid, value["peak"], value["time"], value.get("place")))
        label = f"{sentence(name_of_output(column))} [{words.unit(column, {})}]"
        rows.append((label, *values, error(results, key), *_whole(results, key)))
    head = ("link", "rigid links", "peak", "at [s]", f"place along the beam [{shown_unit('m')}]", "error of peak")
    return PageTable("Flexible links", (*head, *_whole(results)), rows) if rows else None


def _measured(results: Results) -> PageTable | None:
    """Tabulate the residuals of measured curves; None without any."""
    keys = ("peak", "rms", "largest", "time")
    found = results.summary.get("measured", {})
    rows = [
        (sentence(name_of_output(name)), one["column"], str(one["rows"]), *(number(one[key]) for key in keys))
        for name, one in found.items()
    ]
    head = ("output", "column", "samples", "measured peak", "rms difference", "largest difference", "at [s]")
    return PageTable("Measured less computed", head, rows, frozenset({0, 1})) if rows else None


def parameters(results: Results) -> PageTable:
    """Tabulate every value of the experiment with its unit, its meaning and its source."""
    meanings, rows = dict(table_keys(Experiment)), []
    for path, value in leaves(results.experiment):
        if path in ("mechanism", "title", "outputs"):
            continue
        si, meaning = _si_unit(results, path), _meaning(path, meanings)
        source, meaning = _source(results.source_of(path), si), meaning.replace(f" [{bracketed(meaning)}]", "")
        rows.append((path, _plain(value), words.NONE if si in ("", "1") else typeset(si), meaning, source))
    head = ("parameter", "value", "unit", "meaning", "source, from the file")
    return PageTable("Parameters of the experiment", head, rows, frozenset({0, 2, 3, 4}))


def impacts(results: Results) -> PageTable | None:
    """Tabulate the hardest contacts in the order of time; None if no joint could touch."""
    if results.impacts is None:
        return None
    hardest = sorted(results.impacts, key=lambda row: -row.peak_force)[:_SHOWN]
    caption = f"Contacts, {len(results.impacts)} in all"
    if len(results.impacts) > len(hardest):
        caption += f"; the {_SHOWN} hardest are shown; impacts.csv has all"
    if turning := _turning(results):
        caption += f"; of {', '.join(turning)} angles and torques: read rad for m and N m for N"
    head = ("joint", *(shown.head for shown in QUANTITIES.values()))
    rows = []
    for joint, *values in (astuple(row) for row in sorted(hardest, key=lambda row: row.start)):
        scaled = (shown.scale * value for shown, value in zip(QUANTITIES.values(), values, strict=True))
        rows.append((joint, *(words.NONE if math.isnan(value) else number(value) for value in scaled)))
    return PageTable(caption, head, rows)


def _turning(results: Results) -> list[str]:
    """Name the elements whose contacts are in the table with angles and torques."""
    loads = results.summary.get("loads", {})
    tables = {table: results.experiment.get(table, {}) for table in TABLES}
    parts = all_elements_of(tables, (kind for kind in KINDS if kind.derived is None))
    return [
        name for kind, name, given in parts if "impacts" in loads.get(name, {}) and _gives(kind, given, loads[name])
    ]


def _gives(kind: Element[Any], given: Mapping[str, Any], load: Mapping[str, Any]) -> bool:
    """Tell whether the contacts of an element give torques; `load` are its numbers."""
    outputs = kind.outputs_of(kind.keys.model_validate(given), lambda joint: "torque" not in load)
    return any(one.effort == "torque" for one in outputs if one.source is Source.CONTACT)


def provenance(results: Results) -> PageTable:
    """Tabulate the provenance of the numbers."""
    summary, made = results.summary, results.summary["provenance"]
    rows = [
        ("experiment", results.source),
        ("mechanism", str(results.experiment["mechanism"])),
        ("engine", summary["engine"]),
        ("duration", f"{number(summary['duration'])} s, status {summary['status']}"),
        ("time to compute", f"{made['wall_time']:.3g} s for the run alone"),
    ]
    rows += [
        (name.replace("_", " "), f"{value:g}" if isinstance(value, int | float) else str(value))
        for name, value in made["run"].items()
        if name != "engine"
    ]
    rows += [(f"version of {name}", str(value)) for name, value in made["versions"].items()]
    return PageTable("Provenance", ("what", "value"), rows, frozenset({0, 1}))


def files(results: Results) -> PageTable:
    """Tabulate the present and missing files of the folder."""
    rows = []
    for name, meaning in _FILES.items():
        path = results.folder / name
        rows.append((name, meaning, f"{path.stat().st_size / 1e3:.0f} kB" if path.is_file() else "missing"))
    return PageTable("Files in the folder of this page", ("file", "content", "size"), rows, frozenset({0, 1}))


def number(value: float | None) -> str:
    """Write a number with three significant digits; None gives a dash."""
    return words.NONE if value is None else rounded(value).replace("-", "−")


def error(results: Results, key: str) -> str:
    """Write the error of a peak, if an estimate exists."""
    errors = words.reported(results.summary).get("error", {})
    if errors.get(key) is None:
        return words.NONE if key in errors else "not estimated"
    found = errors[key]
    return f"{found:.1e}".replace("-", "−") if found else "0"


def _whole(results: Results, key: str = "") -> tuple[str, ...]:
    """Return the cell with a larger peak of the whole run, or its heading; empty if no peak is larger."""
    if not words.exceeded(results.summary):
        return ()
    return (words.beyond(results.summary, key) or words.NONE if key else "whole run",)


def _plain(value: Any) -> str:
    """Write a parameter in short form; the file at the end of the page has every digit."""
    if isinstance(value, list):
        return f"[{', '.join(_plain(item) for item in value)}]"
    if isinstance(value, float):
        return f"{value:.6g}".replace("-", "−")
    return value if isinstance(value, str) else words.toml_value(value)


def _si_unit(results: Results, path: str) -> str:
    """Return the SI unit of a parameter; for a prismatic joint m, not rad, and N, not N m."""
    table, name, *_ = [*path.split("."), ""]
    of_drive = results.summary["drives"].get(name, {}).get("unit") if table == "drives" else None
    slides = of_drive == "N" or (
        table not in ("drives", "joints") and "force" in results.summary.get("loads", {}).get(name, {})
    )
    return SLIDING.get(unit := value_unit(path), unit) if slides else value_unit(path)


def _source(comment: str, si: str) -> str:
    """Return the source that a comment of the file names, without a leading unit."""
    first, _, rest = comment.partition(",")
    if si and first.strip() in (si, typeset(si)):
        comment = rest.strip()
    return comment or "not given"


def _meaning(path: str, meanings: dict[str, str]) -> str:
    """Look a key up; ``NAME`` in the list of keys stands for any drive, joint or load."""
    parts = path.split(".")
    general = (".".join([*parts[:k], "NAME", *parts[k + 1 :]]) for k in range(len(parts)))
    unknown = "value of the SDF file, replaced" if parts[0] == "sdf" else ""
    return next((meanings[key] for key in (*general, path) if key in meanings), unknown)
