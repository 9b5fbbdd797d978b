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
