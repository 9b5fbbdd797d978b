"""Ideal kinematics against closed forms; branches, mobility, singular positions."""

import numpy as np
import pytest
from machines import PLANES, circle_intersection, four_bar, slider_crank

from linkages.errors import InputError, Status
from linkages.model.experiment import load
from linkages.system.assembly import AssemblyError, IdealMotion, assemble

SPEED = 7.0
DRIVE = f"duration = 1.8\n[drives.O]\nspeed = {SPEED}\n"


def motion(experiment_file, sdf, toml=DRIVE):
    mechanism, experiment = load(experiment_file(sdf, toml))
    return IdealMotion(assemble(mechanism, experiment), experiment)


def differentiate(f, t, h=1e-4):
    """First and second derivative by sixth-order central differences."""
    weights = np.array([-1, 9, -45, 0, 45, -9, 1]) / 60
    second = np.array([2, -27, 270, -490, 270, -27, 2]) / 180
    values = np.array([f(t + k * h) for k in range(-3, 4)])
    return np.tensordot(weights, values, 1) / h, np.tensordot(second, values, 1) / h**2


TIMES = np.linspace(0.01, 1.79, 97)


@pytest.mark.parametrize("play", ["", '[joints.A]\nmodel="lubricated"\nclearance=1e-4\nviscosity=0.1\n'])
@pytest.mark.parametrize("plane", PLANES)
def test_four_bar_follows_freudensteins_closed_form(experiment_file, play, plane):
    ground, crank, coupler, follower = 0.3, 0.1, 0.25, 0.2
    ideal = motion(experiment_file, four_bar(plane=plane), DRIVE + play)
    sign = ideal.assembly.tree.mechanism.joint["O"].sign
    columns = ideal.evaluate(TIMES)

    def angle(t):
        tip = crank * np.array([np.cos(SPEED * t), np.sin(SPEED * t)])
        pins = np.array([circle_intersection(p, coupler, (ground, 0.0), follower) for p in tip.T])
        return np.unwrap(np.arctan2(pins[:, 1], pins[:, 0] - ground))

    got = columns["follower.angle"]
    expected = angle(TIMES)
    rate, acceleration = differentiate(angle, TIMES)
    np.testing.assert_allclose(sign * (got - got[0]), expected - expected[0], atol=1e-12)
    np.testing.assert_allclose(sign * columns["follower.omega"], rate, atol=1e-9)
    np.testing.assert_allclose(sign * columns["follower.alpha"], acceleration, atol=2e-6)  # differences


@pytest.mark.parametrize("offset", [0.0, 0.02])
def test_slider_crank_follows_its_closed_form(experiment_file, offset):
    r, L = 0.05, 0.12
    columns = motion(experiment_file, slider_crank(r, L, offset=offset)).evaluate(TIMES)

    def x(t):
        return r * np.cos(SPEED * t) + np.sqrt(L**2 - (offset - r * np.sin(SPEED * t)) ** 2)

    rate, acceleration = differentiate(x, TIMES)
    np.testing.assert_allclose(columns["slider.x"], x(TIMES), atol=1e-14)
    np.testing.assert_allclose(columns["slider.vx"], rate, atol=1e-10)
    np.testing.assert_allclose(columns["slider.ax"], acceleration, atol=1e-6)


def seven_bar_slider(t, w1=2 * np.pi, w4=2 * np.pi):
    """Slider position from three dyads, Chen 2025 Table 2."""
    a = 0.08 * np.array([np.cos(w1 * t), np.sin(w1 * t)])
    phase = np.radians(310.79) + w4 * t
    b = np.array([0.08 * np.cos(phase), 0.301 + 0.08 * np.sin(phase)])
    c = np.array([circle_intersection(p, 0.18, q, 0.318, side=-1.0) for p, q in zip(a.T, b.T, strict=True)])
    return c[:, 0] + np.sqrt(0.3**2 - c[:, 1] ** 2)


