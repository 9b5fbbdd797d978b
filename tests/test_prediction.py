"""How far derivatives predict: closed forms, and the command and the live page on a machine that is sensitive."""

import json

import numpy as np
import pytest

import linkages
from linkages.cli.main import main
from linkages.explore.prediction import STATED, STEPS, extent, reaches

DRY = ("slider_crank_dry.toml", {"duration": 0.024})
CLEARANCE, MASS = "joints.B.clearance", "sdf.links.rod.mass"


def reach_of(function, rate, value=1.0, scale=1.0):
    """Reach of the derivative of a function of one value."""
    found = reaches({"values.v": value}, np.array([[rate]]), np.array([scale]), lambda table, tight: function(table))
    return found[0, 0]


def test_a_straight_line_predicts_the_stated_change():
    assert reach_of(lambda v: 3.0 * v, 3.0) == STATED
    assert extent(STATED) == "at least 1 %"


def test_a_parabola_predicts_until_its_bend_is_a_tenth():
    """The departure 150 h^2 is a tenth of the predicted h at h = 1/1500: the largest step below is 5e-4."""
    found = reach_of(lambda v: (v - 1.0) + 150.0 * (v - 1.0) ** 2, 1.0)
    assert found == 5e-4
    assert extent(found) == "0.05 %"


def test_what_scatters_predicts_nothing():
    assert reach_of(lambda v: v + 0.02 * np.sin(1e9 * v), 1.0) == 0.0
    assert extent(0.0) == "nothing"


def test_a_run_that_agrees_by_chance_predicts_nothing():
    """Only the largest step agrees, in both directions."""
    assert reach_of(lambda v: np.where(np.abs(v - 1.0) > 0.0099, v, 1.0 + 1e-3 * np.cos(1e7 * v)), 1.0) == 0.0


def test_an_effect_below_a_hundredth_of_the_change_counts_as_none():
    """The number changes by 5e-6 of itself where the value changes by 1e-2: its sign does not matter."""
    assert reach_of(lambda v: 1.0 + 5e-4 * np.abs(v - 1.0), 0.0, scale=1.0) == STATED
    assert reach_of(lambda v: 1.0 + 1e-2 * np.abs(v - 1.0), 0.0, scale=1.0) == 0.0


def test_values_that_are_not_allowed_are_left_out_and_runs_that_fail_are_not():
    assert reach_of(lambda v: np.where(v < 1.0, np.inf, v), 1.0) == STATED
    assert reach_of(lambda v: np.where(v < 1.0, np.nan, v), 1.0) == 0.0


def test_without_a_derivative_there_is_no_reach_and_no_run():
    assert np.isnan(reach_of(None, np.nan))


@pytest.mark.parametrize(("bend", "reach", "smaller"), [(0.0, STATED, []), (999.0, 1e-4, [2 * (len(STEPS) - 3)])])
def test_smaller_steps_are_run_at_a_tighter_accuracy_and_only_where_larger_ones_depart(bend, reach, smaller):
    """Errors of the runs hide the line at the usual accuracy; a parabola departs by a tenth at 1e-4."""
    asked = []

    def numbers(table, tight):
        asked.append((len(table) - 1, tight))
        exact = table + bend * (table - 1.0) ** 2
        return exact if tight else exact + 0.1 * np.sin(1e9 * table)

    assert reaches({"values.v": 1.0}, np.array([[1.0]]), np.array([1.0]), numbers)[0, 0] == reach
    assert asked == [(6, False), (6, True), *((runs, True) for runs in smaller)]


def departs(path, output, span, predicted):
    """Whether the peak of a run whose value is 1 % larger departs from the prediction by more than a tenth of it."""
    system = linkages.load(linkages.find_file(DRY[0]), DRY[1] | {"solver.accuracy": 1e-10})
    peaks = []
    for factor in (1.0, 1.0 + STATED):
        run = linkages.simulate(system.replaced({path: factor * system.value(path)}))
        peaks.append(linkages.extremes(run.within(*span), [output])[output].peak)
    change = (peaks[1] - peaks[0]) / peaks[0]
    return abs(change - predicted) > 0.1 * abs(predicted)


def test_the_command_makes_no_statement_that_runs_contradict(tmp_path, capsys):
    """Dry clearance: the derivative of the largest force by the clearance is right, and predicts -8.8 % for 1 %."""
    command = ["sensitivity", DRY[0], "--wrt", CLEARANCE, "--output", "B.force", "--no-error-estimate", "--no-plots"]
    assert main([*command, "--out", str(tmp_path)]) == 0
    details, text = json.loads((tmp_path / "details.json").read_text()), capsys.readouterr().out
    rate = json.loads((tmp_path / "sensitivity.json").read_text())[CLEARANCE]["B.force.peak"]
    predicted = STATED * rate * details["values"][CLEARANCE] / details["numbers"]["B.force.peak"]
    assert departs(CLEARANCE, "B.force", details["window"], predicted)
    assert 0.0 < details["reach"][CLEARANCE]["B.force.peak"] < STATED
    assert "no statement is possible about a change of joints.B.clearance by 1 %" in " ".join(text.split())
    assert f"{100.0 * predicted:+.3g} %" not in text
    assert json.loads((tmp_path / "record.json").read_text())["answer"] == [
        "No derivative predicts the change of a peak with 1 % of a value."
    ]


def test_a_cell_of_the_matrix_without_a_statement_is_blank():
    """A number that changes by 5 % for 1 % of the value, if the derivative predicted it; its error is not known."""
    from matplotlib.colors import same_color

    from linkages.base.palette import LARGER, PAPER
    from linkages.explore.sensitivity import Sensitivities
    from linkages.show.plots.matrix import matrix_figure

    system = linkages.load(linkages.find_file(DRY[0]), {"duration": 1e-4})
    key, derivatives = "B.force.peak", {CLEARANCE: {"B.force.peak": 5.0}}
    run = linkages.simulate(system)
    for reach, color, said in ((0.0, PAPER, "?"), (STATED, LARGER, "+5")):
        found = Sensitivities(
            {CLEARANCE: 1.0}, {key: 1.0}, derivatives, {CLEARANCE: {key: None}}, {}, [], run, (0.0, 1e-4), {key: 0.0},
            {CLEARANCE: {key: reach}},
        )  # fmt: skip
        (axes,) = matrix_figure(found).axes
        assert [text.get_text() for text in axes.texts] == [said]
        (cell,) = axes.patches
        assert same_color(cell.get_facecolor(), color)


@pytest.mark.slow  # derivatives and 27 runs
def test_the_live_page_makes_no_statement_that_runs_contradict(tmp_path):
    from linkages.show.live.answers import Answers
    from linkages.show.live.controls import controls
    from linkages.show.live.session import Session

    system = linkages.load(linkages.find_file(DRY[0]), {"solver.accuracy": 1e-9})
    answers, values = Answers(Session(system), controls(system), tmp_path), {"duration": 0.024}
    found = answers.answer("sensitivities", {"values": values, "paths": [MASS]})
    page = next(iter(answers._pages.values()))
    assert found["changes"][MASS]["B.force"] is None
    assert found["reasons"][MASS]["B.force"].startswith("predicts to: ")
    shown, part = system.replaced(values), page.part_shown(values, bool)
    details = linkages.sensitivities(shown, [MASS], ["B.force"], False, window=part, reach=False)
    rate, force = details.derivatives[MASS]["B.force.peak"], details.numbers["B.force.peak"]
    assert departs(MASS, "B.force", details.window, STATED * rate * details.values[MASS] / force)
