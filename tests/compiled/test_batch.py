"""Batches: the same bits as whole trajectories, failures in their rows, the same bytes for any number of threads."""

import itertools

import numpy as np
import pytest
from machines import four_bar
from scipy.integrate import trapezoid
from shipped import run, shipped

from linkages import Direction, InputError, Status, extremes, ideal, load, simulate, simulate_batch
from linkages.engines.compiled.batch.statistics import STATISTICS
from linkages.results.extremes import averages
from linkages.results.outputs.registry import default_outputs, has_jitter
from linkages.results.statistic_derivatives import Wanted, differentiate_statistics


@pytest.fixture(scope="module")
def press():
    return shipped("seven_bar", duration=0.5)


CASES = {  # seconds of each run
    "seven_bar": 0.5,
    "slider_crank_dry": 0.012,
    "slider_crank_guide": 0.005,
    "slider_crank_flexible": 0.01,
    "slider_crank_lubricated": 0.02,
    "slider_crank_main_bearing": 0.02,
    "six_bar_dry": 0.02,
}


@pytest.mark.parametrize("name", CASES)
def test_statistics_are_those_of_the_trajectory_to_the_last_bit(name):
    """Steps, replays, search and quadrature are the same, also between steps, at kinks and of motions of sections."""
    duration = CASES[name]
    system = shipped(name, duration=duration)
    names = list(default_outputs(system))
    names += [f"{j.name}.force" for j in system.mechanism.joints if j.name not in system.tree.play]
    names += [f"{point}.jitter" for point in system.experiment.outputs if has_jitter(system, point)]
    windows = [[0.0, duration], [0.3 * duration, 0.77 * duration]]
    batch, trajectory = simulate_batch(system, outputs=names, windows=windows), simulate(system, outputs=names)
    assert batch.status == [Status.OK]
    assert np.nanmax(batch.maximum) > 0.0
    for place, window in enumerate(windows):
        part = trajectory.within(*window)
        found = extremes(part, names)
        for k, output in enumerate(names):
            one, (mean, rms) = found[output], averages(part, output)
            ours = one.min, one.max, one.time_min, one.time_max, mean, rms, part[output][-1]
            theirs = tuple(batch.statistics[each][0, place, k] for each in STATISTICS)
            assert ours == theirs, output


def test_an_objective_and_its_derivative_belong_to_one_number(press):
    """A study takes the first from a batch, the second from a run with derivatives."""
    names, window = ["A.force", "slider7.ax"], (0.1, 0.4)
    statistics = ("minimum", "maximum", "peak", "mean", "rms", "last")
    batch = simulate_batch(press, outputs=names, windows=[window])
    run = simulate(press, outputs=names, wrt=["joints.A.viscosity"])
    wanted = [Wanted(name, each, *window) for name in names for each in statistics]
    found = [one.number for one in differentiate_statistics(run, wanted)]
    assert found == [getattr(batch, each)[0, 0, k] for k in range(len(names)) for each in statistics]


@pytest.mark.parametrize("name", ["seven_bar", "slider_crank_dry"])
def test_no_sample_is_beyond_the_extremes(name):
    """A fine grid shows what a search overlooks."""
    duration = 0.5 if name == "seven_bar" else 0.004
    system = shipped(name, duration=duration)
    names = list(default_outputs(system))
    trajectory = simulate(system, outputs=names)
    columns, found = trajectory.evaluate(np.linspace(0.0, duration, 5001)), extremes(trajectory, names)
    for output in names:
        size = 1e-9 * found[output].peak
        assert columns[output].max() <= found[output].max + size, output
        if not output.endswith(".force"):  # a magnitude dips to nothing between two samples
            assert columns[output].min() >= found[output].min - size, output


def test_means_and_rms_are_integrals(press):
    names = ["slider7.vx", "A.force"]
    batch = simulate_batch(press, outputs=names, windows=[[0.1, 0.5]])
    times = np.linspace(0.1, 0.5, 2001)
    columns = run("compiled", "seven_bar", duration=0.5).evaluate(times)
    for k, name in enumerate(names):
        assert batch.mean[0, 0, k] == pytest.approx(
            trapezoid(columns[name], times) / 0.4, abs=1e-4 * np.abs(columns[name]).max()
        )
        square = trapezoid(columns[name] ** 2, times) / 0.4
        assert batch.rms[0, 0, k] == pytest.approx(np.sqrt(square), rel=1e-4)


