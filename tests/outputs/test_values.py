"""What outputs mean: jitter, forces in joints, columns of different trees."""

import numpy as np
import pytest
from measures import scales
from newton_euler import free_bodies
from shipped import points, run_compiled, shipped

import linkages
from linkages import InputError
from linkages.results.outputs.columns import columns


def test_jitter_is_the_run_less_the_ideal_motion(system):
    """Of every point, over continuous time, in batches."""
    names = [f"{name}.jitter" for name in points(system)]
    if not system.determinate:
        with pytest.raises(InputError, match="do not determine an ideal motion"):
            linkages.simulate_batch(system, outputs=names)
        return
    batch = linkages.simulate_batch(system, outputs=names)
    result, exact = run_compiled(system), linkages.ideal(system)
    scale = scales(result.columns)
    for when, extreme in ((batch.time_of_minimum, batch.minimum), (batch.time_of_maximum, batch.maximum)):
        real, still = result.evaluate(when[0, 0]), exact.evaluate(when[0, 0])
        for k, name in enumerate(points(system)):
            deviation = pytest.approx(real[name][k] - still[name][k], rel=0.0, abs=1e-8 * scale[name])
            assert extreme[0, 0, k] == deviation, name


def test_jitter_is_the_run_less_the_ideal_motion_in_sections_and_in_batches():
    """Peaks: of one revolution over continuous time, by a section and by the batch's own statistics."""
    name = "slider.vx"
    system = shipped("slider_crank_dry")
    section = linkages.stroboscopic(system, [name, f"{name}.jitter"], revolutions=1)
    ideal = linkages.ideal(system).evaluate(section.times)[name]
    np.testing.assert_allclose(section.strobe[f"{name}.jitter"], section.strobe[name] - ideal, rtol=1e-12)
    batch = linkages.simulate_batch(system, outputs=[f"{name}.jitter"], windows=[[0.0, section.period]])
    assert section.peaks(f"{name}.jitter")[0] == pytest.approx(batch.peak[0, 0, 0], rel=1e-6)
    assert batch.peak[0, 0, 0] > 0.1  # m/s: the linkage does rattle


@pytest.mark.parametrize("engine", ["compiled", "drake"])
def test_a_crank_pin_at_constant_speed_accelerates_towards_its_pivot(engine):
    """By omega^2 r, in every direction in turn; a point of a body that only slides by what its body does."""
    run = linkages.simulate(shipped("seven_bar_fast", duration=0.02), engine)
    np.testing.assert_allclose(run["crank1_A.acceleration"], (2.0 * np.pi) ** 2 * 0.080, rtol=1e-6)
    assert np.ptp(run["crank1_A.ay"]) > 0.1
    np.testing.assert_allclose(run["slider7.acceleration"], np.abs(run["slider7.ax"]), rtol=1e-9)


def forces_agree(system, found, expected):
    """Compare columns with the oracle's forces, moments and drive forces, to round-off."""
    force, moment, drive = expected
    largest = max(np.abs(values).max() for values in force.values())
    atol = 1e-9 * largest * system.tree.extent
    for name in system.mechanism.joint:
        got = np.stack([found[f"{name}.fx"], found[f"{name}.fy"]], axis=1)
        np.testing.assert_allclose(got, force[name], rtol=0, atol=1e-9 * largest, err_msg=name)
        np.testing.assert_allclose(found[f"{name}.moment"], moment[name], rtol=0, atol=atol, err_msg=name)
    for name, values in drive.items():
        np.testing.assert_allclose(found[f"{name}.torque"], values, rtol=0, atol=atol, err_msg=name)


def skip_gears(system):
    if system.experiment.gears:
        pytest.skip("the bodies have no gears; conformance/test_backlash.py compares torques with closed forms")


def test_forces_of_a_run_are_those_of_free_bodies(system):
    """Newton and Euler for each body by itself, in absolute coordinates."""
    skip_gears(system)
    replay = run_compiled(system).evaluate.function
    times = np.linspace(0.0, system.experiment.duration, 51)
    states = replay.runner.evaluate(replay.steps, times)
    forces_agree(system, columns(system, times, *states), free_bodies(system, times, *states))


def test_forces_of_the_ideal_linkage_are_those_of_free_bodies(system):
    """Over the whole of the shipped experiment's motion."""
    skip_gears(system)
    if not system.determinate:
        system = system.ideal()
        replay = run_compiled(system).evaluate.function
        times = np.linspace(0.0, system.experiment.duration, 51)
        *states, _ = replay.runner.evaluate(replay.steps, times)
    else:
        motion = linkages.IdealMotion(system.replaced({"duration": shipped_duration(system)}))
        times = np.linspace(0.0, motion.times[-1], 51)
        states = motion.states(times)
    forces_agree(system, columns(system, times, *states), free_bodies(system, times, *states))


def shipped_duration(system):
    return linkages.load(system.experiment.source).experiment.duration


def test_columns_do_not_depend_on_the_tree(seven_bar):
    """The same state described by two spanning trees gives the same columns."""
    other = seven_bar.ideal()
    assert seven_bar.tree.coordinates != other.tree.coordinates
    one, two = (
        columns(each, np.zeros(1), each.assembly.q[None], each.assembly.v[None], 0 * each.assembly.v[None])
        for each in (seven_bar, other)
    )
    for name in ("kinetic_energy", "slider7.vx", "link3.y", "link6.omega"):
        assert one[name][0] == pytest.approx(two[name][0], abs=1e-12)
