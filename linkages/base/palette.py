"""Colours, lines and sizes of all media: figures, drawings, pages, the live page and the terminal read them here.

A colour has one meaning. Links have `LINKS`; `PLAY` is for clearances, forces of contacts and impacts, `LIMIT` for
limits and bad values, `ACCENT` for controls and never for data.
"""

from __future__ import annotations

from collections.abc import Sequence

INK, SOFT, LINE, PAPER = "#1A1A1A", "#565B63", "#D4D7DC", "#FFFFFF"
PANEL, EDGE, GROUND = "#F4F5F7", "#828891", "#70757C"  # behind groups, around controls, fixed parts
IDEAL = "#868D97"  # of the motion with ideal joints, wide behind the run; of nominal designs and linear theory likewise
MEASURED = "#00795C"  # of measured values, dotted; of springs
LIMIT = "#B3261E"
PLAY = "#D55E00"
ACCENT, GOOD = "#005A9C", "#00664D"
MARK = "#7A3E9D"  # of points whose motion is asked for, and of their paths
#: Of links in their order, and of curves that belong to no link.
LINKS = ("#0072B2", "#009E73", "#E69F00", "#56B4E9", "#6A51A3", "#8B6F47")
LARGER, SMALLER = LINKS[3], LINKS[2]  # of signed values in cells, whose text has the sign, too; see `shade`
SCALE, LATER = "viridis", "viridis_r"  # colour maps of fields, and of curves in the order of time
PINS = ("#7A3E9D", "#A34A00", "#00705A", "#A3285F")  # of the live page's pinned runs

_DARK_PINS = ("#CDA6EC", "#F2A65A", "#56D1B0", "#F59AC0")
#: Names of the variables of style sheets, with the colours on light and on dark paper.
VARIABLES = {
    "ink": (INK, "#E8EAED"),
    "soft": (SOFT, "#A9B0BA"),
    "line": (LINE, "#3B414A"),
    "paper": (PAPER, "#16181C"),
    "panel": (PANEL, "#1F2329"),
    "edge": (EDGE, "#747C88"),
    "ground": (GROUND, EDGE),
    "ideal": (IDEAL, IDEAL),
    "measured": (MEASURED, "#4CC9A0"),
    "limit": (LIMIT, "#FF8F86"),
    "play": (PLAY, "#FF9D4D"),
    "accent": (ACCENT, "#6CB6FF"),
    "good": (GOOD, "#4CC9A0"),
    "mark": (MARK, "#CDA6EC"),
    "data": (LINKS[0], "#56B4E9"),
    **dict(zip(("pin1", "pin2", "pin3", "pin4"), zip(PINS, _DARK_PINS, strict=True), strict=True)),
}

#: Widths of lines [pt]: data, the ideal motion behind them, axes, grids, limits; opacity of grids.
DATA_LINE, IDEAL_LINE, AXIS_LINE, GRID_LINE, LIMIT_LINE, GRID_SHADE = 1.2, 3.0, 0.6, 0.4, 1.2, 0.3
#: Sizes of text: small, text, heading, title, answer.
SIZES = 9.0, 11.0, 14.0, 18.0, 24.0
LEAST_SIZE = 6.5  # of text in a figure of one column [pt]
FONT = "system-ui, sans-serif"

_APART = 0.1  # difference of luminance between links that touch


def css(selector: str = ":root", dark: bool = True, chosen: bool = False) -> str:
    """Write the colours as variables of a style sheet; with `dark` also those on dark paper.

    On a page where readers choose, they follow its ``color-scheme``, else the reader's preference.
    """
    if chosen:
        both = (f"--{name}: light-dark({day}, {night}); " for name, (day, night) in VARIABLES.items())
        return f"{selector} {{ {''.join(both)}}}\n"
    light, night = ("".join(f"--{name}: {pair[k]}; " for name, pair in VARIABLES.items()) for k in (0, 1))
    rules = f"{selector} {{ {light}}}\n"
    return rules + (f"@media screen and (prefers-color-scheme: dark) {{ {selector} {{ {night}}} }}\n" if dark else "")


def repainted(before: str = "", variables: bool = True) -> str:
    """Write rules that give the lines and areas of a picture, drawn in light colours, those of its page.

    The page's variables are taken, or else the colours on dark paper. `before` stands before each selector.
    """
    names = ("ink", "soft", "line", "paper", "ground", "limit", "mark", "measured")
    taken = {VARIABLES[name][0]: f"var(--{name})" if variables else VARIABLES[name][1] for name in names}
    return "\n".join(
        f"{before}[{what}='{day}'] {{ {what}: {new}; }}" for day, new in taken.items() for what in ("fill", "stroke")
    )


def luminance(color: str) -> float:
    """Return the relative luminance of a colour ``#rrggbb``, 0 to 1 (WCAG 2.2)."""
    parts = (int(color[k : k + 2], 16) / 255.0 for k in (1, 3, 5))
    linear = (part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts)
    return sum(weight * part for weight, part in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


def contrast(one: str, other: str) -> float:
    """Return the contrast ratio of two colours, 1 to 21 (WCAG 2.2).

    Examples
    --------
    >>> from linkages.base.palette import INK, PAPER, contrast
    >>> round(contrast(INK, PAPER), 1)
    17.4
    """
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


def written_on(color: str) -> str:
    """Return the colour of text on an area of a colour: ink or paper."""
    return max((INK, PAPER), key=lambda text: contrast(text, color))


def shade(part: float) -> str:
    """Return the colour of an area for a signed part of the largest value, -1 to 1: paper for 0.

    Examples
    --------
    >>> from linkages.base.palette import LARGER, PAPER, shade
    >>> shade(0.0) == PAPER, shade(1.0) == LARGER
    (True, True)
    """
    full, part = LARGER if part > 0.0 else SMALLER, min(abs(part), 1.0)
    pairs = ((int(PAPER[k : k + 2], 16), int(full[k : k + 2], 16)) for k in (1, 3, 5))
    return "#" + "".join(f"{round(blank + part * (ink - blank)):02X}" for blank, ink in pairs)


def link_color(order: int, touching: Sequence[str]) -> str:
    """Choose the colour of a link: the next one whose luminance differs enough from the links that it touches.

    `order` is the link's place among all links, and `touching` has the colours of its neighbours. If there is no such
    colour, it is the one that differs most.
    """
    following = [LINKS[(order + k) % len(LINKS)] for k in range(len(LINKS))]
    apart = {one: min((abs(luminance(one) - luminance(other)) for other in touching), default=1.0) for one in following}
    return next((one for one in following if apart[one] > _APART), max(following, key=lambda one: apart[one]))
