"""Tables and contents of the files of ``linkages sweep``."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from linkages.explore.sections import Section
    from linkages.explore.sweep import SweepPoint

#: Numbers of each output at each point.
STATISTICS = ("min", "max", "peak_mean", "peak_std", "peak_min", "peak_max")


def statistics(point: SweepPoint, name: str) -> dict[str, float]:
    """Compute a column's extremes over all revolutions; mean, deviation and range of the revolutions' peaks.

    Undefined values are NaN: all values of a run that failed at once, the deviation of one revolution.
    """
    import numpy as np

    section = point.section
    if section is None or not len(section.times):
        return dict.fromkeys(STATISTICS, float("nan"))
    peaks = section.peaks(name)
    deviation = np.std(peaks, ddof=1) if len(peaks) > 1 else np.nan
    extremes = (section.low[name].min(), section.high[name].max())
    values = (*extremes, peaks.mean(), deviation, peaks.min(), peaks.max())
    return dict(zip(STATISTICS, map(float, values), strict=True))


def write_tables(
    paths: Mapping[str, str],
    rows: Sequence[tuple[Sequence[float], SweepPoint]],
    units: Mapping[str, str],
    horizons: bool,
    folder: Path,
) -> None:
    """Write ``sweep.csv`` and ``sweep.parquet``: a line for each point with its values; undefined numbers are empty.

    `paths` are the variables with their SI units, `units` the SI units of the outputs. Without pyarrow there is no
    Parquet file.
    """
    import numpy as np

    from linkages.show.plots.presentation import presentation, shown, shown_unit

    values, points = zip(*rows, strict=True)
    table: dict[str, Any] = {
        path: shown(si)[1] * column for (path, si), column in zip(paths.items(), np.array(values).T, strict=True)
    }
    table["status"] = np.array([point.status.value for point in points], dtype=object)
    table["revolutions"] = np.array([0 if point.section is None else len(point.section.times) for point in points])
    if horizons:
        table["horizon"] = np.array([point.horizon for point in points], dtype=np.float64)
    of_columns = {path: shown_unit(si) for path, si in paths.items() if si}
    for name, si in units.items():
        found = [statistics(point, name) for point in points]
        unit, factor = shown(si)
        for what in STATISTICS:
            table[f"{name}.{what}"] = factor * np.array([row[what] for row in found])
            of_columns[f"{name}.{what}"] = unit
    with open(folder / "sweep.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        named = of_columns if presentation().units else {}  # SI units are not named
        writer.writerow([f"{name} [{named[name]}]" if name in named else name for name in table])
        for row in zip(*(column.tolist() for column in table.values()), strict=True):
            writer.writerow(["" if cell != cell else cell for cell in row])
    if find_spec("pyarrow"):
        from linkages.input.files.table_formats import write_parquet

        write_parquet(folder / "sweep.parquet", table, of_columns, {})


def entry(point: SweepPoint) -> dict[str, Any]:
    """Return the value of a point, its status, its horizon, and every revolution."""
    found: dict[str, Any] = {"value": point.value, "status": point.status.value, "horizon": point.horizon}
    if (section := point.section) is not None:
        found |= {"period": section.period, "outputs": columns(section)}
    return found


def columns(section: Section) -> dict[str, dict[str, list[float]]]:
    """Return strobes, minima and maxima of each period, by output."""
    kinds = {"strobe": section.strobe, "min": section.low, "max": section.high}
    return {name: {kind: values[name].tolist() for kind, values in kinds.items()} for name in section.strobe}


def extremes_said(name: str, unit: str, peaks: Mapping[str, float]) -> str:
    """Tell the smallest and the largest peak of an output, and the places of both."""
    from linkages.show.plots.presentation import shown

    unit, factor = shown(unit)
    known = {place: factor * peak for place, peak in peaks.items() if peak == peak}
    if not known:
        return f"No run gives a peak of {name}."
    low, high = min(known, key=known.__getitem__), max(known, key=known.__getitem__)
    said = f"largest, {known[high]:.4g} {unit}, at {high}, and smallest, {known[low]:.4g} {unit}, at {low}"
    return f"The mean peak of {name} is {said}."


def some(count: int, most: int) -> list[int]:
    """Return at most so many indices, evenly spaced from the first to the last."""
    return sorted({round(k * (count - 1) / (most - 1)) for k in range(most)}) if count > most else list(range(count))