@pytest.mark.parametrize("w4", [2 * np.pi, -2 * np.pi])
def test_seven_bar_follows_its_closed_form(seven_bar, w4):
    mechanism, experiment = seven_bar
    experiment = experiment.replaced({"drives.O4.speed": w4})
    ideal = IdealMotion(assemble(mechanism, experiment), experiment)
    times = np.linspace(0.01, 1.9, 150)
    columns = ideal.evaluate(times)
    x = lambda t: seven_bar_slider(t, w4=w4)  # noqa: E731
    rate, acceleration = differentiate(x, times)
    np.testing.assert_allclose(columns["slider7.x"], x(times), atol=1e-13)
    np.testing.assert_allclose(columns["slider7.vx"], rate, atol=1e-9)
    np.testing.assert_allclose(columns["slider7.ax"], acceleration, atol=1e-6)


@pytest.mark.parametrize(("w4", "low", "high"), [(2 * np.pi, -4.667, 3.524), (-2 * np.pi, -4.853, 6.517)])
def test_seven_bar_ideal_acceleration_range(seven_bar, w4, low, high):
    """The ranges that an independent calculation of the same data gave, to its printed digits."""
    mechanism, experiment = seven_bar
    experiment = experiment.replaced({"drives.O4.speed": w4, "duration": 1.0})
    columns = IdealMotion(assemble(mechanism, experiment), experiment).evaluate(np.linspace(0, 1, 4001))
    assert columns["slider7.ax"].min() == pytest.approx(low, abs=6e-4)
    assert columns["slider7.ax"].max() == pytest.approx(high, abs=6e-4)


def test_ideal_drive_does_the_work_that_becomes_kinetic_energy(seven_bar):
    """Inverse dynamics: the drives' power is the rate of the kinetic energy (no gravity, no loss)."""
    mechanism, experiment = seven_bar
    ideal = IdealMotion(assemble(mechanism, experiment), experiment)
    times, h = np.linspace(0.05, 1.9, 50), 1e-5
    columns = ideal.evaluate(times)
    power = sum(columns[f"{d}.torque"] * columns[f"{d}.rate"] for d in ("O1", "O4"))
    energy = [ideal.evaluate(times + k * h)["kinetic_energy"] for k in (-1, 1)]
    np.testing.assert_allclose(power, (energy[1] - energy[0]) / (2 * h), atol=1e-8)


def test_the_drawn_branch_is_kept(experiment_file):
    """The same lengths drawn on the other side assemble on the other side."""
    up = four_bar()
    x, y = circle_intersection((0.1, 0.0), 0.25, (0.3, 0.0), 0.2)
    down = up
    for link, angle in (("coupler", np.arctan2(y, x - 0.1)), ("follower", np.arctan2(y, x - 0.3))):
        del link
        assert f"0 0 {angle}</pose>" in down
        down = down.replace(f"0 0 {angle}</pose>", f"0 0 {-angle}</pose>")
    tips = [motion(experiment_file, text).evaluate(TIMES[:1])["follower_tip.y"][0] for text in (up, down)]
    assert tips[0] > 0.05
    assert tips[1] < -0.05


def test_a_drawing_that_does_not_close_is_assembled(experiment_file):
    rough = four_bar().replace("<pose>0.2 0 0 0 0 0</pose>", "<pose>0.21 0 0 0 0 0</pose>")
    columns = motion(experiment_file, rough).evaluate(TIMES)
    expected = circle_intersection(0.1 * np.array([np.cos(0.07), np.sin(0.07)]), 0.25, (0.3, 0.0), 0.21)
    assert columns["B_on_follower.x"][0] == pytest.approx(expected[0], abs=1e-12)
    assert columns["coupler_tip.y"][0] == pytest.approx(expected[1], abs=1e-12)


def test_start_angle_is_reached_along_the_branch(experiment_file):
    toml = "duration = 0.1\n[drives.O]\nspeed = 7.0\nangle = 4.0\n"
    columns = motion(experiment_file, four_bar(), toml).evaluate(np.zeros(1))
    expected = circle_intersection(0.1 * np.array([np.cos(4.0), np.sin(4.0)]), 0.25, (0.3, 0.0), 0.2)
    assert columns["coupler_tip.x"][0] == pytest.approx(expected[0], abs=1e-12)
    assert columns["coupler_tip.y"][0] == pytest.approx(expected[1], abs=1e-12)


