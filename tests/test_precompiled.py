"""Background processes that compile on an empty cache: their work, when there are none, and that none remains."""

import os
import select
import signal
import subprocess
import sys

import pytest
from shipped import FAST_PRESS

from linkages.base.kernel import precompiled

pytestmark = pytest.mark.processes

KERNELS = """
import threading
from linkages.base.kernel import kernel

{kernels}

@kernel
def expected(x):
    return x + 100

def plan(wanted):
    return [lambda: expected(wanted)]
"""
KERNELS = KERNELS.format(kernels="\n".join(f"@kernel\ndef f{k}(x):\n    return x + {k}\n" for k in range(4)))
SCRIPT = """
import sys, threading
from linkages.base.kernel import precompiled
import kernels

print("begun", flush=True)
precompiled.processors = lambda: int(sys.argv[1])
precompiled.expect("kernels:plan", 1.5)
for k in range(4):
    getattr(kernels, f"f{k}")(1.5)
pids = [process.pid for process in precompiled._beside]
print(*pids, flush=True)
for process in precompiled._beside:
    process.wait()
before = precompiled.counts()[1]
assert kernels.expected(1.5) == 101.5
print(precompiled.counts()[1] - before, flush=True)
"""
ENDLESS = SCRIPT.replace("    process.wait()", "    threading.Event().wait()")
WAITING = KERNELS.replace("expected(wanted)", "threading.Event().wait()")


@pytest.fixture
def start(tmp_path):
    """Start a script, with nothing in it that keeps it from running when it is imported; it has a separate cache."""
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}

    def start(processors: int, script: str = SCRIPT, kernels: str = KERNELS) -> subprocess.Popen:
        (tmp_path / "kernels.py").write_text(kernels)
        (tmp_path / "script.py").write_text(script)
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
        return subprocess.Popen([sys.executable, "script.py", str(processors)], cwd=tmp_path, env=environment, **pipes)

    return start


@pytest.mark.slow
def test_what_is_expected_is_compiled_beside_on_an_empty_cache_and_nothing_is_started_on_a_full_one(start):
    found, errors = start(2).communicate()
    begun, beside, hits = found.splitlines()
    assert (begun, len(beside.split()), hits, errors) == ("begun", 1, "1", "")
    found, errors = start(2).communicate()
    assert (found, errors) == ("begun\n\n1\n", "")


HOLDING = """
import sys
from linkages.base.kernel import folder, locks, stored
import numba, kernels

name = stored.name_of(kernels.f0.py_func, (numba.float64,))
assert locks.acquire(folder.folder(), name)
print("holds", flush=True)
sys.stdin.read()
"""
PUT_OFF = """
from linkages.base.kernel import precompiled
import kernels

kernels.plan = lambda: [lambda: kernels.f0(1.5), lambda: kernels.f1(1.5), lambda: print("done", flush=True)]
precompiled.assist([("kernels:plan", ())], 0)
print(kernels.f0(1.5), kernels.f1(1.5), flush=True)
"""


def test_what_another_process_is_compiling_is_put_off_not_waited_for(start):
    """It holds the first of two kernels: the second is compiled, then, as soon as it lets go, the first."""
    holding = start(1, HOLDING)
    assert holding.stdout.readline() == "holds\n"
    assisting = start(1, PUT_OFF)
    assert assisting.stdout.readline() == "done\n"
    assert assisting.poll() is None
    holding.kill()
    assert assisting.stdout.readline() == "1.5 2.5\n"
    assisting.kill()
    holding.communicate()
    assisting.communicate()


def test_one_processor_compiles_in_one_process(start):
    assert start(1).communicate() == ("begun\n\n0\n", "")


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "pidfd_open"), reason="waits for a process that another one has started")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_no_process_is_left_over(start, number):
    """Whatever ends the one that they compile for, they end soon: else they would wait for ever."""
    process = start(2, ENDLESS, WAITING)
    assert process.stdout.readline() == "begun\n"
    (beside,) = map(int, process.stdout.readline().split())
    end = os.pidfd_open(beside)
    process.send_signal(number)
    process.communicate()
    assert select.select([end], [], [], 300.0)[0]
    os.close(end)


RAN = """
from linkages.base.kernel import stored
read, names = stored.read, set()
def noted(name):
    stored = read(name)
    if stored is not None:
        names.add(name)
    return stored
stored.read = noted
{what}
print(*sorted(names))
"""
WORK = """import sys
from linkages.engines import precompilation
for job in precompilation.{}({}):
    job()
assert not {{"pydrake", "matplotlib"}} & set(sys.modules)
"""
RUN = f"""import linkages
system = linkages.load({str(FAST_PRESS)!r}, {{{{"duration": 0.01}}}})
{{}}
"""


@pytest.mark.slow
@pytest.mark.parametrize(("engine", "settings"), [("compiled", "True"), ("drake", "")])
def test_plans_name_what_a_run_needs(engine, settings):
    """A run of the press needs few kernels outside its engine's plan, and the plan has few others.

    What differs are the laws (of the film, of the contact; each for floats and for duals) and what the drop test has not:
    loops, drives, the formulas of their outputs, and for each duty the loop over contacts of the machine's kind.
    """

    def loaded(what):
        command = [sys.executable, "-c", RAN.format(what=what)]
        return set(subprocess.run(command, capture_output=True, text=True, check=True).stdout.split())

    run = RUN.format(f"linkages.summarize(linkages.assess(system, {engine!r}))")
    loaded(run)  # what compiles has the parts of kernels too
    ran, planned = loaded(run), loaded(WORK.format(engine, settings))
    assert len(ran) > 50
    assert len(ran ^ planned) <= len(ran) // 7


def test_processors_are_those_that_may_be_used():
    allowed = os.sched_getaffinity(0)
    try:
        os.sched_setaffinity(0, {min(allowed)})
        assert precompiled.processors() == 1
    finally:
        os.sched_setaffinity(0, allowed)
