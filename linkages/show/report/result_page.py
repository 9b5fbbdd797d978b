"""The page of a folder of any command but ``linkages simulate``, from its record, its figures and its animation."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from linkages.base.brief import counted
from linkages.results.file_shapes import Record, WearContent
from linkages.show.plots.style import typeset
from linkages.show.report.page import data_uri, described, report_page, write_page
from linkages.show.report.page_tables import number
from linkages.show.report.result_folder import PICTURES, read_json, read_page
from linkages.show.report.tables import PageTable, page_table

#: Question and results of a command; content of ``linkages wear``.
RECORD, WEAR = "record.json", "wear.json"

_MOVING = ("wear.html", "animation.html", "drawing.html")  # pages that move, of which one is shown
_HINT = "give the --out folder of a command"
_LENGTHS = (("volume", 1e9), ("depth", 1e6), ("play", 1e6))
WEAR_QUESTION = "How do the joints wear over the service life, and what does the wear change?"
_CAPTIONS = {
    "drawing": "The mechanism where its joints spread most: links, joints, drives and loads.",
    "wear_history": "Worn volume, depth and clearance; peaks of forces, torques and jitter over the initial peaks.",
    "sweep": "Peaks over the variable; where the motion does not repeat, of each revolution.",
    "branches": "Branches of periodic motions over the variable; unstable ones are dashed.",
    "bode": "Frequency response: magnitude and phase of each output for each input.",
    "matrix": "Change of each peak with 1 % of each value.",
    "mode_shapes": "Mode shapes with arbitrary amplitude.",
    "mode_frequencies": "Natural frequencies over the cycle.",
    "bearing_pressure": "Pressure in the film, unrolled.",
    "bearing_chart": "Chart of the bearing over the Sommerfeld number; the dot is the operating point.",
    "overlay": "The runs in one figure.",
    "fit": "Measured and computed samples, and their residuals.",
    "correlation": "Correlation of the values.",
    "windows": "Residuals over the windows that grow.",
    "profiles": "Rise of chi-square over each unknown, with the others fitted again.",
    "histograms": "Histograms of the scattering machines, with their limits.",
    "contributions": "Shares of the variance by tolerance.",
    "influence": "The machines over the two values that matter most.",
    "convergence": "Best value of each objective over the evaluations.",
    "front": "Pareto front.",
    "sobol": "Sobol's indices with their 95 % confidence intervals.",
    "one_at_a_time": "One variable at a time between its bounds; dashed: nominal.",
}


def write_result_report(folder: Path, path: Path) -> None:
    """Write the report of a folder with `RECORD` or `WEAR` atomically; InputError for other folders."""
    worn = read_json(folder / WEAR, WearContent, "give the --out folder of `linkages wear`") if is_worn(folder) else {}
    record: dict[str, Any] = {
        "question": WEAR_QUESTION,
        "words": [],
        "versions": {},
        "table": "",
        "tables": [],
        "tiles": [],
    }
    if (folder / RECORD).is_file() or not worn:
        record |= read_json(folder / RECORD, Record, _HINT)
    if worn:
        record |= {"title": f"{worn['title'] or worn['experiment']}: wear", "answer": wear_answer(worn)}
    words, out = record["words"], f"results/{folder.resolve().name}"
    found = sorted(one for one in folder.iterdir() if one.suffix in PICTURES)
    pictures = {one.stem: one for one in found}.values()  # a figure in two formats is shown once
    text = report_page(
        title=record["title"],
        question=record["question"],
        tiles=record["tiles"],
        remarks=record["answer"],
        text="" if worn else record["table"],
        tables=[_joints(worn), _peaks(worn), _stages(worn)] if worn else [page_table(one) for one in record["tables"]],
        animated="Growing pockets" if worn else "",
        animation=next((page for name in _MOVING if (page := read_page(folder / name)) is not None), None),
        figures=[
            {"caption": _caption(one.stem), "source": data_uri(one), "answer": described(one) or _caption(one.stem)}
            for one in pictures
        ],
        no_figures="there are no files in PNG or SVG format.",
        versions=[("The versions of the packages:", "\n".join(" ".join(one) for one in record["versions"].items()))],
        commands=[shlex.join(["linkages", *words, "--out", out]), shlex.join(["linkages", "report", out])]
        if words
        else [],
    )
    write_page(path, text)


def is_worn(folder: Path) -> bool:
    """Whether a folder has results of ``linkages wear``."""
    return (folder / WEAR).is_file()


def wear_answer(found: dict[str, Any]) -> list[str]:
    """Describe the wear of the joints in sentences."""
    told = [
        f"After {counted(found['cycles'], 'cycle')}, joint {name} has lost {1e9 * joint['volume']:.3g} mm³; its largest"
        f" depth of wear is {1e6 * joint['depth']:.3g} µm, its mean clearance {1e6 * joint['play']:.4g} µm instead of"
        f" {1e6 * joint['clearance']:.4g} µm."
        for name, joint in found["joints"].items()
    ]
    if found["status"] != "ok":
        told.append(f"The calculation ended there: {found['status']}.")
    told.append(
        f"Simulated: {counted(found['simulated_cycles'], 'cycle')} in {counted(len(found['blocks']), 'block')}; the"
        f" error of the depth in each jump between blocks was kept below {1e6 * found['tolerance']:.3g} µm."
    )
    return told


def _joints(found: dict[str, Any]) -> PageTable:
    scales = (*_LENGTHS, ("coefficient", 1e9), ("load_distance", 1.0))
    rows = [(name, *_scaled(joint, scales)) for name, joint in found["joints"].items()]
    head = ("joint", "volume [mm³]", "depth [µm]", "clearance [µm]", "k [mm³/(N m)]", "load times path [N m]")
    return PageTable("Worn joints", head, rows)


def _peaks(found: dict[str, Any]) -> PageTable:
    new, last = (found["blocks"][k]["peaks"] for k in (0, -1))
    units = found.get("units", {})
    rows = [
        (f"{name} [{typeset(units[name])}]" if name in units else name, number(value), number(last[name]))
        for name, value in new.items()
    ]
    return PageTable("Mean peaks of a cycle", ("output", "new", "worn"), rows)


def _stages(found: dict[str, Any]) -> PageTable:
    rows = [
        (f"{block['cycles']:,}", name, *_scaled(joint, _LENGTHS), number(1e6 * block["error"]))
        for block in found["blocks"]
        for name, joint in block["joints"].items()
    ]
    head = ("cycles", "joint", "volume [mm³]", "depth [µm]", "clearance [µm]", "error of the jump [µm]")
    return PageTable("Service life", head, rows, frozenset({0, 1}))


def _scaled(joint: dict[str, Any], scales: tuple[tuple[str, float], ...]) -> Iterator[str]:
    return (number(scale * joint[key]) for key, scale in scales)


def _caption(stem: str) -> str:
    kind, _, name = stem.partition("_")
    if stem in _CAPTIONS:
        return _CAPTIONS[stem]
    if kind == "map":
        return f"Peak of {unquote(name)} over both variables."
    if kind == "wear":
        return f"Joint {unquote(name)}: profiles over the service life; round, with enlarged wear, and unrolled."
    return stem
