"""Tables of studies for reports, as data: the best design, what was identified, tolerances, shares of a variance."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from linkages.show.plots.names import name_of_value, sentence
from linkages.show.plots.quantities import change, number, share, uncertain
from linkages.show.report.tables import PageTable, measured
from optim.identify.result import IdentificationResult
from optim.problem.study import Study
from optim.search.result import StudyResult
from optim.search.tolerance_result import QuantityStatistics, ToleranceResult

_AT = 1e-3  # distance from a bound over the range of a variable up to which it is at its bound

Tiles = list[tuple[str, str]]


def optimised(study: Study, result: StudyResult) -> tuple[Tiles, list[PageTable]]:
    """Tabulate the nominal and the best design; the tiles are the objectives."""
    best, nominal = result.best, result.nominal
    which = "compromise" if result.front else "best"
    rows = []
    for k, path in enumerate(study.paths):
        si = study.points[0].system.value_unit(path)
        values = nominal.variables[path], best.variables[path], study.lower[k], study.upper[k]
        rows.append(
            (sentence(name_of_value(path)), path, *(measured(one, si) for one in values), _bound(study, result, k))
        )
    head = ("variable", "path", "nominal", which, "lower", "upper", "at a bound")
    tables = [PageTable("Design", head, rows, frozenset({0, 1, 6}))]
    tiles: Tiles = []
    for kind in ("objectives", "constraints"):
        lines = []
        for name, value in best[kind].items():
            before, unit = nominal[kind][name], study.unit(name)
            told = "" if value is None or before is None else change(value, before, "nominal")
            lines.append((name, measured(before, unit), measured(value, unit), told or "-"))
            if kind == "objectives":
                tiles.append((measured(value, unit), f"{name}, {which} design" + (f"; {told}" if told else "")))
        if lines:
            tables.append(PageTable(sentence(kind), (kind[:-1], "nominal", which, "change"), lines, frozenset({0, 3})))
    if result.designs:
        known = [
            (name, *(measured(one.objectives[key], study.unit(key)) for key in best.objectives))
            for name, one in result.designs.items()
        ]
        tables.append(PageTable("Reference designs", ("design", *best.objectives), known))
    tiles.append((f"{result.evaluations:,}", f"evaluations, {result.failed} failed"))
    return tiles, tables


def _bound(study: Study, result: StudyResult, k: int) -> str:
    """Name the bound at which a variable of the best design is."""
    value, low, high = result.best.variables[study.paths[k]], study.lower[k], study.upper[k]
    near = {"lower": low, "upper": high}
    return next((name for name, end in near.items() if abs(value - end) <= _AT * (high - low)), "-")


def identified(found: IdentificationResult) -> tuple[Tiles, list[PageTable]]:
    """Tabulate the values that were found; the tiles are the first ones."""
    rows, tiles = [], []
    for one in found["parameters"].values():
        si, name = one["unit"] or "1", sentence(name_of_value(one["path"]))
        known = one["identifiable"] and one["deviation"]
        value = uncertain(one["value"], one["deviation"], si) if known else measured(one["value"], si)
        interval = " to ".join(measured(end, si) for end in one["interval"]) if one["interval"] else "not identifiable"
        rows.append((name, one["path"], value, interval))
        tiles.append((value if known else "unknown", name if known else f"{name}: not identifiable"))
    residual = found["residual"]
    fit = [
        (column, *(number(one) for one in numbers))
        for column, *numbers in zip(
            *(residual[key] for key in ("columns", "rms", "deviation", "chi_square")), strict=True
        )
    ]
    head = ("column", "rms of the residual", "stated deviation", "chi-square")
    return tiles[:4], [
        PageTable("Values", ("value", "path", "found", "95 % interval"), rows, frozenset({0, 1})),
        PageTable("Residuals", head, fit),
    ]


def tolerated(study: Study, result: ToleranceResult) -> tuple[Tiles, list[PageTable]]:
    """Tabulate the quantities of scattering machines, shares of their variances, and yields of halved tolerances."""
    found = result["yield"]
    low, high = (share(one) for one in found["interval"])
    tiles = [(share(found["value"]), f"of {result['samples']:,} machines meet all limits ({low} to {high})")]
    outputs = {name: one for name, one in result["outputs"].items() if one.mean is not None}
    rows = [(name, *_moments(one, study.unit(name)), _limits(result, name, one)) for name, one in outputs.items()]
    head = ("quantity", "mean", "deviation", "90 % of the machines", "beyond its limit")
    tables = [PageTable("Quantities", head, rows)]
    known = {name: one.variance.of_values for name, one in outputs.items() if one.variance is not None}
    values = {name: sentence(name_of_value(path)) for name, path in zip(study.names, study.paths, strict=True)}
    if known:
        shares = [
            (words, *(f"{_share(one[name].first)}, {_share(one[name].total)}" for one in known.values()))
            for name, words in values.items()
        ]
        tables.append(PageTable("Share of the variance: alone, with others", ("value", *known), shares))
    halves = [
        (values.get(name, name), "-" if one.halved is None else share(one.halved))
        for name, one in result["contributions"].items()
    ]
    if halves:
        tables.append(PageTable("Yield with half a tolerance", ("tolerance of", f"yield, now {tiles[0][0]}"), halves))
        name, best = halves[0]
        tiles.append((best, f"yield with half the tolerance of the {name[:1].lower()}{name[1:]}"))
    return tiles, tables


def _moments(one: QuantityStatistics, si: str) -> tuple[str, str, str]:
    ends = (one["quantiles"][key][0] for key in ("0.05", "0.95"))
    return measured(one.mean, si), measured(one.deviation, si, 3), " to ".join(measured(end, si) for end in ends)


def _limits(result: ToleranceResult, name: str, one: QuantityStatistics) -> str:
    told = [share(result["violated"][f"{name}.{key}"] / result["samples"]) for key in one["limits"]]
    return ", ".join(told) or "-"


def explained(study: Study, report: Mapping[str, Any]) -> tuple[Tiles, list[PageTable]]:
    """Tabulate Sobol's indices of all quantities, from the content of ``sensitivity.json``."""
    tables, tiles = [], []
    for name, entry in report["quantities"].items():
        rows = []
        for path, one in entry["variables"].items():
            cells = (_between(one[kind], one[f"{kind}_confidence"]) for kind in ("first", "total"))
            rows.append((sentence(name_of_value(path)), path, *cells, "yes" if one["inert"] else "-"))
        totals = {path: one["total"] for path, one in entry["variables"].items() if one["total"] is not None}
        if totals:
            most = max(totals, key=totals.__getitem__)
            tiles.append((share(min(totals[most], 1.0)), f"of the variance of {name}: {name_of_value(most)}"))
        head = ("variable", "path", "alone", "with interactions", "inert")
        tables.append(PageTable(f"{name}: shares of the variance, ± 95 %", head, rows, frozenset({0, 1, 4})))
    return tiles[:4], tables


def _between(value: float | None, half: float | None) -> str:
    return "-" if value is None or half is None else f"{value:.2f} ± {half:.2f}".replace("-", "−")


def _share(value: float | None) -> str:
    return "-" if value is None else share(min(max(value, 0.0), 1.0))
