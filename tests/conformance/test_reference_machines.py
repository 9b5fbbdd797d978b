"""Machines whose motion is known independently: published values, closed forms, singular positions, long runs."""

import andrews
import numpy as np
import pytest
from engines import slow_on_drake
from machines import bar, joint, model, slider_crank
from reference_machines import (
    WINDOWS,
    chain_model,
    chain_sdf,
    equal_slider_crank_angle,
    equal_slider_crank_sdf,
    folding_angles,
    folding_sdf,
    parallelogram_angle,
    parallelogram_sdf,
    slider_crank_motion,
    windows_angle,
    windows_sdf,
)

from linkages import simulate

#: The tightest accuracy at which each engine is asked, and the error that it may have then, in parts of the largest
#: value.
ACCURACY = {"compiled": 1e-12, "drake": 1e-10}
ERROR = {"compiled": 1e-9, "drake": 1e-7}


@pytest.fixture
def run(run, engine):
    """Run a machine without stiff laws at an accuracy, by default the tightest; its loops stay closed."""

    def simulated(sdf, toml, accuracy=None):
        accuracy = accuracy or ACCURACY[engine]
        result = run(sdf, f'{toml}[solver]\nintegrator = "dormand_prince_5_4"\naccuracy = {accuracy}\n')
        if engine == "compiled":
            assert result.provenance["loop_error"] <= 1e-10
        return result

    return simulated


# --- squeezing mechanism ----------------------------------------------------------------------------------------------

SQUEEZER = f"""duration = {andrews.END_TIME}
gravity = [0.0, 0.0, 0.0]
[drives.O]
torque = {andrews.TORQUE}
"""
SPRING = f"""[springs.S]
point = "spring_K3"
to = "spring_ground"
stiffness = {andrews.STIFFNESS}
free_length = {andrews.REST_LENGTH}
"""


def test_squeezing_mechanism_ends_as_published(run, engine):
    """Torque, spring, three loops; digits as in the test of the independent model: angles 1e-9, rates 1e-7."""
    last = run(andrews.andrews_sdf(), SQUEEZER + SPRING)
    for published, suffix, digits in (
        (andrews.END, "angle", 1e-9), (andrews.END_RATE, "omega", 1e-7), (andrews.END_ACCELERATION, "alpha", 1e-5)
    ):  # fmt: skip
        expected = andrews.TURNS @ published
        got = np.array([last[f"K{b + 1}.{suffix}"][-1] for b in range(7)])
        atol = max(digits, ERROR[engine]) * np.abs(published).max()
        np.testing.assert_allclose(got, expected, rtol=0, atol=atol, err_msg=suffix)


@pytest.mark.slow
@pytest.mark.parametrize("spring", [True, False])
def test_squeezing_mechanism_moves_as_the_independent_model(run, engine, spring):
    found = run(andrews.andrews_sdf(), SQUEEZER + SPRING * spring)
    q, v = andrews.andrews_model(spring).solve(andrews.START, np.zeros(7), found.time, 1e-13)
    for name, values in andrews.columns(q, v).items():
        atol = ERROR[engine] * np.abs(values).max()
        np.testing.assert_allclose(found[name], values, rtol=0, atol=atol, err_msg=name)


# --- pendulums and slider-crank ---------------------------------------------------------------------------------------

#: Errors of angles, rates and energy (in parts of the largest kinetic energy) of a chain that swings for a second.
SWINGING = {"compiled": (1e-8, 1e-7, 1e-9), "drake": (1e-6, 1e-5, 1e-8)}


@slow_on_drake
@pytest.mark.parametrize("n", [2, 4])
def test_chain_swings_as_the_independent_model_and_keeps_its_energy(run, engine, n):
    lengths, angles = np.linspace(0.3, 0.1, n), np.linspace(0.4, -0.9, n)
    found = run(chain_sdf(lengths, angles), "duration = 1.0\ngravity = [0.0, -9.81, 0.0]\n")
    q, v = chain_model(lengths).solve(angles, np.zeros(n), found.time)
    of_angle, of_rate, of_energy = SWINGING[engine]
    for i in range(n):
        np.testing.assert_allclose(found[f"bar{i + 1}.angle"], q[:, i], rtol=0, atol=of_angle)
        np.testing.assert_allclose(found[f"bar{i + 1}.omega"], v[:, i], rtol=0, atol=of_rate)
    energy = found["kinetic_energy"] + found["potential_energy"]
    atol = of_energy * found["kinetic_energy"].max()
    np.testing.assert_allclose(energy, energy[0], rtol=0, atol=atol)


