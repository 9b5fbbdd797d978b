"""The public benchmark of clearance joints: its references, its second solution, and its grades."""

import json
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

import linkages

BENCHMARK = Path(__file__).resolve().parents[1] / "clearance_benchmark"
sys.path.insert(0, str(BENCHMARK))
import compare  # noqa: E402
import make  # noqa: E402

INDEX = json.loads(make.INDEX.read_text(encoding="utf-8"))


def read(name):
    return np.loadtxt(BENCHMARK / name / "reference.csv", delimiter=",", skiprows=1)


def written(folder, name, table):
    """Write a table with the names of a reference's columns."""
    head = ",".join(compare.columns(BENCHMARK / name / "reference.csv"))
    np.savetxt(folder / f"{name}.csv", table, delimiter=",", header=head, comments="", fmt="%.17g")
    return folder / f"{name}.csv"


def the_grade(path, name=None):
    return compare.worst([letter for *_, letter in compare.graded(path, name or path.stem)])


def law(name, title):
    """Return a section of a statement."""
    text = (BENCHMARK / name / "README.md").read_text(encoding="utf-8")
    return text.partition(title)[2].partition("\n## ")[0]


def test_every_reference_has_its_checksum():
    assert set(INDEX) == {*make.PROBLEMS, "statistics"}
    for name in make.PROBLEMS:
        assert make.digest(BENCHMARK / name / "reference.csv") == INDEX[name]["sha256"], name
    assert make.digest(BENCHMARK / make.STATISTICS / "statistics.csv") == INDEX["statistics"]["sha256"]


def test_the_archive_is_fresh_and_needs_nothing_of_this_project():
    with zipfile.ZipFile(make.ARCHIVE) as archive:
        found = {name: archive.read(name) for name in archive.namelist()}
    assert found == {path.relative_to(BENCHMARK.parent).as_posix(): path.read_bytes() for path in make.packed()}
    assert not [name for name, content in found.items() if name.endswith(".py") and b"import linkages" in content]


def test_every_statement_has_the_same_law():
    for title, names in (
        ("## Law: short film", ("main_bearing", "four_bar", "press")),
        ("## Laws: dry contact", ("bouncing_journal", "dry_slider_crank")),
    ):
        texts = {law(name, title) for name in names}
        assert len(texts) == 1
        assert "$$" in texts.pop()


@pytest.mark.parametrize("name", make.PROBLEMS)
def test_three_solutions_agree_to_five_billionths(name):
    """As they were when the reference was made: two engines and an independent code."""
    for column, about in INDEX[name]["columns"].items():
        assert max(about["drake"], about["independent"]) < 5e-9, column


@pytest.mark.slow
@pytest.mark.parametrize("name", make.PROBLEMS)
def test_the_compiled_engine_gives_the_reference(name):
    """At an accuracy of 1e-12, within ten times the accuracy of each column."""
    reference = read(name)
    errors = make.apart(reference, make.solved(name, "compiled", 1e-12, INDEX[name]["columns"], reference))
    least = np.array([about["accuracy"] for about in INDEX[name]["columns"].values()])
    assert np.all(errors <= 10.0 * least)


def test_the_independent_code_meets_the_first_contact_and_the_beginning_of_the_films():
    """The first contact of two problems, and the films of the four-bar after 1 ms."""
    for name in ("bouncing_journal", "dry_slider_crank"):
        np.testing.assert_allclose(make.independent(name).solution(most=1)[0], read(name)[0], rtol=1e-8)
    reference = read("four_bar")[:3]
    found = make.independent("four_bar").solution(reference[:, 0])
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
    loose = make.solved("dry_slider_crank", "compiled", 1e-4, INDEX["dry_slider_crank"]["columns"], reference)
    assert the_grade(written(tmp_path, "dry_slider_crank", loose)) in ("B", "C")


def test_statistics_are_graded_by_the_scatter_of_single_runs(tmp_path):
    reference = compare.columns(BENCHMARK / make.STATISTICS / "statistics.csv")
    for away, grade in ((1.9, "A"), (2.9, "B"), (4.9, "C"), (5.1, compare.FAILED)):
        values = np.array(reference["value"]) + away * np.array(reference["scatter"])
        path = tmp_path / "own.csv"
        np.savetxt(
            path, np.column_stack([reference["number"], values]), delimiter=",", header="number,value", comments=""
        )
        assert compare.worst([letter for *_, letter in compare.graded_statistics(path, make.STATISTICS)]) == grade


def test_what_cannot_be_read_is_said_in_one_line(tmp_path, capsys, monkeypatch):
    own = tmp_path / "own.csv"
    for content, words, said in (
        ("t,slider7.x\n0,1\n", ["press"], "has no column"),
        ("t,none\n0,1\n", ["text"], "is no problem; there are bouncing_journal, "),
        ("t\nnone\n", ["press"], "is no table of numbers"),
        ("number,value\n1,1\n", ["press", "--statistics"], "press: has no statistics"),
    ):
        own.write_text(content)
        monkeypatch.setattr(sys, "argv", ["compare.py", words[0], str(own), *words[1:]])
        assert compare.main() == 2
        said_of_it = capsys.readouterr().err
        assert said in said_of_it
        assert said_of_it.count("\n") == 1


def test_a_located_peak_does_not_depend_on_the_accuracy_as_the_largest_value_at_a_step_does():
    """The numbers of docs/clearance_benchmark.md."""
    found = {}
    for accuracy in (1e-6, 1e-10):
        system = linkages.load(
            BENCHMARK / "dry_slider_crank" / "machine.toml", {"solver.accuracy": accuracy, "duration": 0.012}
        )
        run = linkages.simulate(system)
        found[accuracy] = max(one.peak_force for one in linkages.impacts(run, ["B"])), run["B.force"].max()
    assert found[1e-6] == pytest.approx((45944.0, 45835.0), abs=1.0)
    assert found[1e-10] == pytest.approx((45944.1, 45936.0), abs=1.0)
