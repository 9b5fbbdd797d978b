"""Derivatives of runs, against differences of runs and closed forms."""

import tracemalloc
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from machines import CONTROL, FLYWHEEL, RUBBING_CRANK, bar, joint, model, slider_crank

import linkages
from linkages.engines.compiled.derivatives.sensitivity import differentiate
from linkages.engines.compiled.run.runner import Runner, join
from linkages.engines.drop import CLEARANCE, GRAVITY, MASS, drop
from linkages.results.statistic_derivatives import Wanted, _rates, _stationary, differentiate_statistics


def _end(system):
    runner = Runner(system)
    return runner, runner.run(0.0, runner.start, 0.0, 10**6, differentiated=True)


def _agree(name, overrides, step, limit, path):
    """Compare the derivative of the last state with differences of runs of the fourth order."""
    system = linkages.load(linkages.find_file(name), {"solver.accuracy": 1e-12, **overrides})
    runner, record = _end(system)
    found = differentiate(runner, join([record]), [path])
    value, n = system.value(path), len(runner.model.free)
    h = step * value
    ends = [_end(system.replaced({path: value + k * h}))[1].states[-1] for k in (-2, -1, 1, 2)]
    expected = ((ends[0] - ends[3]) / 12 + (ends[2] - ends[1]) * 2 / 3) / h
    own = found.states[-1][:, -1]
    for part in (slice(0, n), slice(n, 2 * n)):
        assert np.max(np.abs(expected - own)[part]) < limit * np.max(np.abs(own)[part])
    return found


@pytest.mark.parametrize(
    ("path", "step"),
    [
        ("joints.B.clearance", 1e-3),
        ("joints.B.viscosity", 3e-3),
        ("sdf.links.rod.mass", 1e-3),
        ("drives.O.speed", 1e-3),
    ],
)
def test_lubricated_slider_crank_agrees_with_differences_of_runs(path, step):
    found = _agree("slider_crank_lubricated.toml", {"duration": 0.002}, step, 1e-7, path)
    assert not found.event.any()


@pytest.mark.parametrize("path", ["frictions.in_A.coefficient", "frictions.rail.length", "sdf.links.rod.mass"])
def test_friction_from_joint_forces_agrees_with_differences_of_runs(system_of, path):
    """States, and outputs at the end: a friction, and the force in a joint, which the closure's reactions give.

    At an accuracy of 1e-11 they differ by up to 1.2e-5, which depends on where steps end; at 1e-13 by 2e-6.
    """
    system = system_of(slider_crank(), RUBBING_CRANK).replaced({"duration": 0.05, "solver.accuracy": 1e-13})
    names, h = ("O.rate", "in_A.torque", "rail.force", "A.force", "guide.moment"), 1e-4 * system.value(path)
    found = linkages.simulate(system, "compiled", outputs=names, wrt=[path])
    ends = [linkages.simulate(system.replaced({path: system.value(path) + k * h}), "compiled") for k in (-1, 1)]
    for name in names:
        expected = (ends[1][name][-1] - ends[0][name][-1]) / (2.0 * h)
        assert found.sensitivity[path][name][-1] == pytest.approx(expected, rel=1e-5)


