"""Impacts told apart from sustained contact."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import beta
from shipped import shipped

from linkages import Status, Trajectory, assess, phases
from linkages.results.impacts import FREE, HERTZ, IMPACT, SUSTAINED_CONTACT
from linkages.show.plots.journals import finely


def journal(stiffness, load, damping, gap, speed, duration):
    """A unit mass that flies at `speed` over `gap` to a wall F = k d^1.5, pressed on by a load and damped there."""

    def rate(t, y):
        contact = stiffness * max(y[0], 0.0) ** 1.5 + damping * y[1] * (y[0] > 0.0)
        return [y[1], load - contact]

    run = solve_ivp(rate, (0.0, duration), [-gap, speed], rtol=1e-10, atol=1e-13, max_step=duration / 2000)
    columns = {"time": run.t, "B.penetration": run.y[0], "B.closing": run.y[1]}
    return Trajectory(run.t, columns, Status.OK)


def seen(trajectory):
    """The phases in their order."""
    phase = phases(trajectory, "B")
    return phase[np.concatenate([[True], np.diff(phase) != 0])].tolist()


def test_constant_is_the_duration_of_a_hertz_impact():
    assert pytest.approx(0.8 * beta(0.4, 0.5), rel=1e-4) == HERTZ
    run = journal(1e9, 0.0, 0.0, 1e-3, 1.0, 3e-3)
    inside = run.time[run["B.penetration"] > 0.0]
    expected = HERTZ * run["B.penetration"].max() / 1.0
    assert np.ptp(inside) == pytest.approx(expected, abs=2 * 3e-3 / 2000)


@pytest.mark.parametrize("speed", [0.01, 1.0, 30.0])
def test_a_bounce_is_an_impact_whatever_its_speed(speed):
    depth = (1.25 * speed**2 / 1e9) ** 0.4  # energy of a unit mass
    duration = (2e-3 + 2.0 * HERTZ * depth) / speed
    assert seen(journal(1e9, 0.0, 0.0, 1e-3, speed, duration)) == [FREE, IMPACT, FREE]


def test_bouncing_under_a_load_is_one_impact_after_the_other():
    found = seen(journal(1e9, 50.0, 0.0, 1e-3, 0.1, 0.05))
    assert set(found) == {FREE, IMPACT}
    assert found.count(IMPACT) > 2


def test_a_journal_that_swings_within_the_wall_is_in_sustained_contact():
    assert seen(journal(1e9, 1e4, 3e3, 1e-4, 0.01, 0.02)) == [FREE, SUSTAINED_CONTACT]


def test_a_journal_that_settles_without_swinging_is_in_sustained_contact():
    assert seen(journal(1e9, 50.0, 1e5, 1e-4, 0.01, 0.1)) == [FREE, SUSTAINED_CONTACT]


def test_the_drawn_path_is_fine_where_steps_are_long():
    """A dry run on the compiled engine crosses the clearance in a few steps: they are refined for the drawing."""
    system = shipped("slider_crank_dry", duration=1.5e-3)
    found = assess(system, "compiled", error_estimate=False)
    clearance = system.experiment.joints["B"].clearance
    steps = np.column_stack([found.run["B.ex"], found.run["B.ey"]])
    path, phase = finely(found, "B")
    assert np.hypot(*np.diff(steps, axis=0).T).max() > 0.3 * clearance
    assert np.hypot(*np.diff(path, axis=0).T).max() < 0.1 * clearance
    assert len(phase) == len(path) - 1
    assert set(phase) == {FREE, IMPACT}
    at = [int(np.argmin(np.hypot(*(path - point).T))) for point in steps]
    np.testing.assert_array_equal(path[at], steps)  # the run's own states are on it, in their order
    assert at == sorted(at)
    loaded = replace(found, run=replace(found.run, evaluate=None))
    np.testing.assert_array_equal(finely(loaded, "B")[0], steps)
