"""The page of the algorithms agrees with the code, its numbers are measured, and its example works."""

import itertools
import re
import sys
from dataclasses import replace
from pathlib import Path

import make_algorithms
import pytest

import optim
from optim.algorithms import registry as algorithms
from optim.algorithms.nlp import Ending
from optim.algorithms.registry import Algorithm, minimise

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "optimisation_algorithms.md").read_text(encoding="utf-8")


def test_page_is_fresh():
    """Regenerate with ``python docs/make_algorithms.py``."""
    start = PAGE.index("| problems with |")
    problems = PAGE[start : PAGE.index("\nAll optima are found")]
    assert make_algorithms.page(problems) == PAGE


@pytest.mark.slow
def test_the_numbers_are_measured_ones():
    """Published optima to 1e-6; medians of counts to 10 %: counts hang on the processor's rounding where a problem is hard."""
    rows = [make_algorithms.measure(example) for example in make_algorithms.EXAMPLES]
    for row in rows:
        assert row.found == pytest.approx(row.example.optimum, rel=1e-6, abs=1e-6)
    assert [row.example.number for row in rows if row.snopt is None] == [64]
    lines = re.findall(r"^\| [a-z ]+ \| ([\d |]+) \|$", PAGE, re.MULTILINE)
    for line, kind in zip(lines, "bievd", strict=False):
        number, *counts = map(int, line.split(" | "))
        now, *medians = make_algorithms.counts(rows, kind)
        assert now == number
        assert medians == pytest.approx(counts, rel=0.1, abs=2)
    assert len(lines) == 6


def test_adding_an_algorithm_as_the_page_says(tmp_path, monkeypatch):
    module, entry = (
        re.sub(r"^   ", "", block, flags=re.M) for block in re.findall(r"   ```python\n(.*?)   ```", PAGE, flags=re.S)
    )
    (tmp_path / "random_search.py").write_text(module, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    added = eval(f"{{{entry}}}", {"Algorithm": Algorithm})
    monkeypatch.setattr(algorithms, "ALGORITHMS", {**algorithms.ALGORITHMS, **added})
    from multiobjective import constr_ex

    problem = constr_ex()

    def first(designs):
        values = problem.evaluate(designs)
        return replace(values, objectives=values.objectives[:, :1])

    single = replace(problem, evaluate=first, objectives=("f1",))
    result = minimise("random", single, algorithms.read_settings("random", {"designs": 200}), seed=1)
    sys.modules.pop("random_search")
    assert result.status is Ending.BUDGET_USED
    assert result.values.feasible()[0]
    assert result.evaluations == 200


def test_the_path_of_optimise_is_the_order_of_its_calls():
    steps = re.findall(r"^\d+\. ``([\w.]+)``", optim.__doc__, flags=re.MULTILINE)
    folders = [folder for folder, _ in itertools.groupby(step.partition(".")[0] for step in steps)]
    assert len(steps) == 12
    assert len(folders) - len(set(folders)) <= 3  # returns
    study, called = optim.load_study(optim.find_study("sevenbar_force")), {}

    def note(frame, event, _):
        name = f"{frame.f_globals.get('__name__')}.{frame.f_code.co_qualname}"
        if event == "call" and name.startswith("optim."):
            called.setdefault(name.removeprefix("optim."), None)

    sys.setprofile(note)
    try:
        optim.optimise(study, algorithm={"name": "ga", "population": 4, "generations": 1})
    finally:
        sys.setprofile(None)
    assert [name for name in called if name in steps] == steps
