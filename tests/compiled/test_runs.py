"""How runs of the compiled engine end, that they can be repeated, and the command line."""

import json
import os
import shutil
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest

import linkages
from linkages.cli.main import main
from linkages.engines.compiled import simulation
from linkages.engines.compiled.runner import Machine
from linkages.engines.compiled.simulation import simulate
from linkages.errors import Status
from linkages.files.shipped import data_folder
from linkages.model.experiment import load
from linkages.results.extremes import extremes
from linkages.system.assembly import AssemblyError, assemble


def shipped(name, **overrides):
    return load(data_folder() / f"{name}.toml", overrides)


THIN = {f"joints.{name}.viscosity": 1e-7 for name in "AB"}


def test_a_journal_that_leaves_its_film_ends_the_run():
    result = simulate(*shipped("seven_bar", duration=0.5, **THIN))
    assert result.status is Status.JOURNAL_LEFT_BEARING
    assert 0.0 < result.time[-1] < 0.5
    ratio = np.maximum(result["A.eccentricity_ratio"], result["B.eccentricity_ratio"])
    assert 0.999 < ratio[-1] < 1.01
    assert ratio[:-1].max() < ratio[-1]
    assert all(np.isfinite(values).all() for values in result.columns.values())


CENTRED = {"small_eccentricity.ratio": 0.2, "small_eccentricity.power": 0.648}


@pytest.mark.parametrize(
    "changes", [{"film": "finite"}, {"film": "short"}, CENTRED], ids=["finite", "short", "paper"]
)
def test_states_between_the_first_steps_of_a_centred_journal_are_numbers(changes):
    """The eccentricity's direction has no meaning at t = 0."""
    every = {f"joints.{name}.{key}": value for name in "AB" for key, value in changes.items()}
    result = simulate(*shipped("seven_bar", duration=0.1, **every))
    between = np.concatenate([np.linspace(*result.time[k : k + 2], 9) for k in range(20)])
    columns = result.evaluate(between)
    assert all(np.isfinite(values).all() for values in columns.values())
    found = extremes(result, ["slider7.x", "A.eccentricity_ratio"])
    assert 0.0 <= found["A.eccentricity_ratio"].min < found["A.eccentricity_ratio"].max < 1.0


def test_arrays_of_any_layout_give_the_same_run():
    """Functions called by address cannot look at the layout that they are given."""
    mechanism, experiment = shipped("slider_crank_dry", duration=1e-3)
    assembly = assemble(mechanism, experiment)
    strided = np.repeat(assembly.tree.bodies, 2)[::2]
    other = replace(assembly, tree=replace(assembly.tree, bodies=strided))
    assert not strided.flags.c_contiguous
    ends = []
    for each in (assembly, other):
        machine = Machine(each, experiment)
        ends.append(machine.run(0.0, machine.start, machine.first_step, 10**6).states[-1])
    np.testing.assert_array_equal(*ends)


def test_a_result_can_be_sent_to_another_process():
    """Its functions' addresses are of no use there: the same evaluation in a process that has compiled nothing yet."""
    result = simulate(*shipped("slider_crank_dry", duration=1e-3))
    times = np.linspace(0.0, 1e-3, 7)
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        there = pool.submit(result.evaluate, times).result()
    np.testing.assert_array_equal(there["B.force"], result.evaluate(times)["B.force"])


def test_a_linkage_that_cannot_be_closed_does_not_start():
    with pytest.raises(AssemblyError) as problem:
        simulate(*shipped("four_bar_dry", **{"sdf.frames.crank_A.pose.x": 0.9}))
    assert problem.value.status is Status.NO_ASSEMBLY


def test_an_interrupted_run_keeps_what_it_has(monkeypatch):
    monkeypatch.setattr(simulation, "_CHUNK", 20)

    def stop(time):
        if time > 0.05:
            raise KeyboardInterrupt

    result = simulate(*shipped("seven_bar"), progress=stop)
    assert result.status is Status.INTERRUPTED
    assert 0.05 < result.time[-1] < 1.0
    whole = simulate(*shipped("seven_bar", duration=float(result.time[-1])))
    assert result["slider7.x"][-1] == pytest.approx(whole["slider7.x"][-1], rel=1e-9)


def test_progress_goes_forward_to_the_end(monkeypatch):
    monkeypatch.setattr(simulation, "_CHUNK", 20)
    seen = []
    result = simulate(*shipped("seven_bar"), progress=seen.append)
    assert len(seen) > 3
    assert np.all(np.diff(seen) > 0.0)
    assert seen[-1] == result.time[-1] == 2.0
    assert np.all(np.diff(result.time) > 0.0)


