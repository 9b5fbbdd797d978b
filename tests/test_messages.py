"""Messages to users: choices, units, suggested names."""

import argparse
import re

import numpy as np
import pytest
from machines import four_bar, slider_crank

import linkages
from linkages import AssemblyError, InputError, Status, Trajectory, assess, load, summarize
from linkages.cli.main import main, report_failures
from linkages.cli.options import load_system
from linkages.input.files.shipped import find_file
from linkages.input.files.table_keys import described_keys
from linkages.input.model.experiment import Experiment, value_unit
from linkages.input.model.output_names import QUANTITIES, SHAPE_QUANTITIES
from linkages.laws import CONTACTS
from linkages.show.plots import histories, section_figure
from linkages.show.report.terminal import format_table
from linkages.show.report.words import output_unit

DRIVEN = "duration = 1.0\n[drives.O]\nspeed = 1.0\n"


def test_keys_come_with_their_values_and_defaults():
    told = dict(described_keys(Experiment))
    assert told["mechanism"].endswith("; required")
    assert told["solver.accuracy"] == "relative accuracy [1]; > 0 and <= 0.1; default 1e-07"
    assert told["joints.NAME.model"].endswith("; one of ideal, dry, lubricated, mixed; required")
    assert told["joints.NAME.film"].endswith("; one of finite, long, pinkus-sternlicht, short; default finite")
    assert told["joints.NAME.clearance"].endswith(
        "[m]; > 0"
    )  # the requirement for clearance joints is checked elsewhere
    assert told["joints.NAME.contact.clip"].endswith("; default true")
    assert told["solver.integrator"].endswith("runge_kutta3, bogacki_shampine3")


def test_a_law_of_a_users_own_is_among_the_choices(monkeypatch):
    monkeypatch.setitem(CONTACTS, "mine", CONTACTS["hertz"])
    assert ", mine, " in dict(described_keys(Experiment))["joints.NAME.contact.law"]


def test_a_missing_law_lists_its_choices(experiment_file):
    joint = '[joints.B]\nmodel = "dry"\nclearance = 1e-4\ncontact = {restitution = 0.9, youngs_modulus = 2e11}\n'
    with pytest.raises(InputError, match=r"joints\.B\.contact\.law: is missing .*; give one of dubowsky-f.*, hertz, "):
        load(experiment_file(four_bar(), DRIVEN + joint))
    with pytest.raises(InputError, match=r"joints\.B\.model: is missing .*; give one of ideal, dry, lubricated, mixed"):
        load(experiment_file(four_bar(), DRIVEN + "[joints.B]\nclearance = 1e-4\n"))


def test_a_linkage_that_cannot_be_assembled_names_the_drive_and_the_open_joint(experiment_file):
    """Follower and coupler in line reach 0.45 m; the crank's pin goes as far as 0.5 m from the follower's."""
    file = experiment_file(four_bar(0.3, 0.2, 0.25, 0.2), DRIVEN)
    limit = np.arccos((0.3**2 + 0.2**2 - 0.45**2) / (2 * 0.3 * 0.2))
    with pytest.raises(AssemblyError) as problem:
        load(file, {"drives.O.angle": 3.0}).assembly  # noqa: B018
    start, _, gap = str(problem.value).partition(" stays open by ")
    angle = float(start.partition("O = ")[2].partition(":")[0])
    assert limit < angle < limit + 0.06  # the first step beyond
    distance = np.sqrt(0.3**2 + 0.2**2 - 2 * 0.3 * 0.2 * np.cos(angle))
    assert start.startswith("no-assembly: the loops do not close at O = ")
    assert start.endswith((": B", ": A"))
    assert 0.5 * (distance - 0.45) < float(gap.partition(" m;")[0]) < 2.0 * (distance - 0.45)


def test_a_run_that_locks_says_where_its_drives_are(capsys):
    time = np.array([0.0, 0.5])
    columns = {"time": time, "O.rate": time, "q.O": np.array([0.0, 2.22])}
    run = Trajectory(time, columns, Status.LOCKED, units={"q.O": "rad"})
    assert report_failures({"the run": run}) == 1
    assert capsys.readouterr().err.startswith("the run ended at t = 0.5 s, O = 2.22 rad: locked; ")


def test_the_end_of_a_files_name_may_be_left_out(experiment_file, tmp_path, monkeypatch):
    experiment_file(four_bar(), DRIVEN)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "experiment").mkdir()  # as results may be called
    assert find_file("experiment", ".toml").name == "experiment.toml"
    assert find_file("machine", ".toml", ".sdf").name == "machine.sdf"
    assert find_file("seven_bar", ".toml").name == "seven_bar.toml"
    with pytest.raises(InputError, match="cannot be read"):
        find_file("nothing", ".toml")


def test_every_joint_can_be_taken_as_ideal():
    options = argparse.Namespace(file="seven_bar", set=[], duration=None, ideal=True)
    system = load_system(options)
    assert system.tree.play == ()
    assert system.experiment.sources["joints.A"] == "command line"  # so that a report repeats it
    assert load_system(argparse.Namespace(file="seven_bar", set=[], duration=None)).tree.play == ("A", "B")


def test_a_joint_that_slides_is_driven_by_a_force(experiment_file):
    """A force drives a prismatic joint as a torque drives a revolute joint, also over time."""
    table = "times = [0.0, 0.01]\nforces = [0.0, 3.0]\n"
    for drive, torque in (("force = 2.0\n", "torque = 2.0\n"), (table, table.replace("forces", "torques"))):
        systems = [
            load(experiment_file(slider_crank(offset=0.01), f"duration = 0.01\n[drives.guide]\n{text}"))
            for text in (drive, torque)
        ]
        times = np.linspace(0.0, 0.01, 5)
        assert systems[0].tree.powered == ("guide",)
        assert np.array_equal(systems[0].torques(times)[0], systems[1].torques(times)[0])
    with pytest.raises(InputError, match=r"drives\.O\.force: belongs to a prismatic joint"):
        load(experiment_file(slider_crank(), "duration = 0.01\n[drives.O]\nforce = 1.0\n"))


