"""Ideal kinematics against closed forms; branches, mobility, singular positions."""

import numpy as np
import pytest
from machines import PLANES, bar, circle_intersection, four_bar, joint, model, seven_bar_slider, slider_crank, solid
from reference_machines import parallelogram_sdf
from shipped import NAMES, shipped

from linkages import AssemblyError, InputError, Status, ideal
from linkages.results.outputs.columns import columns
from linkages.system.assembly import independent

SPEED = 7.0
DRIVE = f"duration = 1.8\n[drives.O]\nspeed = {SPEED}\n"


@pytest.fixture
def motion(system_of):
    """The ideal motion of a machine, as a trajectory."""
    return lambda sdf, toml=DRIVE: ideal(system_of(sdf, toml))


def differentiate(f, t, h=1e-4):
    """First and second derivative by sixth-order central differences."""
    weights = np.array([-1, 9, -45, 0, 45, -9, 1]) / 60
    second = np.array([2, -27, 270, -490, 270, -27, 2]) / 180
    values = np.array([f(t + k * h) for k in range(-3, 4)])
    return np.tensordot(weights, values, 1) / h, np.tensordot(second, values, 1) / h**2


TIMES = np.linspace(0.01, 1.79, 97)


@pytest.mark.parametrize("play", ["", '[joints.A]\nmodel="lubricated"\nclearance=1e-4\nviscosity=0.1\n'])
@pytest.mark.parametrize("plane", PLANES)
def test_four_bar_follows_freudensteins_closed_form(system_of, play, plane):
    ground, crank, coupler, follower = 0.3, 0.1, 0.25, 0.2
    system = system_of(four_bar(plane=plane), DRIVE + play)
    sign = system.mechanism.joint["O"].sign
    found = ideal(system).evaluate(TIMES)

    def angle(t):
        tip = crank * np.array([np.cos(SPEED * t), np.sin(SPEED * t)])
        pins = np.array([circle_intersection(p, coupler, (ground, 0.0), follower) for p in tip.T])
        return np.unwrap(np.arctan2(pins[:, 1], pins[:, 0] - ground))

    got = found["follower.angle"]
    expected = angle(TIMES)
    rate, acceleration = differentiate(angle, TIMES)
    np.testing.assert_allclose(sign * (got - got[0]), expected - expected[0], atol=1e-12)
    np.testing.assert_allclose(sign * found["follower.omega"], rate, atol=1e-9)
    np.testing.assert_allclose(sign * found["follower.alpha"], acceleration, atol=2e-6)  # differences


@pytest.mark.parametrize("offset", [0.0, 0.02])
def test_slider_crank_follows_its_closed_form(motion, offset):
    r, L = 0.05, 0.12
    found = motion(slider_crank(r, L, offset=offset)).evaluate(TIMES)

    def x(t):
        return r * np.cos(SPEED * t) + np.sqrt(L**2 - (offset - r * np.sin(SPEED * t)) ** 2)

    rate, acceleration = differentiate(x, TIMES)
    np.testing.assert_allclose(found["slider.x"], x(TIMES), atol=1e-14)
    np.testing.assert_allclose(found["slider.vx"], rate, atol=1e-10)
    np.testing.assert_allclose(found["slider.ax"], acceleration, atol=1e-6)


def test_the_linkages_of_the_sources_are_there():
    names = ("four_bar_dry", "five_bar_dry", "six_bar_dry", "seven_bar", "seven_bar_dry", "slider_crank_dry")
    assert set(names) <= set(NAMES)


def test_drag_link_follows_its_closed_form():
    """Pins by intersecting circles; the follower's speed from the vector loop; both cranks turn fully."""
    ground, crank, coupler, follower = 0.1, 0.2, 0.18, 0.22  # m, as in the file
    system = shipped("four_bar_dry", **{"drives.O.ramp": 0.0})
    speed = system.value("drives.O.speed")
    times = np.linspace(0.0, 2.0 * np.pi / speed, 73)
    found = ideal(system).evaluate(times)
    theta = 0.5 * np.pi + speed * times
    a = crank * np.column_stack([np.cos(theta), np.sin(theta)])
    b = np.array([circle_intersection(pin, coupler, (ground, 0.0), follower) for pin in a])
    rounding = 1e-9  # m: the file's angles close the loop to its nine digits; the assembly does the rest
    np.testing.assert_allclose(found["follower_B.x"], b[:, 0], rtol=0, atol=rounding)
    np.testing.assert_allclose(found["follower_B.y"], b[:, 1], rtol=0, atol=rounding)
    theta_3 = np.arctan2(*(b - a).T[::-1])
    theta_4 = np.arctan2(b[:, 1], b[:, 0] - ground)
    rate = speed * crank / follower * np.sin(theta - theta_3) / np.sin(theta_4 - theta_3)
    np.testing.assert_allclose(found["follower.omega"], rate, rtol=1e-8)
    assert rate.min() > 0.0
    assert np.ptp(found["follower.angle"]) == pytest.approx(2.0 * np.pi, rel=1e-9)


