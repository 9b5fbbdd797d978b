"""Results, words and tables of a folder put into a template: ``report.html``, of a run or of wear."""

from __future__ import annotations

import base64
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from markupsafe import Markup

from linkages.base.brief import counted
from linkages.base.errors import InputError
from linkages.input.files.writing import whole
from linkages.results.measured import load_measured
from linkages.results.shape import WearContent
from linkages.results.trajectory import load_trajectory
from linkages.show.plots.pages import columns, curves, embedded, filled, own_text, script
from linkages.show.plots.style import typeset
from linkages.show.report import answer, page_tables, words
from linkages.show.report.page_tables import PageTable, number
from linkages.show.report.result_folder import FIGURES, Results, read_json, read_page

#: Files of ``linkages wear``.
CONTENT = "wear.json"
_LENGTHS = (("volume", 1e9), ("depth", 1e6), ("play", 1e6))


def write_report(results: Results, path: Path) -> None:
    """Write the page atomically; InputError if the place is not writable."""
    _write(path, render(results))


def _write(path: Path, text: str) -> None:
    with whole(path) as partial:
        partial.write_text(text, encoding="utf-8")


def report_page(name: str, **values: Any) -> str:
    """Fill a template of this package, with a macro for tables."""
    return filled(own("table.html") + own(name), style=Markup(own("page.css")), **values)


def render(results: Results) -> str:
    """Return the page as text."""
    drawn = curves_of(results)
    versions = results.summary["provenance"]["versions"]
    elsewhere = ("python", "linkages")  # not installed like the other packages
    return report_page(
        "page.html",
        script=Markup(own("page.js")),
        curves=embedded(drawn) if drawn else "",
        curves_script=Markup(script() + own("curves.js")),
        results=results,
        answer=answer,
        words=words,
        tables=page_tables,
        drawing=data_uri(results.drawing, "svg+xml") if results.drawing else None,
        figures=[_figure(path) for path in results.figures],
        versions=[f"{k}=={v}" for k, v in versions.items() if k not in elsewhere],
        python=versions.get("python", ""),
    )


def _figure(path: Path) -> dict[str, str]:
    """Return caption, and picture as a data URI."""
    caption = FIGURES.get(path.stem, path.stem)
    if path.stem.startswith("output_"):
        output = unquote(path.stem.removeprefix("output_"))
        caption = f"{output} over time, ideal joints and clearance; below: their difference."
    return {"caption": caption, "source": data_uri(path, "png")}


def data_uri(path: Path, kind: str) -> str:
    """Encode a picture as part of the page."""
    return f"data:image/{kind};base64,{base64.b64encode(path.read_bytes()).decode('ascii')}"


def own(name: str) -> str:
    """Read a file of this package."""
    return own_text("linkages.show.report", name)


def curves_of(results: Results) -> list[dict[str, Any]]:
    """Return outputs, forces in clearance joints and drive torques over time, real and ideal.

    None if the folder has no trajectory; InputError if it cannot be read.
    """
    files = (results.folder / name for name in ("trajectory.npz", "ideal.npz"))
    run, ideal = (load_trajectory(path) if path.is_file() else None for path in files)
    names = columns(results.summary["outputs"], results.play, results.summary["drives"])
    errors = {name: results.summary["error"].get(f"{name}.peak") or 0.0 for name in names}
    found = results.folder / "measured.npz"
    try:
        measured = load_measured(found) if found.is_file() else {}
    except (ValueError, KeyError) as problem:
        raise InputError(str(found), "", f"cannot be read ({problem}); remove it, or run again") from None
    return [] if run is None else curves(names, run, ideal, errors, measured=measured)


def write_wear_report(folder: Path, path: Path) -> None:
    """Write the report of an ``--out`` folder of ``linkages wear`` atomically; InputError for other folders."""
    found = read_json(folder / CONTENT, WearContent, "give the --out folder of `linkages wear`")
    pictures = sorted(folder.glob("wear_*.png"))
    text = report_page(
        "wear.html",
        title=found["title"] or found["experiment"],
        answer=_answer(found),
        results=[_joints(found), _peaks(found), _stages(found)],
        animation=read_page(folder / "wear.html"),
        figures=[{"caption": _caption(one.stem), "source": data_uri(one, "png")} for one in pictures],
    )
    _write(path, text)


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
    if stem == "wear_history":
        return "Worn volume, depth and clearance; peaks of forces, torques and jitter over the initial peaks."
    joint = unquote(stem.removeprefix("wear_"))
    return f"Joint {joint}: profiles over the service life; round, with enlarged wear, and unrolled."
