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
from linkages.input.files.writing import whole
from linkages.results.measured import load_measured
from linkages.results.trajectory import load_trajectory
from linkages.show.plots.drawing.svg import without_notes
from linkages.show.plots.pages import FRAME_POLICY, columns, curves, embedded, filled, own_text, page_style, script
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


#: Parts of a page that it lacks by default.
_NONE: dict[str, Any] = {
    "picture": "", "facts": (), "tiles": (), "sentences": (), "remarks": (), "animation": None, "animated": "",
    "curves": "", "about_curves": "", "about_numbers": "", "tables": (), "text": "", "about_contacts": "",
    "figures": (), "no_figures": "", "more": (), "commands": (), "about_commands": "", "versions": (), "experiment": (),
}  # fmt: skip
_CONTENTS = {"numbers": "Numbers", "figures": "Figures"}


def report_page(**parts: Any) -> str:
    """Fill the page of reports with its parts: ``title``, ``question`` and those of `_NONE`."""
    shown = _NONE | parts
    moving = {name: text for name, text in (("animation", "Animation"), ("curves", "Curves")) if shown[name]}
    contents = {"answer": "Answer"} | moving | _CONTENTS | {name: heading for name, heading, *_ in shown["more"]}
    contents |= {"repeat": "How to repeat"} if shown["commands"] else {}
    scripts = [script("curves")] if shown["curves"] else []
    looks = {"style": page_style(own("page.css")), "script": Markup("".join([*scripts, own("page.js")]))}
    return filled(own("page.html"), policy=FRAME_POLICY, contents=contents.items(), **looks, **shown)


def render(results: Results) -> str:
    """Return the page as text."""
    summary, drawn = results.summary, curves_of(results)
    versions, replaced = summary["provenance"]["versions"], words.overrides(summary)
    pinned = " ".join(f"{name}=={version}" for name, version in versions.items() if name not in ("python", "linkages"))
    shown = replace(results, summary=as_shown(summary))
    picture, facts = _drawing(results.drawing)
    contacts, about_contacts = _contacts(results)
    return report_page(
        title=results.title,
        question=answer.question(results),
        tiles=answer.tiles(summary),
        sentences=answer.answer(summary, results.source),
        remarks=answer.remarks(summary),
        picture=picture,
        facts=facts,
        animated="Animation",
        animation=results.animation,
        curves=embedded(drawn) if drawn else "",
        about_curves=words.about_curves(results),
        about_numbers=words.about_numbers(results),
        tables=[*(table for table in page_tables.numbers(shown) if table.rows), *contacts],
        about_contacts=about_contacts,
        figures=[_figure(path, summary["ideal"] is not None) for path in results.figures],
        no_figures="the run was made with --no-plots, or the files were removed.",
        more=[
            (
                "parameters",
                "Parameters and their sources",
                words.about_parameters(results),
                [page_tables.parameters(results)],
            ),
            ("provenance", "Provenance", "", [page_tables.provenance(results), page_tables.files(results)]),
        ],
        commands=words.commands(results),
        about_commands=words.about_commands(results)
        + (f" Replaced when the run was made: {', '.join(replaced)}." if replaced else ""),
        versions=[
            (
                f"The same versions of the other packages, on Python {versions.get('python', '')}:",
                f"pip install {pinned}",
            )
        ],
        experiment=(f"The experiment as it was run, a complete {results.source}", words.experiment_file(results)),
    )


def _drawing(path: Path | None) -> tuple[Markup | str, list[str]]:
    """Return the drawing of the machine as an element, and its properties as sentences."""
    if path is None:
        return "", []
    picture, facts = without_notes(path.read_text(encoding="utf-8"))
    source = f"data:image/svg+xml;base64,{base64.b64encode(picture.encode()).decode('ascii')}"
    facts = [*dict.fromkeys(facts)]  # of several drives
    return Markup('<img src="{}" alt="The machine, with its links and joints named">').format(source), facts


def _contacts(results: Results) -> tuple[list[page_tables.PageTable], str]:
    """Return the table of contacts, or why there is none."""
    found = page_tables.impacts(results)
    if found is None:
        return [], "No joint can touch in this run, so there is no list of contacts."
    return ([found], "") if found.rows else ([], "Joints could touch in this run, and none did.")


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
