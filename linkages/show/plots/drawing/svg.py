"""A drawing as SVG, and as an HTML page with a slider for each drive, whose script moves the body-fixed points."""

from __future__ import annotations

import html
import re
from textwrap import wrap

import numpy as np
from markupsafe import Markup, escape

from linkages.base.arrays import Array
from linkages.base.palette import FONT, INK, LIMIT, PAPER, repainted
from linkages.show.plots.drawing.drawing import Drawing
from linkages.show.plots.drawing.shapes import STYLES, Shape, placed
from linkages.show.plots.pages import embedded, filled, own_text, page_style, script

_SIGNS = (
    "Ring: a bearing; orange ring: a clearance joint; larger red ring: friction; arrow at a joint: the way its drive"
    " goes first, or that of its coordinate; small coloured dot: centre of mass."
)
WIDTH = 960.0  # width of the picture [px]
_HALO = 0.35  # width of the halo around words, in units
_LINE = 17.0  # line height of text [px]
_WORDS = 128  # most characters of a line
_INDENT = "\u2003"  # of its further lines


def scale(drawing: Drawing) -> float:
    """Return the pixels per metre."""
    return WIDTH / float(drawing.high[0] - drawing.low[0])


def svg(drawing: Drawing, said: bool = True) -> Markup:
    """Write a drawing as an ``<svg>`` element; with `said` also title, properties and questions below."""
    height = scale(drawing) * float(drawing.high[1] - drawing.low[1])
    lines = notes(drawing) if said else []
    total = height + (_LINE * (len(lines) + 1) if lines else 0.0)
    size = f"viewBox='0 0 {WIDTH:g} {total:.1f}' width='{WIDTH:g}' height='{total:.1f}'"
    shapes = Markup("\n").join(_element(drawing, one, said) for one in drawing.shapes)
    text = Markup("<text x='12' y='{:.1f}' font-size='13' font-weight='{}' fill='{}'>{}</text>")
    texts = Markup("\n").join(  # pages have them as HTML
        text.format(height + _LINE * (k + 1), "normal" if k else "bold", color, line)
        for k, (line, color) in enumerate(lines)
    )
    frame = f"<rect width='{WIDTH:g}' height='{total:.1f}' fill='{PAPER}'/>"
    start = f"<svg xmlns='http://www.w3.org/2000/svg' {size} role='img' font-family='{FONT}'>"
    label = Markup("<title>{}</title>").format(drawing.title)
    style = f"<style>{_dark()}</style>" if said else ""  # a page has its own
    notes_of = f"<g class='notes' data-height='{height:.1f}'>\n{texts}\n</g>\n" if lines else ""
    return Markup(f"{start}{label}{style}{frame}\n{shapes}\n{notes_of}</svg>\n")


def without_notes(picture: str) -> tuple[str, list[str]]:
    """Return a written drawing without the texts below it, and its properties as sentences."""
    found = re.search(r"<g class='notes' data-height='([\d.]+)'>\n(.*?)\n</g>\n", picture, re.DOTALL)
    if not found:  # of an earlier version
        return picture, []
    lines = [html.unescape(line) for line in re.findall(r">([^<]*)</text>", found[2])][1:]  # the first is the title
    facts: list[str] = []
    for line in lines:
        if line.startswith(_INDENT) and facts:
            facts[-1] += f" {line.removeprefix(_INDENT)}"
        else:
            facts.append(line)
    whole = re.search(r"viewBox='0 0 [\d.]+ ([\d.]+)'", picture)
    bare = picture.replace(found[0], "")
    return (
        bare.replace(f"'{whole[1]}'", f"'{found[1]}'").replace(f" {whole[1]}'", f" {found[1]}'") if whole else bare
    ), facts


def _dark() -> str:
    """Write the rules with which ink, lines and paper change places on dark paper."""
    return f"@media screen and (prefers-color-scheme: dark) {{ {repainted(variables=False)} }}"


