"""Files, ``--set`` values and stores with something wrong in them: one line of refusal or finite numbers, and soon.

Run as a script, it tries as many as one likes: ``python tests/test_mutations.py --count 10000 --seed 1``.
"""

from __future__ import annotations

import argparse
import faulthandler
import io
import json
import shutil
import signal
import sys
import tempfile
import traceback
from collections import Counter
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import toy_optimisation
from mutants import EXPERIMENTS, MACHINES, Mutator, write

import linkages
import optim
from linkages.cli.main import main
from linkages.errors import InputError, RunError

COUNTS = {"load": 400, "study": 100, "store": 100, "import": 200, "compiled": 40}  # mutants of every run of the tests
SHARES = {"load": 4, "study": 2, "store": 2, "import": 2, "compiled": 11, "drake": 1}  # of the script's
LONGEST = 20  # s of the processor for one mutant
STUCK = 1800  # s after which the script gives up

FAULT, HANG = "FAULT", "HANG"  # beginnings of the endings that must not be


@contextmanager
def at_most(seconds: float):
    """Press Ctrl-C if it takes the processor longer, and again: results of an interrupted run are kept."""
    before = signal.signal(signal.SIGPROF, lambda *_: signal.raise_signal(signal.SIGINT))
    signal.setitimer(signal.ITIMER_PROF, seconds, 2.0)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


def command(*words: object) -> tuple[int, str, str]:
    """Run a command; returns its exit status and what it wrote to both outputs."""
    with redirect_stdout(io.StringIO()) as out, redirect_stderr(io.StringIO()) as errors:
        status = main([str(word) for word in words])
    if status == 130:
        raise KeyboardInterrupt("the rest takes" in errors.getvalue())
    assert status in (0, 1, 2), status
    assert status != 2 or len(errors.getvalue().splitlines()) == 1, errors.getvalue()
    return status, out.getvalue(), errors.getvalue()


def load(mutator: Mutator, folder: Path) -> str:
    """Load a mutant: what is taken has finite numbers."""
    file, settings = write(mutator, folder, mutator.dice.choice(("machine", "experiment", "setting")))
    try:
        system = linkages.load(file, dict(item.split("=", 1) for item in settings))
        found = [
            system.gravity,
            *system.motions(np.zeros(1)),
            *(system.tree.bodies.records[x] for x in ("mass", "inertia")),
        ]
    except (InputError, RunError) as problem:
        return refusal(problem)
    assert all(np.isfinite(values).all() for values in found)
    return "taken"


def study(mutator: Mutator, folder: Path) -> str:
    """Load a mutant of a study: what is taken has finite numbers."""
    file, _ = write(mutator, folder, "study")
    try:
        found = optim.load_study(file)
    except (InputError, RunError) as problem:
        return refusal(problem)
    assert all(np.isfinite(x).all() for x in (found.lower, found.upper, found.nominal, *found.designs.values()))
    return "taken"


def refusal(problem: Exception) -> str:
    assert "\n" not in str(problem)
    return "refused"


@cache
def undamaged() -> bytes:
    """A store with a hundred evaluations."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "study.sqlite"
        optim.search.run.run(toy_optimisation.make_task(generations=20), path)
        return path.read_bytes()


def store(mutator: Mutator, folder: Path) -> str:
    """Read a damaged store: it is refused, or what is read is what was written."""
    path, table = folder / "study.sqlite", folder / "designs.csv"
    shown = []
    for data in (undamaged(), mutator.damage(undamaged())):
        path.write_bytes(data)
        table.unlink(missing_ok=True)
        status, told, _ = command("study", "show", path)
        exported, _, _ = command("study", "export", path, "--out", table)
        shown.append((told, table.read_bytes() if table.exists() else b""))
        assert status in (0, 2)
        assert status == exported, (status, exported)
    assert status == 2 or shown[0] == shown[1], "shows something else"
    return "taken" if status == 0 else "refused"


#: Of another program, with a loop in it.
URDF = b"""<robot name="four_bar">
<link name="world"/>
<link name="crank"><inertial><origin xyz="0.05 0 0" rpy="0 0 0.1"/><mass value="0.2"/>
<inertia ixx="0" iyy="2e-4" izz="2e-4" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="coupler"><inertial><origin xyz="0.125 0 0"/><mass value="0.2"/>
<inertia ixx="0" iyy="1e-3" izz="1e-3"/></inertial><visual><geometry><box size="0.2 0.01 0.01"/></geometry></visual></link>
<link name="follower"><inertial><mass value="0.2"/><inertia ixx="0" iyy="1e-3" izz="1e-3"/></inertial></link>
<joint name="O" type="continuous"><parent link="world"/><child link="crank"/><axis xyz="0 0 1"/></joint>
<joint name="A" type="continuous"><origin xyz="0.1 0 0" rpy="0 0 0.5"/><parent link="crank"/><child link="coupler"/>
<axis xyz="0 0 1"/></joint>
<joint name="Q" type="revolute"><origin xyz="0.3 0 0" rpy="0 0 1.2"/><parent link="world"/><child link="follower"/>
<axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="0" velocity="0"/></joint>
<loop_joint name="B" type="continuous"><axis xyz="0 0 1"/><link1 link="coupler" xyz="0.25 0 0" rpy="0 0 0"/>
<link2 link="follower" xyz="0.2 0 0" rpy="0 0 0"/></loop_joint></robot>"""


def importing(mutator: Mutator, folder: Path) -> str:
    """Import a mutant of another program's file: what is written loads, and has finite numbers."""
    source, out = folder / "theirs.xml", folder / "ours.sdf"
    out.unlink(missing_ok=True)
    given = [path.read_bytes() for path in MACHINES]
    source.write_bytes(mutator.mutant(mutator.dice.choice([*given, *[URDF] * len(given)])))
    status, _, _ = command("import", source, "--out", out)
    assert out.exists() == (status == 0)
    if status:
        return "refused"
    machine = linkages.load_mechanism(out)
    assert all(np.isfinite([link.mass, link.inertia, *link.com]).all() for link in machine.links)
    return "taken"


