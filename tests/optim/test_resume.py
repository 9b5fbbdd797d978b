"""A study killed at any moment continues and gives the same result."""

import random
import signal
import sqlite3
import subprocess
import sys
from pathlib import Path

import pytest
import toy_optimisation as toy
from strikes import calls_in
from toy_optimisation import run

from linkages import RunError
from optim import Stopped
from optim.algorithms.nlp import Progress
from optim.algorithms.registry import ALGORITHMS, minimise, read_settings

KILLS = 12


def contents(path):
    """Everything a store holds, the time aside."""
    with sqlite3.connect(path) as db:
        tables = {
            name: db.execute(f"SELECT * FROM {name}").fetchall() for name in ("evaluations", "iterations", "meta")
        }
    tables["meta"] = [row for row in tables["meta"] if row[0] != "elapsed"]
    return tables


def solved(store, result, population=1, at=0):
    """Solve in a process that kills itself at a call after so many populations; returns its status and what it says."""
    command = [sys.executable, toy.__file__, *map(str, (store, result, population, at))]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False)
    return done.returncode, done.stdout


@pytest.mark.slow
@pytest.mark.processes
def test_killed_at_random_moments(tmp_path):
    whole, broken = tmp_path / "whole.sqlite", tmp_path / "broken.sqlite"
    status, said = solved(whole, tmp_path / "whole.json")
    assert status == 0
    rng, kept, most = random.Random(0), [], calls_in(said) // (2 * toy.GENERATIONS)  # of a population
    for _ in range(KILLS):
        population, at = rng.randint(1, 2), rng.randint(1, most)
        assert solved(broken, tmp_path / "broken.json", population, at)[0] == -signal.SIGKILL
        kept.append(len(contents(broken)["evaluations"]))
    assert solved(broken, tmp_path / "broken.json")[0] == 0
    assert (tmp_path / "broken.json").read_bytes() == (tmp_path / "whole.json").read_bytes()
    assert contents(broken) == contents(whole)
    assert len(set(kept)) >= 8, f"the kills must fall at different moments, not at {kept}"


@pytest.mark.parametrize("kept", [0, 1, 7, 8, 40, 100])
def test_goes_on_from_any_population(tmp_path, kept):
    """Computation fails after some evaluations; committed evaluations are not repeated."""
    whole, broken = tmp_path / "whole.sqlite", tmp_path / "broken.sqlite"
    expected = run(toy.make_task(), whole)
    asked = []

    def breaks(designs):
        if len(asked) + len(designs) > kept:
            raise RunError("the machine room is on fire")
        asked.extend(map(bytes, designs))
        return toy.evaluate(designs)

    with pytest.raises(RunError, match="on fire"):
        run(toy.make_task(evaluate=breaks), broken)
    again = []

    def counts(designs):
        again.extend(map(bytes, designs))
        return toy.evaluate(designs)

    outcome = run(toy.make_task(evaluate=counts), broken, resume=True)
    assert contents(broken) == contents(whole)
    assert outcome.result.x.tobytes() == expected.result.x.tobytes()
    assert outcome.evaluations == expected.evaluations == len(asked) + len(again)
    assert not set(asked) & set(again)


def test_stops_after_an_iteration_and_goes_on(tmp_path):
    whole, broken = tmp_path / "whole.sqlite", tmp_path / "broken.sqlite"
    expected = run(toy.make_task(), whole)
    seen = []
    with pytest.raises(Stopped, match="after iteration 4"):
        run(toy.make_task(), broken, observe=lambda row: seen.append(row.iteration), stop=lambda: len(seen) == 4)
    outcome = run(toy.make_task(), broken, resume=True)
    assert outcome.result.x.tobytes() == expected.result.x.tobytes()
    assert contents(broken) == contents(whole)


def test_each_design_is_evaluated_once(tmp_path):
    sizes = []

    def counts(designs):
        sizes.append(len(designs))
        return toy.evaluate(designs)

    def repeats(problem, progress):
        design = problem.start
        problem.evaluate(design[None].repeat(3, axis=0))
        values = problem.evaluate(design[None] + [[0.0, 0.0], [0.5, 0.0], [0.5, 0.0]])
        progress(Progress(1, 1, design, values, {}))
        return toy.nlp.Result(design[None], values, "budget-used", 1, 1)

    outcome = run(toy.make_task(evaluate=counts, minimise=repeats), tmp_path / "study.sqlite")
    assert sizes == [1, 1]  # the nominal design, then the only other one
    assert outcome.evaluations == 2


