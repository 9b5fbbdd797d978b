"""Writes the picture of the first page, from a run: ``python docs/make_landing.py``."""

import math
from pathlib import Path

import numpy as np

import linkages
from linkages.base.palette import FONT, IDEAL, INK, LINE, LINKS, PAPER, PLAY, SOFT, VARIABLES, repainted
from linkages.show.plots.pages import seen
from linkages.show.plots.quantities import number

FILE, JOINT = "slider_crank_dry.toml", "B"
FIGURE = Path(__file__).parent / "figures" / "landing.svg"
_CRANK, _ROD = 0.05, 0.12  # lengths of the machine [m], in slider_crank.sdf
_ANGLE = np.radians(52.0)  # of the crank in the picture
_SCALE, _AT = 1150.0, np.array([110.0, 290.0])  # pixels per metre, place of the crank's pivot [px]
_MIDDLE, _BEARING, _GAP = np.array([480.0, 250.0]), 68.0, 21.0  # of the magnified joint [px]
_TICK = 3  # between labelled times [ms]
_LEFT, _RIGHT, _TOP, _BOTTOM = 640.0, 1140.0, 165.0, 360.0  # of the curve [px]


def line(points, color, width, more=""):
    """Write a line through points (n, 2) [px]."""
    words = " ".join(f"{x:.1f},{y:.1f}" for x, y in np.asarray(points))
    look = f"fill='none' stroke='{color}' stroke-width='{width}' stroke-linejoin='round' stroke-linecap='round'"
    return f"<polyline points='{words}' {look} {more}/>"


def moved(at, x, y):
    """Return a place beside another one [px]."""
    return at + np.array([x, y])


def text(at, words, size=15, color=SOFT, more=""):
    """Write a text at a place [px]."""
    return f"<text x='{at[0]:.0f}' y='{at[1]:.0f}' font-size='{size}' fill='{color}' {more}>{words}</text>"


def circle(at, radius, fill, stroke=INK, width=2.0):
    """Write a circle at a place [px]."""
    look = f"fill='{fill}' stroke='{stroke}' stroke-width='{width}'"
    return f"<circle cx='{at[0]:.1f}' cy='{at[1]:.1f}' r='{radius:.1f}' {look}/>"


def machine():
    """Draw the slider-crank."""
    turn = np.array([np.cos(_ANGLE), -np.sin(_ANGLE)])
    pin = _AT + _SCALE * _CRANK * turn
    slider = np.array([pin[0] + np.sqrt((_SCALE * _ROD) ** 2 - (_AT[1] - pin[1]) ** 2), _AT[1]])
    block = f"<rect x='{slider[0] - 24:.1f}' y='{slider[1] - 21:.1f}' width='48' height='42' rx='3' fill='{SOFT}'/>"
    names = [(moved(_AT, -30, 5), "O"), (moved(pin, -5, -15), "A"), (moved(slider, -5, 46), JOINT)]
    return [
        line([moved(slider, -75, 23), moved(slider, 100, 23)], INK, 1.5),
        line([_AT, moved(_AT, -14, 24), moved(_AT, 14, 24), _AT], INK, 1.5),
        line([_AT, pin], LINKS[2], 11), line([pin, slider], LINKS[0], 11), block,
        circle(_AT, 6.5, PAPER), circle(pin, 6.5, PAPER), circle(slider, 8, PAPER, PLAY, 2.5),
        *(text(at, name, 16, INK, "font-weight='600'") for at, name in names),
        *(line([moved(slider, 6, sign * 6), moved(_MIDDLE, -55, sign * 68)], SOFT, 1, "stroke-dasharray='3 4'") for sign in (-1, 1)),
    ]  # fmt: skip


def magnified(run, clearance):
    """Draw the journal in its bearing at the largest force after the start-up, and its way before."""
    path = np.column_stack([run[f"{JOINT}.ex"], -run[f"{JOINT}.ey"]]) / clearance * _GAP + _MIDDLE
    top = int(np.argmax(run[f"{JOINT}.force"]))
    journal, radius = path[top], _BEARING - _GAP
    way = path[(run.time > run.time[top] - 2e-3) & (run.time <= run.time[top])]
    pull = np.array([run[f"{JOINT}.fx"][top], -run[f"{JOINT}.fy"][top]])
    pull /= np.linalg.norm(pull)
    side = np.array([-pull[1], pull[0]])
    tip = journal + 52.0 * pull
    head = " ".join(f"{x:.1f},{y:.1f}" for x, y in (tip + 12 * pull, tip + 6 * side, tip - 6 * side))
    return [
        circle(_MIDDLE, _BEARING + 20.0, LINE, INK, 1.5), circle(_MIDDLE, _BEARING, PAPER, INK, 1.5),
        circle(journal, radius, "#B8C9E4", LINKS[0]), line(way, LINKS[0], 1.6),
        line([journal, tip], PLAY, 4), f"<polygon points='{head}' fill='{PLAY}'/>",
        text(moved(_MIDDLE, 0, 114), f"joint {JOINT}, clearance magnified", 15, SOFT, "text-anchor='middle'"),
    ]  # fmt: skip


