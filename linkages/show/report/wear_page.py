"""Report of a folder of ``linkages wear``: ``report.html``."""

from __future__ import annotations

from pathlib import Path
from typing import Any
from urllib.parse import unquote

from linkages.base.brief import counted
from linkages.input.files.writing import whole
from linkages.results.shape import WearContent
from linkages.show.plots.style import typeset
from linkages.show.report.page import data_uri, report_page
from linkages.show.report.page_tables import PageTable, number
from linkages.show.report.result_folder import read_json, read_page

#: Files of ``linkages wear``.
CONTENT = "wear.json"


def write_wear_report(folder: Path, path: Path) -> None:
    """Write the report of an ``--out`` folder of ``linkages wear`` atomically; InputError for other folders."""
    found = read_json(folder / CONTENT, WearContent, "give the --out folder of `linkages wear`")
    text = report_page(
        "wear.html",
        title=found["title"] or found["experiment"],
        answer=_answer(found),
        results=[_joints(found), _peaks(found), _stages(found)],
        animation=read_page(folder / "wear.html"),
        figures=[
            {"caption": _caption(figure.stem), "source": data_uri(figure, "png")}
            for figure in sorted(folder.glob("wear_*.png"))
        ],
    )
    with whole(path) as partial:
        partial.write_text(text, encoding="utf-8")


def _answer(found: dict[str, Any]) -> list[str]:
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
    rows = [
        (
            name,
            *(number(scale * joint[key]) for key, scale in (*_LENGTHS, ("coefficient", 1e9), ("load_distance", 1.0))),
        )
        for name, joint in found["joints"].items()
    ]
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
        (
            f"{block['cycles']:,}",
            name,
            *(number(scale * joint[key]) for key, scale in _LENGTHS),
            number(1e6 * block["error"]),
        )
        for block in found["blocks"]
        for name, joint in block["joints"].items()
    ]
    head = ("cycles", "joint", "volume [mm³]", "depth [µm]", "clearance [µm]", "error of the jump [µm]")
    return PageTable("Service life", head, rows, frozenset({0, 1}))


_LENGTHS = (("volume", 1e9), ("depth", 1e6), ("play", 1e6))


def _caption(stem: str) -> str:
    if stem == "wear_history":
        return "Worn volume, depth and clearance; peaks of forces, torques and jitter over the initial peaks."
    joint = unquote(stem.removeprefix("wear_"))
    return f"Joint {joint}: profiles over the service life; round, with enlarged wear, and unrolled."
