"""Manners of the command line: errors, help, quiet and verbose, new, doctor, completion."""

import argparse
import importlib.metadata
import io
import json
import os
import re
import subprocess
import sys
import types
from contextlib import redirect_stdout
from math import sqrt

import pytest
from machines import LUBRICATED, four_bar, slider_crank
from mutant_commands import subparsers
from processes import finish, start

from linkages.base.kernel import precompiled
from linkages.base.kernel.folder import temporary_folder
from linkages.cli import commands, doctor, progress
from linkages.cli.main import exit_status, main
from linkages.engines import drop
from linkages.results.outputs.registry import names
from linkages.system import load

TOML = "duration = 0.02\n" + LUBRICATED

MISTAKES = {
    ("simulat", "x.toml"): 'simulat: is unknown; did you mean "simulate"?',
    ("--versoin",): 'did you mean "--version"?',
    ("simulate", "x.toml", "--durration", "3"): '--durration: is unknown; did you mean "--duration"?',
    ("simulate", "x.toml", "--durration=3"): '--durration: is unknown; did you mean "--duration"?',
    ("simulate", "x.toml", "y.toml"): "y.toml: is one argument too many",
    ("simulate",): "required: file",
    ("simulate", "x.toml", "--engine", "draek"): "'draek' (choose from",
    ("simulate", "x.toml", "-q", "-v"): "not allowed with argument",
    ("modes", "x.toml", "--verfy"): 'did you mean "--verify"?',
    ("completion", "fsh"): "'fsh' (choose from",
    ("sweep", "x.toml", "--vary", "a=0:1:2", "--duration", "1"): "--duration: is unknown",  # the revolutions give it
    ("continue", "x.toml", "--vary", "a=0:1", "--duration", "1"): "--duration: is unknown",  # the periods give it
}


@pytest.mark.parametrize("words", MISTAKES)
def test_a_mistake_on_the_command_line_gets_one_line_and_the_nearest_word(words, capsys):
    assert main(list(words)) == 2
    error = capsys.readouterr().err.strip()
    assert error.startswith("error: linkages")
    assert MISTAKES[words] in error
    assert "\n" not in error


def single_options():
    """Find the options of all commands that may be given once only, with a value."""
    for name, one in subparsers().items():
        for action in one._actions:
            if action.option_strings and action.dest != "help" and not isinstance(action, argparse._AppendAction):
                value = [str(next(iter(action.choices or ["1"])))] if action.nargs != 0 else []
                yield pytest.param([*name.split(), *2 * [action.option_strings[0], *value]], id=f"{name} {action.dest}")


@pytest.mark.parametrize("words", list(single_options()))
def test_an_option_that_is_given_twice_is_refused(words, capsys):
    """The second value would be used, without a word."""
    assert main(words) == 2
    assert re.fullmatch(r"error: linkages [a-z ]+: -+[a-z-]+: is given twice\n", capsys.readouterr().err)


def test_a_repeated_option_has_each_path_once(capsys):
    for words in (
        ("--set", "a=1", "--set", "a=2"),
        ("--set=a=1", "--set", " a = 2"),
        ("--output", "a=1", "--output", "a=1"),
    ):
        assert main(["sweep", "x.toml", *words]) == 2
        assert "is given twice" in capsys.readouterr().err
    assert main(["sweep", "x.toml", "--set", "a=1", "--set", "b=2"]) == 2
    assert "--vary" in capsys.readouterr().err  # which is missing


#: Arguments of the library that are options of a command: the message names the option.
OPTIONS = {
    ("wear", "slider_crank_wear.toml", "--cycles", "1", "--drive", "x"): '--drive: "x" has no prescribed motion',
    ("linearise", "slider_crank_dry.toml", "--input", "X"): '--input: "X" is unknown',
    ("sweep", "slider_crank_dry.toml", "--vary", "duration=1:2:2", "--revolutions", "-1"): "--revolutions: is -1",
    ("new", "é", "--from", "f"): "NAME: é: must begin with a letter",
    ("new", "--from", "é.toml"): "--from: é.toml: the file's name: é: must begin with a letter",
}


