"""Independent runs in threads: errors end them at once, and the machine may refuse threads."""

import itertools
import threading

import pytest

from linkages import InputError, RunError, find_file, load, simulate_batch
from linkages.engines.compiled.batch import runs as runs_of
from linkages.engines.threads import in_threads

pytestmark = pytest.mark.processes


@pytest.mark.parametrize("threads", [1, 2, 7, None])
def test_results_are_in_order_and_the_end_is_looked_at(threads):
    ended = []

    def work(k):
        ended.append(k)
        return k * k

    seen = []
    assert in_threads(work, 20, threads, lambda: seen.append(len(ended))) == [k * k for k in range(20)]
    assert seen[-1] == 20
    assert in_threads(work, 0, threads) == []


@pytest.mark.parametrize("threads", [1, 2])
def test_an_error_ends_the_runs_that_have_not_begun(threads):
    begun, ended = [], threading.Event()

    def work(k):
        begun.append(k)
        if k == 3:
            raise InputError("run", "3", "fails")
        if k > 3:
            ended.wait(300.0)

    with pytest.raises(InputError, match="run: 3: fails"):
        in_threads(work, 10_000, threads, stop=ended.set if threads > 1 else None)
    assert max(begun) <= 3 + (threads - 1)


def test_a_batch_without_memory_for_threads_ends_in_one_line(monkeypatch):
    """As under a limit of the address space that the stacks of many threads exceed."""
    start, started, full = threading.Thread.start, [], threading.Event()

    def refused(thread):
        if len(started) == 2:
            full.set()
            raise RuntimeError("can't start new thread")
        started.append(thread)
        start(thread)

    monkeypatch.setattr(threading.Thread, "start", refused)
    monkeypatch.setattr(runs_of.Runs, "_run", lambda *_: full.wait(300.0))
    monkeypatch.setattr(runs_of, "RUNS_AT_ONCE", 1)
    system = load(find_file("seven_bar.toml"), {"duration": 0.01})
    with pytest.raises(RunError, match=r"the threads of 20 runs cannot be started .*: use fewer threads"):
        simulate_batch(system, ["joints.A.clearance"], [[2e-4]] * 20, ["A.force"], threads=20)


def test_a_batch_whose_run_finds_no_memory_ends_at_once(monkeypatch):
    def run(*_):
        runs.append(number := next(numbers))
        if number == 5:
            raise MemoryError
        if number > 5:
            ended.wait(300.0)

    def end(self):
        stop(self)
        ended.set()

    runs, parts, numbers, ended, stop = [], [], itertools.count(), threading.Event(), runs_of.Runs._end
    monkeypatch.setattr(runs_of.Runs, "_run", run)
    monkeypatch.setattr(runs_of.Runs, "_end", end)
    monkeypatch.setattr(runs_of, "RUNS_AT_ONCE", 1)
    system = load(find_file("seven_bar.toml"), {"duration": 0.01})
    with pytest.raises(MemoryError):
        simulate_batch(system, ["joints.A.clearance"], [[2e-4]] * 2000, ["A.force"], threads=2, progress=parts.append)
    assert max(runs) <= 6