def test_kelvin_voigt_takes_its_stiffness_from_the_material(experiment_file):
    """Parallel cylinders: pi/4 E' L, with 1/E' = 2 (1 - nu^2)/E of two equal bodies; L is the bearing's 20 mm."""
    contact = 'contact = {law = "kelvin-voigt", restitution = 0.9, youngs_modulus = "210 GPa", damping = "50 N s/m"}\n'
    joint = f'[joints.B]\nmodel = "dry"\nclearance = "0.1 mm"\n{contact}'
    system = load(experiment_file(four_bar(), DRIVEN + joint))
    assert system.laws["stiffness"][0] == pytest.approx(np.pi / 4 * 2.1e11 / (2 * 0.91) * 0.02)
    assert system.replaced({"joints.B.contact.stiffness": 1e8}).laws["stiffness"][0] == 1e8


@pytest.mark.slow
def test_a_drive_that_slides_speaks_of_a_force(experiment_file):
    driven = "duration = 0.01\n[drives.O]\nangle = 1.0\n speed = 1.0\n"
    turning = assess(load(experiment_file(slider_crank(), driven)), "compiled", error_estimate=False)
    assert re.search(r"\nO torque \[[kmµ]?N m\] ", format_table(summarize(turning)))
    sliding = "duration = 0.01\n[drives.guide]\nangle = -0.02\n speed = -0.1\n"
    found = assess(load(experiment_file(slider_crank(offset=0.01), sliding)), "compiled", error_estimate=False)
    summary = summarize(found)
    assert summary["drives"]["guide"]["unit"] == "N"
    assert re.search(r"\nguide force \[[kmµ]?N\] ", format_table(summary))


@pytest.mark.parametrize(
    ("path", "unit"),
    [("joints.A.clearance", "m"), ("drives.O.speed", "rad/s"), ("duration", "s"), ("springs.S.stiffness", "N/m"),
     ("joints.A.contact.youngs_modulus", "Pa"), ("sdf.links.rod.inertia", "kg m2"), ("sdf.frames.tip.pose.x", "m"),
     ("sdf.links.rod.beam.height", "m"), ("sdf.links.rod.beam.second_moment", "m4"), ("outputs", "")],
)  # fmt: skip
def test_every_value_that_can_be_varied_has_its_unit(path, unit):
    assert value_unit(path) == unit


@pytest.mark.parametrize(("count", "size"), [(5, 12.0), (299, 12.0), (300, 4.0), (3000, 1.6)])
def test_few_marks_are_large_enough_to_be_seen(count, size):
    values = np.linspace(0.0, 1.0, count)
    figure = section_figure({"a": values, "b": values}, "a", "b", ("m", "m"))
    assert figure.axes[0].lines[0].get_markersize() == size


@pytest.mark.parametrize("quantity", [*QUANTITIES, *SHAPE_QUANTITIES])
def test_every_output_has_a_unit_and_a_figure_with_its_name(quantity, monkeypatch):
    said = []
    monkeypatch.setattr(histories, "_compare", lambda study, columns, errors, around: said.append(columns))
    histories.output_figure(None, f"rod.{quantity}")
    assert output_unit(f"rod.{quantity}") in {"m", "rad", "m/s", "rad/s", "m/s2", "rad/s2", "N", "N m", "Pa"}
    (((name, title),),) = (columns.items() for columns in said)
    assert (name, title.partition(": ")[0]) == (f"rod.{quantity}", "rod")
    assert "_" not in title.replace("$_", "")


ONE_TEXT = {
    "variables": lambda system: linkages.simulate_batch(system, "joints.B.clearance", [[1e-4]]),
    "outputs": lambda system: linkages.simulate_batch(system, outputs="B.force"),
    "wrt": lambda system: linkages.simulate(system, wrt="joints.B.clearance"),
    "names": lambda system: linkages.stroboscopic(system, "B.force", 1),
}


@pytest.mark.parametrize("argument", ONE_TEXT)
def test_one_text_is_no_list_of_names(argument):
    system = load(find_file("slider_crank_lubricated.toml"))
    with pytest.raises(InputError, match=rf"^argument: {argument}: is a text; give a list: \[\""):
        ONE_TEXT[argument](system)


def test_a_long_list_of_names_is_replaced_by_the_closest_their_number_and_the_place_of_the_list(tmp_path, capsys):
    """An unknown output of a machine with some hundred, in the command line of a run and of stored ones."""
    out = tmp_path / "out"
    few = ["--duration", "1e-3", "--no-plots", "--no-animation", "--no-error-estimate", "--out", str(out)]
    assert main(["simulate", "seven_bar.toml", *few]) == 0
    count = len(linkages.load_trajectory(out / "trajectory.npz").columns)
    capsys.readouterr()
    assert main(["overlay", str(out), "--output", "NAME"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert re.fullmatch(
        rf"error: --output: NAME: is in none of the runs; the closest of {count} are (\S+, ){{4}}\S+;"
        r" `linkages keys` lists all kinds",
        line,
    )
    assert main(["overlay", str(out), "--output", "A.forc"]) == 2
    assert capsys.readouterr().err.endswith('; did you mean "A.force"?\n')
    with pytest.raises(InputError) as refused:
        linkages.simulate(linkages.load(find_file("seven_bar.toml")), "compiled", outputs=["NAME"])
    assert len(str(refused.value)) < 250
    assert str(refused.value).endswith("; `linkages keys` lists all kinds")