def curve(run, ideal, since):
    """Draw the force in the joint with clearance, and with ideal joints behind it."""
    high = 1e4 * np.ceil(run[f"{JOINT}.force"][run.time >= since].max() / 1e4)
    first, last = since, float(run.time[-1])

    def placed(motion):
        keep = np.flatnonzero(motion.time >= first)
        keep = keep[seen(motion.time[keep], motion[f"{JOINT}.force"][keep], 500)]
        x = _LEFT + (motion.time[keep] - first) / (last - first) * (_RIGHT - _LEFT)
        return np.column_stack([x, _BOTTOM - motion[f"{JOINT}.force"][keep] / high * (_BOTTOM - _TOP)])

    parts = [text((_LEFT, _TOP - 25), f"force in {JOINT} [kN]")]
    for value in np.arange(0.0, high + 1.0, 1e4):
        y = _BOTTOM - value / high * (_BOTTOM - _TOP)
        parts += [
            line([(_LEFT, y), (_RIGHT, y)], LINE, 1),
            text((_LEFT - 8, y + 5), f"{1e-3 * value:.0f}", 13, SOFT, "text-anchor='end'"),
        ]
    times = range(_TICK * math.ceil(1e3 * first / _TICK), math.floor(1e3 * last + 1e-9) + 1, _TICK)
    for time in times:
        at = _LEFT + (1e-3 * time - first) / (last - first) * (_RIGHT - _LEFT)
        end, unit = ("end", " ms") if time == times[-1] else ("middle", "")
        parts.append(text((at, _BOTTOM + 20), f"{time}{unit}", 13, SOFT, f"text-anchor='{end}'"))
    return [*parts, line(placed(ideal), IDEAL, 5), line(placed(run), LINKS[0], 1.3)]


def landing():
    """Make the picture; its numbers come from the run."""
    system = linkages.load(linkages.find_file(FILE))
    study = linkages.assess(system, "compiled", error_estimate=False)
    summary = linkages.summarize(study)
    shown = summary["windows"][summary["report"]]
    joint, exact = shown["joints"][JOINT], shown["ideal"]["joints"][JOINT]["force"]["peak"]
    clearance = system.experiment.joints[JOINT].clearance
    run, since = study.run.within(*study.reported_span), study.reported_span[0]
    ratio, share = joint["force"]["peak"] / exact, joint["contact_fraction"]
    title = f"What {number(1e3 * clearance)} mm of clearance does to a machine"
    facts = [
        (f"{number(ratio, 2)} times", f"the force in {JOINT}"), (f"{100.0 * share:.0f} %", "of the time in contact"),
        (str(joint["impacts"]), f"impacts in {1e3 * (run.time[-1] - since):.0f} ms"), ("2 engines", "one checks the other"),
    ]  # fmt: skip
    shapes = [
        text((60, 84), f"{title}.", 30, INK, "font-weight='600'"),
        *machine(), *magnified(run, clearance), *curve(run, study.ideal, since),
        text((_LEFT + 190, _TOP - 25), f"dry joint: up to {number(1e-3 * joint['force']['peak'], 3)} kN", 15, LINKS[0]),
        text((_LEFT + 370, _TOP - 25), f"ideal: {number(1e-3 * exact, 2)} kN", 15, SOFT),
        *(text((60 + 270 * k, 455), big, 26, INK, "font-weight='600'") for k, (big, _) in enumerate(facts)),
        *(text((60 + 270 * k, 480), small) for k, (_, small) in enumerate(facts)),
        text((60, 525), f"$ linkages simulate {FILE}", 15, INK, "font-family='ui-monospace, monospace'"),
    ]  # fmt: skip
    said = f"{title}: the force in joint {JOINT} of a slider-crank is {number(ratio, 2)} times the ideal one"
    rules = f"{repainted(variables=False)} text[fill='{LINKS[0]}'] {{ fill: {VARIABLES['data'][1]}; }}"
    dark = f"<style>@media screen and (prefers-color-scheme: dark) {{ {rules} }}</style>"
    head = f"<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 1200 550' font-family='{FONT}' role='img'>"
    return "\n".join(
        [head, f"<title>{said}</title>", dark, f"<rect width='1200' height='550' fill='{PAPER}'/>", *shapes, "</svg>\n"]
    )


if __name__ == "__main__":
    FIGURE.write_text(landing(), encoding="utf-8")
