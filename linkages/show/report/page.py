"""Results, words and tables put into the template: ``report.html``."""

from __future__ import annotations

import base64
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from markupsafe import Markup

from linkages.input.files.writing import whole
from linkages.results.trajectory import load_trajectory
from linkages.show.plots.pages import columns, curves, embedded, filled, own_text, script
from linkages.show.report import page_tables, words
from linkages.show.report.result_folder import FIGURES, Results


def write_report(results: Results, path: Path) -> None:
    """Write the page atomically; InputError if the place is not writable."""
    text = render(results)
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
        starts=bool(results.play),
        curves_script=Markup(script() + own("curves.js")),
        title=results.title,
        question=words.question(results),
        answer=words.answer(results),
        results=[
            table
            for make in (
                page_tables.outputs,
                page_tables.joints,
                page_tables.heats,
                page_tables.drives,
                page_tables.links,
            )
            if (table := make(results))
        ],
        estimated=bool(results.summary["error"]),
        dry=any(joint["model"] == "dry" for joint in results.play.values()),
        impacts=page_tables.impacts(results),
        drawing=data_uri(results.drawing, "svg+xml") if results.drawing else None,
        figures=[_figure(path) for path in results.figures],
        animation=results.animation,
        parameters=page_tables.parameters(results),
        mechanism=results.experiment["mechanism"],
        provenance=[page_tables.provenance(results), page_tables.files(results)],
        versions=[f"{k}=={v}" for k, v in versions.items() if k not in elsewhere],
        python=versions.get("python", ""),
        commands=words.commands(results),
        overrides=words.overrides(results),
        experiment_name=results.source,
        experiment_file=words.experiment_file(results),
    )


def _figure(path: Path) -> dict[str, str]:
    """Return caption, and picture as a data URI."""
    output = unquote(path.stem.removeprefix("output_"))
    caption = FIGURES.get(path.stem, path.stem)
    if path.stem.startswith("output_"):
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
    return [] if run is None else curves(names, run, ideal, errors)