def test_an_algorithm_that_catches_everything_cannot_hide_an_error(tmp_path):
    def deaf(problem, progress):
        try:
            return problem.evaluate(problem.start[None] + 0.1)
        except Exception:
            pytest.fail("the error must pass")

    def breaks(designs):
        if not (designs == toy.NOMINAL).all():
            raise RunError("no more licences")
        return toy.evaluate(designs)

    with pytest.raises(RunError, match="licences"):
        run(toy.make_task(evaluate=breaks, minimise=deaf), tmp_path / "study.sqlite")


def test_other_code_is_noticed(tmp_path):
    path = Path(tmp_path / "study.sqlite")
    seen = []
    with pytest.raises(Stopped):
        run(toy.make_task(), path, observe=lambda row: seen.append(row), stop=lambda: len(seen) == 5)
    before = contents(path)
    changed = toy.make_task(minimise=lambda problem, progress: toy.evolve(problem, 2, progress))
    with pytest.raises(RunError, match="iteration 1 does not come out as it was stored"):
        run(changed, path, resume=True)
    after = contents(path)
    assert after["evaluations"][: len(before["evaluations"])] == before["evaluations"]
    assert after["iterations"] == before["iterations"]


SETTINGS = {
    "ga": {"population": 8, "generations": 6, "restarts": 2},
    "nsga2": {"population": 8, "generations": 6},
    "grg": {"starts": 2, "iterations": 8},
    "snopt": {"starts": 2, "iterations": 8},
    "differential-evolution": {"generations": 6, "population": 8},
}


@pytest.mark.parametrize("name", ALGORITHMS)
def test_every_algorithm_goes_on_from_where_it_broke_off(tmp_path, name):
    settings = read_settings(name, SETTINGS[name])

    def task(evaluate):
        return toy.make_task(
            evaluate=evaluate, minimise=lambda problem, progress: minimise(name, problem, settings, 5, progress)
        )

    populations = []

    def counts(designs):
        populations.append(len(designs))
        return toy.evaluate(designs)

    whole, broken = tmp_path / "whole.sqlite", tmp_path / "broken.sqlite"
    expected = run(task(counts), whole)
    assert expected.evaluations == sum(populations)
    assert contents(whole)["iterations"]
    rest = len(populations)
    while rest:  # five populations at a time
        left = [5]

        def breaks(designs, left=left):
            left[0] -= 1
            if left[0] < 0:
                raise RunError("a power cut")
            return toy.evaluate(designs)

        rest = max(rest - 5, 0)
        if rest:
            with pytest.raises(RunError, match="a power cut"):
                run(task(breaks), broken, resume=True)
        else:
            outcome = run(task(breaks), broken, resume=True)
    assert contents(broken) == contents(whole)
    assert outcome.result.x.tobytes() == expected.result.x.tobytes()
    assert outcome.found.objectives.tobytes() == expected.found.objectives.tobytes()


@pytest.mark.parametrize("name", ALGORITHMS)
def test_every_algorithm_stops_when_asked(tmp_path, name):
    settings = read_settings(name, SETTINGS[name])

    def task(evaluate=toy.evaluate):
        return toy.make_task(
            evaluate=evaluate, minimise=lambda problem, progress: minimise(name, problem, settings, 5, progress)
        )

    seen = []
    with pytest.raises(Stopped):
        run(task(), tmp_path / "asked.sqlite", observe=lambda row: seen.append(row.step), stop=lambda: len(seen) == 2)
    assert seen == [1, 2]
    calls = []

    def interrupted(designs):  # Ctrl-C for the second time
        calls.append(len(designs))
        if len(calls) == 4:
            raise KeyboardInterrupt
        return toy.evaluate(designs)

    with pytest.raises(KeyboardInterrupt):
        run(task(interrupted), tmp_path / "at_once.sqlite")
    assert len(calls) == 4
    whole = run(task(), tmp_path / "whole.sqlite")
    for stopped in ("asked", "at_once"):
        again = run(task(), tmp_path / f"{stopped}.sqlite", resume=True)
        assert again.result.x.tobytes() == whole.result.x.tobytes()
        assert contents(tmp_path / f"{stopped}.sqlite") == contents(tmp_path / "whole.sqlite")
