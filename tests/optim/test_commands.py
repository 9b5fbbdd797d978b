"""The commands: files, output, interruption, rejected input."""

import csv
import json
import signal

import numpy as np
import pytest

import optim
from linkages.cli.main import main
from optim import format_result, load_study
from optim.store.store import read_store


def command(*words):
    """Run a command of an entry point: reinstall the package if a working copy does not know it."""
    return main([str(word) for word in words])


STUDY = """
experiment = "seven_bar.toml"
title = "A short one"
[variables.mass]
path = "sdf.links.link2.mass"
relative = true
lower = 0.5
upper = 2.0
[variables.oil]
path = "joints.A.viscosity"
lower = 0.05
upper = 0.6
[linked]
"joints.B.viscosity" = "oil"
[objectives.force]
unit = "N"
terms = [{ functional = "peak", output = "A.force" }]
[constraints.torque]
relative = true
at_most = 1.0
terms = [{ functional = "peak", output = "O1.torque" }]
[algorithm]
name = "ga"
population = 8
generations = 5
"""


@pytest.fixture
def file(tmp_path, invented_engine):
    path = tmp_path / "short.toml"
    path.write_text(STUDY)
    return path


@pytest.mark.parametrize(("oil", "note"), [(0.6, "at its upper bound"), (0.0505, "at its lower bound"), (0.06, "")])
def test_a_variable_at_a_bound_is_said_to_be_there(file, oil, note):
    """Within a thousandth of the range, 0.05 to 0.6."""
    variables = {"sdf.links.link2.mass": 0.3, "joints.A.viscosity": oil}
    design = optim.Design.model_construct(variables=variables, objectives={"force": 1.0}, constraints={}, feasible=True)
    result = optim.StudyResult.model_construct(
        best=design, nominal=design, front=[], designs={}, unrun=0, status="converged", seed=0,
        algorithm={"name": "ga"}, evaluations=1, failed=0, wall_time=1.0,
    )  # fmt: skip
    lines = format_result(load_study(file), result).splitlines()
    assert next(line for line in lines if "viscosity" in line).endswith(note or "0.6")
    assert next(line for line in lines if "mass" in line).endswith("0.438")


def table(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def without_time(result):
    return {key: value for key, value in result.items() if key != "wall_time"}


def test_optimise(file, tmp_path, capsys):
    assert command("optimise", file, "--out", tmp_path / "out", "--seed", 3) == 0
    assert sorted(p.name for p in (tmp_path / "out").iterdir() if not p.name.endswith(".lock")) == [
        "convergence.png",
        "record.json",
        "result.json",
        "study.sqlite",
    ]
    result = json.loads((tmp_path / "out" / "result.json").read_text())
    assert set(result["best"]["variables"]) == {"sdf.links.link2.mass", "joints.A.viscosity"}
    assert result["best"]["linked"] == {"joints.B.viscosity": result["best"]["variables"]["joints.A.viscosity"]}
    assert (result["seed"], result["failed"], result["front"]) == (3, 0, [])
    assert result["nominal"]["variables"] == {"sdf.links.link2.mass": 0.219, "joints.A.viscosity": 0.4}
    assert result["nominal"]["constraints"] == {"torque": 1.0}
    printed = capsys.readouterr().out
    assert "A short one" in printed
    assert "force [N]" in printed
    with read_store(tmp_path / "out" / "study.sqlite") as store:
        designs, found = store.evaluations()
        assert len(designs) == result["evaluations"]
        feasible = found.constraints[:, 0] <= found.constraints[0, 0]  # the nominal design comes first
        assert result["best"]["feasible"]
        assert result["best"]["objectives"]["force"] == found.objectives[feasible, 0].min()


def test_resume(file, tmp_path, capsys):
    out = tmp_path / "out"
    assert command("optimise", file, "--out", out, "--no-plots") == 0
    first = json.loads((out / "result.json").read_text())
    assert command("optimise", file, "--out", out, "--no-plots") == 2
    assert "exists already; continue with --resume" in capsys.readouterr().err
    (out / "result.json").unlink()
    assert command("optimise", file, "--out", out, "--no-plots", "--resume") == 0
    assert without_time(json.loads((out / "result.json").read_text())) == without_time(first)
    assert not (out / "convergence.png").exists()
    file.write_text(STUDY.replace("upper = 0.6", "upper = 0.7"))
    assert command("optimise", file, "--out", out, "--resume") == 2
    assert (
        "study.sqlite: problem.variables.oil.upper: belongs to another study: there 0.6, here 0.7"
        in capsys.readouterr().err
    )


GRG = STUDY.replace('[algorithm]\nname = "ga"', '[algorithm]\nname = "grg"').replace(
    "population = 8\ngenerations = 5", "iterations = 2"
)


@pytest.mark.parametrize("text", [STUDY, GRG], ids=["ga", "grg"])
def test_the_answer_of_one_study_starts_another(file, tmp_path, text):
    """The nominal design stays the first, and what relative quantities are divided by; the start comes next."""
    assert command("optimise", file, "--out", tmp_path / "first", "--no-plots") == 0
    answer = json.loads((tmp_path / "first" / "result.json").read_text())
    assert answer["start"] is None
    (tmp_path / "second.toml").write_text(text)
    second = command(
        "optimise", tmp_path / "second.toml", "--start", tmp_path / "first", "--out", tmp_path / "out", "--no-plots"
    )
    assert second == 0
    result = json.loads((tmp_path / "out" / "result.json").read_text())
    assert result["start"] == answer["best"]["variables"]
    assert result["best"]["objectives"]["force"] <= answer["best"]["objectives"]["force"]
    with read_store(tmp_path / "out" / "study.sqlite") as store:
        designs = store.evaluations()[0]
    np.testing.assert_array_equal(designs[0], [0.219, 0.4])
    np.testing.assert_allclose(designs[1], [*answer["best"]["variables"].values()], rtol=1e-15)


def test_a_study_is_not_gone_on_with_from_another_start(file, tmp_path, capsys):
    out = tmp_path / "out"
    assert command("optimise", file, "--out", out, "--no-plots") == 0
    assert command("optimise", file, "--out", out, "--no-plots", "--resume", "--start", out) == 2
    assert "study.sqlite: start: belongs to another study: there nothing, here [" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (None, "result.json: cannot be read; give the output folder of a finished linkages optimise"),
        ("{", "result.json: is not a result.json of linkages optimise"),
        ('{"best": null}', "result.json: is not a result.json of linkages optimise"),
        (
            '{"best": {"variables": {"joints.A.viscosit": 0.1}}}',
            'varies joints.A.viscosit, short.toml does not; did you mean "joints.A.viscosity"?',
        ),
        (
            '{"best": {"variables": {"joints.A.viscosity": 0.7}}}',
            "joints.A.viscosity is 0.7, in short.toml between 0.05 and 0.6",
        ),
        ('{"best": {"variables": {"joints.A.viscosity": NaN}}}', "has a value that is not finite"),
    ],
)
def test_wrong_start(file, tmp_path, capsys, content, message):
    (tmp_path / "other").mkdir()
    if content is not None:
        (tmp_path / "other" / "result.json").write_text(content)
    assert command("optimise", file, "--start", tmp_path / "other", "--out", tmp_path / "out") == 2
    err = capsys.readouterr().err
    assert err.startswith("error: --start: ")
    assert message in err
    assert err.count("\n") == 1
    assert not (tmp_path / "out").exists()


