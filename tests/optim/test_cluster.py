"""Evaluations on a Dask cluster: a real scheduler and two worker processes, one of which is killed."""

import os
import re
import signal
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest
import toy_optimisation as toy
from toy_optimisation import run

from optim.evaluate.evaluations import Evaluations

distributed = pytest.importorskip("distributed")
pytestmark = pytest.mark.processes

REMEDY = "continue with --resume"
TESTS = Path(__file__).resolve().parents[1]


def start(*arguments):
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(TESTS), os.environ.get("PYTHONPATH", "")])}
    return subprocess.Popen(
        [sys.executable, "-m", *arguments],
        env=environment,
        stderr=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        text=True,
    )


def address_of(process):
    """The address that a process says it listens at."""
    for line in process.stderr:
        if found := re.search(r"(?:Scheduler|worker) at: +(tcp://\S+)", line):
            return found[1]
    raise AssertionError("no address")


@pytest.fixture
def loopback():
    """Address of a scheduler, and the processes of scheduler and two workers."""
    scheduler = start("distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard")
    processes = [scheduler]
    try:
        address = address_of(scheduler)
        for _ in range(2):
            processes.append(
                start("distributed.cli.dask_worker", address, "--no-nanny", "--nthreads", "1", "--no-dashboard")
            )
        with distributed.Client(address, set_as_default=False) as client:
            client.wait_for_workers(2)
        yield address, processes
    finally:
        for process in processes:
            process.kill()
            process.wait()
            process.stderr.close()


def worth(design, victim=0):
    """Runs on a worker; the victim is killed as it begins."""
    if os.getpid() == victim:
        os.kill(victim, signal.SIGKILL)
    return (*toy.worth(design), os.getpid())


@pytest.mark.slow
def test_a_killed_worker_loses_nothing(tmp_path, loopback):
    from linkages.engines.cluster import cluster

    address, (_, *workers) = loopback
    expected = run(toy.make_task(generations=8), tmp_path / "here.sqlite")
    calls, after = [], set()
    with cluster(address, REMEDY) as (executor, threads):
        assert threads() >= 1

        def evaluate(designs):
            calls.append(len(designs))
            victim = workers[0].pid if len(calls) >= 4 else 0
            futures = [executor.submit(worth, design, victim) for design in designs]
            f, g, status, reason, pid = zip(*(future.result() for future in futures), strict=True)
            if victim:
                after.update(pid)
            return Evaluations(np.array(f)[:, None], np.array(g)[:, None], status, reason)

        outcome = run(toy.make_task(generations=8, evaluate=evaluate), tmp_path / "there.sqlite")
    assert outcome.result.x.tobytes() == expected.result.x.tobytes()
    assert outcome.evaluations == expected.evaluations
    assert workers[0].wait() == -signal.SIGKILL, "it must have begun an evaluation, in which it is killed"
    assert after == {workers[1].pid}


@pytest.mark.slow
def test_a_killed_scheduler_ends_the_study_in_one_line_and_resume_ends_it_well(tmp_path, loopback, capfd):
    from linkages import RunError
    from linkages.engines.cluster import cluster

    address, (scheduler, *_) = loopback
    expected = run(toy.make_task(generations=8), tmp_path / "here.sqlite")
    calls = []

    def evaluate(designs):
        calls.append(len(designs))
        if len(calls) == 4:
            scheduler.kill()
        f, g, status, reason, _ = zip(*executor.map(worth, designs), strict=True)
        return Evaluations(np.array(f)[:, None], np.array(g)[:, None], status, reason)

    store = tmp_path / "there.sqlite"
    with pytest.raises(RunError, match=r"scheduler is lost.*--resume"), cluster(address, REMEDY) as (executor, _):
        run(toy.make_task(generations=8, evaluate=evaluate), store)
    assert capfd.readouterr().err == ""  # the error is the only message
    outcome = run(toy.make_task(generations=8), store, resume=True)
    assert outcome.result.x.tobytes() == expected.result.x.tobytes()
    assert outcome.evaluations == expected.evaluations


@pytest.mark.slow
def test_workers_of_other_versions_are_refused(loopback, monkeypatch):
    from linkages import RunError
    from linkages.engines import cluster

    address, _ = loopback
    here = cluster.determining()

    def pretended():
        return {**here, "numpy": "0.1"} if os.getpid() != PID else here

    PID = os.getpid()
    monkeypatch.setattr(cluster, "determining", pretended)
    with pytest.raises(RunError, match=r"worker tcp://\S+ has numpy 0\.1, here is"), cluster.cluster(address, REMEDY):
        pass


@pytest.mark.slow
def test_no_workers():
    from linkages import RunError
    from linkages.engines import cluster

    scheduler = start("distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard")
    try:
        address = address_of(scheduler)
        with (
            pytest.raises(RunError, match="has no workers; start some with: dask worker"),
            cluster.cluster(address, REMEDY, wait=0.5),
        ):
            pass
    finally:
        scheduler.kill()
        scheduler.wait()
        scheduler.stderr.close()


