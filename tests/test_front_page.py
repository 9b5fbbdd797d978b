"""Numbers on the front pages agree with runs."""

import re
from pathlib import Path

import pytest

import linkages
from linkages.cli.main import main

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def parts_of_the_clearance():
    """Largest parts of the clearance that the journals A and B of the press use [%], with both films."""

    def used(film):
        run = linkages.simulate(linkages.load(linkages.find_file("seven_bar.toml"), film), "compiled")
        names = [f"{joint}.eccentricity_ratio" for joint in "AB"]
        found = linkages.extremes(run, names)
        return [100.0 * found[name].peak for name in names]

    return [*used({}), *used({f"joints.{joint}.film": "finite" for joint in "AB"})]


@pytest.mark.parametrize("page", ["README.md", "docs/index.md"])
def test_the_caption_of_the_journals_has_both_films(page, parts_of_the_clearance):
    """The long-bearing film alone would promise less than half of the motion: it is not for L/D = 1.33."""
    text = (ROOT / page).read_text(encoding="utf-8")
    caption = re.search(r"\*The two journals of the seven-bar press.*?\.\*", text, re.DOTALL).group()
    printed = [float(number) for number in re.findall(r"([\d.]+) %", caption)]
    assert printed == pytest.approx(parts_of_the_clearance, abs=0.06)


@pytest.mark.parametrize(
    ("page", "words"),
    [
        ("first_run.md", ("simulate", "seven_bar.toml", "--no-plots", "--no-animation")),
        ("command_line.md", ("draw", "slider_crank_dry.toml")),
    ],
)
def test_pages_show_what_the_command_prints(page, words, tmp_path, capsys):
    """Line by line; one that ends with dots is the beginning of a longer one."""
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")
    blocks = re.findall(r"^```(\w*)\n(.*?)^```", text, re.DOTALL | re.MULTILINE)
    shown = next(block for language, block in blocks if not language).splitlines()
    assert main([*words, "--out", str(tmp_path / "out")]) == 0
    printed = capsys.readouterr().out.splitlines()
    assert len(shown) > 4
    for line in shown:
        assert any(one.startswith(line[:-3]) if line.endswith("...") else one == line for one in printed), line