def test_windows_divide_the_run(press):
    """Extremes over the whole are the extremes of the parts; a window's ends count though no step is there."""
    edges = [0.0, 0.1234, 0.3, 0.5]
    parts = simulate_batch(press, outputs=["slider7.x"], windows=list(itertools.pairwise(edges)))
    whole = simulate_batch(press, outputs=["slider7.x"])
    assert parts.minimum[0, :, 0].min() == pytest.approx(whole.minimum[0, 0, 0], rel=1e-9)
    assert parts.maximum[0, :, 0].max() == pytest.approx(whole.maximum[0, 0, 0], rel=1e-9)
    at_edge = run("compiled", "seven_bar", duration=0.5).evaluate(np.array([0.1234]))["slider7.x"][0]
    assert parts.minimum[0, 0, 0] == pytest.approx(at_edge, rel=1e-9)  # the slider goes one way at first


def test_jitter_is_the_deviation_from_the_ideal_linkage():
    system = shipped("slider_crank_dry", duration=1e-3)
    batch = simulate_batch(system, outputs=["slider.ax.jitter", "slider.x.jitter"])
    real = run("compiled", "slider_crank_dry", duration=1e-3)
    times = np.union1d(real.time, np.linspace(0.0, 1e-3, 4001))
    columns, exact = real.evaluate(times), ideal(system).evaluate(times)
    for k, name in enumerate(("slider.ax", "slider.x")):
        deviation = columns[name] - exact[name]
        size = np.abs(deviation).max()
        assert batch.peak[0, 0, k] == pytest.approx(size, rel=1e-3)
        assert batch.peak[0, 0, k] >= size * (1.0 - 1e-9)  # the grid can only miss the peak


def test_rows_do_not_depend_on_threads_or_neighbours(press):
    variables = ["sdf.links.link2.mass", "joints.A.viscosity", "drives.O1.speed"]
    values = np.random.default_rng(0).uniform([0.2, 0.3, 6.0], [0.4, 0.5, 7.0], size=(12, 3))
    one = simulate_batch(press, variables, values, threads=1)
    many = simulate_batch(press, variables, values, threads=5)
    alone = simulate_batch(press, variables, values[7:8])
    for name in ("minimum", "maximum", "mean", "rms", "time_of_maximum"):
        assert getattr(one, name).tobytes() == getattr(many, name).tobytes()
        assert getattr(one, name)[7].tobytes() == getattr(alone, name)[0].tobytes()
    assert len({row.tobytes() for row in one.maximum}) == 12


def test_a_row_is_what_the_overrides_give_alone(press):
    """Masses without reading the file again, lengths with it: both as `load` with the same overrides."""
    given = {"sdf.links.link2.mass": 0.3, "sdf.links.link2.inertia": 9e-4, "joints.A.clearance": 2e-4}
    batch = simulate_batch(press, list(given), [list(given.values())], outputs=["A.force"])
    changed = load(press.experiment.source, given | {"duration": 0.5})
    alone = simulate_batch(changed, outputs=["A.force"])
    assert batch.maximum[0, 0, 0] == pytest.approx(alone.maximum[0, 0, 0], rel=1e-12)
    nominal = simulate_batch(press, outputs=["A.force"])
    assert abs(batch.maximum[0, 0, 0] / nominal.maximum[0, 0, 0] - 1.0) > 1e-2


def test_failures_are_rows(system_of):
    """No assembly, invalid values, a journal that leaves its film: statuses and reasons among good rows."""
    toml = """duration = 0.2
outputs = ["follower.angle"]
[drives.O]
speed = 20.0
[joints.A]
model = "lubricated"
clearance = 1e-3
viscosity = 0.1
"""
    variables = ["joints.A.viscosity", "joints.A.clearance", "drives.O.angle"]
    values = [[0.1, 1e-3, 0.0], [-1.0, 1e-3, 0.0], [1e-9, 1e-3, 0.0], [0.1, np.nan, 0.0], [0.1, 5.0, 0.0]]
    batch = simulate_batch(system_of(four_bar(), toml), variables, values)
    assert batch.status == [
        Status.OK,
        Status.BAD_INPUT,
        Status.JOURNAL_LEFT_BEARING,
        Status.BAD_INPUT,
        Status.BAD_INPUT,
    ]
    assert "viscosity" in batch.reason[1]
    assert "raise the viscosity" in batch.reason[2]
    assert "bearing's radius" in batch.reason[4]
    assert np.isnan(batch.maximum[1:]).all()
    assert np.isfinite(batch.maximum[0]).all()


@pytest.mark.parametrize(("path", "good"), [("joints.A.viscosity", 0.4), ("solver.max_step", 1e-3)])
def test_a_failure_in_the_first_row_is_a_row_too(press, path, good):
    """Also where the experiment has no value of its own, as for the longest step."""
    status = [simulate_batch(press, [path], rows).status for rows in ([[good], [-1.0]], [[-1.0], [good]])]
    assert status == [[Status.OK, Status.BAD_INPUT], [Status.BAD_INPUT, Status.OK]]


