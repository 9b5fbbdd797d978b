"""Names in words: one function for the live page, reports, animations."""

import pytest

import linkages
from linkages.results.outputs.registry import names
from linkages.show.live.controls import controls
from linkages.show.plots.names import name_of_output, name_of_value, sentence


@pytest.mark.parametrize(
    ("path", "words"),
    [
        ("joints.A.clearance", "Clearance of A"),
        ("sdf.links.link6.mass", "Mass of link6"),
        ("sdf.frames.link2_C.pose.x", "Position x of link2_C"),
        ("sdf.links.rod.pose.yaw", "Angle of rod"),
        ("sdf.links.rod.com.x", "Centre of mass x of rod"),
        ("joints.B.contact.youngs_modulus", "Contact Young's modulus of B"),
        ("sdf.parameters.r", "Parameter r"),
        ("solver.accuracy", "Accuracy of the solver"),
        ("duration", "Duration"),
    ],
)
def test_a_value_has_a_name(path, words):
    assert sentence(name_of_value(path)) == words


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("slider7.ax", "Acceleration x of slider7"),
        ("A.eccentricity_ratio", "Eccentricity ratio of A"),
        ("slider7.x.jitter", "Position x jitter of slider7"),
        ("ideal.A.force", "Ideal force in A"),
        ("q.C2", "Coordinate of C2"),
        ("energy", "Energy"),
    ],
)
def test_an_output_has_a_name(name, words):
    assert sentence(name_of_output(name)) == words


@pytest.mark.parametrize(
    "machine", ["seven_bar_mixed", "slider_crank_flexible", "slider_crank_motor", "gear_rattle", "slider_crank_guide"]
)
def test_two_outputs_or_values_never_share_a_name(machine):
    """Otherwise a reader could not tell rows of one table apart."""
    system = linkages.load(linkages.find_file(f"{machine}.toml"))
    for found in (
        [sentence(name_of_output(name)) for name in names(system)],
        [sentence(name_of_value(path)) for path in controls(system)],
    ):
        assert sorted({one for one in found if found.count(one) > 1}) == []