@pytest.mark.parametrize("w4", [2 * np.pi, -2 * np.pi])
def test_seven_bar_follows_its_closed_form(fast_press, w4):
    times = np.linspace(0.01, 1.9, 150)
    found = ideal(fast_press.replaced({"drives.O4.speed": w4})).evaluate(times)
    x = lambda t: seven_bar_slider(t, w4=w4)  # noqa: E731
    rate, acceleration = differentiate(x, times)
    np.testing.assert_allclose(found["slider7.x"], x(times), atol=1e-13)
    np.testing.assert_allclose(found["slider7.vx"], rate, atol=1e-9)
    np.testing.assert_allclose(found["slider7.ax"], acceleration, atol=1e-6)


@pytest.mark.parametrize(("w4", "low", "high"), [(2 * np.pi, -4.667, 3.524), (-2 * np.pi, -4.853, 6.517)])
def test_seven_bar_ideal_acceleration_range(fast_press, w4, low, high):
    """The ranges that an independent calculation of the same data gave, to its printed digits."""
    system = fast_press.replaced({"drives.O4.speed": w4, "duration": 1.0})
    acceleration = ideal(system).evaluate(np.linspace(0, 1, 4001))["slider7.ax"]
    assert acceleration.min() == pytest.approx(low, abs=6e-4)
    assert acceleration.max() == pytest.approx(high, abs=6e-4)


def test_ideal_drive_does_the_work_that_becomes_kinetic_energy(fast_press):
    """Inverse dynamics: the drives' power is the rate of the kinetic energy (no gravity, no loss)."""
    motion = ideal(fast_press)
    times, h = np.linspace(0.05, 1.9, 50), 1e-5
    found = motion.evaluate(times)
    power = sum(found[f"{d}.torque"] * found[f"{d}.rate"] for d in ("O1", "O4"))
    energy = [motion.evaluate(times + k * h)["kinetic_energy"] for k in (-1, 1)]
    np.testing.assert_allclose(power, (energy[1] - energy[0]) / (2 * h), atol=1e-8)


def test_the_drawn_branch_is_kept(motion):
    """The same lengths drawn on the other side assemble on the other side."""
    up = four_bar()
    x, y = circle_intersection((0.1, 0.0), 0.25, (0.3, 0.0), 0.2)
    down = up
    for angle in (np.arctan2(y, x - 0.1), np.arctan2(y, x - 0.3)):
        assert f"0 0 {angle}</pose>" in down
        down = down.replace(f"0 0 {angle}</pose>", f"0 0 {-angle}</pose>")
    tips = [motion(text).evaluate(TIMES[:1])["follower_tip.y"][0] for text in (up, down)]
    assert tips[0] > 0.05
    assert tips[1] < -0.05


def test_a_drawing_that_does_not_close_is_assembled(motion):
    rough = four_bar().replace("<pose>0.2 0 0 0 0 0</pose>", "<pose>0.21 0 0 0 0 0</pose>")
    found = motion(rough).evaluate(TIMES)
    expected = circle_intersection(0.1 * np.array([np.cos(0.07), np.sin(0.07)]), 0.25, (0.3, 0.0), 0.21)
    assert found["B_on_follower.x"][0] == pytest.approx(expected[0], abs=1e-12)
    assert found["coupler_tip.y"][0] == pytest.approx(expected[1], abs=1e-12)


def test_start_angle_is_reached_along_the_branch(motion):
    toml = "duration = 0.1\n[drives.O]\nspeed = 7.0\nangle = 4.0\n"
    found = motion(four_bar(), toml).evaluate(np.zeros(1))
    expected = circle_intersection(0.1 * np.array([np.cos(4.0), np.sin(4.0)]), 0.25, (0.3, 0.0), 0.2)
    assert found["coupler_tip.x"][0] == pytest.approx(expected[0], abs=1e-12)
    assert found["coupler_tip.y"][0] == pytest.approx(expected[1], abs=1e-12)


def test_no_assembly_is_a_named_status(system_of):
    """A double-rocker: its crank cannot reach half a turn."""
    sdf = four_bar(crank=0.2, coupler=0.15, follower=0.2)
    system = system_of(sdf, DRIVE.replace("speed", "angle = 3.0\nspeed"))
    with pytest.raises(AssemblyError) as caught:
        _ = system.assembly
    assert caught.value.status is Status.NO_ASSEMBLY


def test_ideal_motion_ends_where_the_loop_opens(motion):
    found = motion(four_bar(crank=0.2, coupler=0.15, follower=0.2))
    assert found.status is Status.LOCKED
    reach = np.arccos((0.2**2 + 0.3**2 - 0.35**2) / (2 * 0.2 * 0.3))  # coupler and follower in line
    assert SPEED * found.time[-1] == pytest.approx(reach, abs=1e-9)


