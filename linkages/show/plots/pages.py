"""HTML pages from templates, which need no network; curves of a run for them, reduced without losing peaks."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from importlib.resources import files
from types import MappingProxyType
from typing import Any, cast

import numpy as np
from jinja2 import Environment, StrictUndefined
from markupsafe import Markup
from numpy.typing import NDArray

from linkages.base import palette
from linkages.base.arrays import Array
from linkages.base.palette import repainted
from linkages.input.files.writing import json_text
from linkages.results.trajectory import Trajectory
from linkages.show.naming import output_in_words
from linkages.show.plots.presentation import shown, shown_unit

_HEAD = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{policy}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>{title}</title>
"""
#: Pages load nothing. Those with an animation in a frame also read the data that it contains.
POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:; base-uri 'none';"
    " form-action 'none'"
)
FRAME_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval'; style-src 'unsafe-inline'; img-src data: blob:;"
    " connect-src data: blob:; worker-src blob:; frame-src 'self'; base-uri 'none'; form-action 'none'"
)
_DIGITS = 7  # of numbers: enough for a curve that is enlarged a thousand times


def own_text(package: str, name: str) -> str:
    """Read a file of a package."""
    return (files(package) / name).read_text(encoding="utf-8")


def filled(template: str, **values: Any) -> str:
    """Fill a template: texts are escaped unless they are `Markup`, and a missing value is an error.

    ``{{ head(title) }}`` begins a page, with the policy of what it may load, up to its style.
    """
    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True
    )
    environment.globals["head"] = lambda title, policy=POLICY: Markup(_HEAD).format(title=title, policy=policy)
    return environment.from_string(template).render(values)


def embedded(content: Any) -> Markup:
    """Write JSON for embedding in a page: its text cannot end the script element."""
    return Markup(json_text(content).strip().replace("<", "\\u003c"))


def columns(outputs: Iterable[str], play: Iterable[str], actuators: Iterable[str]) -> list[str]:
    """Return the names of the main columns: outputs, forces in clearance joints, torques of drives and motors."""
    others = *(f"{name}.force" for name in play), *(f"{name}.torque" for name in actuators)
    return [*dict.fromkeys([*outputs, *others])]


def curves(
    names: Iterable[str],
    run: Trajectory,
    ideal: Trajectory | None,
    errors: Mapping[str, float],
    intervals: int = 800,
    measured: Mapping[str, tuple[Array, Array]] = MappingProxyType({}),
) -> list[dict[str, Any]]:
    """Return columns over time for `curves.js`; missing columns are skipped.

    Each curve has `name`, `label` (in words), `unit`, and `run`, `ideal` and `measured` (None if missing), each with
    `time` [s] and `values`; `measured` has the times and values of measured curves. Variations of a column below its
    error are not drawn; see `seen` for the intervals. Empty for a run of a single sample.
    """
    if len(run.time) < 2:
        return []
    return [
        {"name": name, "label": output_in_words(name), "unit": shown_unit(run.units.get(name, ""))}
        | {"run": _drawn(run, name, errors, intervals)}
        | {"ideal": _drawn(ideal, name, errors, intervals)}
        | {"measured": _reduced(*measured[name], intervals, run.units.get(name, "")) if name in measured else None}
        for name in dict.fromkeys([*names, *measured])
        if name in run.columns
    ]


def drawn_errors(errors: Mapping[str, float | None], noise: Mapping[str, float]) -> dict[str, float]:
    """Return the error of each column, by the key of its peak in `errors` if there is one, at least its rounding."""
    return {name: max(errors.get(f"{name}.peak") or 0.0, least) for name, least in noise.items()}


def resolved(values: Array, error: float) -> Array:
    """Return values, or a constant if they vary by less than their error: noise is not drawn as a motion."""
    low, high = float(np.fmin.reduce(values)), float(np.fmax.reduce(values))  # NaN is not drawn
    if not high - low <= 2.0 * error:
        return values
    middle = 0.5 * (low + high)
    return np.where(np.isfinite(values), middle if abs(middle) > error else 0.0, values)


def script(*names: str) -> str:
    """Return scripts that pages share, as JavaScript: curves, moving shapes, or those with given names."""
    return "".join(own_text("linkages.show.plots", f"{name}.js") for name in names or ("curves", "moves"))


def shared_style(holder: str = "") -> str:
    """Return the style that all pages share, of an element with a selector, by default of the page."""
    rules = own_text("linkages.show.plots", "base.css")
    return f"{holder} {{\n{rules}}}\n" if holder else rules


def page_style(own: str = "") -> Markup:
    """Return the style of a page: colours, text, curves, drawings, and rules of its own."""
    text = own_text("linkages.show.plots", "page.css")
    return Markup("\n".join([palette.css(), shared_style(), text, repainted(".picture "), own]))


def seen(time: Array, values: Array, intervals: int) -> NDArray[np.int64]:
    """Choose samples (k,) that draw the same curve: first, smallest and largest of each of equal time intervals."""
    piece = np.searchsorted(np.linspace(time[0], time[-1], intervals + 1)[1:-1], time, side="right")
    starts = np.flatnonzero(np.diff(piece, prepend=-1))
    by_value = np.lexsort((np.nan_to_num(values), piece))  # in each interval from the smallest to the largest
    ends = np.append(starts[1:], len(time)) - 1
    return np.unique(np.concatenate([[0, len(time) - 1], starts, by_value[starts], by_value[ends]]))


def _drawn(
    run: Trajectory | None, name: str, errors: Mapping[str, float], intervals: int
) -> dict[str, list[float | None]] | None:
    if run is None or name not in run.columns:
        return None
    return _reduced(run.time, resolved(run[name], errors.get(name, 0.0)), intervals, run.units.get(name, ""))


def _reduced(time: Array, values: Array, intervals: int, si: str) -> dict[str, list[float | None]]:
    keep = seen(time, values, intervals)
    return {"time": short(time[keep]), "values": short(shown(si)[1] * values[keep])}


def short(values: Array) -> list[Any]:
    """Return an array as nested lists of numbers with `_DIGITS` digits of the largest; None for non-finite numbers."""
    finite = np.isfinite(values)
    largest = float(np.abs(values[finite]).max(initial=0.0))
    rounded: Any = np.round(values, min(_DIGITS - 1 - math.floor(math.log10(largest or 1.0)), 300))
    if not finite.all():
        rounded = rounded.astype(object)
        rounded[~finite] = None
    return cast(list[Any], rounded.tolist())