@pytest.mark.parametrize("name", ["seven_bar", "slider_crank_dry"])
def test_a_run_can_be_repeated_to_the_last_bit_in_threads_too(name):
    mechanism, experiment = shipped(name)
    first = simulate(mechanism, experiment)
    with ThreadPoolExecutor(4) as pool:
        others = list(pool.map(lambda _: simulate(mechanism, experiment), range(8)))
    for other in others:
        assert other.columns.keys() == first.columns.keys()
        for column, values in first.columns.items():
            np.testing.assert_array_equal(other[column], values)


@pytest.mark.parametrize("name", ["seven_bar", "slider_crank_lubricated", "seven_bar_mixed"])
@pytest.mark.parametrize("accuracy", [1e-4, 1e-7])
def test_states_between_steps_are_those_of_a_run_that_ends_there(name, accuracy):
    """Also where a step cannot be taken again in one piece."""
    mechanism, experiment = shipped(name, **{"solver.accuracy": accuracy})
    result = simulate(mechanism, experiment)
    times = np.linspace(0.0, result.time[-1], 2003)
    columns = result.evaluate(times)
    assert all(np.isfinite(values).all() for values in columns.values())
    middle = float(times[1001])
    ended = simulate(mechanism, experiment.replaced({"duration": middle}))
    finest = simulate(mechanism, experiment.replaced({"duration": middle, "solver.accuracy": 1e-11}))
    joint = experiment.play[0]
    for end in ("ex", "ey"):
        name = f"{joint}.{end}"
        size = np.abs(columns[name]).max()
        error = abs(ended[name][-1] - finest[name][-1])
        assert abs(columns[name][1001] - finest[name][-1]) < 10.0 * error + 100.0 * accuracy * size


def test_command_line_writes_a_summary(tmp_path):
    arguments = ["simulate", str(data_folder() / "seven_bar.toml"), "--engine", "compiled", "--duration", "1"]
    assert main([*arguments, "--no-plots", "--no-animation", "--out", str(tmp_path)]) == 0
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["engine"] == summary["provenance"]["run"]["engine"] == "compiled"
    assert summary["provenance"]["run"]["method"] == "radau-iia-5"
    assert summary["status"] == summary["ideal"]["status"] == "ok"
    # PHYSICS of the paper's case, from two independent computations
    assert summary["joints"]["A"]["force"]["peak"] == pytest.approx(3.345, abs=1e-3)
    assert summary["joints"]["B"]["force"]["peak"] == pytest.approx(2.481, abs=1e-3)
    assert summary["outputs"]["slider7.ax"]["peak"] == pytest.approx(4.667, abs=1e-3)
    assert summary["ideal"]["outputs"]["slider7.ax"]["max"] == pytest.approx(3.524, abs=1e-3)
    error = summary["error"]
    assert 0.0 < error["A.force.peak"] < 1e-3 * 3.345
    assert 0.0 < error["slider7.ax.peak"] < 1e-3 * 4.667


def test_command_line_says_how_a_run_failed(tmp_path, capsys):
    settings = [part for key, value in THIN.items() for part in ("--set", f"{key}={value}")]
    arguments = ["simulate", str(data_folder() / "seven_bar.toml"), "--engine", "compiled", *settings]
    arguments += ["--no-plots", "--no-animation", "--out", str(tmp_path)]
    assert main(arguments) == 1
    assert "journal-left-bearing" in capsys.readouterr().err
    assert json.loads((tmp_path / "summary.json").read_text())["status"] == "journal-left-bearing"


PROBE = """
import ctypes
import numpy as np
from numba import types
import linkages
from linkages.kernel import address
from linkages.laws import FILMS
from linkages.laws.film.films import film_force

NONE = np.zeros(1)
SHORT = FILMS["short"].address

def probe(eps):
    return film_force(SHORT, eps, 0.1, 0.2, 0.25, NONE)[0]

by_address = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_double)(address(probe, types.float64(types.float64)))
print(linkages.__file__, probe(0.5), by_address(0.5))
"""


@pytest.mark.slow
def test_an_edited_law_reaches_the_kernels_that_call_it(tmp_path):
    """A copy of the package, run, edited, and run again: nothing stale comes from the compiler's cache."""
    shutil.copytree(Path(linkages.__file__).parent, tmp_path / "linkages")
    film = tmp_path / "linkages" / "laws" / "film" / "closed_form.py"
    (tmp_path / "probe.py").write_text(PROBE)
    environment = os.environ | {"PYTHONPATH": str(tmp_path), "NUMBA_CACHE_DIR": str(tmp_path / "cache")}

    def value():
        done = subprocess.run(
            [sys.executable, "probe.py"],
            env=environment,
            cwd=tmp_path,
            capture_output=True,
            text=True,
            check=True,
        )
        path, called, by_address = done.stdout.split()
        assert Path(path).is_relative_to(tmp_path)
        assert called == by_address
        return float(called)

    before = value()
    assert value() == before
    text = film.read_text()
    edited = text.replace("scale = 4.0 * slenderness", "scale = 8.0 * slenderness")
    assert edited != text
    film.write_text(edited)
    assert value() == 2.0 * before