@pytest.mark.processes
def test_ctrl_c_stops_at_once_and_keeps_the_generations(file, tmp_path, capsys, monkeypatch, invented_engine):
    out, populations = tmp_path / "out", []
    before = signal.getsignal(signal.SIGINT)

    def interrupted(request):
        populations.append(len(request.values))
        if len(populations) == 4:
            signal.raise_signal(signal.SIGINT)
        return invented_engine(request)

    monkeypatch.setattr("optim.evaluate.evaluator.run_compiled", interrupted)
    assert command("optimise", file, "--out", out) == 130
    err = capsys.readouterr().err
    assert err == "interrupted; what was computed is kept, continue with --resume\n"
    assert not (out / "result.json").exists()
    with read_store(out / "study.sqlite") as store:
        kept = store.count()[0]
        assert kept == sum(populations[:-1])
        assert len(store.iterations()) >= 1
    assert signal.getsignal(signal.SIGINT) is before
    before = len(populations)
    assert command("optimise", file, "--out", out, "--resume") == 0
    assert command("optimise", file, "--out", tmp_path / "whole") == 0
    broken, whole = (json.loads((x / "result.json").read_text()) for x in (out, tmp_path / "whole"))
    assert without_time(broken) == without_time(whole)
    assert sum(populations[before:]) == 2 * whole["evaluations"] - kept


