"""Numbers on the front pages agree with runs."""

import re
from pathlib import Path

import pytest

import linkages
from linkages.cli.main import main

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def dry_forces():
    """Largest force in joint A of the dry press and of the ideal one [N]."""
    system = linkages.load(linkages.find_file("seven_bar_dry.toml"))
    runs = linkages.simulate(system), linkages.ideal(system)
    return [linkages.extremes(run, ["A.force"])["A.force"].peak for run in runs]


@pytest.mark.parametrize("page", ["README.md", "docs/first_run.md"])
def test_pages_say_how_hard_a_dry_joint_strikes(page, dry_forces):
    text = (ROOT / page).read_text(encoding="utf-8")
    (times,) = re.findall(r"(\d+) times as large", text)
    assert float(times) == pytest.approx(dry_forces[0] / dry_forces[1], rel=0.02)


def test_the_picture_of_the_first_page_has_the_numbers_of_its_run():
    """The run goes on after its start-up in a chaotic motion, so that its peaks depend on the last digits."""
    system = linkages.load(linkages.find_file("slider_crank_dry.toml"))
    summary = linkages.summarize(linkages.assess(system, "compiled", error_estimate=False))
    shown = summary["windows"][summary["report"]]
    ratio = shown["joints"]["B"]["force"]["peak"] / shown["ideal"]["joints"]["B"]["force"]["peak"]
    picture = (ROOT / "docs" / "figures" / "landing.svg").read_text(encoding="utf-8")
    assert f"{1e3 * system.experiment.joints['B'].clearance:g} mm of clearance" in picture
    assert float(re.search(r">([\d.]+) times<", picture)[1]) == pytest.approx(ratio, rel=0.05)
    assert float(re.search(r">(\d+) %<", picture)[1]) == pytest.approx(
        100.0 * shown["joints"]["B"]["contact_fraction"], abs=2
    )
    for page in ("README.md", "docs/index.md"):
        (said,) = re.findall(r"force in it: ([\d.]+) times", (ROOT / page).read_text(encoding="utf-8"))
        assert float(said) == pytest.approx(ratio, rel=0.05)


def test_the_first_run_says_what_thinner_oil_does():
    text = (ROOT / "docs" / "first_run.md").read_text(encoding="utf-8")
    (used,) = re.findall(r"Joint A now uses ([\d.]+) %", text)
    system = linkages.load(linkages.find_file("seven_bar.toml"), {"joints.A.viscosity": 0.2})
    found = linkages.extremes(linkages.simulate(system), ["A.eccentricity_ratio"])["A.eccentricity_ratio"]
    assert float(used) == pytest.approx(100.0 * found.peak, abs=0.5)


@pytest.mark.parametrize(
    ("page", "words"),
    [
        ("first_run.md", ("simulate", "seven_bar.toml", "--no-plots", "--no-animation")),
        ("drawings.md", ("draw", "slider_crank_dry.toml")),
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