def test_bad_requests_are_refused_before_any_run(press):
    with pytest.raises(InputError, match="did you mean"):
        simulate_batch(press, ["joints.A.viscosit"], [[0.4]])
    with pytest.raises(InputError, match="link22"):
        simulate_batch(press, ["sdf.links.link22.mass"], [[0.4]])
    with pytest.raises(InputError, match="did you mean"):
        simulate_batch(press, outputs=["slider7.axx"])
    with pytest.raises(InputError, match="windows"):
        simulate_batch(press, windows=[[0.3, 0.1]])
    with pytest.raises(InputError, match="windows: end at 9 s, after the duration of"):
        simulate_batch(press, windows=[[0.0, 9.0]])
    with pytest.raises(InputError, match="values: are no real numbers but texts"):
        simulate_batch(press, ["joints.A.film"], [["long"]])
    with pytest.raises(InputError, match="values: have 3 dimensions"):
        simulate_batch(press, ["joints.A.viscosity"], [[[0.4]]])
    with pytest.raises(InputError, match="windows: are no real numbers but texts"):
        simulate_batch(press, windows="all")
    with pytest.raises(InputError, match="limits: have 1 numbers for 2 variables"):
        simulate_batch(press, ["joints.A.viscosity", "joints.B.viscosity"], [[0.4, 0.3]], limits=[[0.1], [0.5]])
    with pytest.raises(InputError, match="limits: must have two lines"):
        simulate_batch(press, ["joints.A.viscosity"], [[0.4]], limits=[[0.5], [0.1], [0.3]])
    with pytest.raises(InputError, match=r'variables: has "joints\.A\.viscosity" twice'):
        simulate_batch(press, ["joints.A.viscosity"] * 2, [[0.4, 0.3]])
    with pytest.raises(InputError, match="values: have masked entries"):
        simulate_batch(press, ["joints.A.viscosity"], np.ma.masked_greater([[0.4], [9e9]], 1.0))
    with pytest.raises(InputError, match=r"joints\.A\.viscosity: is given twice"):
        simulate_batch(press, wrt=["joints.A.viscosity"] * 2)
    with pytest.raises(InputError, match="oil: has no rates"):
        simulate_batch(press, wrt=[Direction("oil", 1.0, {})])
    with pytest.raises(InputError, match="values: have 2 numbers for 1 variables"):
        simulate_batch(press, ["joints.A.viscosity"], [[0.4, 0.3]])


def test_a_run_has_the_columns_that_are_named(press):
    """The same numbers as among all columns; of a linkage with closed loops with its coordinates, which are checked."""
    few, every = simulate(press, outputs=["A.force", "slider7.ax"]), run("compiled", "seven_bar", duration=0.5)
    assert list(few) == ["time", "A.force", "slider7.ax"]
    assert all(few[name].tobytes() == every[name].tobytes() for name in few)
    assert (few.units["A.force"], few.provenance["loop_error"]) == ("N", every.provenance["loop_error"])
    looped = shipped("six_bar_dry", duration=1e-3)
    names = ["C.force", *(f"q.{name}" for name in looped.tree.coordinates)]
    assert list(simulate(looped, outputs=["C.force"])) == ["time", *names]
    with pytest.raises(InputError, match="did you mean"):
        simulate(press, outputs=["A.forc"])
    with pytest.raises(InputError, match="compiled engine alone"):
        simulate(press, "drake", outputs=["A.force"])


def test_a_batch_shows_its_progress_on_a_terminal_unless_the_caller_does(monkeypatch):
    bars, parts = [], []

    class Bar:
        def __init__(self, **settings):
            self.settings, self.n = settings, 0.0
            bars.append(self)

        def __enter__(self):
            return self

        def __exit__(self, *_):
            return None

        def update(self, more):
            self.n += more

    monkeypatch.setattr("tqdm.tqdm", Bar)
    system = shipped("slider_crank_dry", duration=1e-3)
    simulate_batch(system, outputs=["B.force"])
    assert [bar.n for bar in bars] == [1.0]
    assert bars[0].settings["disable"] is None  # for tqdm: where there is no terminal
    simulate_batch(system, outputs=["B.force"], progress=parts.append)
    assert (len(bars), parts[-1]) == (1, 1.0)


def test_a_batch_of_an_implicit_method_has_the_numbers_of_a_run_at_the_ends_of_windows():
    """A replayed step is predicted by what its run has recorded: never by columns of outputs, however many there are."""
    system = shipped("slider_crank_flexible", duration=0.02)
    names, end = ["slider.ax", "slider.x", "B.force", "B.eccentricity_ratio"], 0.0171
    exact = simulate(system, "compiled").evaluate(np.array([end]))
    for count in (1, 2, 4):
        found = simulate_batch(system, outputs=names[:count], windows=[[0.0031, end]]).last[0, 0]
        np.testing.assert_allclose(found, [exact[name][0] for name in names[:count]], rtol=1e-13)
