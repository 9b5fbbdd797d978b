"""How runs end: journals that leave their films, linkages that lock or cannot be closed, interruption; repetition."""

import json
import subprocess
import sys
from itertools import pairwise

import numpy as np
import pytest
from engines import slow_on_drake
from machines import four_bar
from shipped import run as run_shipped
from shipped import shipped

from linkages import AssemblyError, Status, Stepper, extremes, ideal, load, simulate, simulate_batch
from linkages.cli.main import main
from linkages.engines import budget
from linkages.engines.compiled import simulation
from linkages.explore.flow import Flow

FILM = '[joints.{0}]\nmodel="lubricated"\nclearance=1e-4\nviscosity=0.1\n'


def test_a_journal_that_leaves_its_film_ends_the_run(engine):
    thin = {f"joints.{name}.viscosity": 1e-7 for name in "AB"}
    result = simulate(shipped("seven_bar_fast", duration=0.5, **thin), engine)
    assert result.status is Status.JOURNAL_LEFT_BEARING
    assert 0.0 < result.time[-1] < 0.1
    ratio = np.maximum(result["A.eccentricity_ratio"], result["B.eccentricity_ratio"])
    assert 0.9998 < ratio[-1] < 1.01
    assert ratio[:-1].max() < ratio[-1]
    assert all(np.isfinite(values).all() for values in result.columns.values())


def test_a_finite_film_ends_where_its_map_does(engine, system_of):
    """Never extrapolated: the run stops with a status when the journal passes the map's largest eps, 0.999."""
    film = FILM.format("A").replace("viscosity=0.1", 'viscosity=1e-6\nfilm="finite"')
    run = simulate(system_of(four_bar(), "duration=0.3\n[drives.O]\nspeed=15.0\n" + film), engine)
    assert run.status is Status.JOURNAL_LEFT_BEARING
    assert run["A.eccentricity_ratio"][-1] == pytest.approx(0.999, abs=2e-4)
    assert run["A.eccentricity_ratio"][:-1].max() < 0.999


def test_a_linkage_that_cannot_be_closed_does_not_start(engine):
    with pytest.raises(AssemblyError) as problem:
        simulate(shipped("four_bar_dry", **{"sdf.frames.crank_A.pose.x": 0.9}), engine)
    assert problem.value.status is Status.NO_ASSEMBLY


@slow_on_drake
def test_a_crank_that_locks_ends_the_run_where_geometry_says(engine, experiment_file, tmp_path, capsys):
    """Coupler and follower are stretched where the crank's tip is 0.3 m from the follower's pivot: cos(phi) = 1/3."""
    speed = 15.0  # rad/s
    sdf = four_bar(ground=0.3, crank=0.2, coupler=0.15, follower=0.15)
    path = experiment_file(sdf, f"duration=0.2\noutputs=['follower.omega']\n[drives.O]\nspeed={speed}\n")
    locked = np.arccos(1.0 / 3.0) / speed
    motion = ideal(load(path))
    assert motion.status is Status.LOCKED
    assert motion.time[-1] == pytest.approx(locked, abs=1e-9)
    assert np.sin(motion["coupler.angle"][-1] - motion["follower.angle"][-1]) == pytest.approx(0.0, abs=1e-3)
    out = tmp_path / "out"
    words = ["simulate", str(path), "--engine", engine, "--set", "solver.accuracy=1e-5", "--out", str(out)]
    assert main([*words, "--no-plots"]) == 1
    told = capsys.readouterr().err
    assert "the run ended" in told
    end = motion.time[-1]
    assert f"the ideal linkage ended at t = {end:.6g} s, O = {speed * end:.4g} rad: {motion.status.value}" in told
    summary = json.loads((out / "summary.json").read_text())
    assert summary["status"] == summary["ideal"]["status"] == "locked"
    assert summary["duration"] == pytest.approx(locked, abs=1e-4)
    (warning,) = summary["warnings"]
    assert warning["kind"] == "singular"
    assert "no other branch starts there" in warning["what"]
    for numbers in (summary, summary["ideal"]):  # which have no bound as the lock is neared
        assert numbers["outputs"]["follower.omega"]["peak"] is None
        assert numbers["joints"]["A"]["force"]["peak"] is None
    # though the ideal linkage cannot be drawn where the run still is
    assert (out / "animation.html").exists()