def _element(drawing: Drawing, one: Shape, static: bool) -> Markup:
    """Write an element, with its body-fixed points if it is movable."""
    style, unit = STYLES[one.role], 0.01 * WIDTH
    fill, stroke = ("none" if named is None else named or one.color for named in (style.fill, style.stroke))
    look = [f"fill='{fill}'", f"stroke='{stroke}'", *(["class='mark'"] if one.role == "link mark" else [])]
    if style.kind == "text":
        look[1] = f"stroke='{PAPER}' stroke-width='{_HALO * unit:.1f}' paint-order='stroke' stroke-linejoin='round'"
    if style.width:
        look.append(f"stroke-width='{style.width * unit:.2f}' stroke-linecap='round' stroke-linejoin='round'")
    if style.opacity < 1.0:
        look.append(f"opacity='{style.opacity:g}'")
    if style.dash:
        look.append(f"stroke-dasharray='{style.dash * unit:.1f}'")
    points = pixels(drawing, placed(one.at, drawing.pose))
    if not static:
        numbers = " ".join(",".join(f"{value:.6g}" for value in row) for row in one.at)
        look.append(f"data-at='{numbers}'")
    shown = " ".join(look)
    if style.kind == "text":
        x, y = points[0]
        font = f"font-size='{style.size * unit:.1f}' text-anchor='middle' dominant-baseline='central'"
        heavy = " font-weight='bold'" if style.bold else ""
        return Markup(f"<text x='{x:.1f}' y='{y:.1f}' {font}{heavy} {shown}>{escape(one.text)}</text>")
    if style.kind == "circle":
        x, y = points[0]
        title = f"<title>{escape(one.text)}</title>" if one.text else ""
        return Markup(f"<circle cx='{x:.2f}' cy='{y:.2f}' r='{style.radius * unit:.2f}' {shown}>{title}</circle>")
    tag = "polygon" if style.kind == "area" else "polyline"
    return Markup(f"<{tag} points='{' '.join(f'{x:.2f},{y:.2f}' for x, y in points)}' {shown}/>")


def pixels(drawing: Drawing, points: Array) -> Array:
    """Return positions in the picture, y downwards [px]."""
    x, y = ((points - [drawing.low[0], drawing.high[1]]) * scale(drawing)).T
    return np.column_stack([x, -y])


def notes(drawing: Drawing) -> list[tuple[str, str]]:
    """Return the lines of text below the picture, with colours."""
    said = [(drawing.title, INK), *((fact, INK) for fact in drawing.facts)]
    said += [(doubt, LIMIT) for doubt in (drawing.problem, *drawing.doubts) if doubt]
    return [(line, color) for text, color in said for line in wrap(text, _WORDS, subsequent_indent=_INDENT)]


def page(drawing: Drawing, moves: str = "Joints are ideal here.") -> str:
    """Write the page; `moves` says how the mechanism moves on it."""
    sliders = [
        {
            "first": slider.first,
            "sense": slider.sense,
            "texts": [f"{value:.{slider.digits}f} {slider.unit}" for value in slider.values.tolist()],
            "poses": [[[float(f"{v:.6g}") for v in row] for row in pose] for pose in slider.poses],
            "full": slider.unit == "s" or bool(np.ptp(slider.values) > 359.9 and slider.unit == "deg"),
        }
        for slider in drawing.sliders
    ]
    data = {"low": drawing.low[0], "high": drawing.high[1], "scale": scale(drawing), "sliders": sliders}
    return filled(
        own_text("linkages.show.plots.drawing", "page.html"),
        drawing=drawing,
        moves=moves,
        asked=[text for text in (drawing.problem, *drawing.doubts) if text],
        picture=svg(drawing, said=False),
        signs=_SIGNS,
        style=page_style(),
        scripts=Markup(script("moves", "player")),
        data=embedded(data),
    )
