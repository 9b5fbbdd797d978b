"""Derivatives of a system's numbers with respect to values: those that they fill, or differences of two systems."""

from typing import Any, NamedTuple
from unittest import mock

import numpy as np
import pytest
from shipped import NAMES, shipped

import linkages
from linkages.base.kernel.block import contents
from linkages.engines.compiled.derivatives import neighbours as module
from linkages.engines.compiled.derivatives import start_derivatives as start_module
from linkages.engines.compiled.derivatives.neighbours import Neighbours, neighbours
from linkages.engines.compiled.derivatives.start_derivatives import start_derivatives
from linkages.engines.compiled.run.model import start_state
from linkages.results.outputs.registry import names, packer
from linkages.system.owners import owners

LINEAR = [
    "joints.A.clearance",
    "joints.A.viscosity",
    "joints.B.viscosity",
    "sdf.links.link2.mass",
    "sdf.links.link6.mass",
]


class Numbers(NamedTuple):
    """An array of integers, and a number."""

    whole: Any
    number: float


def _dense(near):
    """Return the derivatives of all numbers of the arrays."""
    found = np.zeros(len(contents(near.system.arrays).words))
    places, rates = near.arrays
    found[places] = rates
    return found


def _has_systems(near):
    return "_systems" in vars(near)


def _compare(near, system, value):
    """Compare with differences of systems."""
    differences = Neighbours(system, value)
    with mock.patch.object(module, "_owners", return_value={}):
        own = _dense(differences)
    np.testing.assert_array_equal(_dense(near) != 0.0, own != 0.0)
    np.testing.assert_allclose(_dense(near), own, rtol=1e-7)


#: Files with values of many kinds, beside the shipped ones.
KEYS = {
    "elements": """[springs.S]
point = "slider"
anchor = [0.3, 0.0]
stiffness = 4530.0
free_length = 0.07785
damping = 2.0
[torsion_springs.T]
joint = "A"
stiffness = 3.0
free_angle = 0.1
damping = 0.01
"""
}


@pytest.mark.parametrize("name", NAMES)
def test_the_register_has_all_numbers_that_a_value_fills(name):
    """Numbers of arrays, of the closed linkage at the start and of all outputs, against differences of systems."""
    check_register(shipped(name))


def test_the_register_has_the_numbers_of_springs(tmp_path):
    text = linkages.find_file("slider_crank_lubricated.toml").read_text()
    file = f'"{linkages.find_file("slider_crank.sdf")}"'
    (tmp_path / "sprung.toml").write_text(text.replace('"slider_crank.sdf"', file) + KEYS["elements"])
    system = linkages.load(tmp_path / "sprung.toml")
    known = check_register(system)
    assert {"springs.S.damping", "springs.S.free_length", "torsion_springs.T.free_angle"} <= known


def check_register(system):
    read = packer(system, names(system, False))
    makes = [module._arrays, start_module._closure, read]
    register = owners(system)
    for path in register:
        try:
            value = system.value(path)
        except linkages.InputError:
            continue  # not given, as a drive's angle
        for make in makes:
            found = Neighbours(system, path).rates(make)
            with mock.patch.object(module, "_owners", return_value={}):
                expected = Neighbours(system, path).rates(make)
            unit = max(abs(value), 1e-2)
            real = np.abs(expected.rates) * unit > 1e-9
            np.testing.assert_array_equal(found.places, expected.places[real], err_msg=path)
            np.testing.assert_allclose(found.rates, expected.rates[real], rtol=1e-7, err_msg=path)
    return set(register)


def test_values_that_fill_numbers_need_no_other_system():
    system = linkages.load(linkages.find_file("seven_bar.toml"))
    oil = linkages.Direction("oil", 0.5, {"joints.A.viscosity": 2.0, "joints.B.viscosity": 1.0})
    values = [*LINEAR, "drives.O1.speed", "drives.O4.angle", "gravity.x", "gravity.y", oil]
    for near, value in zip(neighbours(system, values), values, strict=True):
        _compare(near, system, value)
        assert not _has_systems(near), value
    assert not start_derivatives(system, neighbours(system, LINEAR)).any()


def test_lengths_have_their_own_systems_and_add_up():
    """The place of the slider in the world is the sum of both lengths."""
    system = linkages.load(linkages.find_file("seven_bar.toml"))
    lengths = ["sdf.frames.link2_C.pose.x", "sdf.frames.link6_D.pose.x"]
    both = linkages.Direction("both", 1.0, dict(zip(lengths, (1.0, -2.0), strict=True)))
    one, two, sum_of_both = map(_dense, neighbours(system, [*lengths, both]))
    np.testing.assert_allclose(sum_of_both, one - 2.0 * two, atol=1e-9)
    assert np.count_nonzero(one) > 0


