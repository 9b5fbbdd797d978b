"""Words of tables and reports: units, changes, the final motion, and the commands that repeat the run."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import reduce
from operator import getitem
from typing import Any

import tomlkit

from linkages.base.errors import ARGUMENT, COMMAND_LINE, Status, listed
from linkages.input.files.magnitudes import rounded
from linkages.results.shape import peaks_by_key
from linkages.show.plots.names import name_of_output, sentence
from linkages.show.plots.presentation import shown_unit
from linkages.show.plots.style import typeset
from linkages.show.report.result_folder import Results
from linkages.show.report.units import output_unit

NONE = "–"  # symbol of an undefined value
_COMPARED = "outputs", "joints", "drives", "loads"  # numbers that the ideal linkage has too
_ALIKE = 1e-3  # relative difference from the steady cycle's peak that is neglected
_SAME = 1e-4  # relative change that is neglected
_NAMED = 6  # most names in a sentence
#: Why quantities have no value, by the kind of the warning.
_VALUELESS = {"indeterminate": "statically indeterminate", "singular": "unbounded"}
NOTHING = 1e-9  # relative value below which a difference is rounding


def reported(summary: dict[str, Any]) -> dict[str, Any]:
    """Return the numbers for the tables: of the reported window, or of the whole run."""
    return summary.get("windows", {}).get(summary.get("report"), summary)


def perfect(shown: dict[str, Any]) -> dict[str, Any]:
    """Return the numbers with ideal joints for the `reported` ones; without an ideal motion each has no value."""
    ideal: dict[str, Any] | None = shown["ideal"]
    return _emptied({kind: shown.get(kind, {}) for kind in _COMPARED}) if ideal is None else ideal


def _emptied(content: Any) -> Any:
    if isinstance(content, dict):
        return {key: _emptied(value) for key, value in content.items()}
    return content if isinstance(content, str) else None


def unknown(peaks: Mapping[str, float | None]) -> list[str]:
    """Name the quantities without a value, which is not zero."""
    return [name for name, peak in peaks.items() if peak is None]


def some(names: Sequence[str]) -> str:
    """List names, of many the first ones."""
    return listed(names if len(names) <= _NAMED else [*names[: _NAMED - 1], f"{len(names) - _NAMED + 1} more"])


def reason(warnings: Iterable[Mapping[str, Any]], count: int = 1) -> str:
    """Tell why quantities have no value, by the kinds of a run's warnings: "are unbounded"."""
    kinds = {one["kind"] for one in warnings}
    why = [words for kind, words in _VALUELESS.items() if kind in kinds]
    if not why:
        return "has no value" if count == 1 else "have no value"
    return f"{'is' if count == 1 else 'are'} {' or '.join(why)}"


def beyond(summary: dict[str, Any], key: str, of: str = "") -> str:
    """Write value, unit and time of a peak of the whole run if it exceeds the tables' peak; otherwise ""."""
    shown, owner, _, effort = reported(summary), *key.removesuffix(".peak").rpartition(".")
    found: list[dict[str, Any]] = []
    for numbers in (shown, summary):
        kinds = [numbers.get(kind, {}).get(owner, {}) for kind in ("joints", "drives", "loads", "links")]
        kinds.insert(0, {effort: entry} if (entry := numbers["outputs"].get(f"{owner}.{effort}")) else {})
        found.append(next((each[effort] for each in kinds if effort in each), {"peak": None}))
    inside, whole = found
    if inside["peak"] is None or whole["peak"] is None or "time" not in whole:
        return ""
    if whole["peak"] <= (1.0 + _ALIKE) * inside["peak"]:
        return ""
    during = " (start-up)" if whole["time"] < (summary.get("start_up") or 0.0) else ""
    return f"{rounded(whole['peak'])} {of}".rstrip() + f" at {rounded(whole['time'])} s{during}"


def meeting(summary: dict[str, Any], joint: str) -> str:
    """Name the links of a joint, the bearing's first; empty if the summary does not have them."""
    return ", ".join(summary.get("mechanism", {}).get("joints", {}).get(joint, ()))