def _stepped(system):
    return Stepper(system, outputs=[]).step(system.experiment.duration)


def _flown(system):
    flow = Flow(system)
    flow.advance(system.experiment.duration)
    return flow.status


def _in_a_diagram(system):
    from pydrake.systems.analysis import Simulator
    from pydrake.systems.framework import DiagramBuilder

    from linkages.engines.drake import add_linkage

    builder = DiagramBuilder()
    linkage = add_linkage(builder, system)
    simulator = Simulator(builder.Build())
    linkage.set_initial_state(simulator.get_mutable_context())
    return linkage.advance(simulator, system.experiment.duration)


#: Ways to run a system; each returns the status of the end.
WAYS = {
    "simulate": lambda system: simulate(system, "compiled").status,
    "batch": lambda system: simulate_batch(system, outputs=["O.torque"]).status[0],
    "stepper": _stepped,
    "flow": _flown,
    "diagram": _in_a_diagram,
}


LOOSE, FEW = "accuracy=1e-5", "accuracy=1e-10\nmax_steps=1500"  # a flow has no limit of its steps


@pytest.mark.parametrize(
    ("way", "solver"), [*((way, LOOSE) for way in WAYS), *((way, FEW) for way in WAYS if way != "flow")]
)
def test_all_ways_to_run_into_a_dead_point_end_with_one_verdict(way, solver, system_of):
    """Steps shrink without a bound as it is neared: they collapse, or the run has taken all that it may."""
    sdf = four_bar(ground=0.3, crank=0.2, coupler=0.15, follower=0.15)
    system = system_of(sdf, f"duration=0.2\n[drives.O]\nspeed=15.0\n[solver]\n{solver}\n")
    assert WAYS[way](system) is Status.LOCKED


def test_a_design_that_locks_says_so_in_its_row(experiment_file):
    sdf = four_bar(ground=0.3, crank=0.2, coupler=0.15, follower=0.15)
    batch = simulate_batch(load(experiment_file(sdf, "duration=0.2\n[drives.O]\nspeed=15.0\n")), outputs=["O.torque"])
    assert batch.status == [Status.LOCKED]
    assert "dead point" in batch.reason[0]


def test_a_film_that_a_dead_point_breaks_is_not_blamed(engine, system_of):
    """The film fails when the coupler is stretched, soon after the lock of the ideal linkage, as above."""
    film = FILM.format("B").replace("viscosity=0.1", "viscosity=0.05")
    sdf = four_bar(ground=0.3, crank=0.2, coupler=0.15, follower=0.15)
    run = simulate(system_of(sdf, "duration=0.2\n[drives.O]\nspeed=15.0\n" + film), engine)
    assert run.status is Status.LOCKED
    assert run.time[-1] == pytest.approx(np.arccos(1.0 / 3.0) / 15.0, abs=2e-3)


@pytest.fixture
def often(monkeypatch):
    """Let the compiled engine look at the keyboard every 20 steps; Drake does at each."""
    monkeypatch.setattr(simulation, "WINDOW", 20)


@pytest.mark.usefixtures("often")
def test_an_interrupted_run_keeps_what_it_has(engine):
    def stop(time):
        if time > 0.05:
            raise KeyboardInterrupt

    result = simulate(shipped("seven_bar"), engine, progress=stop)
    assert result.status is Status.INTERRUPTED
    assert 0.05 < result.time[-1] < {"compiled": 1.0, "drake": 0.1}[engine]
    assert len(result["A.force"]) == len(result.time)
    whole = simulate(shipped("seven_bar", duration=float(result.time[-1])), engine)
    assert result["slider7.x"][-1] == pytest.approx(whole["slider7.x"][-1], rel=1e-9)