def test_recorded_stages_and_repeated_steps_give_the_same_derivatives():
    system = linkages.load(
        linkages.find_file("slider_crank_lubricated.toml"), {"duration": 0.002, "solver.accuracy": 1e-11}
    )
    paths, found = ["joints.B.clearance", "sdf.frames.rod_B.pose.x"], []
    for stages in (False, True):
        runner = Runner(system)
        steps = join([runner.run(0.0, runner.start, 0.0, 10**6, differentiated=stages)])
        found.append(differentiate(runner, steps, paths).states)
    assert (found[0] != found[1]).any()
    scale = np.abs(found[0]).max(axis=0)
    assert np.all(np.abs(found[1] - found[0]).max(axis=0) < 1e-7 * scale + 1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("path", ["joints.B1.clearance", "joints.B1.viscosity"])
def test_a_robot_with_films_of_a_map_agrees_with_differences_of_runs(path):
    """Third derivatives of the map's splines jump at its nodes: long differences of the law had errors of 2e-7."""
    _agree("three_rrr_clearance.toml", {"duration": 0.002}, 1e-3, 1e-7, path)


@pytest.mark.parametrize(
    ("path", "step", "limit"),
    [
        ("joints.B.contact.restitution", 1e-4, 1e-6),
        ("drives.O.speed", 1e-5, 1e-6),
        ("joints.B.friction.v_0", 0.1, 3e-4),  # it moves a kink; its effects before and after a reversal nearly cancel
    ],
)
def test_dry_slider_crank_agrees_through_impacts_and_reversals_of_sliding(path, step, limit):
    overrides = {"duration": 7.3e-4, "solver.integrator": "radau_iia_5"}
    found = _agree("slider_crank_dry.toml", overrides, step, limit, path)
    assert found.event.any()


@pytest.mark.parametrize(
    ("name", "overrides", "path", "outputs"),
    [
        (
            "slider_crank_lubricated.toml",
            {"duration": 0.002},
            "sdf.frames.rod_B.pose.x",
            ["slider.x", "B.force", "slider.x.jitter"],
        ),
        (
            "slider_crank_lubricated.toml",
            {"duration": 0.002},
            "joints.B.clearance",
            ["B.eccentricity_ratio", "O.torque"],
        ),
        ("slider_crank_lubricated.toml", {"duration": 0.002}, "gravity.y", ["guide.force", "B.fy"]),
        (
            "slider_crank_main_bearing.toml",
            {"duration": 0.002},
            "joints.O.clearance",
            ["O.eccentricity_ratio", "O.friction_torque"],
        ),
        ("six_bar_dry.toml", {"duration": 0.004}, "sdf.frames.link5_D.pose.x", ["output.angle", "output.alpha"]),
        # a stiff contact in oil: the depth changes by little, the journal moves along the wall by much
        (
            "seven_bar_mixed.toml",
            {"duration": 0.004, "joints.A.offset": [2.999e-4, 0.0]},
            "joints.A.contact.youngs_modulus",
            ["A.penetration"],
        ),
    ],
)
def test_derivatives_of_outputs_agree_with_differences_of_runs(name, overrides, path, outputs):
    system = linkages.load(linkages.find_file(name), {"solver.accuracy": 1e-12, **overrides})
    run = linkages.simulate(system, outputs=outputs, wrt=[path])
    assert run.sensitivity.status == "ok"
    times = np.linspace(0.0, overrides["duration"], 9)[1:]
    found, value = run.sensitivity.evaluate(times)[path], system.value(path)
    step = 1e-3 * abs(value) or 1.0
    near = [linkages.simulate(system.replaced({path: value + k * step}), outputs=outputs) for k in (-2, -1, 1, 2)]
    columns = [one.evaluate(times) for one in near]
    for output in outputs:
        before, lower, upper, after = (column[output] for column in columns)
        expected = ((before - after) / 12 + (upper - lower) * 2 / 3) / step
        assert np.max(np.abs(found[output] - expected)) < 2e-6 * np.max(np.abs(expected))
    at_steps = run.sensitivity[path]
    assert all(len(at_steps[output]) == len(run.time) for output in outputs)


@pytest.mark.parametrize(
    ("name", "overrides", "path", "outputs"),
    [
        ("seven_bar.toml", {"duration": 0.1}, "joints.A.clearance", ["A.force", "slider7.ax", "link6_D.x"]),
        ("slider_crank_flexible.toml", {"duration": 1e-3}, "drives.O.speed", ["rod_mid.y", "slider.ax"]),
    ],
)
def test_an_output_has_the_same_derivatives_alone_as_among_all(name, overrides, path, outputs):
    """Alone it needs the motion of few bodies."""
    system = linkages.load(linkages.find_file(name), overrides)
    everything = linkages.simulate(system, wrt=[path]).sensitivity[path]
    for output in outputs:
        alone = linkages.simulate(system, outputs=[output], wrt=[path]).sensitivity[path][output]
        assert alone.any()
        np.testing.assert_array_equal(alone, everything[output])


def test_paths_without_a_derivative_are_refused():
    system = linkages.load(linkages.find_file("slider_crank_lubricated.toml"), {"duration": 1e-4})
    for path, why in (("joints.B.film", "not a number"), ("joints.X.clearance", "has no")):
        with pytest.raises(linkages.InputError, match=why):
            linkages.simulate(system, wrt=[path])
    with pytest.raises(linkages.InputError, match="compiled"):
        linkages.simulate(system, "drake", wrt=["joints.B.clearance"])


def test_derivatives_end_at_the_horizon():
    system = linkages.load(linkages.find_file("slider_crank_dry.toml"), {"duration": 0.006})
    run = linkages.simulate(system, outputs=["B.force"], wrt=["joints.B.clearance"])
    rates, until = run.sensitivity["joints.B.clearance"]["B.force"], run.sensitivity.until
    assert run.sensitivity.status == "horizon"
    assert 1e-3 < until < 0.006
    assert np.isfinite(rates[run.time <= until]).all()
    assert np.isnan(rates[run.time > until]).all()


def _compare(found, runner, record, motion, values, rtol=1e-9):
    """Compare last place and speed, and their derivatives, with those of a closed form, whose first value is gravity."""
    n, last = len(runner.model.free), record.states[-1]
    rows = int(np.argmax(np.abs(last[:n]))) + np.array([0, n])
    np.testing.assert_allclose(last[rows], motion(*values), rtol=rtol)
    for k, value in enumerate(values):
        moved = values.astype(complex)
        moved[k] += 1e-20j * value
        expected = motion(*moved).imag / (1e-20 * value) * (-1.0 if k == 0 else 1.0)  # gravity.y is negative
        np.testing.assert_allclose(found.states[-1][rows, len(runner.start) + k], expected, rtol=rtol)


def _bouncing(time, gravity, clearance, stiffness, mass):
    """Place and speed of a journal that falls in its bearing onto a linear elastic contact, in closed form.

    Starts at the centre; falls, is in contact for a half period and a little more, and rises to the centre again. All
    arguments but the time may be complex, for derivatives by a complex step.
    """
    speed, rate = np.sqrt(2 * clearance * gravity), np.sqrt(stiffness / mass)
    start, lasting = np.sqrt(2 * clearance / gravity), 2 * (np.pi - np.arctan(speed * rate / gravity)) / rate
    while True:
        since = time - start
        if time < (start + lasting).real:
            depth = gravity / rate**2 * (1 - np.cos(rate * since)) + speed / rate * np.sin(rate * since)
            return np.array([-clearance - depth, -gravity / rate * np.sin(rate * since) - speed * np.cos(rate * since)])
        start += lasting
        since -= lasting
        if time < (start + 2 * speed / gravity).real:
            return np.array([-clearance + speed * since - gravity * since**2 / 2, speed - gravity * since])
        start += 2 * speed / gravity


@pytest.mark.parametrize(
    ("integrator", "accuracy", "rtol"),
    [
        ("radau_iia_5", 1e-13, 1e-9),
        ("dormand_prince_5_4", 1e-13, 1e-9),
        ("radau_iia_5", 1e-9, 1e-6),  # in longer parts of steps, as the next one
        ("dormand_prince_5_4", 1e-10, 1e-6),
    ],
)
def test_a_chain_of_three_impacts_has_the_derivatives_of_its_closed_form(integrator, accuracy, rtol):
    end, values = 0.08, np.array([GRAVITY, CLEARANCE, 1e7, MASS])
    contact = {"law": "hertz", "exponent": 1.0, "restitution": 1.0, "stiffness": values[2]}
    system = drop().replaced(
        {"joints.J.contact": contact, "duration": end, "solver.integrator": integrator, "solver.accuracy": accuracy}
    )
    paths = ["gravity.y", "joints.J.clearance", "joints.J.contact.stiffness", "sdf.links.journal.mass"]
    runner, record = _end(system)
    found = differentiate(runner, join([record]), paths)
    assert (found.event > 0).sum() == 3
    _compare(found, runner, record, partial(_bouncing, end), values, rtol)


def _dashpot(time, gravity, clearance, stiffness, damping, mass):
    """Place and speed of a journal that falls in its bearing onto a spring and a damper, during their first contact."""
    speed, since = np.sqrt(2 * clearance * gravity), time - np.sqrt(2 * clearance / gravity)
    decay, rest = damping / (2 * mass), gravity * mass / stiffness
    rate = np.sqrt(stiffness / mass - decay**2)
    sine = (speed - decay * rest) / rate
    fall, cos, sin = np.exp(-decay * since), np.cos(rate * since), np.sin(rate * since)
    depth = rest + fall * (sine * sin - rest * cos)
    return np.array(
        [-clearance - depth, -fall * (rate * (sine * cos + rest * sin) - decay * (sine * sin - rest * cos))]
    )


SPRINGS = """
duration = 2.0
[drives.O]
torque = 0.0
speed = 3.0
[torques.springs]
joint = "O"
formula = "-2*max(O.coordinate, 0) - 0.5*min(O.coordinate, 0)"
"""


def _between_springs(time, inertia, speed):
    """Angle and rate of a wheel that leaves a spring of 2 N m/rad for one of 0.5 N m/rad at each zero of its angle."""
    stiffnesses, side = (2.0, 0.5), 0
    while time > np.pi * np.sqrt(inertia / stiffnesses[side]).real:
        time, side = time - np.pi * np.sqrt(inertia / stiffnesses[side]), 1 - side
    rate, sign = np.sqrt(stiffnesses[side] / inertia), 1.0 - 2.0 * side
    return sign * speed * np.array([np.sin(rate * time) / rate, np.cos(rate * time)])


@pytest.mark.parametrize(
    ("integrator", "accuracy", "rtol"),
    [
        ("radau_iia_5", 1e-6, 1e-6),
        ("radau_iia_5", 1e-11, 1e-11),
        ("dormand_prince_5_4", 1e-6, 1e-4),
        ("dormand_prince_5_4", 1e-11, 1e-9),
    ],
)
def test_a_formula_with_kinks_has_the_derivatives_of_its_closed_form(system_of, integrator, accuracy, rtol):
    system = system_of(FLYWHEEL, SPRINGS).replaced({"solver.integrator": integrator, "solver.accuracy": accuracy})
    runner, record = _end(system)
    found = differentiate(runner, join([record]), ["sdf.links.wheel.inertia", "drives.O.speed"])
    inertia, speed = 0.02, 3.0
    np.testing.assert_allclose(record.states[-1], _between_springs(2.0, inertia, speed), rtol=rtol)
    by_inertia = _between_springs(2.0, inertia * (1.0 + 1e-20j), speed).imag / (inertia * 1e-20)
    expected = np.stack([by_inertia, _between_springs(2.0, inertia, 1.0)], axis=1)
    np.testing.assert_allclose(found.states[-1][:, -2:], expected, rtol=rtol)


@pytest.mark.parametrize("integrator", ["radau_iia_5", "dormand_prince_5_4"])
@pytest.mark.parametrize("path", ["controllers.C.integral", "controllers.C.limits.1", "sdf.links.wheel.inertia"])
def test_derivatives_after_a_controller_leaves_its_limit_agree_with_differences(system_of, integrator, path):
    """At a loose accuracy. Without steps that end at the kink the errors are 5e-6 and 2e-4."""
    system = system_of(FLYWHEEL, "duration = 0.5\n[drives.O]\ntorque = 0.0\n" + CONTROL).replaced(
        {"solver.integrator": integrator, "solver.accuracy": 1e-7}
    )
    value, fine = system.value(path), system.replaced({"solver.accuracy": 1e-12})
    ends = [
        linkages.simulate(fine.replaced({path: value * (1.0 + k * 1e-3)}), outputs=["O.rate"])["O.rate"][-1]
        for k in (-2, -1, 1, 2)
    ]
    expected = ((ends[0] - ends[3]) / 12 + (ends[2] - ends[1]) * 2 / 3) / (1e-3 * value)
    run = linkages.simulate(system, outputs=["O.rate"], wrt=[path])
    np.testing.assert_allclose(run.sensitivity[path]["O.rate"][-1], expected, rtol=5e-7)


@pytest.mark.parametrize("integrator", ["radau_iia_5", "dormand_prince_5_4"])
def test_a_force_that_jumps_at_the_start_of_a_contact_has_the_derivatives_of_its_closed_form(integrator):
    end, values = 0.01465, np.array([GRAVITY, CLEARANCE, 1e7, 2e3, MASS])
    contact = {"law": "kelvin-voigt", "restitution": 1.0, "stiffness": values[2], "damping": values[3]}
    system = drop().replaced(
        {"joints.J.contact": contact, "duration": end, "solver.integrator": integrator, "solver.accuracy": 1e-12}
    )
    paths = ["gravity.y", "joints.J.clearance", "joints.J.contact.stiffness", "joints.J.contact.damping"]
    runner, record = _end(system)
    found = differentiate(runner, join([record]), [*paths, "sdf.links.journal.mass"])
    assert found.event[found.event != 0].tolist() == [1]
    _compare(found, runner, record, partial(_dashpot, end), values)


def test_both_integrators_have_the_same_derivatives_through_an_impact():
    ends = []
    for integrator in ("radau_iia_5", "dormand_prince_5_4"):
        overrides = {"duration": 2.9e-4, "solver.integrator": integrator, "solver.accuracy": 1e-12}
        runner, record = _end(linkages.load(linkages.find_file("slider_crank_dry.toml"), overrides))
        ends.append(differentiate(runner, join([record]), ["joints.B.clearance"]).states[-1][:, -1])
    np.testing.assert_allclose(ends[1], ends[0], rtol=1e-6, atol=1e-9 * np.abs(ends[0]).max())


def test_the_derivative_of_a_run_converges_with_the_order_of_the_method():
    """The steps of the explicit method of order 5 are halved.

    Newton's iterations of the implicit method end as soon as their error is below 0.003 of the tolerance, here after
    two. This error is larger than that of the steps, 6e-8 of the tolerance with 32 steps, and of order 4. If they end
    at 1e-8 of the tolerance, the order of the implicit method is 5 too; but already at 1e-6 runs of the lubricated
    slider-crank take twice as many evaluations, for errors that are far below the tolerance anyway.
    """
    exact, errors = None, []
    for steps in (512, 32, 64):
        overrides = {"duration": 0.01, "solver.accuracy": 1e-3, "solver.max_step": 0.01 / steps}
        system = drop().replaced({**overrides, "solver.integrator": "dormand_prince_5_4"})
        system = system.replaced({"joints.J.model": "lubricated", "joints.J.film": "short", "joints.J.viscosity": 0.5})
        runner, record = _end(system)
        end = differentiate(runner, join([record]), ["joints.J.viscosity"]).states[-1][:, -1]
        if exact is None:
            exact = end
        else:
            errors.append(np.abs(end - exact).max())
    assert np.log2(errors[0] / errors[1]) > 4.5


@settings(max_examples=4, deadline=None, derandomize=True)
@given(clearance=st.floats(5e-5, 3e-4), speed=st.floats(50.0, 200.0), threads=st.integers(1, 2), dry=st.booleans())
def test_derivatives_of_batches_equal_those_of_single_runs_bit_for_bit(clearance, speed, threads, dry):
    system = linkages.load(
        linkages.find_file("slider_crank_dry.toml" if dry else "slider_crank_lubricated.toml"), {"duration": 0.001}
    )
    variables, outputs = ["joints.B.clearance", "drives.O.speed"], ["B.force", "slider.ax"]
    wrt, values = ["sdf.links.rod.mass", "drives.O.speed"], [[clearance, speed], [1e-4, 100.0]]
    batch = linkages.simulate_batch(system, variables, values, outputs, threads=threads, wrt=wrt)
    assert len(batch.sensitivity_status) == 2
    for row, design in enumerate(values):
        one = system.replaced(dict(zip(variables, design, strict=True)))
        single = linkages.sensitivities(one, wrt, outputs, error_estimate=False)
        assert batch.sensitivity_status[row] == single.run.sensitivity.status
        for path in wrt:
            for k, output in enumerate(outputs):
                for kind in ("peak", "mean", "rms"):
                    rate = batch.sensitivity[path][kind][row, 0, k]
                    assert (None if np.isnan(rate) else rate) == single.derivatives[path][f"{output}.{kind}"]


def test_derivatives_of_a_batch_are_slopes_of_its_statistics_in_each_window():
    system = linkages.load(linkages.find_file("slider_crank_lubricated.toml"), {"duration": 0.002})
    system = system.replaced({"solver.accuracy": 1e-12})
    path, outputs, windows = "drives.O.speed", ["slider.ax", "B.force"], [[0.0005, 0.001], [0.001, 0.002]]
    value = system.value(path)
    step = 1e-3 * value
    values = [[value + k * step] for k in (0, -2, -1, 1, 2)]
    batch = linkages.simulate_batch(system, [path], values, outputs, windows)
    found = linkages.simulate_batch(system, outputs=outputs, windows=windows, wrt=[path]).sensitivity[path]
    assert set(found) == {"minimum", "maximum", "peak", "mean", "rms", "last"}
    for kind, rates in found.items():
        assert rates.shape == (1, 2, 2)
        table = getattr(batch, kind)
        expected = np.tensordot([1 / 12, -2 / 3, 2 / 3, -1 / 12], table[1:], 1) / step
        # the means of a batch have errors of up to 1e-6 of themselves, which differences magnify
        np.testing.assert_allclose(rates[0], expected, rtol=1e-4, atol=1e-6 * np.abs(table[0]).max() / step)


def test_rows_of_a_batch_without_derivatives_say_why():
    system = linkages.load(linkages.find_file("slider_crank_dry.toml"), {"duration": 0.006})
    paths, values = ["joints.B.clearance", "drives.O.speed"], [[1e-4, 100.0], [-1.0, 100.0], [1e-4, 0.5]]
    batch = linkages.simulate_batch(system, paths, values, ["B.force"], wrt=paths)
    assert batch.sensitivity_status == ["horizon", "no run", "ok"]
    rates = batch.sensitivity["drives.O.speed"]["peak"][:, 0, 0]
    assert np.isfinite(rates).tolist() == [True, False, True]  # the peak of the first row is before its horizon
    assert np.isnan(batch.sensitivity["drives.O.speed"]["mean"][:2]).all()
    frame = batch.to_dataframe()
    assert frame["B.force.mean wrt drives.O.speed"].isna().tolist() == [True, True, False]
    assert frame["sensitivity_status"].tolist() == batch.sensitivity_status
    assert batch.to_xarray()["mean_rate"].dims == ("wrt", "run", "window", "output")
    with pytest.raises(linkages.InputError, match="not a number"):
        linkages.simulate_batch(system, wrt=["joints.B.model"])


def test_a_machine_that_its_drive_determines_has_the_derivatives_of_its_closed_form():
    """Without clearance: x = a cos(wt) + sqrt(l2 - a2 sin2(wt)), over a revolution; no other motion is free."""
    crank, rod, rate = 0.05, 0.12, 523.5987755982989
    system = linkages.load(linkages.find_file("slider_crank_dry.toml"), {"joints": {}, "duration": 0.012})
    run = linkages.simulate(system, outputs=["slider.x"], wrt=["sdf.frames.rod_B.pose.x", "drives.O.speed"])
    angle = rate * run.time
    along = np.sqrt(rod**2 - (crank * np.sin(angle)) ** 2)
    by_angle = -crank * np.sin(angle) * (1.0 + crank * np.cos(angle) / along)
    assert run.sensitivity.status == "ok"
    found = [run.sensitivity[path]["slider.x"] for path in ("sdf.frames.rod_B.pose.x", "drives.O.speed")]
    np.testing.assert_allclose(found[0], rod / along, rtol=1e-8)
    np.testing.assert_allclose(found[1], by_angle * run.time, atol=1e-8 * 0.012 * crank)


def test_a_machine_without_a_free_coordinate_has_derivatives(system_of):
    """A driven bar: x = L cos(wt), a = -L w2 cos(wt)."""
    bar_alone = model("alone", bar("rod", 0.3, "__model__") + joint("O", "world", "rod"))
    run = linkages.simulate(system_of(bar_alone, "duration = 0.5\n[drives.O]\nspeed = 3.0\n"), wrt=["drives.O.speed"])
    found, t = run.sensitivity["drives.O.speed"], run.time
    np.testing.assert_allclose(found["rod_tip.x"], -0.3 * t * np.sin(3.0 * t), atol=1e-9)
    by_rate = -0.3 * (6.0 * np.cos(3.0 * t) - 9.0 * t * np.sin(3.0 * t))
    np.testing.assert_allclose(found["rod_tip.ax"], by_rate, atol=1e-8)


def test_derivatives_stay_within_the_run_and_its_parts():
    """The drive's angle is its speed times the time: its derivative along the speed is the time."""
    system = linkages.load(linkages.find_file("slider_crank_lubricated.toml"), {"duration": 0.002})
    run = linkages.simulate(system, outputs=["crank.angle"], wrt=["drives.O.speed"])
    part = run.within(0.0005, 0.001)
    for one, low, high in ((run, 0.0, 0.002), (part, 0.0005, 0.001)):
        np.testing.assert_allclose(one.sensitivity["drives.O.speed"]["crank.angle"], one.time, atol=1e-12)
        found = one.sensitivity.evaluate([high, low])["drives.O.speed"]["crank.angle"]
        np.testing.assert_allclose(found, [high, low], atol=1e-12)
        for times, problem in (
            ([low, 0.1], "have 0.1 s, outside the run"),
            ([np.nan], "have nan"),
            (low, "have 0 dim"),
        ):
            with pytest.raises(linkages.InputError, match=problem):
                one.sensitivity.evaluate(times)


@pytest.mark.parametrize("accuracy", [1e-6, 1e-7, 1e-8])
def test_the_stated_error_of_a_mean_includes_its_quadrature(accuracy):
    """The largest stress of a rod has kinks within steps, where it moves from section to section.

    The right value has 20 points a step at an accuracy of 3e-12.
    """
    path = "sdf.links.rod.beam.height"
    values = {"duration": 0.03, "solver.accuracy": accuracy}
    system = linkages.load(linkages.find_file("slider_crank_flexible.toml"), values)
    found = linkages.sensitivities(system, [path], ["rod.stress"])
    key = "rod.stress.mean"
    assert abs(found.derivatives[path][key] + 6.80804e9) < 2.0 * found.errors[path][key] < 1e-2 * 6.8e9


@pytest.mark.parametrize(
    ("name", "start", "output"),
    [("slider_crank_flexible.toml", "centred", "slider.x"), ("slider_crank_lubricated.toml", "equilibrium", "B.ex")],
)
def test_a_mass_changes_the_start(name, start, output):
    """The quasi-static shape of a flexible link, and the place of a journal in its film."""
    path, given = "sdf.links.slider.mass", {"duration": 0.002, "start": start, "solver.accuracy": 1e-11}
    system = linkages.load(linkages.find_file(name), given)
    times, value = np.linspace(5e-4, 0.002, 4), system.value(path)
    run = linkages.simulate(system, outputs=[output], wrt=[path])
    low, high = (
        linkages.simulate(system.replaced({path: value * (1.0 + k)}), outputs=[output]).evaluate(times)[output]
        for k in (-1e-4, 1e-4)
    )
    expected = (high - low) / (2e-4 * value)
    found = run.sensitivity.evaluate(times)[path][output]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-4 * np.abs(expected).max())


