"""Sobol's indices against closed forms and another estimator; inert variables of the press."""

import json
import math

import numpy as np
import pytest
from scipy.stats import sobol_indices, uniform

from linkages import InputError, RunError
from linkages.cli.main import main
from optim.evaluate.evaluator import Evaluator
from optim.problem.load import find_study, load_study
from optim.search.sensitivity import inert, one_at_a_time, sensitivity, sobol

A, B = 7.0, 0.1
LOWER, UPPER = np.full(3, -math.pi), np.full(3, math.pi)


def ishigami(x):
    """T. Ishigami, T. Homma, An importance quantification technique in uncertainty analysis, 1990."""
    return (np.sin(x[:, 0]) + A * np.sin(x[:, 1]) ** 2 + B * x[:, 2] ** 4 * np.sin(x[:, 0]))[:, None]


def closed_form():
    """First-order and total indices: integrals of powers and sines."""
    first = np.array([0.5 * (1.0 + B * math.pi**4 / 5.0) ** 2, A**2 / 8.0, 0.0])
    together = B**2 * math.pi**8 * (1.0 / 18.0 - 1.0 / 50.0)  # of the first and the third
    variance = first.sum() + together
    return first / variance, (first + together * np.array([1.0, 0.0, 1.0])) / variance, variance


def test_ishigami():
    first, total, variance = closed_form()
    found = sobol(ishigami, LOWER, UPPER, 2**14, 1)
    assert found.first[0] == pytest.approx(first, abs=0.01)
    assert found.total[0] == pytest.approx(total, abs=0.01)
    assert found.deviation[0] ** 2 == pytest.approx(variance, rel=0.01)
    assert found.mean[0] == pytest.approx(A / 2.0, rel=0.01)
    other = sobol_indices(
        func=lambda x: ishigami(x.T)[:, 0], n=4096, dists=[uniform(-math.pi, 2.0 * math.pi)] * 3, rng=2
    )
    assert found.first[0] == pytest.approx(other.first_order, abs=0.02)
    assert found.total[0] == pytest.approx(other.total_order, abs=0.02)


def test_confidence_intervals_hold_what_they_say():
    """Of 40 estimates of 3 indices about 95 % hold the closed form; resampling is a little narrow."""
    first, total, _ = closed_form()
    inside = []
    for seed in range(40):
        found = sobol(ishigami, LOWER, UPPER, 128, seed)
        inside += [abs(found.first[0] - first) <= found.first_confidence[0]]
        inside += [abs(found.total[0] - total)[:2] <= found.total_confidence[0][:2]]
    assert np.concatenate(inside).mean() > 0.85


def test_seed_determines_everything():
    a, b, c = (sobol(ishigami, LOWER, UPPER, 64, seed) for seed in (3, 3, 4))
    assert a.first.tobytes() == b.first.tobytes()
    assert a.total_confidence.tobytes() == b.total_confidence.tobytes()
    assert a.first.tobytes() != c.first.tobytes()


def test_constant_quantities_and_failed_designs():
    def holes(x):
        y = np.column_stack([ishigami(x)[:, 0], np.full(len(x), 3.0)])
        y[x[:, 0] > 3.1] = np.nan
        return y

    found = sobol(holes, LOWER, UPPER, 1024, 1)
    assert np.isnan(found.first[1]).all()
    assert found.deviation[1] == 0.0
    assert 0 < found.failed < 0.02 * found.evaluations
    assert found.first[0] == pytest.approx(closed_form()[0], abs=0.05)
    with pytest.raises(RunError, match="too many for indices"):
        sobol(lambda x: np.full((len(x), 1), np.nan), LOWER, UPPER, 64, 1)


def test_one_at_a_time():
    grid, found = one_at_a_time(ishigami, LOWER, UPPER, np.array([0.0, 0.0, 1.0]), 5)
    assert grid[1] == pytest.approx(np.linspace(-math.pi, math.pi, 5))
    assert found[1, :, 0] == pytest.approx(A * np.sin(grid[1]) ** 2)
    assert found[0, :, 0] == pytest.approx(np.sin(grid[0]) * (1.0 + B))
    assert inert(found).tolist() == [[False, False, True]]  # sin(x_1) = 0


