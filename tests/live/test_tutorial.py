"""The answers of the live page's tutorial agree with the page."""

import pytest

import linkages
from linkages.show.live.session import Session


def peaks(name, values, runs=15):
    """Peaks of the steady motion, or of the first run of a motion that does not repeat."""
    session = Session(linkages.load(linkages.find_file(f"{name}.toml")), limit=600.0)
    for _ in range(runs):
        view = session.compute(values)
        if view["settled"]:
            break
    return view, {row["name"]: row for row in session.numbers()["table"]}


def film(viscosity):
    return peaks("seven_bar", {f"joints.{name}.viscosity": viscosity for name in "AB"})[1]


@pytest.mark.parametrize(("viscosity", "ratio"), [(0.4, 0.476), (0.2, 0.684), (0.05, 0.923), (0.005, 0.994)])
def test_the_film_carries_the_load(viscosity, ratio):
    table = film(viscosity)
    assert table["A.eccentricity_ratio"]["value"] == pytest.approx(ratio, abs=1e-3)
    assert table["A.force"]["value"] == pytest.approx(6.97, abs=0.015)


def test_a_direction_moves_the_peaks():
    table = peaks("seven_bar", {"drives.O4.speed": 6.283185307})[1]
    assert table["slider7.ax"]["value"] == pytest.approx(8.05, abs=5e-3)
    assert table["A.force"]["value"] == pytest.approx(12.8, abs=0.05)


def test_a_clearance_moves_the_journal_and_a_length_exchanges_torques():
    assert peaks("seven_bar", {"joints.B.clearance": 7.8e-4})[1]["B.eccentricity_ratio"]["value"] == pytest.approx(
        0.9, abs=3e-3
    )
    long, short = (peaks("seven_bar", {"sdf.frames.link3_C.pose.x": length})[1] for length in (0.318, 0.2875))
    ratios = [short[f"{name}.torque"]["value"] / long[f"{name}.torque"]["value"] for name in ("O4", "O1")]
    assert ratios == pytest.approx([0.9, 2.05], rel=5e-3)


def test_a_short_link_locks_the_press():
    session = Session(linkages.load(linkages.find_file("seven_bar.toml")))
    assert session.compute({"sdf.frames.link2_C.pose.x": 0.13})["locked"] == pytest.approx(1.511, abs=1e-3)


def test_the_mass_of_a_driven_crank_changes_no_force_in_the_clearance_joints():
    heavy, light = (peaks("seven_bar", {"sdf.links.crank4.mass": mass})[1] for mass in (0.5, 0.107))
    for name in ("A.force", "B.force"):
        assert heavy[name]["value"] == pytest.approx(light[name]["value"], rel=1e-6)
    other = peaks("seven_bar", {"sdf.links.link2.mass": 0.4})[1]
    assert abs(other["A.force"]["value"] - light["A.force"]["value"]) > 0.1
    assert abs(other["B.force"]["value"] - light["B.force"]["value"]) > 0.1


@pytest.mark.slow
@pytest.mark.parametrize(("viscosity", "ratio"), [(0.1, 0.45), (0.01, 0.93), (0.003, 0.986)])
def test_contact_begins(viscosity, ratio):
    table = peaks("seven_bar_mixed", {f"joints.{name}.viscosity": viscosity for name in "AB"}, 1)[1]
    assert table["A.eccentricity_ratio"]["value"] == pytest.approx(ratio, abs=5e-3)


@pytest.mark.slow
def test_the_journal_touches():
    table = peaks("seven_bar_mixed", {f"joints.{name}.viscosity": 1e-3 for name in "AB"}, 1)[1]
    assert table["A.eccentricity_ratio"]["value"] > 1.0


def test_friction_makes_a_dry_motion_repeat():
    speed = {"drives.O.speed": 200.0}
    view, _ = peaks("slider_crank_dry", {**speed, "joints.B.friction.coefficient": 0.0})
    assert not view["periodic"]
    view, table = peaks("slider_crank_dry", {**speed, "joints.B.friction.coefficient": 0.2})
    assert view["periodic"]
    assert table["B.force"]["value"] == pytest.approx(828.0, rel=5e-3)