def effects(summary: dict[str, Any]) -> Iterator[tuple[tuple[str, ...], list[tuple[str, float, float, str]]]]:
    """Yield tables of the effects of clearance: headings, and rows of name, value, time [s] and share."""
    shown, apart, film = reported(summary), [], []
    for name, value in shown.get("difference", {}).items():
        unit = shown_unit(output_unit(name, shown["drives"]))
        label = f"{sentence(name_of_output(name))} [{unit}]"
        apart.append((label, value["peak"], value["time"], percent(value["share"])))
    for name, joint in shown["joints"].items():
        if found := joint.get("film_thickness"):
            film.append((f"{name} [{shown_unit('m')}]", found["min"], found["time"], percent(found["share"])))
    if apart:
        yield ("difference from ideal joints, after the start", "largest", "at [s]", "of ideal"), apart
    if film:
        yield ("oil film", "thinnest", "at [s]", "of clearance"), film


def percent(part: float | None) -> str:
    """Write a part in per cent with two digits, or as a multiple; "-" if there is no whole."""
    if part is None:
        return "-"
    return f"{float(f'{100.0 * part:.2g}'):g} %" if part < 1.995 else f"{part:.3g} times"


def link_rows(shown: dict[str, Any]) -> Iterator[tuple[str, float | None, dict[str, Any]]]:
    """Yield column, peak with rigid links, and entry of each quantity of the flexible links."""
    for name, entry in shown.get("links", {}).items():
        rigid = perfect(shown).get("links", {}).get(name, {})
        for quantity, found in entry.items():
            exact = None if quantity == "deflection" else rigid.get(quantity, {}).get("peak")
            yield f"{name}.{quantity}", exact, found


def effort_rows(shown: dict[str, Any], kind: str) -> Iterator[tuple[str, str, dict[str, Any], dict[str, Any], str]]:
    """Yield label, key of the peak, entry, entry with ideal joints, SI unit of the "drives" or "loads" that act."""
    for name in (name for name, entry in shown.get(kind, {}).items() if entry.get("acts", True)):
        entry = shown[kind][name]
        quantity = "torque" if "torque" in entry else "force"
        unit = entry.get("unit", "N m" if quantity == "torque" else "N")  # the force of a drive is its torque's entry
        value, exact = ({**one[quantity], "work": one["work"]} for one in (entry, perfect(shown)[kind][name]))
        yield f"{name} {'force' if unit == 'N' else 'torque'}", f"{name}.{quantity}.peak", value, exact, unit


def exceeded(summary: dict[str, Any]) -> bool:
    """Check whether the whole run has a larger force, torque, stress or output than the tables."""
    return any(beyond(summary, key) for key in peaks_by_key(summary) if not key.endswith(".eccentricity_ratio.peak"))


def recorded_lines(summary: dict[str, Any]) -> list[str]:
    """Describe the signals from data files and how they are smoothed."""
    return [
        f"signal of {path}: {signal['file']}, {fit['rows']} rows, {fit['text']},"
        f" residual {fit['residual']:.2g} (stated deviation {fit['deviation']:.2g})"
        for path, signal in summary.get("recorded", {}).items()
        for fit in signal["fits"]
    ]


def smoothing_lines(summary: dict[str, Any]) -> list[str]:
    """Describe the largest change of a peak force or torque with other smoothing of signals from data files."""
    found = []
    for name, ratios in summary.get("smoothing", {}).items():
        if not ratios:  # no force has a value
            continue
        key, ratio = max(ratios.items(), key=lambda one: abs(one[1] - 1.0))
        found.append(
            f"{name} smoothing changes the peaks of forces by at most {100.0 * abs(ratio - 1.0):.2g} % ({key})"
        )
    return found


def motion_lines(summary: dict[str, Any]) -> list[str]:
    """Describe the final motion of the run, and the time range of the numbers."""
    motion, shown = summary.get("motion"), reported(summary)
    if motion is None or motion["kind"] is None:
        play = any(joint["model"] != "ideal" for joint in summary["joints"].values())
        lines = [f"no search for a steady cycle: {motion['why']}"] if motion and play else []
    elif motion["kind"] == "periodic":
        several = "" if motion["periods"] == 1 else f" in {motion['periods']} periods of the drives"
        lasts = rounded(motion["period"] * motion["periods"])
        lines = [f"the motion is periodic{several}, {lasts} s, from {rounded(motion['since'])} s on"]
    else:
        remedy = "; use a longer duration" if motion["kind"] == "not settled" else ""
        lines = [f"the motion is {motion['kind']}: {motion['why']}{remedy}"]
    if no_ideal := summary.get("no_ideal"):
        lines.append(f"no linkage with ideal joints to compare with: {no_ideal}")
    until = summary.get("start_up")
    why = "journals cross their clearances from the middle, and impacts or films stop them"
    if until is not None and until < summary["duration"]:
        lines.append(f"start-up: up to {rounded(until)} s {why}")
    elif until is not None:
        remedy = 'use a longer duration, or start = "equilibrium"'
        lines.append(f"start-up: {why} during the whole run, and its peaks belong to the start-up; {remedy}")
    if shown is not summary:
        part = {"steady": "its last period", "later": "the run after its start-up"}.get(summary["report"], "the run")
        said = f"the numbers belong to {part}, {shown['from']:.6g} to {shown['to']:.6g} s"
        lines.append(f'{said}; larger peaks of the rest of the run: see "whole run"' if exceeded(summary) else said)
    return lines


