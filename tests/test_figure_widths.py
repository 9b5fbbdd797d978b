"""Figures of all commands in the two widths of a page: no text is cut off, small or on another; each has an answer."""

import pytest
from figure_texts import faults
from PIL import Image

from linkages.cli.main import main
from linkages.show.plots.names import name_of_output, name_of_value

SHORT = "--no-error-estimate --no-animation --quiet --duration"
BEARING = "bearing --diameter 0.1 --length 0.05 --clearance 1e-4 --viscosity 0.03 --speed 100 --load 1000"
SWEEP = "sweep seven_bar.toml --revolutions 1 --transient 0 --vary joints.A.clearance=0.1mm:0.4mm"
FIT = "optim/identify/examples/slider_crank_fit.toml"
#: Commands, how many figures they write, and whether they take long.
COMMANDS = {
    "press": (f"simulate seven_bar.toml {SHORT} 0.02", 5, True),
    "dry press": (f"simulate seven_bar_dry.toml {SHORT} 0.03", 6, True),
    "mixed press": (f"simulate seven_bar_mixed.toml {SHORT} 0.02", 6, False),
    "five-bar": (f"simulate five_bar_dry.toml {SHORT} 0.02", 4, False),
    "guide": (f"simulate slider_crank_guide.toml {SHORT} 0.03", 6, False),
    "flexible link": (f"simulate slider_crank_flexible.toml {SHORT} 0.02", 6, False),
    "gears": (f"simulate gear_rattle.toml {SHORT} 0.03", 3, False),
    "motor": (f"simulate slider_crank_motor.toml {SHORT} 0.05", 5, False),
    "robot with clearances": (f"simulate three_rrr_clearance.toml {SHORT} 0.01", 6, False),
    "sensitivity": (
        "sensitivity seven_bar.toml --duration 0.05 --no-error-estimate --quiet --wrt joints.A.clearance"
        " joints.B.viscosity sdf.links.link6.mass drives.O1.speed sdf.links.slider7.mass",
        1,
        True,
    ),
    "linear model": ("linearise slider_crank_motor.toml --quiet", 1, True),
    "modes": ("modes slider_crank_flexible.toml --cycle 4", 2, True),
    "robot": ("modes three_rrr.toml --no-animation", 12, False),
    "bearing": (BEARING, 2, True),
    "sweep": (f"{SWEEP}:3 --quiet", 1, True),
    "map": (f"{SWEEP}:3 --vary drives.O1.speed=2:4:2 --limit A.force=20N --output A.force --quiet", 1, True),
    "wear": ("wear slider_crank_wear.toml --cycles 2000 --no-animation --quiet", 2, False),
    "identification": (f"identify {FIT} --profile", 3, False),
    "tolerances": ("tolerances slidercrank_tolerances.toml --samples 64", 3, False),
    "study": ("study sensitivity sevenbar_force.toml --samples 2", 2, False),
    "optimisation": ("optimise .ci/small_study.toml", 1, True),
}
QUICK = [name for name, (_, _, quick) in COMMANDS.items() if quick]


@pytest.mark.parametrize("size", ["85mm", pytest.param("160mm", marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    "name", [name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in COMMANDS]
)
def test_no_text_of_a_figure_is_cut_off_or_lies_on_another(name, size, drawn, tmp_path, pytestconfig, monkeypatch):
    monkeypatch.chdir(pytestconfig.rootpath)
    words, least, _ = COMMANDS[name]
    assert main([*words.split(), "--size", size, "--out", str(tmp_path / "out")]) == 0
    assert len(drawn) >= least, sorted(drawn)
    for file, figure in drawn.items():
        assert figure.get_size_inches()[0] == pytest.approx(float(size[:-2]) / 25.4), file
        assert faults(figure) == [], file
        assert figure.get_label().endswith("."), file
    for path in (tmp_path / "out").glob("*.png"):
        with Image.open(path) as picture:  # pages have the answer as alternative text
            assert picture.info["Description"], path.name


@pytest.mark.parametrize(
    ("path", "words"),
    [
        ("joints.A.clearance", "clearance of A"),
        ("sdf.links.link6.mass", "mass of link6"),
        ("sdf.links.link6.com.x", "centre of mass x of link6"),
        ("sdf.frames.rod_B.pose.yaw", "angle of rod_B"),
        ("links.rod.youngs_modulus", "Young's modulus of rod"),
        ("parameters.load", "parameter load"),
        ("duration", "duration"),
    ],
)
def test_a_value_is_named_in_words(path, words):
    assert name_of_value(path) == words


def test_an_output_is_named_in_words():
    assert [name_of_output(name) for name in ("A.force", "rod.omega", "rod.stress")] == [
        "force in A",
        "angular velocity of rod",
        "largest stress in rod",
    ]