@pytest.mark.slow
def test_a_scheduler_is_found_by_its_file_and_waited_for(tmp_path):
    """The command begins before the scheduler, which begins before its worker."""
    from linkages.engines.cluster import cluster

    file, ended = tmp_path / "dask.json", []
    command = ("distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard")

    def work():
        with cluster(str(file), REMEDY, wait=100.0) as (executor, threads):
            ended.append((executor.submit(sum, [1, 2]).result(), threads()))

    thread = threading.Thread(target=work)
    thread.start()
    processes = [start(*command, "--scheduler-file", str(file))]
    try:
        address_of(processes[0])
        words = ("--no-nanny", "--nthreads", "1", "--no-dashboard", "--scheduler-file", str(file))
        processes.append(start("distributed.cli.dask_worker", *words))
        thread.join()
    finally:
        for process in processes:
            process.kill()
            process.wait()
            process.stderr.close()
    assert ended == [(3, 1)]


def test_a_file_that_no_scheduler_writes_is_not_waited_for_longer_than_asked(tmp_path, capsys):
    from linkages.cli.main import main

    words = ["tolerances", "slidercrank_tolerances", "--out", str(tmp_path / "out"), "--cluster"]
    file = str(tmp_path / "dask.json")
    assert main([*words, file, "--wait", "0"]) == 2
    remedy = f"start one with: dask scheduler --scheduler-file {file}; or give a longer --wait"
    assert capsys.readouterr().err == f"error: --cluster: {file}: no scheduler has written this file; {remedy}\n"


@pytest.mark.parametrize(("words", "said"), [
    (["--wait", "5"], "--wait: 5: belongs to --cluster; give the address, or remove it"),
    (["--wait", "-5", "--cluster", "x.json"], "--wait: -5: must be zero or positive"),
])  # fmt: skip
def test_a_time_to_wait_is_checked(tmp_path, capsys, words, said):
    from linkages.cli.main import main

    assert main(["tolerances", "slidercrank_tolerances", "--out", str(tmp_path / "out"), *words]) == 2
    assert capsys.readouterr().err == f"error: {said}\n"


STUDY = """experiment = "slider_crank_dry.toml"
[set]
duration = 0.001
joints.B.contact = {law = "sent", my_stiffness = 1e8}
[variables.stiffness]
path = "joints.B.contact.my_stiffness"
lower = 5e7
upper = 5e8
[variables.damping]
path = "joints.B.contact.my_damping"
lower = 0.0
upper = 1e3
[objectives.force]
terms = [{functional = "peak", output = "B.force"}]
[algorithm]
name = "ga"
"""


@pytest.mark.slow
def test_a_law_with_parameters_is_evaluated_by_workers_as_it_is_here(tmp_path, loopback, own_registries):
    from linkages import laws
    from linkages.engines.cluster import cluster
    from optim import Evaluator, load_study

    def spring(delta, ddelta, ddelta0, joint):
        return joint.my_stiffness * delta + joint.my_damping * ddelta

    stiffness = laws.Parameter("my_stiffness", "N/m", None, "stiffness", gt=0.0)
    damping = laws.Parameter("my_damping", "N s/m", 0.0, "damping", ge=0.0)
    laws.register_contact("sent", spring, parameters=[stiffness, damping])
    (tmp_path / "study.toml").write_text(STUDY)
    study = load_study(tmp_path / "study.toml")
    designs = np.array([[5e7, 0.0], [2e8, 0.0], [2e8, 500.0]])
    here = Evaluator(study)(designs)
    assert here.status == ("ok",) * 3
    assert len(np.unique(here.objectives)) == 3
    with cluster(loopback[0], REMEDY) as (executor, _):
        there = Evaluator(study, executor, parts=3)(designs)
    assert there.objectives.tobytes() == here.objectives.tobytes()


@pytest.mark.slow
def test_workers_compute_the_rows_of_a_sweep_as_they_are_here(tmp_path, loopback):
    from linkages.cli.main import main

    vary = ("--vary", "drives.O.speed=40:60:3", "--vary", "joints.B.clearance=0.2mm:0.5mm:2")
    words = ("sweep", "four_bar_dry.toml", *vary, "--revolutions", "1", "--transient", "0", "--output", "B.force")
    assert main([*words, "--out", str(tmp_path / "here")]) == 0
    assert main([*words, "--cluster", loopback[0], "--out", str(tmp_path / "there")]) == 0
    here, there = ({path.name: path.read_bytes() for path in (tmp_path / one).glob("*.*")} for one in ("here", "there"))
    assert here == there
    assert "map_B.force.png" in here
