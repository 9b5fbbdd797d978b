"""Results, words and tables of a run put into a template: ``report.html``; `result_page` is of other commands."""

from __future__ import annotations

import base64
import html
import re
from dataclasses import replace
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from markupsafe import Markup

from linkages.base.errors import InputError
from linkages.base.palette import css
from linkages.input.files.writing import whole
from linkages.results.measured import load_measured
from linkages.results.trajectory import load_trajectory
from linkages.show.plots.pages import columns, curves, embedded, filled, own_text, script
from linkages.show.report import answer, page_tables, words
from linkages.show.report.result_folder import FIGURES, PICTURES, Results
from linkages.show.report.units import as_shown


def write_report(results: Results, path: Path) -> None:
    """Write the page atomically; InputError if the place is not writable."""
    write_page(path, render(results))


def write_page(path: Path, text: str) -> None:
    """Write a page atomically; InputError if the place is not writable."""
    with whole(path) as partial:
        partial.write_text(text, encoding="utf-8")


def report_page(name: str, **values: Any) -> str:
    """Fill a template of this package, with a macro for tables."""
    return filled(own("table.html") + own(name), style=Markup(css() + own("page.css")), **values)


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
        shown=replace(results, summary=as_shown(results.summary)),
        drawing=data_uri(results.drawing) if results.drawing else None,
        figures=[_figure(path, results.summary["ideal"] is not None) for path in results.figures],
        versions=[f"{k}=={v}" for k, v in versions.items() if k not in elsewhere],
        python=versions.get("python", ""),
    )


def _figure(path: Path, compared: bool) -> dict[str, str]:
    """Return caption, and picture as a data URI; `compared`: figures show the motion with ideal joints too."""
    caption = FIGURES.get(path.stem, path.stem)
    if path.stem.startswith("output_"):
        output = unquote(path.stem.removeprefix("output_"))
        caption = f"{output} over time, ideal joints and clearance; below: their difference."
    if not compared:
        caption = caption.replace(", ideal joints and clearance; below: their difference", "")
    return {"caption": caption, "source": data_uri(path), "answer": described(path) or caption}


def described(path: Path) -> str:
    """Read the answer of a figure from its file; empty if it has none."""
    if path.suffix == ".svg":
        found = re.search(r"<dc:description>(.*?)</dc:description>", path.read_text(encoding="utf-8"), re.DOTALL)
        return html.unescape(found[1]).strip() if found else ""
    from PIL import Image  # of matplotlib

    with Image.open(path) as picture:
        return str(picture.info.get("Description", ""))


def data_uri(path: Path) -> str:
    """Encode a picture as part of the page."""
    return f"data:{PICTURES[path.suffix]};base64,{base64.b64encode(path.read_bytes()).decode('ascii')}"


def own(name: str) -> str:
    """Read a file of this package."""
    return own_text("linkages.show.report", name)


def curves_of(results: Results) -> list[dict[str, Any]]:
    """Return outputs, forces in clearance joints, drive torques over time, real and ideal, with their links' colours.

    None if the folder has no trajectory; InputError if it cannot be read.
    """
    files = (results.folder / name for name in ("trajectory.npz", "ideal.npz"))
    run, ideal = (load_trajectory(path) if path.is_file() else None for path in files)
    drives = [name for name, drive in results.summary["drives"].items() if drive.get("acts", True)]
    actuators = [*drives, *results.experiment.get("motors", {})]
    names = columns(results.summary["outputs"], results.play, actuators)
    errors = {name: results.summary["error"].get(f"{name}.peak") or 0.0 for name in names}
    found = results.folder / "measured.npz"
    try:
        measured = load_measured(found) if found.is_file() else {}
    except (ValueError, KeyError) as problem:
        raise InputError(str(found), "", f"cannot be read ({problem}); remove it, or run again") from None
    if run is None:
        return []
    colors = results.summary["mechanism"].get("colors", {})  # runs of earlier versions have none
    drawn = curves(names, run, ideal, errors, measured=measured)
    return [curve | {"color": colors.get(curve["name"].partition(".")[0])} for curve in drawn]
