"""Figures of studies: all designs and the best of them so far, and shares of a variance with their certainty."""

import matplotlib
import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

import optim
from linkages.base.palette import LINE
from optim.algorithms.nlp import Values
from optim.report.figures import write_convergence
from optim.report.observe import Observer
from optim.report.shares import write_indices
from optim.store.store import Iteration

NOMINAL, VIOLATING = 1.2577, 0.9


@pytest.fixture
def study():
    return optim.load_study(optim.find_study("sevenbar_force"))


def values(*designs):
    """Make values from pairs of an objective and a violation."""
    objectives, violation = np.array(designs, dtype=float).T
    return Values(objectives[:, None], violation[:, None], np.empty((len(designs), 0)), np.isinf(objectives))


def iteration(number, objective, violation):
    """Make an iteration that ends at one design."""
    return Iteration(number, number, 9, 1, np.zeros((1, 1)), np.array([[objective]]), np.array([violation]), "{}")


@pytest.fixture
def drawn(monkeypatch):
    figures, draw = [], FigureCanvasAgg.draw

    def keep(canvas):
        figures.append(canvas.figure)
        draw(canvas)

    monkeypatch.setattr(FigureCanvasAgg, "draw", keep)
    return figures


def test_a_feasible_nominal_design_is_the_best_until_another_one_is_better(study):
    """An algorithm that is at a design which violates constraints has not lost the nominal one."""
    with Observer(study, 1, None) as observer:
        observer(iteration(1, VIOLATING, 0.5), values((NOMINAL, 0.0), (VIOLATING, 0.5)))
        assert f"{NOMINAL:.5g}" in observer.told()
        observer(iteration(2, 1.1, 0.0), values((1.1, 0.0)))
        assert "1.1" in observer.told()


def test_progress_says_that_no_design_is_feasible(study):
    with Observer(study, 1, None) as observer:
        observer(iteration(1, VIOLATING, 0.5), values((NOMINAL, 0.1), (VIOLATING, 0.5)))
        assert observer.told() == "no design satisfies the constraints yet"


@pytest.mark.parametrize("others", [[], [(VIOLATING, 0.5)], [(VIOLATING, 0.5), (1.3, 0.0), (np.inf, 0.0)]])
def test_the_figure_shows_the_best_design_also_where_it_is_the_nominal_one(study, drawn, tmp_path, others):
    write_convergence(study, "one", values((NOMINAL, 0.0), *others), tmp_path / "convergence.png")
    (axes,) = drawn[-1].axes
    best = next(line for line in axes.lines if line.get_label() == "best so far")
    assert set(best.get_ydata()) == {NOMINAL}
    assert np.ptp(best.get_xdata()) > 0.0  # a line, also of one design
    assert [text.get_text() for text in axes.texts] == [f"{NOMINAL:.5g}"]
    low, high = axes.get_ylim()
    assert low < NOMINAL < high


def test_designs_that_violate_constraints_are_open_circles(study, drawn, tmp_path):
    write_convergence(study, "one", values((NOMINAL, 0.0), (VIOLATING, 0.5), (1.1, 0.0)), tmp_path / "c.png")
    (axes,) = drawn[-1].axes
    found = {dots.get_label(): dots for dots in axes.collections}
    assert found["feasible"].get_offsets().tolist() == [[1.0, NOMINAL], [3.0, 1.1]]
    assert found["violates constraints"].get_offsets().tolist() == [[2.0, VIOLATING]]
    assert matplotlib.colors.same_color(found["violates constraints"].get_facecolor(), "none")


def test_the_star_is_at_the_result(invented_engine, drawn, tmp_path):
    study = optim.load_study(optim.find_study("sevenbar_force"))
    with Observer(study, 1, tmp_path / "convergence.png") as observer:
        algorithm = {"name": "ga", "population": 6, "generations": 3}
        result = optim.optimise(study, algorithm=algorithm, seed=1, observe=observer)
    (best,) = result["best"]["objectives"].values()
    assert [text.get_text() for text in drawn[-1].axes[0].texts] == [f"{best:.5g}"]


@pytest.mark.parametrize(
    ("share", "half", "grey", "few"),
    [
        (0.6, 0.1, False, False),
        (1.14, 1.0, True, True),
        (0.2, 0.3, True, True),
        (0.95, 0.2, True, True),
        (0.0, 0.01, True, False),
    ],
)
def test_a_share_that_may_be_zero_or_beyond_one_is_grey(study, drawn, tmp_path, share, half, grey, few):
    row = dict.fromkeys(("first", "total"), share) | dict.fromkeys(("first_confidence", "total_confidence"), half)
    rows = dict.fromkeys(study.paths, row | {"inert": False})
    report = {"title": "one", "evaluations": 64, "quantities": {"force": {"variables": rows}}}
    write_indices(study, report, tmp_path / "sobol.png")
    (axes,) = drawn[-1].axes
    bars = [bar for bar in axes.patches if bar.get_width()]
    assert bars or share == 0.0
    assert all(matplotlib.colors.same_color(bar.get_facecolor(), LINE) == grey for bar in bars)
    assert ("64 designs are too few" in drawn[-1].get_suptitle()) == few
