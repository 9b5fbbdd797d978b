"""Derivatives of runs, against differences of runs and closed forms."""

import numpy as np
import pytest

import linkages
from linkages.engines.compiled.runner import Runner, join
from linkages.engines.compiled.sensitivity import differentiate


def _end(system):
    runner = Runner(system)
    return runner, runner.run(0.0, runner.start, 0.0, 10**6)


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


@pytest.mark.parametrize("path", ["joints.B.contact.restitution", "drives.O.speed"])
def test_dry_slider_crank_agrees_through_impacts_and_reversals_of_sliding(path):
    overrides = {"duration": 7.3e-4, "solver.integrator": "radau_iia_5"}
    found = _agree("slider_crank_dry.toml", overrides, 1e-5, 1e-6, path)
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
        ("six_bar_dry.toml", {"duration": 0.004}, "sdf.frames.link5_D.pose.x", ["output.angle", "output.alpha"]),
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