def test_studies_and_seeds_in_one_job(file, tmp_path, capsys):
    other = tmp_path / "other.toml"
    other.write_text(STUDY.replace("A.force", "B.force"))
    out = tmp_path / "out"
    assert command("optimise", file, "--out", out, "--no-plots", "--seeds", "2:2") == 0  # one run: no subfolder
    assert (out / "study.sqlite").exists()
    out = tmp_path / "both"
    assert command("optimise", file, other, "--out", out, "--no-plots", "--seeds", "1:3") == 0
    rows = table(out / "results.csv")
    assert [(row["study"], row["seed"]) for row in rows] == [(s, str(n)) for s in ("short", "other") for n in (1, 2, 3)]
    result = json.loads((out / "other_2" / "result.json").read_text())
    assert float(rows[4]["objective:force"]) == result["best"]["objectives"]["force"]
    printed = capsys.readouterr().out
    best = [float(row["objective:force"]) for row in rows[:3]]
    assert f"{np.mean(best):.6g}" in printed
    assert f"{np.std(best, ddof=1):.6g}" in printed
    (out / "other_3" / "study.sqlite").unlink()
    assert command("optimise", file, other, "--out", out, "--no-plots", "--seeds", "1:3") == 2
    assert command("optimise", file, other, "--out", out, "--no-plots", "--seeds", "1:3", "--resume") == 0
    again = table(out / "results.csv")
    assert [without_time(row) for row in again] == [without_time(row) for row in rows]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--seeds", "3"], "error: --seeds: 3: write A:B"),
        (["--seeds", "3:1"], "error: --seeds: 3:1: write A:B"),
        (["--seed", "-1"], "error: --seed: -1: must be between"),
        (["--threads", "0"], "error: --threads: 0: must be at least 1"),
        (["--out", "short.toml"], "is a file; give a folder"),
        (["--out", "short.toml/out"], "error: --out: short.toml/out: short.toml is a file"),
        (["--cluster", "tcp://127.0.0.1:9"], "error: --cluster: tcp://127.0.0.1:9: "),
        (["missing.toml"], "error: missing.toml: cannot be read"),
        ([""], "error: .: cannot be read"),
    ],
)
def test_refused(file, tmp_path, capsys, monkeypatch, arguments, message):
    pytest.importorskip("distributed")
    monkeypatch.setattr("linkages.engines.cluster.WAIT", 1.0)
    monkeypatch.chdir(tmp_path)
    assert command("optimise", file.name, *arguments) == 2
    err = capsys.readouterr().err
    assert message in err
    assert err.count("\n") == 1
    assert not list(tmp_path.rglob("study.sqlite"))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"ga"', '"gaa"', 'algorithm.name: "gaa" is unknown; did you mean "ga"'),
        ('name = "ga"', "", "algorithm.name: is missing"),
        ("population = 8", "population = 8.5", "short.toml: algorithm: population: is 8.5; it should be an integer"),
        ("population = 8", "poplation = 8", 'short.toml: algorithm: poplation: unknown key; did you mean "population"'),
    ],
)
def test_wrong_algorithm(file, tmp_path, capsys, old, new, message):
    file.write_text(STUDY.replace(old, new))
    assert command("optimise", file, "--out", tmp_path / "out") == 2
    assert message in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_show_and_export(file, tmp_path, capsys):
    pyarrow = pytest.importorskip("pyarrow.parquet")
    out = tmp_path / "out"
    command("optimise", file, "--out", out, "--no-plots")
    store = out / "study.sqlite"
    capsys.readouterr()
    assert command("study", "show", store) == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert "ga, seed 1" in printed
    with read_store(store) as opened:
        designs, found = opened.evaluations()
    assert f"evaluations: {len(designs)}, of which failed: 0" in printed
    assert command("study", "export", store) == 0
    rows = table(out / "evaluations.csv")
    assert [float(row["variable:joints.A.viscosity"]) for row in rows] == designs[:, 1].tolist()
    assert [float(row["objective:force"]) for row in rows] == found.objectives[:, 0].tolist()
    assert command("study", "export", store, "--out", tmp_path / "x.parquet") == 0
    columns = pyarrow.read_table(tmp_path / "x.parquet").to_pydict()
    assert columns["constraint:torque"] == found.constraints[:, 0].tolist()
    assert columns["status"] == list(found.status)
    assert command("study", "export", store, "--out", tmp_path / "x.xls") == 2
    assert "ends with .csv or .parquet" in capsys.readouterr().err
    assert command("study", "show", tmp_path / "nothing.sqlite") == 2


def test_parquet_without_its_package(file, tmp_path, capsys, monkeypatch):
    out = tmp_path / "out"
    command("optimise", file, "--out", out, "--no-plots")
    monkeypatch.setitem(__import__("sys").modules, "pyarrow", None)
    assert command("study", "export", out / "study.sqlite", "--out", tmp_path / "x.parquet") == 2
    assert "needs pyarrow" in capsys.readouterr().err
    assert not list(tmp_path.glob("*x.parquet*"))


def test_front_with_reference_designs(tmp_path, capsys, invented_engine):
    file, out = tmp_path / "front.toml", tmp_path / "out"
    text = STUDY.replace('"ga"', '"nsga2"').replace("[constraints", SECOND + "[constraints", 1)
    file.write_text(text + '[designs.theirs]\n"joints.A.viscosity" = 0.1\n')
    assert command("optimise", file, "--out", out, "--verify") == 0
    result = json.loads((out / "result.json").read_text())
    assert result["designs"]["theirs"]["variables"]["joints.A.viscosity"] == 0.1
    assert result["designs"]["theirs"]["linked"] == {"joints.B.viscosity": 0.1}
    assert result["designs"]["theirs"]["objectives"]["film"] > 0.0
    assert "theirs" in capsys.readouterr().out
    assert (out / "front.png").stat().st_size > 10_000
    with read_store(out / "study.sqlite") as store:
        assert len(store.evaluations()[0]) == result["evaluations"]  # theirs is not among them
    assert result["verification"]["objectives"]["force"]["difference"] == 0.0  # the invented engine again
    assert command("optimise", file, "--out", out, "--resume", "--no-plots") == 0
    assert "give --resume --verify" in capsys.readouterr().out
    again = json.loads((out / "result.json").read_text())
    assert "verification" not in again
    del result["verification"]
    assert without_time(again) == without_time(result)


SECOND = """[objectives.film]
terms = [{ functional = "max", output = "B.film_thickness" }]
"""
