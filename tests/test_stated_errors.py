"""Stated errors against true ones, from much more accurate runs of the compiled engine."""

from itertools import islice

import numpy as np
import pytest
import stated_errors
from machines import bar, joint, model
from shipped import shipped

from linkages import assess, horizon, simulate, summarize
from linkages.explore.flow import period_of
from linkages.results.characteristics import numbers
from linkages.results.divergence import PARTED
from linkages.results.peak_errors import RESOLVED
from linkages.results.shape import peaks_by_key

FALLING = (
    "duration = {}\ngravity = [0.0, -9.81, 0.0]\noutputs = ['lower.omega', 'lower_tip.x']\n[solver]\naccuracy = {}\n"
)


def double_pendulum():
    body = bar("upper", 0.3, "__model__", 2.0) + bar("lower", 0.2, "upper_tip", 0.7)
    return model("pendulum", body + joint("O", "world", "upper") + joint("A", "upper_tip", "lower"))


def stated_and_true(system, engine="compiled"):
    """Stated and true error of each peak, in parts of the peak."""
    found = assess(system, engine)
    summary = summarize(found)
    exact = simulate(system.replaced({"solver.accuracy": 1e-12, "solver.max_step": None}), "compiled")
    true = peaks_by_key(numbers(system, exact, ()))
    peaks = peaks_by_key(summary)
    return {key: (summary["error"][key], abs(peak - true[key]), peak) for key, peak in peaks.items()}


def too_small(errors):
    """Peaks whose stated error is less than half of the true one, where this exceeds a millionth of the peak."""
    return {
        key: row
        for key, row in errors.items()
        if row[0] is not None and row[1] > 1e-6 * row[2] and row[0] < 0.5 * row[1]
    }


@pytest.mark.parametrize("duration", [0.5, 2.0])
def test_a_run_does_not_depend_on_its_duration(system_of, duration):
    """Its steps do not, but for the last ones, which end there."""
    for system in (
        shipped("slider_crank_dry"),
        shipped("seven_bar_fast"),
        system_of(double_pendulum(), FALLING.format(1, 1e-7)),
    ):
        asked = system.replaced({"duration": duration * system.experiment.duration})
        run, other = (simulate(each, "compiled").time for each in (system, asked))
        shared = min(len(run), len(other)) - 4
        np.testing.assert_array_equal(run[:shared], other[:shared])


@pytest.mark.parametrize(
    ("engine", "changed"), [("compiled", {}), ("compiled", {"solver.max_step": 1e-4}), ("drake", {"duration": 0.02})]
)
def test_the_run_that_estimates_errors_shares_no_step(engine, changed):
    found = assess(shipped("seven_bar_fast", **({"duration": 0.1} | changed)), engine)
    run, tighter = (np.diff(each.time) for each in (found.run, found.tighter))
    assert tighter[0] < run[0]
    assert tighter.max() < 0.75 * run.max()


@pytest.mark.parametrize(
    ("name", "accuracy"),
    [
        ("seven_bar_rig", 1e-3),
        ("seven_bar_rig", 1e-5),
        ("slider_crank_flexible", 1e-3),
        ("three_rrr_clearance", 1e-5),  # at 1e-3 its steps are longer than the periods of the modes
        pytest.param("three_rrr_clearance", 1e-7, marks=pytest.mark.slow),
    ],
)
def test_peaks_of_the_start_have_honest_errors(name, accuracy):
    """Films stop the journals within microseconds, and flexible links vibrate."""
    system = shipped(name, **{"duration": 0.01, "solver.accuracy": accuracy})
    assert too_small(stated_and_true(system)) == {}


def test_a_start_is_resolved_at_any_accuracy():
    """The film stops the journal of a thin bearing within nanoseconds, and the force is largest then."""
    film = {"clearance": 3e-5, "viscosity": 0.3}
    changed = {f"joints.{name}.{key}": value for name in "AB" for key, value in film.items()} | {"duration": 0.01}
    peaks = [
        numbers(system, simulate(system, "compiled"), ())["joints"]["A"]["force"]["peak"]
        for system in (shipped("seven_bar_fast", **changed, **{"solver.accuracy": 10.0**-k}) for k in (4, 7, 12))
    ]
    np.testing.assert_allclose(peaks, peaks[-1], rtol=1e-4)


def test_friction_reversals_have_honest_errors_that_are_small():
    """Forces turn within 1e-8 s there, by which the runs' errors shift them: such a shift is no error of a peak."""
    errors = stated_and_true(shipped("four_bar_dry", duration=0.09))
    assert too_small(errors) == {}
    assert all(stated < 0.01 * peak for stated, _, peak in errors.values())