def simulate(engine: str, mutator: Mutator, folder: Path) -> str:
    """Simulate a mutant: every number of a run that is ok is finite."""
    file, settings = write(mutator, folder, mutator.dice.choice(("machine", "experiment", "setting")))
    out = folder / "out"
    shutil.rmtree(out, ignore_errors=True)
    sets = [word for item in settings for word in ("--set", item)]
    how = ("--engine", engine, "--no-plots", "--no-animation", "--duration", "0.01", "--out", out)
    status, _, told = command("simulate", file, *how, *sets)
    if status == 2:
        assert not list(out.glob("*")), "something was written"
        return "refused"
    if not (out / "summary.json").exists():
        assert status == 1
        return "refused: no run"
    summary = json.loads((out / "summary.json").read_text(), parse_constant=lambda word: pytest.fail(word))
    assert (summary["status"] == "ok") == (status == 0) or "the run ended" not in told, summary["status"]
    if summary["status"] == "ok":
        assert None not in [output["peak"] for output in summary["outputs"].values()]
    return summary["status"]


TRIALS = {"load": load, "study": study, "store": store, "import": importing}
TRIALS |= {engine: lambda *given, engine=engine: simulate(engine, *given) for engine in ("compiled", "drake")}


def ending(kind: str, number: int, seed: int, folder: Path) -> str:
    """Try a mutant; what hangs is tried twice: the first time it may have been the compiler."""
    for _ in range(2):
        try:
            with at_most(LONGEST):
                return TRIALS[kind](Mutator(f"{kind} {number} {seed}"), folder)
        except KeyboardInterrupt as pressed:
            found = "slow, and says so" if pressed.args == (True,) else HANG
        except BaseException as problem:
            frames = traceback.extract_tb(problem.__traceback__)
            ours = [frame for frame in frames if "site-packages" not in frame.filename] or frames
            said = f"{type(problem).__name__}: {' '.join(str(problem).split())[:100]}"
            return f"{FAULT} {Path(ours[-1].filename).name}:{ours[-1].lineno} {said}"
    return found


def faults(ends: Counter) -> list[str]:
    return [text for text in ends if text.startswith((FAULT, HANG))]


@pytest.mark.slow
@pytest.mark.parametrize("kind", COUNTS)
def test_mutants_are_refused_in_one_line_or_give_finite_numbers(kind, tmp_path):
    ends = Counter(ending(kind, k, 1, tmp_path) for k in range(COUNTS[kind]))
    assert not faults(ends), ends
    assert min(ends["refused"], COUNTS[kind] - ends["refused"]) > 0.1 * COUNTS[kind]


def script() -> int:
    """Try many mutants; prints how many of each kind ended how, and which did not end well."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=1000, help="default: %(default)s")
    parser.add_argument("--first", type=int, default=0, help="number of the first; default: %(default)s")
    parser.add_argument("--seed", type=int, default=1, help="default: %(default)s")
    parser.add_argument("--kinds", nargs="+", choices=TRIALS, default=list(TRIALS), help="default: all")
    options = parser.parse_args()
    order = [kind for kind in options.kinds for _ in range(SHARES[kind])]
    ends: Counter = Counter()
    with tempfile.TemporaryDirectory() as folder:
        for path in EXPERIMENTS if "compiled" in options.kinds else ():  # compiles what they need
            command("simulate", path, "--engine", "compiled", "--duration", "0.01", "--out", Path(folder) / "out")
        for number in range(options.first, options.first + options.count):
            kind = order[number % len(order)]
            faulthandler.dump_traceback_later(STUCK, exit=True)
            found = ending(kind, number, options.seed, Path(folder))
            ends[f"{kind:10s}{found}"] += 1
            if faults(Counter([found])):
                print(f"{kind} {number}: {found}", flush=True)
            if sys.stderr.isatty() or number % 100 == 99:
                print(f"\r{number + 1 - options.first}", end="", file=sys.stderr, flush=True)
    faulthandler.cancel_dump_traceback_later()
    print(f"\n{options.count} mutants from number {options.first}, seed {options.seed}")
    for text, count in sorted(ends.items()):
        print(f"{count:7d}  {text}")
    return int(any(text[10:].startswith((FAULT, HANG)) for text in ends))


if __name__ == "__main__":
    sys.exit(script())