def commands(results: Results) -> list[str]:
    """Write the commands that repeat the run and this page."""
    summary = results.summary
    out = f"results/{results.folder.resolve().name}"
    words = simulation(summary, results.source, {})
    if not summary["error"] and summary["status"] == Status.OK.value:
        words.append("--no-error-estimate")
    return [shlex.join([*words, "--out", out]), shlex.join(["linkages", "report", out])]


def simulation(summary: dict[str, Any], file: str, values: dict[str, Any]) -> list[str]:
    """Write the command that repeats the run of an experiment's file with other values, by dotted path, as words."""
    given = summary["provenance"]["experiment"]
    values = {path: reduce(getitem, path.split("."), given) for path in overrides(summary)} | values
    settings = [word for path, value in values.items() for word in ("--set", f"{path}={toml_value(value)}")]
    return ["linkages", "simulate", file, "--engine", summary["engine"], *settings]


def about_curves(results: Results) -> str:
    """Tell how the curves are read."""
    said = "The line follows the animation. The wheel zooms in time, dragging moves, a click takes the animation there."
    if not results.play:
        return said
    return (
        f"{said} A curve that begins with a vertical line shows the start: journals begin where `offset` puts them, in"
        " the middle of their bearings by default, and first find their place; zoom in to see it."
    )


def about_numbers(results: Results) -> str:
    """Tell which numbers the tables have, and their errors."""
    said = (
        "Extremes are those of continuous time; a peak is the largest magnitude. Ideal joints: the same linkage without"
        " clearance. Numbers have three digits here, all of them in summary.json, in SI units."
    )
    if not results.summary["error"]:
        return f"{said} The errors of this run were not estimated."
    said += " The error of a peak is its change when the run is repeated at a ten times tighter tolerance."
    if any(joint.get("model") == "dry" for joint in results.play.values()):
        said += (
            " Dry joints are chaotic: once the two runs have parted, their difference says nothing about the accuracy"
            " of either."
        )
    return said


def about_parameters(results: Results) -> str:
    """Tell where the sources of values stand."""
    return (
        "The source of a value is the comment after it in the experiment's file. Lengths, masses and bearings are those"
        f" of {results.experiment['mechanism']}, which gives their sources too."
    )


def about_commands(results: Results) -> str:
    """Tell where the commands run."""
    files = f"{results.source} and {results.experiment['mechanism']}"
    return f"In a folder with {files} (files that come with the package are found by their names):"


def overrides(summary: dict[str, Any]) -> list[str]:
    """List the dotted paths of the values that were replaced on the command line or in Python."""
    sources = summary["provenance"]["sources"]
    return [path for path, source in sources.items() if source in (ARGUMENT, COMMAND_LINE)]


def experiment_file(results: Results) -> str:
    """Return the experiment of the run as a TOML file, with replaced values."""
    return tomlkit.dumps(results.experiment)


def toml_value(value: Any) -> str:
    """Write a value as in a TOML file, on one line."""
    if isinstance(value, dict):
        table = tomlkit.inline_table()
        table.update(value)
        return table.as_string()
    return tomlkit.item(value).as_string()


def unit(output: str, drives: Mapping[str, Any]) -> str:
    """Return the shown, typeset unit of an output: m/s²; `drives` are the summary's."""
    return typeset(shown_unit(output_unit(output, drives)))


def change(value: float | None, reference: float | None) -> str:
    """Write the relative change of a magnitude against its reference, if both have a value."""
    if value is None or reference is None:
        return NONE
    if value == reference:
        return "unchanged"
    if abs(reference) < NOTHING * abs(value):
        return "there is none"
    ratio = value / reference
    if abs(ratio - 1.0) < _SAME:
        return f"within {100.0 * _SAME:g} %"
    if 0.5 < ratio < 2.0:
        return f"{100.0 * (ratio - 1.0):+.2g} %".replace("-", "−")
    return f"{ratio:.3g} times"