def test_a_variable_with_one_value_is_not_inert():
    """One run of 5 tells nothing of a variable, and none tells less: unknown is not inert. numpy warns of nothing."""
    found = np.full((2, 5, 1), np.nan)
    found[0, 2] = 3.0
    assert inert(found).tolist() == [[False, False]]


def test_a_quantity_that_does_not_vary_depends_on_nothing(tmp_path, capsys):
    """A variance of zero has no shares: the answer names no variable that the quantity depends on most."""
    path = tmp_path / "press.toml"
    formula = '[objectives.same]\nformula = "3.0 + 0 * mass_4"\n'
    text = find_study("sevenbar_pareto").read_text()
    path.write_text(text[: text.index("[objectives")] + formula + '[algorithm]\nname = "ga"\n')
    assert main(["study", "sensitivity", str(path), "--samples", "2", "--out", str(tmp_path / "out")]) == 0
    assert "it does not vary, there are no shares" in " ".join(capsys.readouterr().out.split())
    answer = json.loads((tmp_path / "out" / "record.json").read_text())["answer"]
    assert answer == ["same does not vary over the bounds."]


@pytest.mark.slow
def test_crank_4_is_inert_but_for_its_torque(tmp_path):
    """Its motion is prescribed: its weight affects only its pivot, and its drive while the speed changes."""
    text = find_study("sevenbar_pareto").read_text().replace("[objectives.acceleration]", TORQUE, 1)
    path = tmp_path / "press.toml"
    path.write_text(text.replace('"gravity"', 'duration = 1.0\ndrives.O4.ramp = 0.5\n"gravity"', 1))
    study = load_study(path)
    evaluate = Evaluator(study)

    def values(designs):
        return evaluate(designs).objectives

    _, found = one_at_a_time(values, study.lower, study.upper, study.nominal, 3)
    torque, *others = inert(found)
    index = [study.names.index(name) for name in ("mass_4", "inertia_4")]
    assert not torque[index].any()
    for row in others:
        assert row[index].all()
        assert not np.delete(row, index).any()
    indices = sobol(values, study.lower, study.upper, 8, 1)
    assert np.abs(indices.total[1:, index]).max() == 0.0


TORQUE = """[objectives.torque]
terms = [{ functional = "peak", output = "O4.torque" }]
[objectives.acceleration]"""


def test_command(tmp_path, capsys, invented_engine):
    out = tmp_path / "out"
    words = ["study", "sensitivity", "sevenbar_force"]
    assert main([*words, "--samples", "16", "--out", str(out)]) == 0
    assert "first order" in capsys.readouterr().out
    names = ["one_at_a_time.png", "record.json", "sensitivity.json", "sobol.png"]
    assert sorted(path.name for path in out.iterdir()) == names
    report = json.loads((out / "sensitivity.json").read_text())
    variables = list(load_study(find_study("sevenbar_force")).paths)
    assert report["evaluations"] == 16 * (len(variables) + 2)
    assert list(report["quantities"]["force"]["variables"]) == variables
    for arguments, message in ((["--samples", "12"], "power of two"), (["--seed", "-1"], "between 0")):
        assert main([*words, *arguments, "--out", str(tmp_path / "no")]) == 2
        assert message in capsys.readouterr().err
        assert not (tmp_path / "no").exists()


def test_a_number_of_points_that_is_not_balanced_is_refused():
    with pytest.raises(InputError, match="samples: 3: must be a power of two"):
        sensitivity(load_study(find_study("sevenbar_force")), samples=3)


def test_unknown_shares_are_not_zero_in_the_answer():
    from linkages.show.plots.names import name_of_value
    from optim.cli.study import _answer

    study = load_study(find_study("sevenbar_force"))
    totals = {path: {"total": None} for path in study.paths}
    report = {"quantities": {"force": {"variables": totals}}}
    assert _answer(study, report) == ["force does not vary over the bounds."]
    totals[study.paths[1]] = {"total": 0.25}
    assert _answer(study, report) == [
        f"force depends most on the {name_of_value(study.paths[1])}: 25 % of the variance, with interactions."
    ]