@pytest.mark.parametrize("path", ["sdf.frames.link2_C.pose.x", "drives.O1.speed"])
@pytest.mark.parametrize("offset", [[0.0, 0.0], [1e-4, -2e-4]])
def test_the_start_follows_a_value_as_the_starts_of_assembled_systems_do(path, offset):
    system = linkages.load(linkages.find_file("seven_bar.toml"), {"joints.A.offset": offset})
    value = system.value(path)
    step = 1e-3 * value
    near = [start_state(system.replaced({path: value + k * step})) for k in (-2, -1, 1, 2)]
    expected = ((near[0] - near[3]) / 12 + (near[2] - near[1]) * 2 / 3) / step
    found = start_derivatives(system, neighbours(system, [path, "sdf.links.link2.mass"]))
    assert np.abs(expected).max() > 0.0
    assert np.abs(found[:, 0] - expected).max() < 1e-8 * np.abs(expected).max()
    assert not found[:, 1].any()


def test_values_with_other_numbers_have_their_own_systems():
    """The damping of a contact is not proportional to its restitution."""
    system = linkages.load(linkages.find_file("slider_crank_dry.toml"))
    values = ["joints.B.contact.restitution", "sdf.links.rod.mass", "joints.B.clearance", "sdf.frames.rod_B.pose.x"]
    for near, value in zip(neighbours(system, values), values, strict=True):
        assert near.arrays.places.size
        assert _has_systems(near) != (value == "sdf.links.rod.mass"), value


def test_a_value_that_changes_an_integer_has_no_derivative():
    system = linkages.load(linkages.find_file("seven_bar.toml"))

    def make(one):
        return Numbers(np.array([round(1e9 * one.value("sdf.frames.link2_C.pose.x"))]), 2.0)

    near = Neighbours(system, "sdf.frames.link2_C.pose.x")
    with pytest.raises(linkages.InputError, match="changes the structure"):
        near.rates(make)


def test_rounding_is_no_change():
    system = linkages.load(linkages.find_file("seven_bar.toml"))
    near = Neighbours(system, "sdf.frames.link2_C.pose.x")
    here, places = contents(system.arrays).words.view(np.float64), near.arrays.places
    assert np.all(np.abs(near.arrays.rates * near.magnitude) > 1e-9 * np.abs(here[places]))


SPRUNG = """
[springs.S]
point = "slider"
anchor = [0.3, 0.0]
stiffness = 4530.0
free_length = 0.07785
damping = 2.0
"""


def test_springs_lengths_and_speeds_share_a_run(tmp_path):
    """Loads, lengths and drives, in a linkage with a spring."""
    text = linkages.find_file("slider_crank_lubricated.toml").read_text()
    (tmp_path / "sprung.toml").write_text(
        text.replace('"slider_crank.sdf"', f'"{linkages.find_file("slider_crank.sdf")}"') + SPRUNG
    )
    system = linkages.load(tmp_path / "sprung.toml", {"duration": 0.002, "solver.accuracy": 1e-12})
    values, outputs = ["springs.S.stiffness", "sdf.frames.rod_B.pose.x", "drives.O.speed"], ["B.fy", "slider.x"]
    run, times = linkages.simulate(system, outputs=outputs, wrt=values), np.linspace(0.0, 0.002, 5)[1:]
    for value, step in zip(values, (1e-2, 1e-3, 1e-3), strict=True):  # the spring is weak
        h = step * system.value(value)
        near = [linkages.simulate(system.replaced({value: system.value(value) + k * h})) for k in (-2, -1, 1, 2)]
        columns = [one.evaluate(times) for one in near]
        for name in outputs:
            before, lower, upper, after = (column[name] for column in columns)
            expected = ((before - after) / 12 + (upper - lower) * 2 / 3) / h
            found = run.sensitivity.evaluate(times)[value][name]
            assert np.abs(found - expected).max() < 2e-6 * np.abs(expected).max(), (value, name)


def test_the_length_that_scales_errors_does_not_change_with_a_value():
    """The diagonal of the box around the joints has a kink where a corner moves to another joint."""
    arrays = (system := linkages.load(linkages.find_file("four_bar_dry.toml"))).arrays
    size = np.flatnonzero(contents(arrays).words != contents(arrays._replace(size=2.0 * arrays.size)).words)
    for path in ("sdf.frames.ground_Q.pose.x", "sdf.frames.crank_A.pose.x"):
        near = Neighbours(system, path)
        assert len(near.arrays.places) > 0
        assert not np.isin(size, near.arrays.places).any()
        assert near._systems[0][0].arrays.size != arrays.size
