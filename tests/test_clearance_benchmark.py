"""The public benchmark of clearance joints: its references, its second solution, and its grades."""

import hashlib
import json
import sys
from pathlib import Path

import numpy as np
import pytest

BENCHMARK = Path(__file__).resolve().parents[1] / "clearance_benchmark"
sys.path.insert(0, str(BENCHMARK))
import compare  # noqa: E402
import machines  # noqa: E402
import make  # noqa: E402

INDEX = json.loads((BENCHMARK / "references" / "references.json").read_text(encoding="utf-8"))


def read(name):
    return np.loadtxt(BENCHMARK / "references" / f"{name}.csv", delimiter=",", skiprows=1)


def written(folder, name, table):
    """Write a table with the names of a reference's columns."""
    head = ",".join(compare.columns(BENCHMARK / "references" / f"{name}.csv"))
    np.savetxt(folder / f"{name}.csv", table, delimiter=",", header=head, comments="", fmt="%.17g")
    return folder / f"{name}.csv"


def the_grade(path, name=None):
    return compare.worst([letter for *_, letter in compare.graded(path, name or path.stem)])


def test_every_reference_has_its_checksum():
    assert set(INDEX) == {*make.PROBLEMS, make.STATISTICS}
    for name, about in INDEX.items():
        content = (BENCHMARK / "references" / f"{name}.csv").read_bytes()
        assert hashlib.sha256(content).hexdigest() == about["sha256"], name


@pytest.mark.parametrize("name", make.PROBLEMS)
def test_three_solutions_agree_to_a_billionth(name):
    """As they were when the reference was made: two engines and an independent code."""
    for column, about in INDEX[name]["columns"].items():
        assert max(about["drake"], about["independent"]) < 1e-9, column


@pytest.mark.slow
@pytest.mark.parametrize("name", make.PROBLEMS)
def test_the_compiled_engine_gives_the_reference(name):
    """At an accuracy of 1e-12, within ten times the accuracy of each column."""
    reference = read(name)
    errors = make.apart(reference, make.solved(name, "compiled", 1e-12, reference))
    least = np.array([about["accuracy"] for about in INDEX[name]["columns"].values()])
    assert np.all(errors <= 10.0 * least)


def test_the_independent_code_meets_the_first_contact_and_the_beginning_of_the_films():
    """The first contact of two problems, and the films of the four-bar after 1 ms."""
    for name, machine, steps in (
        ("bouncing_journal", machines.bouncing_journal(), (1e-3, 2e-6)),
        ("dry_slider_crank", machines.dry_slider_crank(), (1e-5, 1e-6)),
    ):
        first = machines.contacts(machine, 1, *steps)[0]
        np.testing.assert_allclose(first, read(name)[0], rtol=1e-8)
    reference = read("four_bar")[:3]
    found = machines.over_time(machines.four_bar(), reference[:, 0], {"state": (8, 17), "rates": (17,)})
    np.testing.assert_allclose(found[-1], reference[-1], rtol=1e-7, atol=1e-13)


def test_a_copy_has_grade_a_and_a_wrong_result_fails(tmp_path):
    for name in make.PROBLEMS:
        table = read(name)
        assert the_grade(written(tmp_path, name, table)) == "A"
        assert the_grade(written(tmp_path, name, table * 1.05)) == compare.FAILED
        assert the_grade(written(tmp_path, name, table[:-1])) == compare.FAILED


def test_grades_follow_from_the_largest_error(tmp_path):
    table = read("press")
    size = np.abs(table).max(axis=0)
    for error, grade in ((9e-7, "A"), (2e-6, "B"), (2e-4, "C"), (2e-2, compare.FAILED)):
        changed = table.copy()
        changed[7, 2] += error * size[2]
        assert the_grade(written(tmp_path, "press", changed)) == grade


def test_a_run_at_a_loose_accuracy_has_grade_b_or_c(tmp_path):
    reference = read("dry_slider_crank")
    loose = make.solved("dry_slider_crank", "compiled", 1e-4, reference)
    assert the_grade(written(tmp_path, "dry_slider_crank", loose)) in ("B", "C")


def test_statistics_are_graded_by_the_scatter_of_single_runs(tmp_path):
    reference = compare.columns(BENCHMARK / "references" / f"{make.STATISTICS}.csv")
    for away, grade in ((1.9, "A"), (2.9, "B"), (4.9, "C"), (5.1, compare.FAILED)):
        values = np.array(reference["value"]) + away * np.array(reference["scatter"])
        path = tmp_path / "own.csv"
        np.savetxt(path, np.column_stack([reference["number"], values]), delimiter=",", header="number,value", comments="")
        assert the_grade(path, make.STATISTICS) == grade


def test_what_cannot_be_read_is_said_in_one_line(tmp_path, capsys, monkeypatch):
    (tmp_path / "press.csv").write_text("t,slider7.x\n0,1\n")
    (tmp_path / "text.csv").write_text("t\nnone\n")
    for file, said in (("press.csv", "has no column"), ("text.csv", "is no reference"), ("none.csv", "is no reference")):
        monkeypatch.setattr(sys, "argv", ["compare.py", str(tmp_path / file)])
        assert compare.main() == 2
        assert said in capsys.readouterr().err