def test_ideal_slider_crank_moves_as_its_closed_form(run, engine):
    """With reactions and drive torque."""
    text = "duration = 0.25\ngravity = [0.0, -9.81, 0.0]\n[drives.O]\nspeed = 30.0\n"
    text += "".join(f'[joints.{name}]\nmodel = "ideal"\n' for name in "AB")
    found = run(slider_crank(), text)
    for name, values in slider_crank_motion(30.0 * found.time, 30.0, gravity=9.81).items():
        atol = ERROR[engine] * np.abs(values).max()
        np.testing.assert_allclose(found[name], values, rtol=0, atol=atol, err_msg=name)


# --- through singular positions ---------------------------------------------------------------------------------------

#: Tighter is never worse.
THROUGH = pytest.mark.parametrize(
    ("engine", "accuracy"),
    [("compiled", 1e-6), ("compiled", 1e-9), ("compiled", 1e-12), ("drake", 1e-6), ("drake", 1e-9)],
)


@THROUGH
def test_parallelogram_passes_its_flat_positions(run, accuracy):
    text = "duration = 0.9\ngravity = [0.0, 0.0, 0.0]\n[drives.O]\ntorque = 0.01\nspeed = 6.0\n"
    found = run(parallelogram_sdf(), text, accuracy)
    theta, rate = parallelogram_angle(found.time, 0.01, 6.0)
    assert theta[-1] > 2.0 * np.pi
    for link in ("crank", "follower"):
        np.testing.assert_allclose(found[f"{link}.angle"], theta, rtol=0, atol=1e-6)
        np.testing.assert_allclose(found[f"{link}.omega"], rate, rtol=0, atol=1e-5)
    np.testing.assert_allclose(found["coupler.angle"], 0.0, atol=1e-6)


@pytest.mark.parametrize("longer", [1e-2, 1e-4, 1e-6])
def test_branches_that_pass_each_other_are_not_crossed(run, engine, longer):
    """A coupler that is a little too long makes the parallelogram fold, in a turn as sharp as the root of it."""
    text = "duration = 0.6\n[drives.O]\ntorque = 0.0\nspeed = 6.0\n"
    found = run(folding_sdf(longer), text, 1e-9)
    expected = folding_angles(longer, 6.0, 0.6)
    assert expected[0] - expected[1] > 3.0
    atol = {"compiled": 1e-7, "drake": 1e-6}[engine]  # Drake's states are led back to the loops, not projected
    np.testing.assert_allclose([found["crank.angle"][-1], found["follower.angle"][-1]], expected, rtol=0, atol=atol)


def test_an_implicit_method_passes_flat_positions(system_of):
    text = f"duration = 3.0\n{WINDOWS}[solver]\nintegrator = 'radau_iia_5'\naccuracy = 1e-9\n"
    found = simulate(system_of(windows_sdf(2), text), "compiled")
    angle, _ = windows_angle(2, found.time)
    assert found.provenance["method"] == "radau_iia_5"
    np.testing.assert_allclose(found["crank0.angle"], angle, rtol=0, atol=1e-6)


@THROUGH
def test_equal_slider_crank_passes_its_singular_positions(run, engine, accuracy):
    text = "duration = 1.2\ngravity = [0.0, 0.0, 0.0]\n[drives.O]\ntorque = 0.02\nspeed = 6.0\n"
    found = run(equal_slider_crank_sdf(), text, accuracy)
    theta, rate = equal_slider_crank_angle(found.time, 0.02, 6.0)
    assert theta[-1] > 2.0 * np.pi
    limit = max(1e-6, 3.0 * accuracy)  # the error of one revolution follows the accuracy
    np.testing.assert_allclose(found["crank.angle"], theta, rtol=0, atol=limit)
    error = np.abs(found["crank.omega"] - rate)
    near = np.abs(np.cos(theta)) <= 1e-2  # there the loop's rows are all but dependent: rates have few digits
    assert error[~near].max() < 10.0 * limit
    assert error.max() < {"compiled": 1e-3, "drake": 1e-5}[engine]
    np.testing.assert_allclose(found["rod.angle"], -theta, rtol=0, atol=limit)