@pytest.mark.parametrize("words", OPTIONS)
def test_a_refused_value_is_named_with_its_option(words, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(list(words)) == 2
    *progress, line = capsys.readouterr().err.splitlines()  # which a slow machine shows
    assert line.startswith(f"error: {OPTIONS[words]}")
    assert not [each for each in progress if "error" in each]


@pytest.mark.parametrize(
    "words", [("new", ""), ("simulate", ""), ("simulate", "seven_bar.toml", "--out", ""), ("modes", "x.toml", "--")]
)
def test_a_name_of_two_thousand_characters_is_shortened(words, capsys):
    assert main([*words[:-1], words[-1] + "x" * 2000]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("error: ")
    assert len(line) < 500


def test_no_command_shows_what_there_is(capsys):
    assert main([]) == 2
    shown = capsys.readouterr().err
    assert all(name in shown for name in commands())


def test_a_broken_plug_in_takes_no_other_command_away(monkeypatch, capsys):
    """Two that cannot be used and one that takes the name of a command of ours."""
    points = [
        importlib.metadata.EntryPoint(name, value, "linkages.commands")
        for name, value in {"gone": "no_such_package.gone", "empty": "json", "simulate": "json"}.items()
    ]
    monkeypatch.setattr("linkages.cli.entry_points", lambda group: points)
    with pytest.raises(SystemExit) as done:
        main(["--help"])
    assert done.value.code == 0
    shown = capsys.readouterr()
    assert "simulate" in shown.out
    assert "gone" not in shown.out
    assert shown.err.splitlines() == [
        "warning: command gone (no_such_package.gone) is skipped: ModuleNotFoundError: No module named 'no_such_package'",
        "warning: command empty (json) is skipped: TypeError: it has no HELP",
        "warning: command simulate (json) is skipped: ValueError: the name is taken",
    ]


@pytest.mark.parametrize("name", [None, *commands()])
def test_help_has_examples_that_the_parser_takes(name, capsys, monkeypatch):
    """Every example in a help text is parsed; nothing is run."""
    with pytest.raises(SystemExit) as done:
        main([name, "--help"] if name else ["--help"])
    assert done.value.code == 0
    printed = re.sub(r" \\\n +", " ", capsys.readouterr().out.partition("examples:")[2])  # as a shell joins lines
    examples = re.findall(r"^ +linkages (.*?)(?:  .*)?$", printed, re.M)
    assert examples
    for command in commands().values():
        monkeypatch.setattr(command, "run", lambda options: 0)
    for example in examples:
        words = re.split(r" [|>&]", example)[0].split()
        assert main(words) == 0, example


def test_the_version_is_the_package_s(capsys):
    with pytest.raises(SystemExit) as done:
        main(["--version"])
    assert done.value.code == 0
    assert capsys.readouterr().out.strip() == f"linkages {importlib.metadata.version('linkages')}"


def test_quiet_prints_nothing_and_verbose_says_how(experiment_file, tmp_path, capsys):
    path = experiment_file(four_bar(), TOML)
    words = ["simulate", str(path), "--no-plots", "--no-animation", "--out", str(tmp_path / "out")]
    assert main([*words, "--quiet"]) == 0
    assert capsys.readouterr() == ("", "")
    assert main([*words, "--verbose"]) == 0
    shown = capsys.readouterr()
    assert shown.err.splitlines() == ["run ...", "error estimate ..."]
    assert f"experiment {path}" in " ".join(shown.out.split())
    assert "joints cut to get a tree: A" in shown.out
    assert "accuracy 1e-07\n" in shown.out
    assert main([*words, "--verbose", "--engine", "drake"]) == 0
    assert "accuracy 1e-07, steps of at most 0.002 s" in capsys.readouterr().out
    assert main(["simulate", str(tmp_path / "none.toml"), "--quiet"]) == 2
    assert capsys.readouterr().err.startswith("error: ")  # errors are never quiet


LOADED = """
import sys
from linkages.cli.main import exit_status, main

words = ["simulate", "seven_bar.toml", "--duration", "1e-3", "--engine", "compiled", "--no-plots", "--no-animation"]
main([*words, "--out", sys.argv[1]])
print(*sys.modules)
"""


def test_a_compiled_run_imports_neither_drake_nor_what_scipy_computes_with(tmp_path):
    """They would take a second of every command, and what draws or makes pages as well."""
    command = [sys.executable, "-c", LOADED, str(tmp_path / "out")]
    for _ in range(2):  # the first one may compile, which imports all of numba
        done = subprocess.run(command, capture_output=True, text=True, check=True)
    loaded = set(done.stdout.splitlines()[-1].split())
    heavy = {f"scipy.{part}" for part in ("linalg", "optimize", "interpolate", "sparse")}
    assert "linkages.engines.compiled.simulation" in loaded
    assert not {"pydrake", "matplotlib", "pint", "jinja2", *heavy} & loaded


def test_help_imports_nothing_that_computes():
    """Nor what draws: it is there in 0.2 s of a quiet machine."""
    code = (
        "import sys\nfrom linkages.cli.main import main\ntry:\n    main(['--help'])\nfinally:\n    print(*sys.modules)"
    )
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout
    assert "COMMAND" in shown
    assert not {"numpy", "numba", "scipy", "pydantic", "matplotlib", "pydrake"} & set(shown.split())


ANNOUNCED = """
from linkages.cli import progress
from linkages.base.kernel import kernel

for _ in range(2):
    progress.announce_compilation()
for constant in (1, 2):
    exec(f"def add(x):\\n    return x + {constant}")
    kernel(add)(1)
"""


def test_compilation_is_announced_once(tmp_path):
    """Runs in a separate process, because another test may have announced it here."""
    empty = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
    done = subprocess.run([sys.executable, "-c", ANNOUNCED], env=empty, capture_output=True, text=True, check=True)
    assert done.stderr == "compiling, once after an installation: up to a minute ...\n"


def test_where_there_is_no_terminal_progress_is_a_line_within_two_seconds_and_then_every_ten(monkeypatch, capsys):
    now = [0.0]
    monkeypatch.setattr(progress, "_FIRST", 1.2)
    monkeypatch.setattr(progress, "_LATER", 9.0)
    monkeypatch.setattr("time.monotonic", lambda: now[0])
    progress.silence.begin(False)
    advance = progress.progress_bar("run", 2.0)
    for k in range(1, 101):
        now[0] = 0.4 * k
        advance(0.01 * k)
    assert capsys.readouterr().err.splitlines() == [
        "run: 1.50% in 1 s, the rest takes 79 s",
        "run: 13.00% in 10 s, the rest takes 70 s",
        "run: 24.50% in 19 s, the rest takes 60 s",
        "run: 36.00% in 28 s, the rest takes 51 s",
        "run: 47.50% in 38 s, the rest takes 42 s",
    ]
    progress.silence.begin(False)
    now[0] += 5.0
    progress.progress_bar("run", 2.0)(1.95)  # the first call comes late: the speed is unknown
    assert capsys.readouterr().err == "run: 97.50%\n"


def test_a_sign_of_life_names_the_finished_amount(monkeypatch, capsys):
    """Where a single motion of a branch takes minutes, as with a small clearance."""
    monkeypatch.setattr(progress.silence, "stage", "")
    progress.progress_bar("branches")(0.04)
    assert progress.silence.stage == "branches: 4.00%"
    progress.progress_bar("branches")(1.0)
    assert progress.silence.stage == "results"


@pytest.mark.processes
def test_a_command_that_says_nothing_shows_a_sign_of_life_unless_it_is_quiet(monkeypatch, capsys, heartbeats):
    for name in ("_FIRST", "_LATER", "_GRACE"):
        monkeypatch.setattr(progress, name, 0.0)

    def silent(quiet):
        progress.be_quiet(argparse.Namespace(quiet=quiet))
        progress.silence.stage = "the long stage"
        heartbeats()
        return 0

    for quiet in (False, True):
        assert exit_status(silent, quiet) == 0
        assert re.fullmatch("" if quiet else r"(the long stage, \d+ s so far\n)+", capsys.readouterr().err)


def test_the_first_line_of_a_run_names_its_engine(tmp_path, capsys):
    """The compiled engine unless another is named."""
    words = ["simulate", "seven_bar.toml", "--duration", "1e-3", "--no-plots", "--no-animation"]
    for engine, options in (("compiled", []), ("drake", ["--engine", "drake"])):
        out = tmp_path / engine
        assert main([*words, *options, "--out", str(out)]) == 0
        told = capsys.readouterr().out
        assert re.match(rf"engine: {engine}; --engine (?!{engine})\w+ (runs|integrates) the same", told)
        assert json.loads((out / "summary.json").read_text())["engine"] == engine
    assert main([*words, "--quiet", "--out", str(out)]) == 0
    assert capsys.readouterr() == ("", "")


def listing(text):
    """Names and meanings of a list whose long names and meanings take several lines."""
    found, name = {}, ""
    for line in filter(None, text.splitlines()):
        if line[0] != " ":
            name, _, line = line.partition("  ")
        found[name] = f"{found.get(name, '')} {line.strip()}".strip()
    return found


def test_keys_and_outputs_are_listed_with_their_units(seven_bar, capsys):
    assert main(["keys"]) == 0
    listed = listing(capsys.readouterr().out)
    for name, unit in {"joints.NAME.clearance": "m", "DRIVE.rate": "rad/s or m/s", "POINT.ax": "m/s2"}.items():
        assert listed[name].partition(";")[0].endswith(f" [{unit}]")  # then its bounds and default
    quantities = {name.rpartition(".")[2] for name in listed}
    assert {name.rpartition(".")[2] for name in names(seven_bar) if not name.startswith("q.")} <= quantities


@pytest.mark.parametrize("path", ["joints.A.friction", "joints.NAME.friction", "contacts.foot.friction", "friction"])
def test_keys_at_a_path_are_listed(path, capsys):
    assert main(["keys", path]) == 0
    listed = list(listing(capsys.readouterr().out))
    tables = {"joints": "", "contacts": ""} if path == "friction" else {path.partition(".")[0]: ""}
    tables |= {name: "backlash." for name in ("gears", "couplings", "drives") if path == "friction"}
    for table, part in tables.items():
        assert {f"{table}.NAME.{part}friction.{key}" for key in ("law", "coefficient", "v_0", "v_1")} <= set(listed)
    assert {name.split(".")[0] for name in listed} == set(tables)
    assert all("friction" in name for name in listed)


def test_outputs_are_listed_by_path_and_a_wrong_path_is_answered(capsys):
    assert main(["keys", "A.eccentricity_ratio"]) == 0
    assert next(iter(listing(capsys.readouterr().out))) == "JOINT (film, dry, mixed).eccentricity_ratio"
    assert main(["keys", "joints.A.frictoin"]) == 2
    assert capsys.readouterr().err.startswith("error: keys: joints.A.frictoin: is no key and no output; did you mean")
    assert main(["keys", "yoke.toml"]) == 2
    expected = "error: keys: yoke.toml: is no key and no output; `linkages keys` lists them all\n"
    assert capsys.readouterr().err.endswith(expected)


def test_names_with_a_slash_become_files(tmp_path, capsys, experiment_file):
    text = slider_crank().replace('"slider"', '"arm/slider"').replace(">slider<", ">arm/slider<")
    file = experiment_file(text, 'duration = 0.05\noutputs = ["arm/slider.x"]\n[drives.O]\nspeed = 100.0\n')
    out = tmp_path / "out"
    assert main(["simulate", str(file), "--out", str(out), "--no-animation"]) == 0
    assert (out / "output_arm%2Fslider.x.png").is_file()
    assert main(["report", str(out)]) == 0
    assert "arm/slider.x over time" in (out / "report.html").read_text()
    for form in ("csv", "mat", "netcdf"):
        assert main(["export", str(out), "--to", form]) == 0
    capsys.readouterr()


@pytest.mark.processes
def test_a_reader_that_leaves_is_no_error():
    left, pipe = os.pipe()
    os.close(left)  # it has left before the command begins
    status, errors = finish(start("keys", stdout=pipe))
    os.close(pipe)
    assert (status, errors) == (141, "")


@pytest.mark.parametrize("model", ["lubricated", "dry"])
def test_new_files_run_at_once(model, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["new", "my-press", "--model", model]) == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["my-press.sdf", "my-press.toml"]
    assert "linkages simulate my-press.toml" in capsys.readouterr().out
    system = load("my-press.toml")
    assert system.mechanism.name == "my-press"
    assert system.experiment.joints["A"].model == model
    numbers = set(re.findall(r"^(\w+) += [-\d.[]", (tmp_path / "my-press.toml").read_text(), re.M))
    named = {path.rpartition(".")[2] for path in system.experiment.sources}
    assert numbers <= named  # every number of the template has a source
    words = ["--duration", "0.01", "--no-plots", "--no-animation", "--no-error-estimate"]
    assert main(["simulate", "my-press.toml", *words]) == 0
    shown = capsys.readouterr().out
    assert "  ok, 0.01 s, compiled\n" in shown
    assert max(map(len, shown.splitlines())) <= 78
    tables = [part for part in shown.split("\n\n") if re.match(r"output|drive|oil film", part)]
    assert len(tables) >= 2
    for section in tables:  # columns end where their heads do, however long the names
        assert len({len(line) for line in section.splitlines() if not line.startswith("    ")}) == 1


def test_the_drawing_of_the_new_machine_closes_and_its_bars_are_uniform_steel(tmp_path):
    assert main(["new", "m", "--out", str(tmp_path / "made")]) == 0
    mechanism = load(tmp_path / "made" / "m.toml").mechanism
    for joint in mechanism.joints:
        gap = sqrt(sum((joint.on_parent - joint.on_child) ** 2))
        assert gap < 5e-5  # its angles have two decimals: half of 0.01 deg over 0.25 m
    for link, length in {"crank": 0.1, "coupler": 0.25, "follower": 0.2}.items():
        mass = 7850 * length * 0.02 * 0.01
        assert mechanism.link[link].mass == pytest.approx(mass, rel=1e-3)
        assert mechanism.link[link].inertia == pytest.approx(mass * length**2 / 12, rel=2e-3)


@pytest.mark.parametrize("name", ["", "3bar", "a/b", "../x", "world", "a b", "x" * 65, "é"])
def test_new_refuses_names_that_files_or_sdf_cannot_have(name, tmp_path, capsys):
    assert main(["new", name, "--out", str(tmp_path)]) == 2
    assert "must begin with a letter" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("there", ["m.sdf", "m.toml"])
def test_new_overwrites_nothing(there, tmp_path, capsys):
    (tmp_path / there).write_text("mine")
    assert main(["new", "m", "--out", str(tmp_path)]) == 2
    assert "already exists" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == [there]
    assert (tmp_path / there).read_text() == "mine"


def test_new_replaces_no_link_that_leads_nowhere(tmp_path, capsys):
    (tmp_path / "m.toml").symlink_to(tmp_path / "nowhere" / "m.toml")
    assert main(["new", "m", "--out", str(tmp_path)]) == 2
    assert "already exists" in capsys.readouterr().err
    assert (tmp_path / "m.toml").is_symlink()
    assert not (tmp_path / "m.sdf").exists()


@pytest.mark.drake
def test_doctor_finds_this_installation_sound(capsys):
    assert main(["doctor"]) == 0
    shown = capsys.readouterr().out
    assert "WRONG" not in shown
    for name in ("Python", "drake", "compile cache", "film maps", "threads", "data", "figures", "self-check, drake"):
        assert re.search(rf"^ok +{name} ", shown, re.M), name
    assert shown.rstrip().endswith("all is well")


def test_the_self_check_finds_a_wrong_engine(monkeypatch):
    """A stiffness that is 0.1 % off changes the depth by 0.04 %: found."""
    wrong = drop._TOML.replace("stiffness = 1000000000.0", "stiffness = 1001000000.0")
    assert wrong != drop._TOML
    monkeypatch.setattr(drop, "_TOML", wrong)
    finding = doctor.self_check("drake")
    assert finding.remedy
    assert float(re.search(r"to ([\d.e-]+)", finding.text)[1]) == pytest.approx(4e-4, rel=0.05)


def test_doctor_tells_what_is_wrong_and_exits_with_1(monkeypatch, capsys, tmp_path):
    def broken(engine):
        raise OSError("no such\nlibrary")

    blocked = tmp_path / "file"
    blocked.write_text("")
    monkeypatch.setenv("LINKAGES_CACHE", str(blocked / "maps"))
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setattr(doctor, "self_check", broken)
    monkeypatch.setattr(doctor, "data_folder", lambda: tmp_path)
    needs = ["numpy>=999", "no-such-package>=1", 'pytest>=8; extra == "dev"']
    monkeypatch.setattr(importlib.metadata, "requires", lambda name: needs)
    assert main(["doctor"]) == 1
    shown = capsys.readouterr().out
    wrong = re.findall(r"^WRONG (\S+)", shown, re.M)
    assert wrong[:6] == ["numpy", "no-such-package", "data", "compile", "film", "self-check,"]
    assert 'run `pip install -U "numpy>=999"`' in shown
    assert "set LINKAGES_CACHE to a writable folder" in shown
    assert "OSError: no such library" in shown
    assert "need a remedy" in shown


def test_doctor_knows_compilers_without_a_cache_or_switched_off(monkeypatch):
    for place in (None, temporary_folder() / "compiled"):
        monkeypatch.setattr("linkages.base.kernel.folder.folder", lambda place=place: place)
        assert "NUMBA_CACHE_DIR" in doctor.compile_cache().remedy
    monkeypatch.setattr("numba.config.DISABLE_JIT", True)
    assert doctor.compile_cache().remedy == "unset NUMBA_DISABLE_JIT"


def test_a_compilation_is_a_stage_of_any_command(monkeypatch):
    """`doctor`, for instance, compiles for a minute on an empty cache."""
    compiled, counted = [3, 3, 5, 5], [0]
    monkeypatch.setattr(precompiled, "counts", lambda: (compiled.pop(0), 0))
    told = [progress._compilation(counted) for _ in range(4)]
    assert [text.startswith("compiling") for text in told] == [True, False, True, False]
    monkeypatch.setitem(sys.modules, "linkages.base.kernel.precompiled", types.ModuleType("imported half-way"))
    assert progress._compilation(counted) == ""


def test_fish_completes_commands_and_options(capsys):
    assert main(["completion", "fish"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert any(
        line.startswith("complete -c linkages") and "-l duration" in line and "simulate" in line for line in lines
    )


def test_bash_completes_commands_options_and_choices(tmp_path):
    script = io.StringIO()
    with redirect_stdout(script):
        assert main(["completion", "bash"]) == 0
    (tmp_path / "completion").write_text(script.getvalue())
    ask = """source completion
complete_line() { COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); COMPREPLY=(); _shtab_linkages 2>/dev/null; echo "${COMPREPLY[@]}"; }
complete_line linkages sim
complete_line linkages simulate --dur
complete_line linkages simulate x.toml --engine dr
"""
    done = subprocess.run(["bash", "-c", ask], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert [line.strip() for line in done.stdout.splitlines()] == ["simulate", "--duration", "drake"]