def test_no_assembly_is_a_named_status(experiment_file):
    """A double-rocker: its crank cannot reach half a turn."""
    mechanism, experiment = load(
        experiment_file(
            four_bar(crank=0.2, coupler=0.15, follower=0.2), DRIVE.replace("speed", "angle = 3.0\nspeed")
        )
    )
    with pytest.raises(AssemblyError) as caught:
        assemble(mechanism, experiment)
    assert caught.value.status is Status.NO_ASSEMBLY


def test_ideal_motion_ends_where_the_loop_opens(experiment_file):
    ideal = motion(experiment_file, four_bar(crank=0.2, coupler=0.15, follower=0.2))
    assert ideal.status in (Status.NO_ASSEMBLY, Status.SINGULAR)
    reach = np.arccos((0.2**2 + 0.3**2 - 0.35**2) / (2 * 0.2 * 0.3))  # coupler and follower in line
    assert SPEED * ideal.times[-1] == pytest.approx(reach, abs=0.03)


def test_mobility_and_quality_are_reported(seven_bar):
    assembly = assemble(*seven_bar)
    assert assembly.mobility == 2
    assert assembly.determinate
    assert 1e-3 < assembly.quality <= 1.0


def test_a_parallelogram_with_a_redundant_link_still_assembles(experiment_file):
    """Three parallel cranks: one closure too many, one degree of freedom all the same."""
    from machines import bar, joint, model

    parts = "".join(
        f'<frame name="g{i}" attached_to="world"><pose relative_to="__model__">{0.2 * i} 0 0 0 0 0</pose></frame>'
        + bar(f"c{i}", 0.1, f"g{i}", 1.0)
        + joint(f"G{i}", "world", f"c{i}")
        for i in range(3)
    )
    beam = bar("beam", 0.4, "c0_tip", -1.0)
    pins = joint("P0", "c0_tip", "beam") + "".join(
        f'<frame name="b{i}" attached_to="beam"><pose>{0.2 * i} 0 0 0 0 0</pose></frame>'
        f'<joint name="P{i}" type="revolute"><parent>c{i}_tip</parent><child>b{i}</child><axis><xyz>0 0 1</xyz></axis></joint>'
        for i in (1, 2)
    )
    ideal = motion(
        experiment_file, model("press", parts + beam + pins), "duration=0.5\n[drives.G0]\nspeed=2.0\n"
    )
    assert ideal.assembly.mobility == 1
    columns = ideal.evaluate(np.linspace(0, 0.5, 11))
    np.testing.assert_allclose(columns["beam.angle"], 0.0, atol=1e-12)
    np.testing.assert_allclose(columns["c2.omega"], 2.0, atol=1e-10)
    assert np.isfinite(columns["P1.force"]).all()


def test_too_many_drives_are_refused(experiment_file):
    mechanism, experiment = load(experiment_file(four_bar(), DRIVE + "[drives.Q]\nspeed = 1.0\n"))
    with pytest.raises(InputError, match="2 joints are driven, but four_bar has 1 degrees of freedom"):
        assemble(mechanism, experiment)


def test_offset_places_the_journal(seven_bar):
    mechanism, experiment = seven_bar
    moved = experiment.replaced({"joints.A.offset": [1e-4, -5e-5]})
    assembly = assemble(mechanism, moved)
    columns = IdealMotion(assemble(mechanism, experiment), experiment).evaluate(np.zeros(1))
    from linkages.outputs.columns import columns_from_states

    there = columns_from_states(
        assembly.tree, moved, np.zeros(1), assembly.q[None], assembly.v[None], 0 * assembly.v[None]
    )
    assert there["link2.x"][0] - there["crank1_A.x"][0] == pytest.approx(1e-4, abs=1e-15)
    assert there["link2.y"][0] - there["crank1_A.y"][0] == pytest.approx(-5e-5, abs=1e-15)
    assert columns["link2.x"][0] == pytest.approx(columns["crank1_A.x"][0], abs=1e-15)