def test_mobility_and_quality_are_reported(seven_bar):
    assert seven_bar.assembly.mobility == 2
    assert seven_bar.determinate
    assert 1e-3 < seven_bar.assembly.quality <= 1.0


def test_a_parallelogram_with_a_redundant_link_still_assembles(system_of):
    """Three parallel cranks: one closure too many, one degree of freedom all the same."""
    parts = "".join(
        f'<frame name="g{i}" attached_to="world"><pose relative_to="__model__">{0.2 * i} 0 0 0 0 0</pose></frame>'
        + bar(f"c{i}", 0.1, f"g{i}", 1.0)
        + joint(f"G{i}", "world", f"c{i}")
        for i in range(3)
    )
    beam = bar("beam", 0.4, "c0_tip", -1.0)
    pins = joint("P0", "c0_tip", "beam") + "".join(
        f'<frame name="b{i}" attached_to="beam"><pose>{0.2 * i} 0 0 0 0 0</pose></frame>'
        + joint(f"P{i}", f"c{i}_tip", f"b{i}")
        for i in (1, 2)
    )
    system = system_of(model("press", parts + beam + pins), "duration=0.5\n[drives.G0]\nspeed=2.0\n")
    assert system.assembly.mobility == 1
    found = ideal(system).evaluate(np.linspace(0, 0.5, 11))
    np.testing.assert_allclose(found["beam.angle"], 0.0, atol=1e-12)
    np.testing.assert_allclose(found["c2.omega"], 2.0, atol=1e-10)
    assert np.isfinite(found["P1.force"]).all()


@pytest.mark.parametrize(
    "drive", ["speed = 2.0", "speed = 2.0\nangle = 1.0", "torque = 0.1", "torque = 0.1\nspeed = 2.0"]
)
def test_a_four_bar_drawn_flat_is_refused(system_of, drive):
    """All links on one line, where parallelogram and contra-parallelogram meet: one degree of freedom, not two."""
    system = system_of(parallelogram_sdf(angle=0.0), f"duration = 0.5\n[drives.O]\n{drive}\n")
    with pytest.raises(AssemblyError, match="two motions branch at the reference configuration") as caught:
        _ = system.assembly
    assert caught.value.status is Status.SINGULAR
    tree = system.tree
    assert tree.size - independent(tree, tree.closure_rows, np.zeros(tree.size)) == 1


def test_too_many_drives_are_refused(system_of):
    system = system_of(four_bar(), DRIVE + "[drives.Q]\nspeed = 1.0\n")
    with pytest.raises(InputError, match="2 drives for 1 degree of freedom of four_bar; drive fewer joints"):
        _ = system.assembly


HINT = 'for another direction change the axis, in a description "along ground at 90 deg"'


def test_an_immobile_machine_says_along_which_directions_its_slides_move(system_of):
    """A block below its crank that slides along x, as by default, and not along y, cannot move."""
    links = bar("crank", 0.04, "__model__", angle=np.pi / 2) + bar("rod", 0.15, "crank_tip")
    links += solid("block", 0.1, 1e-4, "0 0.19 0 0 0 0") + joint("O", "world", "crank") + joint("A", "crank_tip", "rod")
    links += joint("B", "rod_tip", "block")
    for axis, moves in (("1 0 0", False), ("0 1 0", True)):
        system = system_of(model("press", links + joint("G", "world", "block", "prismatic", axis)), DRIVE)
        if moves:
            assert system.assembly.mobility == 1
            continue
        with pytest.raises(AssemblyError, match="is immobile") as caught:
            _ = system.assembly
        assert f"(G slides along x; {HINT})" in str(caught.value)


def test_a_machine_without_freedom_says_along_which_directions_its_slides_move(system_of):
    guides = joint("G", "world", "block", "prismatic", "1 0 0") + joint(
        "H", "world", "block", "prismatic", "0.5 0.8660254 0"
    )
    system = system_of(model("guides", solid("block", 0.1, 1e-4) + guides), "duration = 1.0\n[drives.G]\nspeed = 1.0\n")
    with pytest.raises(InputError, match="1 drive for 0 degrees of freedom of guides") as caught:
        _ = system.assembly
    assert f"(G slides along x and H slides at 60 degrees to x; {HINT})" in str(caught.value)


def test_offset_places_the_journal(seven_bar):
    def at_start(offset):
        system = seven_bar.replaced({"joints.A.offset": offset})
        q, v = system.assembly.q[None], system.assembly.v[None]
        found = columns(system, np.zeros(1), q, v, 0 * v)
        return [found[f"link2.{axis}"][0] - found[f"crank1_A.{axis}"][0] for axis in "xy"]

    np.testing.assert_allclose(at_start([1e-4, -5e-5]), [1e-4, -5e-5], rtol=0, atol=1e-15)
    np.testing.assert_allclose(at_start([0.0, 0.0]), 0.0, atol=1e-15)