@pytest.mark.slow
def test_steps_that_drake_takes_at_its_longest_have_honest_errors():
    speeds = {"drives.O1.speed": 400.0, "drives.O4.speed": 400.0}
    system = shipped("seven_bar_fast", **speeds, **{"duration": 0.02, "solver.accuracy": 1e-3})
    assert too_small(stated_and_true(system, "drake")) == {}


@pytest.mark.slow
def test_rigid_segments_at_a_loose_accuracy_have_honest_errors_against_a_rod_that_does_not_stretch():
    """Segments do not stretch; with `axial = 1` the compiled engine has 202 N in O at t = 0, which are no error of Drake's."""
    slow = {"drives.O.speed": 50.0, "duration": 0.02, "links.rod.axial": 0, "solver.accuracy": 1e-4}
    errors = stated_and_true(shipped("slider_crank_flexible", **slow), "drake")
    assert too_small(errors) == {}
    stated, true, peak = errors["O.force.peak"]
    assert true < stated < 1e-3 * peak
    assert peak == pytest.approx(180.752, abs=0.05)


def test_a_fall_that_is_chaotic_has_no_errors_and_a_short_one_has(system_of):
    """Sensitive dependence without any contact: the runs part, and a larger peak may follow."""
    long = summarize(assess(system_of(double_pendulum(), FALLING.format(20.0, 1e-5)), "compiled"))
    assert long["error"]["lower.omega.peak"] is None
    (warning,) = long["warnings"]
    assert warning["kind"] == "rough"
    assert "lower bounds" in warning["what"]
    assert 0.5 < warning["time"] < 20.0
    short = system_of(double_pendulum(), FALLING.format(0.9 * warning["time"], 1e-5))
    errors = stated_and_true(short)
    assert too_small(errors) == {}
    assert all(row[0] < 0.1 * row[2] for row in errors.values())


def test_a_larger_peak_may_follow_once_dry_runs_have_parted():
    """The peak of a whole run that comes before they part has no error either; a window that ends before has."""
    system = shipped("slider_crank_dry", **{"windows.early.start": 0.0, "windows.early.end": 0.002})
    found = assess(system, "compiled")
    assert 0.002 < found.apart[0] < 0.024
    summary = summarize(found)
    key = "B.force.peak"
    assert summary["error"][key] is None
    early = summary["windows"]["early"]
    assert early["error"][key] < 0.01 * early["joints"]["B"]["force"]["peak"]
    error = summary["error"]["slider.x.peak"]  # chaos moves the slider within the clearance
    assert 1e-5 < error < 2e-3


def test_errors_are_no_smaller_than_rounding():
    summary = summarize(assess(shipped("seven_bar_fast", duration=0.1), "compiled"))
    for key, peak in peaks_by_key(summary).items():
        assert summary["error"][key] >= RESOLVED * peak


def test_the_horizon_does_not_depend_on_how_far_it_is_looked_for():
    system = shipped("slider_crank_dry")
    found = {horizon(system, most=most) for most in (1, 2, 3, 6, 12)}
    assert len(found) == 1
    (turns,) = found
    period = period_of(system)
    times = np.linspace(0.0, 2.0 * period, 401)
    run, looser = (
        simulate(system.replaced({"solver.accuracy": accuracy}), "compiled").evaluate(times)
        for accuracy in (1e-7, 10.0 * 1e-7)
    )
    apart = np.max([np.abs(run[name] - looser[name]) for name in ("B.ex", "B.ey")], axis=0)
    first = np.argmax(apart > PARTED * system.experiment.joints["B"].clearance)
    assert turns == pytest.approx(times[first - 1] / period, abs=1e-9)


@pytest.mark.slow
def test_random_machines_have_honest_errors(tmp_path):
    """A sample of what benchmarks/stated_errors.py judges."""
    judged = 0
    for _, (_, system) in zip(range(7), stated_errors.experiments(11, "compiled", tmp_path), strict=False):
        rows = stated_errors.rows(system, "compiled") or []
        assert [row for row in rows if row.fails] == []
        judged += sum(row.judged for row in rows)
    assert judged > 10


@pytest.mark.parametrize(
    ("seed", "number"),
    [(2811282, 27), (2811283, 7), (2811501, 13)],
    ids=["steady film", "start of a film", "vibration of a flexible link"],
)
def test_runs_of_few_steps_have_honest_errors(tmp_path, seed, number):
    """Newton's method limits the steps, at any accuracy; a tighter run with about as few steps errs as much."""
    _, system = next(islice(stated_errors.experiments(seed, "compiled", tmp_path), number, None))
    rows = stated_errors.rows(system, "compiled")
    assert sum(row.judged for row in rows) > 5
    assert [row for row in rows if row.fails] == []
