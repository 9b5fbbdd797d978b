"""Colours of all media: contrast, links that touch for everyone, and no colour beside the palette."""

import ast
import re
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from matplotlib import colormaps
from matplotlib.colors import is_color_like

import linkages
from linkages.base import palette
from linkages.base.palette import INK, LINKS, PAPER, VARIABLES, contrast, link_color, luminance
from linkages.input.files.shipped import data_folder
from linkages.input.model.skeleton import color_of

TEXT, GRAPHIC = 4.5, 2.0  # least contrasts: of text (WCAG 2.2, 1.4.3), of wide lines
WORDS = ("ink", "soft", "limit", "accent", "good", "measured", "mark", "pin1", "pin2", "pin3", "pin4")
#: Names of arguments and keys that give colours to matplotlib.
COLOR_KEYS = {
    "color", "colors", "c", "ec", "fc", "mec", "mfc", "edgecolor", "edgecolors", "facecolor", "facecolors", "ecolor",
    "foreground", "markeredgecolor", "markerfacecolor", "cmap",
}  # fmt: skip
NO_COLOR = ("none", "")
APART = 0.1  # difference of luminance
ROOT = Path(linkages.__file__).parent.parent

# of linear red, green, blue: Machado, Oliveira and Fernandes 2009, Table 1, deuteranopia
DEUTERANOPIA = np.array(
    [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
)


def linear(color):
    parts = np.array([int(color[k : k + 2], 16) / 255.0 for k in (1, 3, 5)])
    return np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)


def seen(color):
    """Return the luminance of a colour as a deuteranope sees it."""
    return float(np.array([0.2126, 0.7152, 0.0722]) @ np.clip(DEUTERANOPIA @ linear(color), 0.0, 1.0))


def test_contrast_of_black_and_white_is_21():
    assert contrast("#000000", "#ffffff") == pytest.approx(21.0)
    assert luminance("#808080") == pytest.approx(0.2158605, abs=1e-6)  # WCAG's formula


@pytest.mark.parametrize("paper", [0, 1])
def test_text_and_lines_have_contrast_on_light_and_on_dark_paper(paper):
    behind = VARIABLES["paper"][paper], VARIABLES["panel"][paper]
    for name in WORDS:
        assert min(contrast(VARIABLES[name][paper], one) for one in behind) >= TEXT, name
    for name in ("ideal", "play", "edge", "data"):
        assert contrast(VARIABLES[name][paper], behind[0]) >= GRAPHIC, name


def test_links_are_seen_on_paper_and_their_names_are_read():
    assert all(contrast(color, PAPER) >= GRAPHIC for color in LINKS)
    assert contrast(INK, PAPER) >= TEXT
    assert palette.PLAY not in LINKS  # the clearance's alone


def machines():
    return sorted(data_folder().glob("*.sdf"))


@pytest.mark.parametrize("path", machines(), ids=lambda path: path.stem)
def test_links_that_touch_differ_also_for_deuteranopes(path):
    mechanism = linkages.load_mechanism(path)
    for joint in mechanism.joints:
        links = {joint.parent, joint.child} - {"world"}
        for one, other in combinations([color_of(mechanism, name) for name in links], 2):
            assert abs(luminance(one) - luminance(other)) > APART, joint.name
            assert abs(seen(one) - seen(other)) > 0.8 * APART, joint.name


def test_a_link_has_the_next_colour_that_differs_from_its_neighbours():
    assert link_color(0, []) == LINKS[0]
    assert link_color(4, [LINKS[0]]) == "#009E73"  # the two after LINKS[3] are as dark as the neighbour
    dark, middle, bright = "#0072B2", "#009E73", "#E69F00"
    assert link_color(1, [dark, middle, bright]) in LINKS  # none differs enough from all: the best one


def test_every_colour_is_of_the_palette():
    found = []
    for folder in ("linkages", "optim"):
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix in (".py", ".css", ".js", ".html") and path.name != "palette.py":
                text = path.read_text(encoding="utf-8")
                found += [
                    f"{path.name}: {one}" for one in re.findall(r"#[0-9a-fA-F]{6}\b|[: ]#[0-9a-fA-F]{3}[; ]", text)
                ]
    assert found == []


def chosen(path):
    """Yield the texts that a module gives as colours or colour maps: by keyword, or by key of a dict."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.keyword):
            pairs = [(node.arg, node.value)]
        elif isinstance(node, ast.Dict):
            pairs = [(key.value, value) for key, value in zip(node.keys, node.values, strict=True)
                     if isinstance(key, ast.Constant)]  # fmt: skip
        else:
            continue
        for name, value in pairs:
            if name in COLOR_KEYS:
                yield from (one.value for one in ast.walk(value) if isinstance(one, ast.Constant))


def test_no_figure_has_a_colour_or_a_colour_map_by_a_name_of_matplotlib():
    """Greys such as "0.6", letters such as "k", names such as "white" and "viridis" are in the palette alone."""
    found = []
    for folder in ("linkages/show", "linkages/cli", "optim"):
        for path in sorted((ROOT / folder).rglob("*.py")):
            texts = (one for one in chosen(path) if isinstance(one, str) and one not in NO_COLOR)
            found += [f"{path.name}: {one}" for one in texts if is_color_like(one) or one in colormaps]
    assert found == []


def test_a_shade_is_between_paper_and_the_full_colour():
    assert [palette.shade(part) for part in (0.0, 1.0, -1.0)] == [PAPER, palette.LARGER, palette.SMALLER]
    light = [luminance(palette.shade(part)) for part in np.linspace(0.0, 1.0, 9)]
    assert np.all(np.diff(light) < 0.0)
    for part in np.linspace(-1.0, 1.0, 21):  # numbers in the cells are read
        assert contrast(palette.written_on(palette.shade(part)), palette.shade(part)) >= TEXT


def test_style_sheets_have_both_papers():
    text = palette.css(".page")
    assert text.startswith(f".page {{ --ink: {INK};")
    assert f"prefers-color-scheme: dark) {{ .page {{ --ink: {VARIABLES['ink'][1]};" in text
    assert "dark" not in palette.css(dark=False)
