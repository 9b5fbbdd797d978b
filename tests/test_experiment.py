"""Experiments from TOML: sources, overrides, refusals."""

import math
import re

import pytest
from machines import four_bar
from shipped import BENT, NAMES

from linkages import InputError, find_file, load, load_experiment
from linkages.cli.main import main
from linkages.input.files.table_keys import table_keys
from linkages.input.model.experiment import Experiment
from linkages.laws.friction import friction_coefficient

GOOD = """
duration = 1.0              # s, assumed
outputs = ["follower.omega"]
[drives.O]
speed = 5.0                 # rad/s, measured
[joints.A]
model = "lubricated"
clearance = 1e-4            # m, drawing 7
viscosity = 0.1             # Pa s, data sheet
shear_torque = false        # neglected
"""

#: case -> (text, overrides, expected part of the message)
REFUSED = {
    "not TOML": ("duration = ", {}, "is not valid TOML"),
    "unknown key": (GOOD.replace("duration", "duraton"), {}, 'duraton: unknown key; did you mean "duration"?'),
    "unknown joint key": (
        GOOD.replace("viscosity", "viscocity"),
        {},
        'joints.A.viscocity: unknown key; did you mean "viscosity"?',
    ),
    "missing duration": (GOOD.replace("duration = 1.0", ""), {}, "duration: is missing (simulated time [s])"),
    "negative duration": (GOOD.replace("duration = 1.0", "duration = -1.0"), {}, "greater than 0"),
    "text for a number": (GOOD.replace("= 5.0", '= "fast"'), {}, "drives.O.speed: is 'fast'"),
    "infinite speed": (GOOD.replace("= 5.0", "= inf"), {}, "finite"),
    "unknown joint": (GOOD.replace("[joints.A]", "[joints.Aa]"), {}, "machine.sdf has no such joint"),
    "unknown joint with an incomplete table": (
        GOOD + "[joints.a]\nmodel = 'dry'\nclearance = 1e-4\n",
        {},
        "joints.a: machine.sdf has no such joint; known are: A, B, O, Q",
    ),
    "unknown link with a wrong key": (
        GOOD + "[links.crnk]\nmodle = 'rigid'\n",
        {},
        "links.crnk: machine.sdf has no such link",
    ),
    "unknown joint of the command line": (GOOD, {"joints.Z.model": "dry"}, "joints.Z: machine.sdf has no such joint"),
    "unknown drive": (GOOD.replace("[drives.O]", "[drives.o1]"), {}, "machine.sdf has no such joint"),
    "negative clearance": (GOOD.replace("1e-4 ", "-1e-4 "), {}, "joints.A.clearance: is -0.0001"),
    "clearance larger than bearing": (
        GOOD.replace("1e-4 ", "0.02 "),
        {},
        "smaller than the bearing's radius of 0.01 m",
    ),
    "clearance lost in rounding": (GOOD.replace("1e-4 ", "1e-30 "), {}, "a rounding error"),
    "no bearing": (GOOD.replace("[joints.A]", "[joints.Q]"), {}, "needs a <linkages:bearing>"),
    "no viscosity": (GOOD.replace("viscosity = 0.1", ""), {}, 'model "lubricated" needs viscosity'),
    "unknown model": (GOOD.replace('"lubricated"', '"greasy"'), {}, "'ideal', 'dry', 'lubricated' or 'mixed'"),
    "unknown film": (GOOD + 'film = "finit"\n', {}, 'did you mean "finite"?'),
    "offset outside": (GOOD + "offset = [1e-4, 1e-4]\n", {}, "must lie inside the clearance circle"),
    "unknown output": (GOOD.replace("follower.omega", "folower.omega"), {}, 'did you mean "follower"?'),
    "unknown quantity": (GOOD.replace("follower.omega", "follower.omga"), {}, 'did you mean "omega"?'),
    "two kinds of drive": (
        GOOD.replace("[joints.A]", "torque = 1.0\nangles=[0.0,1.0]\ntimes=[0.0,1.0]\n[joints.A]"),
        {},
        "only one of",
    ),
    "table too short": (
        GOOD.replace("speed = 5.0", "times=[0.0,0.5]\nangles=[0.0,1.0]"),
        {},
        "before the duration of 1 s",
    ),
    "table not increasing": (
        GOOD.replace("speed = 5.0", "times=[0.0,2.0,1.0]\nangles=[0.0,1.0,2.0]"),
        {},
        "times must increase",
    ),
    "wrong gravity": (GOOD + "", {"gravity": [0.0, 1.0]}, "gravity"),
    "unknown override": (GOOD, {"joints.A.clearence": "1"}, 'did you mean "clearance"?'),
    "override without a key": (GOOD, {"joints..clearance": "1"}, "is not a path; write keys with dots between"),
    "table where a value is": (GOOD, {"joints.A": "3"}, "joints.A: is 3; it should be a table"),
    "text where a number is": (GOOD, {"joints.A.clearance": "'wide'"}, "is 'wide'; it should be a number (radial"),
    "list too short": (GOOD, {"gravity": "[0, 1]"}, "it should have at least 3 items, not 2"),
    "override into a value": (GOOD, {"duration.x": "1"}, '"duration" is a value'),
    "unknown sdf path": (GOOD, {"sdf.links.couplr.mass": 1.0}, 'did you mean "coupler"?'),
    "sdf value not a number": (GOOD, {"sdf.links.coupler.mass": "heavy"}, "must be a number"),
    "negative sdf mass": (GOOD, {"sdf.links.coupler.mass": -1.0}, "must be positive"),
    "accuracy zero": (GOOD, {"solver.accuracy": 0.0}, "greater than 0"),
    "speed out of all proportion": (GOOD, {"drives.O.speed": "1e60"}, "drives.O.speed: is 1e+60; a number"),
    "gravity with a tiny part": (GOOD, {"gravity": "[0, 1e-300, 0]"}, "gravity.1: is 1e-300; a number"),
    "integer of thousands of digits": (GOOD.replace("= 5.0", "= 0x" + "f" * 5000), {}, "drives.O.speed: is too large"),
    "decimal comma": (GOOD.replace("= 5.0", "= 5,5"), {}, "it has a decimal comma: write 5.5"),
    "decimal comma in quotes": (
        GOOD.replace("1e-4 ", '"0,1 mm" '),
        {},
        "is '0,1 mm'; it has a decimal comma: write 0.1 mm",
    ),
    "decimal comma of an override": (GOOD, {"joints.A.clearance": "0,2mm"}, "it has a decimal comma: write 0.2mm"),
    "decimal comma of an sdf value": (GOOD, {"sdf.links.coupler.mass": "0,3"}, "it has a decimal comma: write 0.3"),
    "nested deep": (GOOD + "[sdf" + ".a" * 50 + "]\nx = 1\n", {}, "is nested more than 20 levels deep"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_bad_experiments_are_refused_in_one_line_with_exit_status_2(experiment_file, tmp_path, capsys, case):
    text, overrides, reason = REFUSED[case]
    sets = [part for path, value in overrides.items() for part in ("--set", f"{path}={value}")]
    out = tmp_path / "out"
    assert main(["simulate", str(experiment_file(four_bar(), text)), "--out", str(out), *sets]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert reason in error
    assert error.startswith(("error: experiment.toml: ", "error: machine.sdf: ", "error: command line: "))
    assert not out.exists()
    with pytest.raises(InputError) as caught:
        load(experiment_file(four_bar(), text), overrides)
    message = str(caught.value)
    assert reason in message
    assert "\n" not in message
    assert message.startswith(("experiment.toml: ", "machine.sdf: ", "argument: "))


@pytest.mark.parametrize(
    ("words", "right"),
    [
        (["simulate", "four_bar_dry", "--duration", "0,5 s"], "0.5 s"),
        (["sweep", "four_bar_dry", "--vary", "joints.B.clearance=0,1mm:0,2mm:3"], "0.1mm"),
        (["sweep", "four_bar_dry", "--vary", "drives.O.speed=1,5:2,5:3"], "1.5"),
        (["play", "four_bar_dry", "--limit", "2,5"], "2.5"),
    ],
)
def test_a_decimal_comma_of_an_option_is_said(words, right, capsys):
    assert main(words) == 2
    assert f"it has a decimal comma: write {right}" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("path", "value", "problem"),
    [
        ("links.coupler.mass", -1.0, '<link name="coupler">/<inertial>/<mass>: is -1 kg; it must be positive'),
        ("links.coupler.inertia", 0.0, "is 0; it must be positive"),
        ("links.couplr.mass", 1.0, 'there is no link "couplr"; did you mean "coupler"?'),
    ],
)
def test_a_wrong_value_of_the_machine_is_said_to_stand_where_it_was_given(experiment_file, path, value, problem):
    known = {"sdf.links.crank.mass": 0.5}
    file = experiment_file(four_bar(), GOOD)
    found = []
    for refused in (
        lambda: load(file, {**known, f"sdf.{path}": value}),
        lambda: load(file, known).replaced({f"sdf.{path}": value}),
    ):
        with pytest.raises(InputError) as caught:
            refused()
        found.append(str(caught.value))
    assert found == [f"argument: sdf.{path}: {problem}"] * 2
    kind, name, key = path.split(".")
    with pytest.raises(InputError) as caught:
        load(experiment_file(four_bar(), f"{GOOD}\n[sdf.{kind}.{name}]\n{key} = {value}\n"))
    assert str(caught.value) == f"experiment.toml: sdf.{path}: {problem}"


def test_a_fault_of_the_machines_file_is_not_laid_on_a_value(experiment_file):
    file = experiment_file(four_bar().replace("<mass>", "<mass>-", 1), GOOD)
    with pytest.raises(InputError, match=r"machine\.sdf: <link name="):
        load(file, {"sdf.links.coupler.mass": 0.5})


def test_missing_files_are_refused(tmp_path):
    with pytest.raises(InputError, match=r"none\.toml: cannot be read"):
        load(tmp_path / "none.toml")
    path = tmp_path / "e.toml"
    path.write_text('mechanism = "none.sdf"\nduration = 1.0\n')
    with pytest.raises(InputError, match=r'^e\.toml: mechanism: is "none\.sdf", which cannot be read'):
        load(path)
    (tmp_path / "A.x").write_text("no machine")
    for name, problem in (
        ("A.x", "is not well-formed XML"),
        ("e.toml", "is not well-formed XML"),
        ("B.x", "cannot be"),
    ):
        path.write_text(f'mechanism = "{name}"\nduration = 1.0\n')
        with pytest.raises(InputError, match=rf'^e\.toml: mechanism: is "{re.escape(name)}", which {problem}'):
            load(path)


@pytest.mark.parametrize(("law", "fine"), [("coulomb", True), ("lugre", True), ("ambrosio", False), ("cubic", False)])
def test_a_law_without_v_0_takes_any_v_1(experiment_file, law, fine):
    """Coulomb's law is mu_d tanh(v/v_1), which v_0 is no part of."""
    contact = 'contact = { law = "flores", restitution = 0.8, youngs_modulus = 2e11 }\n'
    friction = f'friction = {{ law = "{law}", coefficient = 0.1, v_1 = 1e-4 }}\n'
    text = f'duration = 1.0\n[joints.A]\nmodel = "dry"\nclearance = 1e-4\n{contact}{friction}'
    file = experiment_file(four_bar(), text)
    if fine:
        system = load(file)
        assert system.value("joints.A.friction.v_1") == 1e-4
        if law == "coulomb":
            assert friction_coefficient(2e-4, system.laws[0]) == pytest.approx(0.1 * math.tanh(2.0), rel=1e-14)
    else:
        with pytest.raises(InputError, match=r"v_1 must be above v_0, which is 0\.0001 m/s, the default; give v_0"):
            load(file)
        assert load(file, {"joints.A.friction.v_0": 1e-5}).laws["friction_0"][0] == 1e-5


def test_files_without_an_end_are_refused(tmp_path, experiment_file):
    """As `/dev/zero`, of which no memory holds the whole."""
    path = experiment_file(four_bar(), GOOD)
    for name in ("machine.sdf", "experiment.toml"):
        with open(tmp_path / name, "r+b") as file:
            file.truncate(10_000_001)
        with pytest.raises(InputError, match=rf"{name}\b.* is larger than 10 MB"):
            load(path)


def test_a_misspelt_file_gets_the_nearest_name(experiment_file, capsys, monkeypatch):
    path = experiment_file(four_bar(), GOOD)
    monkeypatch.chdir(path.parent)
    mistakes = {
        "experimnet.toml": 'experimnet.toml: cannot be read (No such file or directory); did you mean "experiment.toml"?',
        "seven_bra.toml": 'seven_bra.toml: cannot be read (No such file or directory); did you mean "seven_bar.toml"?',
        "nothing.toml": "nothing.toml: cannot be read (No such file or directory)",
        "machine.sdf": "machine.sdf: is a mechanism; give the experiment file (.toml) that names it",
        ".": ".: cannot be read (Is a directory)",
    }
    for name, told in mistakes.items():
        assert main(["simulate", name]) == 2
        assert capsys.readouterr().err == f"error: {told}\n"
    path.write_text(path.read_text().replace("machine.sdf", "mashine.sdf"))
    with pytest.raises(
        InputError, match=r'mechanism: is "mashine\.sdf", which cannot be read .*; did you mean "machine\.sdf"\?$'
    ):
        load(path)


def test_comments_are_kept_as_sources(experiment_file):
    experiment = load_experiment(experiment_file(four_bar(), GOOD), {"joints.A.viscosity": "0.2"})
    assert experiment.sources["duration"] == "s, assumed"
    assert experiment.sources["joints.A.clearance"] == "m, drawing 7"
    assert experiment.sources["joints.A.shear_torque"] == "neglected"
    assert experiment.sources["joints.A.viscosity"] == "argument"
    assert experiment.joints["A"].viscosity == 0.2


def test_every_number_of_the_shipped_experiments_has_a_source(seven_bar):
    for name in ("seven_bar.toml", "seven_bar_paper.toml", "seven_bar_rig.toml"):
        experiment = load_experiment(seven_bar.experiment.source.parent / name)
        for path in ("duration", "gravity", "drives.O1.speed", "joints.A.clearance", "joints.B.viscosity"):
            assert len(experiment.sources[path]) > 5


def test_replaced_leaves_the_original_alone(seven_bar):
    experiment = seven_bar.experiment
    other = experiment.replaced({"joints.A.clearance": 1e-4, "duration": 0.5})
    assert (experiment.joints["A"].clearance, experiment.duration) == (3e-4, 2.0)
    assert (other.joints["A"].clearance, other.duration) == (1e-4, 0.5)
    assert other.ideal().play == ()
    assert other.play == ("A", "B")


def test_every_key_has_a_meaning():
    listed = dict(table_keys(Experiment))
    assert "joints.NAME.clearance" in listed
    assert all(listed.values())
    assert "[m]" in listed["joints.NAME.clearance"]


@pytest.mark.parametrize("name", [*NAMES, *BENT])
def test_an_experiment_knows_whether_anything_can_touch(name):
    """The same as the models of the system's contacts say."""
    system = load(find_file(f"{name}.toml"))
    assert system.experiment.can_touch == bool(system.touching.any())