@pytest.mark.usefixtures("often")
def test_progress_goes_forward_to_the_end(engine):
    seen = []
    result = simulate(shipped("seven_bar", duration=1.0), engine, progress=seen.append)
    assert len(seen) > 3
    assert all(before < after for before, after in pairwise(seen))
    assert seen[-1] == result.time[-1] == 1.0
    assert np.all(np.diff(result.time) > 0.0)


@pytest.mark.usefixtures("often")
def test_a_run_of_too_many_steps_is_ended(engine, monkeypatch):
    monkeypatch.setattr(budget, "WINDOW", 40)
    monkeypatch.setattr(budget, "MOST", 160)
    result = simulate(shipped("seven_bar", **{"duration": 0.1, "solver.max_step": 1e-4}), engine)
    assert result.status is Status.TOO_MANY_STEPS
    assert "check the units" in result.status.remedy
    assert 0.0 < result.time[-1] < 0.1
    assert len(result.time) == pytest.approx(160, abs=40)


MANY_STEPS = """
import resource
import linkages
from linkages.engines import budget

def held():
    return 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss

system = linkages.load(linkages.find_file("seven_bar.toml"), {"duration": 0.01})
linkages.simulate(system, "compiled")  # whatever it takes to run at all
before, budget.ROOM = held(), 40_000_000
run = linkages.simulate(system.replaced({"duration": 1.0, "solver.max_step": 1e-6}), "compiled")
print(run.status.value, sum(column.nbytes for column in run.columns.values()), held() - before)
"""


def test_memory_for_a_run_of_many_steps_is_bounded():
    """Here 40 MB for the trajectory, to the next 20,000 steps, and not as much again to make it."""
    done = subprocess.run([sys.executable, "-c", MANY_STEPS], capture_output=True, text=True, check=True)
    status, size, held = done.stdout.split()
    assert status == "too-many-steps"
    assert 40e6 < int(size) < 80e6
    assert int(held) < 1.8 * int(size)


def test_a_run_whose_end_is_out_of_reach_is_ended():
    """At 1e12 rad/s every step is accurate, and 1.6e9 revolutions are to come."""
    result = simulate(shipped("five_bar_dry", **{"drives.O2.speed": 1e12, "duration": 0.01}), "compiled")
    assert result.status is Status.TOO_MANY_STEPS
    assert 0.0 < result.time[-1] < 1e-6 * 0.01


def test_a_run_can_be_repeated_to_the_last_bit(engine):
    first = run_shipped(engine, "seven_bar", duration=0.1)
    second = simulate(shipped("seven_bar", duration=0.1), engine)
    assert first.columns.keys() == second.columns.keys()
    for name, column in first.columns.items():
        np.testing.assert_array_equal(column, second[name])


CENTRED = {"small_eccentricity.ratio": 0.2, "small_eccentricity.power": 0.648}


@pytest.mark.parametrize("changes", [{"film": "finite"}, {"film": "short"}, CENTRED], ids=["finite", "short", "paper"])
def test_states_between_the_first_steps_of_a_centred_journal_are_numbers(engine, changes):
    """The eccentricity's direction has no meaning at t = 0."""
    every = {f"joints.{name}.{key}": value for name in "AB" for key, value in changes.items()}
    result = simulate(shipped("seven_bar", duration=0.1, **every), engine)
    between = np.concatenate([np.linspace(*result.time[k : k + 2], 9) for k in range(20)])
    columns = result.evaluate(between)
    assert all(np.isfinite(values).all() for values in columns.values())
    found = extremes(result, ["slider7.x", "A.eccentricity_ratio"])
    assert 0.0 <= found["A.eccentricity_ratio"].min < found["A.eccentricity_ratio"].max < 1.0