@pytest.mark.parametrize("step", [2e-7, 6.5e-8, 3.4e-8])  # of accuracies 1e-9, 1e-11 and 1e-12
def test_the_time_of_a_peak_is_exact_beyond_the_rounding_of_a_contact_force(step):
    """A force of a dry contact is rounded to 1e-11 of itself, for its depth is: the parts of a step must not be short.

    The derivative of this force at a fixed time changes by 1e-6 of itself in 3e-12 s.
    """
    top, omega, random = 1.2345e-3, 1.2e5, np.random.default_rng(0)

    def evaluate(times):
        return {"force": 170.0 * np.cos(omega * (times - top)) * (1.0 + 1e-11 * random.uniform(-1.0, 1.0, len(times)))}

    run = SimpleNamespace(time=top + step * np.arange(-5.3, 5.0), evaluate=evaluate)
    found = _stationary(run, [(("force", run.time[0], run.time[-1]), top + 0.3 * step)] * 20)
    assert np.abs(found - top).max() < 1e-12


def test_the_derivative_of_an_extreme_at_a_kink_is_the_derivative_of_the_crossing():
    """The curves p + 3 (t - 1) and 2 - 5 p (t - 1)^2 - 2 (t - 1) cross at their least maximum, where p = 2, at t = 1.

    With s = t - 1 the crossing satisfies p + 3 s = 2 - 5 p s^2 - 2 s: ds/dp = -1/5 and d(p + 3 s)/dp = 2/5 at p = 2.
    """
    time = np.linspace(0.85, 1.12, 7)

    def values(times):
        s = times - 1.0
        return {"x": np.where(s < 0.0, 2.0 - 10.0 * s**2 - 2.0 * s, 2.0 + 3.0 * s)}

    def rates(times):
        s = times - 1.0
        return {"p": {"x": np.where(s < 0.0, -5.0 * s**2, 1.0)}}

    sensitivity = SimpleNamespace(evaluate=rates)
    run = SimpleNamespace(time=time, evaluate=values, sensitivity=sensitivity)
    place = ("x", time[0], time[-1]), 1.0 + 1e-9
    assert _rates(run, [place])[place] == pytest.approx([2.0 / 5.0], rel=1e-7)