@pytest.mark.parametrize(
    ("engine", "n", "accuracy", "duration"),
    [
        *(("compiled", n, accuracy, 10.0) for n in (1, 2) for accuracy in (1e-6, 1e-8, 1e-9, 1e-10, 1e-11)),
        *(pytest.param("compiled", 40, accuracy, 10.0, marks=pytest.mark.slow) for accuracy in (1e-6, 1e-9)),
        *(("drake", n, accuracy, 2.0) for n in (1, 2) for accuracy in (1e-6, 1e-9)),
        *(pytest.param("drake", n, 1e-9, 10.0, marks=pytest.mark.slow) for n in (1, 2)),
    ],
)
def test_windows_fall_through_their_flat_positions(run, engine, n, accuracy, duration):
    """Ten flat positions in 10 s, n branches crossing at each; the error follows the tolerance down to round-off."""
    found = run(windows_sdf(n), f"duration = {duration}\n{WINDOWS}", accuracy)
    angle, rate = windows_angle(n, found.time)
    assert np.sum(np.diff(np.sign(np.sin(angle))) != 0) >= duration / 2
    limit = 150.0 * accuracy if engine == "compiled" else 3e-8  # how closely Drake's feedback holds the loops
    for i in range(n + 1):
        np.testing.assert_allclose(found[f"crank{i}.angle"], angle, rtol=0, atol=limit)
        np.testing.assert_allclose(found[f"crank{i}.omega"], rate, rtol=0, atol=10.0 * limit)
    for i in range(n):
        np.testing.assert_allclose(found[f"coupler{i}.angle"], 0.0, atol=limit)


# --- long runs --------------------------------------------------------------------------------------------------------


def drag_link() -> str:
    """A four-bar whose crank and follower both turn fully, every pin ideal; it coasts without end."""
    ground, crank, coupler, follower = 0.1, 0.2, 0.18, 0.22
    pin = crank * np.exp(1j * np.pi / 2)
    reach = ground - pin
    inner = (coupler**2 + abs(reach) ** 2 - follower**2) / (2 * coupler * abs(reach))
    coupler_angle = np.angle(reach) + np.arccos(inner)
    follower_angle = np.angle(pin + coupler * np.exp(1j * coupler_angle) - ground)
    body = f"""
<frame name="pivot" attached_to="world"><pose relative_to="__model__">{ground} 0 0 0 0 0</pose></frame>
{bar("crank", crank, "__model__", np.pi / 2)}{bar("coupler", coupler, "crank_tip", coupler_angle - np.pi / 2)}
{bar("follower", follower, "pivot", follower_angle)}
{joint("O", "world", "crank")}{joint("A", "crank_tip", "coupler")}{joint("Q", "world", "follower")}
{joint("B", "coupler_tip", "follower_tip")}"""
    return model("drag_link", body)


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["compiled"])  # Drake would take hours
def test_a_loop_stays_closed_over_a_thousand_revolutions(run):
    """A drag-link that coasts: no torque, no gravity; its loop is integrated, its energy is constant.

    The change of energy falls with the accuracy: 1.4e-5 of it at 1e-7, 8.9e-8 at 1e-9, 8.2e-9 at 1e-10.
    """
    text = "duration = 110.0\ngravity = [0.0, 0.0, 0.0]\n[drives.O]\ntorque = 0.0\nspeed = 60.0\n"
    found = run(drag_link(), text, 1e-10)
    turned = np.ptp(found["crank.angle"])
    assert turned > 1000 * 2.0 * np.pi
    assert found.provenance["loop_error"] <= 1e-12  # round-off of angles of 6000 rad
    energy = found["kinetic_energy"]
    np.testing.assert_allclose(energy, energy[0], rtol=1e-8)
