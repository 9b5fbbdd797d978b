"""Validity of the flexible-link model: each rule at its limit."""

from math import pi, sqrt

import numpy as np
import pytest
from shipped import BENT, run, shipped

from linkages import Status
from linkages.results.impacts import Impact
from linkages.results.joint_validity import outside
from linkages.results.trajectory import Trajectory

LENGTH = 0.3  # of the rod
CONTACT = {"law": "hunt-crossley", "stiffness": 1e9, "restitution": 0.9}
DRY = {"model": "dry", "clearance": 5e-5, "contact": CONTACT}
WALL = {"point": "slider", "anchor": [0.5, 0.0], "angle": 0.5 * pi, "contact": CONTACT}
FINE = {"links.rod.axial": 4}


def machine(**overrides):
    return shipped("slider_crank_flexible", **overrides)


def found(system, impacts=(), speed=150.0, compression=0.0, **eta):
    """Warnings of a run of two steps; in the second, modes of the rod, its load and the drive have these values."""
    modes = {
        f"q.rod.{name}": np.array([0.0, eta.get(name, 0.0)]) for name in system.tree.substructures["rod"].modes.names
    }
    turning = {f"{name}.omega": np.zeros(2) for name in system.mechanism.link} | {"O.rate": np.array([0.0, -speed])}
    rest = {"B.eccentricity_ratio": np.full(2, 0.5), "B.penetration": np.full(2, -2.5e-5)}
    rest["rod.compression"] = np.array([0.0, compression])
    return outside(system, Trajectory(np.array([0.0, 0.25]), modes | turning | rest, Status.OK), impacts)


def hit(duration, joint="B"):
    return Impact(joint, 0.125, 1.0, 0.0, duration, 1e3, 1e-6, 1.0, 1e3)


@pytest.mark.parametrize("name", BENT)
def test_shipped_machines_are_within_every_range(name):
    assert outside(shipped(name), run("compiled", name), ()) == []


@pytest.mark.parametrize(("part", "count"), [(0.98, 0), (-1.02, 1)])
def test_slopes_change_the_stiffness_by_one_per_cent_at_most(part, count):
    """The first mode is half a sine, whose slope is pi/L at the ends."""
    entries = found(machine(), bending1=part * sqrt(0.02) * LENGTH / pi)
    assert [(entry["kind"], entry["time"]) for entry in entries] == [("flexible", 0.25)] * count
    for entry in entries:
        limit = "the relative error of the stiffness is half its square, 1 % at 0.141; the link has `pieces` = 1"
        assert f"0.144 in rod at 0.25 s ({limit})" in entry["what"]


def test_a_link_in_pieces_is_advised_more_than_it_has():
    """Each of eight pieces is half a sine long: they need a slope of 1 % each."""
    system = machine(**{"links.rod.pieces": 8})
    names = [name for part in system.tree.deformable["rod"] for name in part.coordinates]
    bent = {f"q.{name}": np.array([0.0, name.endswith("bending1") * 0.2 * LENGTH / 8 / pi]) for name in names}
    rest = {f"{name}.omega": np.zeros(2) for name in system.mechanism.link} | {"O.rate": np.array([0.0, -150.0])}
    rest |= {"B.eccentricity_ratio": np.full(2, 0.5), "B.penetration": np.full(2, -2.5e-5)}
    rest["rod.compression"] = np.zeros(2)
    (entry,) = outside(system, Trajectory(np.array([0.0, 0.25]), bent | rest, Status.OK), ())
    assert "the link has `pieces` = 8" in entry["what"]
    assert "more `pieces`" in entry["remedy"]


@pytest.mark.parametrize(("part", "count"), [(0.49, 0), (0.51, 1)])
def test_struts_carry_half_of_eulers_load(part, count):
    euler = pi**2 * 2e11 * 0.008**4 / 12.0 / LENGTH**2
    entries = found(machine(), compression=part * euler)
    assert [(entry["kind"], entry["time"]) for entry in entries] == [("flexible", 0.25)] * count
    assert all("0.51 in rod at 0.25 s (half doubles" in entry["what"] for entry in entries)


@pytest.mark.parametrize(("axial", "count"), [(1, 1), (3, 1), (4, 0)])
def test_blows_need_four_stretching_modes(axial, count):
    system = machine(**{"joints.B": DRY, "links.rod.axial": axial})
    entries = found(system, [hit(1.0), hit(2.0)])
    assert [(entry["kind"], entry["time"]) for entry in entries] == [("flexible", 0.125)] * count
    assert all(f"{axial} in rod at 0.125 s (4 or more)" in entry["what"] for entry in entries)
    assert found(system) == []


@pytest.mark.parametrize(("part", "count"), [(1.02, 0), (0.98, 1)])
def test_the_shortest_contact_lasts_as_long_as_a_swing_of_the_fastest_mode(part, count):
    """Of four modes with one end held, as rods have them: 7/4 waves of sqrt(E/rho) in its length, 6 % more in this space."""
    system = machine(**{"joints.B": DRY}, **FINE)
    fastest = system.tree.substructures["rod"].modes.frequencies.max() / (2.0 * pi)
    assert 1.0 < fastest / (7.0 / 4.0 * sqrt(2e11 / 7870.0) / LENGTH) < 1.2
    entries = found(system, [hit(1.0), hit(part / fastest)])
    assert [(entry["kind"], entry["time"]) for entry in entries] == [("flexible", 0.125)] * count
    assert all(f"{part:.3g} in rod" in entry["what"] for entry in entries)


def test_contacts_of_other_links_do_not_count():
    system = machine(**{"contacts.wall": WALL, "joints.B": DRY})
    assert found(system, [hit(1e-5, "wall")]) == []
    assert len(found(system, [hit(1e-5, "wall"), hit(1e-5)])) == 2


@pytest.mark.parametrize(("part", "count"), [(0.98, 0), (1.02, 1)])
def test_drives_are_ten_times_slower_than_the_fastest_bending_mode(part, count):
    system = machine(**FINE)
    entries = found(system, speed=part * system.tree.substructures["rod"].modes.frequencies[3] / 10.0)
    assert [(entry["kind"], entry["time"]) for entry in entries] == [("flexible", 0.25)] * count
    assert all(f"{10 / part:.3g} in rod at 0.25 s (10 or more)" in entry["what"] for entry in entries)