@pytest.mark.slow
def test_the_least_stress_of_a_link_has_the_derivative_of_differences():
    """The largest stress of a link is least where its place changes: a kink. Without it the derivative is five times it."""
    base = linkages.load(linkages.find_file("slider_crank_flexible.toml"), {"joints": {}, "solver.accuracy": 1e-11})
    system, path = base.replaced({"duration": 0.03}), "drives.O.speed"
    run = linkages.simulate(system, outputs=["rod.stress"], wrt=[path])
    (found,) = differentiate_statistics(run, [Wanted("rod.stress", "minimum", 0.005, 0.03)])
    ends = []
    for factor in (1.0 - 1e-5, 1.0 + 1e-5):
        other = linkages.simulate(system.replaced({path: 150.0 * factor}), outputs=["rod.stress"])
        ends.append(linkages.extremes(other.within(0.005, 0.03), ["rod.stress"])["rod.stress"].min)
    assert found.rates[0] == pytest.approx((ends[1] - ends[0]) / (150.0 * 2e-5), rel=1e-3)


def test_derivatives_at_many_times_take_the_memory_of_their_outputs():
    """Changes of all states at 50,000 times take 79 MB; the requested ones 0.8 MB."""
    system = linkages.load(linkages.find_file("slider_crank_lubricated.toml"), {"duration": 1e-3})
    run = linkages.simulate(system, outputs=["slider.x"], wrt=["drives.O.speed"])
    times = np.linspace(0.0, 1e-3, 50_000)
    few = run.sensitivity.evaluate(times[::1000])["drives.O.speed"]["slider.x"]
    tracemalloc.start()
    try:
        many = run.sensitivity.evaluate(times)["drives.O.speed"]["slider.x"]
        _, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    np.testing.assert_array_equal(many[::1000], few)
    assert most < 40e6
