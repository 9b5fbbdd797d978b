"""Curves that the report draws: few points, and every peak."""

import numpy as np
import pytest

from linkages.results.trajectory import load_trajectory
from linkages.show.plots.pages import drawn_errors, resolved, seen
from linkages.show.plots.style import color_for
from linkages.show.report.page import curves_of
from linkages.show.report.result_folder import load_results, recorded_system


def test_a_thinned_curve_keeps_its_ends_and_every_peak():
    time = np.linspace(0.0, 1.0, 100_001)
    values = np.sin(40.0 * time)
    values[[12_345, 77_777]] = 5.0, -7.0  # as impacts are: one sample wide
    kept = seen(time, values, 800)
    assert len(kept) <= 3 * 800 + 2
    assert {0, 12_345, 77_777, 100_000} <= set(kept.tolist())
    assert np.all(np.diff(kept) > 0)
    drawn = np.interp(time, time[kept], values[kept])
    assert np.abs(drawn - values)[20_000:70_000].max() < 40.0 / 800  # slope times an interval


def test_samples_crowd_where_the_solver_put_them():
    """Steps of very unequal length: intervals are of equal time, so that no long step is lost."""
    time = np.concatenate([np.linspace(0.0, 1e-6, 5000), [0.3, 0.6, 1.0]])
    kept = seen(time, time, 800)
    assert {0, 5000, 5001, 5002} <= set(kept.tolist())
    assert len(kept) < 10


def test_variations_below_the_error_are_not_drawn():
    noise = 1e-9 * np.sin(np.arange(50.0))
    np.testing.assert_array_equal(resolved(noise, 1e-9), 0.0)
    assert np.ptp(resolved(3.0 + noise, 1e-9)) == 0.0
    assert resolved(3.0 + noise, 1e-9)[0] == pytest.approx(3.0, abs=1e-9)
    np.testing.assert_array_equal(resolved(noise, 0.5e-9), noise)
    gap = np.where(np.arange(50) == 7, np.nan, noise)
    np.testing.assert_array_equal(resolved(gap, 1e-9), np.where(np.isnan(gap), np.nan, 0.0))
    assert drawn_errors({"A.force.peak": 0.1, "B.force.peak": None}, {"A.force": 1e-12, "B.force": 1e-12}) == {
        "A.force": 0.1,
        "B.force": 1e-12,
    }


def test_ideal_joints_are_drawn_beside_the_run(results_folder):
    """The drawn ideal torque differs by less than the resolution of a screen."""
    found = {curve["name"]: curve for curve in curves_of(load_results(results_folder))}
    assert list(found) == ["follower.omega", "coupler.ax", "A.force", "B.force", "O.torque"]
    ideal = load_trajectory(results_folder / "ideal.npz")
    for name, curve in found.items():
        drawn = np.interp(ideal.time, curve["ideal"]["time"], curve["ideal"]["values"])
        np.testing.assert_allclose(drawn, ideal[name], atol=2e-3 * np.abs(ideal[name]).max())
    assert found["coupler.ax"]["unit"] == "m/s2"
    of_links = recorded_system(load_results(results_folder)).colors
    colors = {name: curve["color"] for name, curve in found.items()}
    assert colors == {name: color_for(of_links, name) for name in found}  # as in the figures
    assert len({colors[name] for name in ("follower.omega", "coupler.ax", "O.torque")}) == 3
    assert max(found["B.force"]["run"]["values"]) > 2.0 * max(found["B.force"]["ideal"]["values"])  # impacts
