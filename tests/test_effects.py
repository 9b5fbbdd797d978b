"""Values that change no number of a run are refused, with the path that does: on the command line, in studies, on the page.

As a script it tries many random values: ``python tests/test_effects.py --count 200 --machines 20 --seed 1``. Each must
change a number of the model, or be refused; a path that a refusal names must change the results of a run.
"""

import argparse
import re
import sys
import tempfile
import tomllib
import warnings
from collections import Counter
from functools import cache, partial
from pathlib import Path

import documented_machines
import numpy as np
import pytest
from shipped import NAMES, data_folder

import linkages
import optim
from linkages import AssemblyError, InputError, RunError, load
from linkages.cli.main import main
from linkages.cli.options import load_system
from linkages.engines.compiled.effects import check_varied, differ, near, varied
from linkages.input.files.described_model import KEYS
from linkages.input.files.description import described
from linkages.input.files.sdf import read_sdf
from linkages.input.files.sdf_text import sdf_text
from linkages.results.outputs.registry import names
from linkages.show.live.answers import Answers
from linkages.show.live.controls import controls
from linkages.show.live.session import Session

CRANK, ROD, SPEED = 0.05, 0.15, 20.0 * np.pi
FRAME, JOINT = "sdf.frames.crank_A.pose.x", "sdf.joints.A.pose.x"
RIG = """title = "Rig"
duration = 0.3
outputs = ["slider.ax"]
section = [0.02, 0.01]
bearing = [0.01, 0.02]
points = { O = [0, 0], A = ["O", 0.05, "ANGLE deg"], B = [SLIDER, 0] }
links.ground = "O"
links.crank = { points = "O A", mass = 0.3, inertia = 1e-4 }
links.rod = { points = "A B", mass = 0.2, inertia = 1e-3 }
links.slider = { points = "B along ground", mass = 0.5 }
drives.O.speed = "600 r/min"
"""
DRY = """
[joints.B]
model = "dry"
clearance = "0.25 mm"
contact = { law = "flores", restitution = 0.7, stiffness = 1e9, yield_strength = 3e8, youngs_modulus = 2e11 }
friction = { law = "coulomb", coefficient = 0.08, v_1 = 0.01 }
wear = { coefficient = 1e-16 }
"""


def new(folder, angle=0.0, more="", name="rig"):
    """Write the machine of a description, drawn at an angle of the crank [deg]; return its experiment's file."""
    turn = np.radians(angle)
    reach = CRANK * np.cos(turn) + np.sqrt(ROD**2 - (CRANK * np.sin(turn)) ** 2)
    text = RIG.replace("ANGLE", str(angle)).replace("SLIDER", repr(float(reach)))
    source = folder / f"{name}.machine.toml"
    source.write_text(text + more)
    assert main(["new", "--from", str(source), "--out", str(folder)]) == 0
    return folder / f"{name}.toml"


def old(folder, more=""):
    """The same as earlier versions wrote it: no joint is at a frame."""
    file = new(folder, 0.0, more)
    machine = file.with_suffix(".sdf")
    machine.write_text(sdf_text(read_sdf(machine), at_frames=False))
    return file


def acceleration(system):
    """Acceleration of the slider with the crank along the guide [m/s2]."""
    run = linkages.ideal(system.replaced({"duration": 0.1}))
    return float(run["slider.ax"].min())


# -- written files -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("angle", [0.0, 40.0])
def test_the_frame_of_a_crank_is_its_length(tmp_path, angle):
    """The slider's acceleration with the crank along the guide is -r w^2 (1 + r/l), however the machine is drawn."""
    system = load(new(tmp_path, angle))
    for length in (0.03, CRANK, 0.06):
        expected = -length * SPEED**2 * (1.0 + length / ROD)
        assert acceleration(system.replaced({FRAME: length})) == pytest.approx(expected, rel=1e-6)


def test_each_frame_of_a_written_machine_moves_a_joint(tmp_path):
    """The frames at joints have no other use; a pivot on the ground, a pin and a guide move with theirs."""
    system = load(new(tmp_path))
    for name in (frame.name for frame in system.mechanism.frames):
        ends = [_ends(system.replaced({f"sdf.frames.{name}.pose.{axis}": 0.123})) for axis in "xy"]
        assert [np.abs(end - _ends(system)).max() > 0.01 for end in ends] == [True, True], name


def _ends(system):
    return np.array([(joint.on_parent, joint.on_child) for joint in system.mechanism.joints])


URDF = """<robot name="arm"><link name="base"/>
<link name="upper"><inertial><origin xyz="0.1 0 0"/><mass value="1"/>
<inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="lower"><inertial><origin xyz="0.1 0 0"/><mass value="1"/>
<inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/><axis xyz="0 0 1"/></joint>
<joint name="elbow" type="continuous"><origin xyz="0.2 0 0"/><parent link="upper"/><child link="lower"/>
<axis xyz="0 0 1"/></joint></robot>"""


def test_an_imported_joint_is_at_a_frame_of_its_parent(tmp_path):
    (tmp_path / "arm.urdf").write_text(URDF)
    assert main(["import", str(tmp_path / "arm.urdf"), "--out", str(tmp_path / "arm.sdf")]) == 0
    longer = linkages.load_mechanism(tmp_path / "arm.sdf", {"frames.elbow_on_upper.pose.x": 0.3})
    assert longer.joint["elbow"].on_parent == pytest.approx([0.3, 0.0])
    assert longer.joint["elbow"].on_child == pytest.approx([0.2, 0.0])  # where the lower link is drawn


def test_parameters_of_a_machine_of_an_earlier_version_act(tmp_path):
    """B is drawn at 0.2 m, so that the rod becomes shorter."""
    source = tmp_path / "rig.machine.toml"
    parameter = RIG.replace("ANGLE", "0").replace("SLIDER", "0.2").replace('"O", 0.05', '"O", "r"')
    source.write_text(parameter + 'parameters.r = "50 mm"\n')
    assert main(["new", "--from", str(source), "--out", str(tmp_path)]) == 0
    keys = {key: value for key, value in tomllib.loads(source.read_text()).items() if key in KEYS}
    drawn = described(source, "rig", keys)
    (tmp_path / "rig.sdf").write_text(sdf_text(drawn.model, (), drawn.text, at_frames=False))
    expected = -0.06 * SPEED**2 * (1.0 + 0.06 / 0.14)
    assert acceleration(load(tmp_path / "rig.toml", {"sdf.parameters.r": 0.06})) == pytest.approx(expected, rel=1e-6)


# -- refusals ----------------------------------------------------------------------------------------------------------

REFUSED = rf"changes no number of the model: only the drawing uses it; the place of joint A is {re.escape(JOINT)}$"
COMMANDS = {
    "simulate": ["--set", f"{FRAME}=0.06"],
    "simulate --ideal": ["--ideal", "--set", f"{FRAME}=0.06"],
    "play": ["--no-browser", "--set", f"{FRAME}=0.06"],
    "sweep": ["--vary", f"{FRAME}=0.04:0.06:3"],
    "sweep of two": ["--vary", "drives.O.speed=10:20:2", "--vary", f"{FRAME}=0.04:0.06:3"],
    "continue": ["--vary", f"{FRAME}=0.04:0.06"],
    "sensitivity": ["--wrt", FRAME],
}


@pytest.mark.parametrize("command", COMMANDS)
def test_a_length_of_the_drawing_alone_is_refused_with_the_place_of_the_joint(command, tmp_path, capsys):
    file = old(tmp_path, DRY)
    assert main([command.split()[0], str(file), *COMMANDS[command], *_out(command, tmp_path)]) == 2
    error = capsys.readouterr().err.strip().splitlines()[-1]
    assert re.search(f"{re.escape(FRAME)}: {REFUSED}", error), error


def _out(command, folder):
    return ["--out", str(folder)] if command == "play" else ["--out", str(folder / "out")]


def test_the_path_that_a_refusal_names_is_right(tmp_path):
    """As the closed form says for a crank of 60 mm; the joint moves on both links, so that the rod has 140 mm."""
    expected = -0.06 * SPEED**2 * (1.0 + 0.06 / 0.14)
    assert acceleration(load(old(tmp_path), {JOINT: 0.06})) == pytest.approx(expected, rel=1e-6)


STUDY = """experiment = "rig.toml"
[variables.crank]
path = "sdf.frames.crank_A.pose.x"
lower = 0.04
upper = 0.06
[objectives.force]
terms = [{ output = "slider.ax", functional = "max" }]
[algorithm]
name = "ga"
"""
FIT = """experiment = "rig.toml"
[unknowns.crank]
path = "sdf.frames.crank_A.pose.x"
lower = 0.04
upper = 0.06
[data.run]
file = "data.csv"
columns = { a = { output = "slider.ax", deviation = 1.0 } }
"""


@pytest.mark.parametrize(("reader", "text"), [(optim.load_study, STUDY), (optim.load_identification, FIT)])
def test_studies_and_identification_refuse_it_too(reader, text, tmp_path):
    old(tmp_path, DRY)
    (tmp_path / "data.csv").write_text("time,a\n" + "".join(f"{0.01 * k},{k}\n" for k in range(20)))
    (tmp_path / "mine.toml").write_text(text)
    with pytest.raises(InputError, match=rf"^mine\.toml: \w+\.crank\.path: {re.escape(FRAME)} {REFUSED}"):
        reader(tmp_path / "mine.toml")


CALLS = {
    "a batch": lambda system: linkages.simulate_batch(system, [FRAME], [[0.04], [0.06]]),
    "a batch of one run": lambda system: linkages.simulate_batch(system, [FRAME], [[0.05]]),
    "derivatives of a batch": lambda system: linkages.simulate_batch(system, wrt=[FRAME]),
    "derivatives of a run": lambda system: linkages.simulate(system, outputs=["slider.ax"], wrt=[FRAME]),
    "a direction": lambda system: linkages.simulate(system, wrt=[linkages.Direction("r", 0.05, {FRAME: 1.0})]),
    "sensitivities": lambda system: linkages.sensitivities(system, [FRAME], ["slider.ax"]),
    "a sweep": lambda system: linkages.sweep(system, FRAME, [0.04, 0.06], ["slider.ax"], 1),
    "a grid": lambda system: linkages.sweep_grid(
        system, "drives.O.speed", [10.0, 20.0], FRAME, [0.04, 0.06], ["slider.ax"], 1
    ),
}


@pytest.mark.parametrize("call", CALLS)
def test_functions_refuse_it_as_commands_do(call, tmp_path):
    system = load(old(tmp_path, DRY))
    with pytest.raises(InputError, match=REFUSED):
        CALLS[call](system)


def test_a_batch_may_keep_a_value_that_acts(tmp_path):
    batch = linkages.simulate_batch(load(old(tmp_path), {"duration": 0.01}), [JOINT], [[CRANK]], ["slider.ax"])
    assert batch.status == [linkages.Status.OK]


ALLOWED = {  # other commands read them, they say how a run is made, or they are as before
    "the wear": "joints.B.wear.coefficient=2e-16",
    "a warning's limit": "joints.B.contact.yield_strength=4e8",
    "the accuracy": "solver.accuracy=1e-8",
    "the shown part": "report_from=0.1",
    "the present value": f"{FRAME}=0.05",
    "the present model": "joints.B.model=dry",
}


@pytest.mark.parametrize("case", ALLOWED)
def test_what_acts_elsewhere_is_no_value_without_effect(case, tmp_path):
    options = argparse.Namespace(file=str(old(tmp_path, DRY)), set=[ALLOWED[case]])
    assert load_system(options).experiment.title == "Rig"


IDLE = {
    "sdf.links.rod.com.z": "it is across the plane of motion",
    "sdf.joints.A.bearing.radius": "joint A is ideal; give it a clearance with joints.A.model",
    "joints.B.friction.bristle_stiffness": "the model and the laws of joint B do not use it",
    "sdf.joints.A.pose.yaw": "a revolute joint has no direction in the plane",
    "sdf.links.rod.pose.yaw": "it moves the reference configuration only; the place of joint A is"
    " sdf.joints.A.pose.x and of joint B is sdf.frames.rod_B.pose.x",
    "sdf.joints.slider_guide.pose.yaw": "its direction belongs to a frame; "
    "sdf.frames.slider_guide_on_world.pose.yaw turns it",
}


@pytest.mark.parametrize("path", IDLE)
def test_each_refusal_has_its_reason(path, tmp_path):
    system = load(new(tmp_path, 0.0, DRY))
    value = system.value(path)
    assert varied(system, path, [value, value + 0.01]) == f"changes no number of the model: {IDLE[path]}"


def test_segments_of_a_rigid_link_are_no_number_of_drake_either(tmp_path):
    options = argparse.Namespace(file=str(new(tmp_path)), set=["links.rod.segments=9"])
    with pytest.raises(InputError, match=r'link rod is rigid; give links\.rod\.model = "flexible"'):
        load_system(options)


def test_the_key_of_a_refused_number_is_the_one_in_the_file(tmp_path):
    """Not the type that the number failed to be, where a key takes numbers and texts."""
    new(tmp_path)
    (tmp_path / "mine.toml").write_text(FIT.replace("deviation = 1.0", "deviation = 0.0"))
    with pytest.raises(
        InputError, match=r"^mine\.toml: data\.run\.columns\.a\.deviation: is 0\.0; it should be greater"
    ):
        optim.load_identification(tmp_path / "mine.toml")


def test_the_direction_of_an_output_counts(tmp_path):
    """A frame's own angle changes nothing but an output that asks for it."""
    system, path = load(new(tmp_path)), "sdf.frames.crank_A.pose.yaw"
    assert varied(system, path, [0.0, 0.1])
    assert not varied(system, path, [0.0, 0.1], ["crank_A.angle"])


LAW = 'contact = { law = "flores", restitution = 0.7, stiffness = 1e6 }'
#: Part -> its table, and a value that turns the reference configuration or a frame.
COUNTING = {
    "a torque over a coordinate": (
        '[torques.T]\njoint = "A"\nover = "A.coordinate"\nat = [-9, 9]\ntorques = [-1, 1]\n',
        "sdf.links.rod.pose.yaw",
    ),
    "a torque by a formula": ('[torques.T]\njoint = "A"\nformula = "-0.5*rod.angle"\n', "sdf.links.rod.pose.yaw"),
    "a force in axes of a frame": (
        '[forces.F]\npoint = "rod_B"\naxes = "body"\nforce = [1.0, 2.0]\n',
        "sdf.frames.rod_B.pose.yaw",
    ),
    "a line on a link": (f'[contacts.C]\npoint = "slider"\nline = "rod_B"\n{LAW}\n', "sdf.frames.rod_B.pose.yaw"),
}


@pytest.mark.parametrize("part", COUNTING)
def test_what_counts_from_the_reference_configuration_is_changed_with_it(part, tmp_path):
    text, path = COUNTING[part]
    file = new(tmp_path)
    file.write_text(f"{file.read_text()}\n{text}")
    assert not varied(load(file), path, [0.0, 0.1])


def test_the_page_refuses_it_until_it_is_changed_back(tmp_path):
    system = load(old(tmp_path, DRY))
    answers = Answers(Session(system), controls(system), tmp_path)
    refused = answers.answer("run", {"values": {FRAME: 0.06}})
    assert (refused["path"], refused["problem"][:30]) == (FRAME, "changes no number of the model")
    assert "error" in answers.answer("run", {"values": {FRAME: 0.06, "drives.O.speed": 60.0}})
    assert "error" not in answers.answer("run", {"values": {"drives.O.speed": 60.0}})


def test_the_page_allows_a_model_that_leaves_a_changed_value_idle(tmp_path):
    system = load(new(tmp_path, 0.0, DRY))
    answers = Answers(Session(system), controls(system), tmp_path)
    values = {"joints.B.clearance": 3e-4}
    assert "error" not in answers.answer("run", {"values": values})
    assert "error" not in answers.answer("run", {"values": values | {"joints.B.model": "ideal"}})


# -- random values -----------------------------------------------------------------------------------------------------

_SHORT = 0.05  # duration of a run that shows the effect of a value, at most [s]


@cache
def machines(count):
    """Load shipped machines and those of the documentation's descriptions."""
    found = [load(data_folder() / f"{name}.toml") for name in NAMES]
    for k, text in enumerate(documented_machines.MACHINES.values()):
        folder = Path(tempfile.mkdtemp(prefix="effects-"))
        (folder / f"made{k}.machine.toml").write_text(text)
        main(["new", "--from", str(folder / f"made{k}.machine.toml"), "--out", str(folder)])
        found.append(load(folder / f"made{k}.toml"))
    order = np.random.default_rng(0).permutation(len(found))
    return [found[k] for k in order[:count]]


@cache
def results(system):
    """Outputs of a short run, and of the ideal motion."""
    short = min(system.experiment.duration, _SHORT)
    shown = [name for name in names(system) if not name.startswith("q.")]
    found = {}
    for kind, run in (("run", partial(linkages.simulate, outputs=shown)), ("ideal", linkages.ideal)):
        try:
            done = run(system.replaced({"duration": short}))
        except (AssemblyError, RunError) as problem:
            found[kind] = str(problem)
            continue
        found |= {f"{kind} {name}": done[name][[0, -1]] for name in done.columns if name in shown}
    return found


def same_results(one, other, places=False):
    """Whether all outputs of two systems are the same, but for rounding.

    Of `places` the ideal motion and the start of the run count: rounding grows in runs with contact.
    """
    first, second = results(one), results(other)
    if first.keys() != second.keys():
        return False
    largest = {}  # of outputs of one quantity
    for key, values in first.items():
        if not isinstance(values, str):
            kind = key.rpartition(".")[2]
            largest[kind] = max(largest.get(kind, 0.0), float(np.nanmax(np.abs(values), initial=0.0)))
    for key, values in first.items():
        if isinstance(values, str):
            same = values == second[key]
        else:
            seen, error = (slice(1), 1e-6) if places and key.startswith("run") else (slice(None), 1e-9)
            limit = error * largest[key.rpartition(".")[2]] + 1e-9
            same = np.allclose(values[seen], second[key][seen], rtol=error, atol=limit, equal_nan=True)
        if not same:
            return False
    return True


def trial(number, seed, count):
    """Give a random value by one of three ways, and return how that ends."""
    dice = np.random.default_rng([number, seed])
    system = machines(count)[dice.integers(count)]
    known = [one for one in controls(system).values() if not one.choices and one.value is not None]
    known = [one for one in known if one.path.partition(".")[0] not in ("solver", "duration", "report_from")]
    control = known[dice.integers(len(known))]
    path, way = control.path, ("set", "vary", "page")[number % 3]
    scale = abs(control.value) or (0.1 * system.tree.extent if control.unit == "m" else 0.1)
    value = control.value + (1 if control.whole else float(dice.uniform(0.02, 0.2) * scale * dice.choice([-1, 1])))
    try:
        changed = system.replaced({path: value})
        _ = changed.assembly
    except (InputError, AssemblyError):
        return "is no valid value"
    try:
        _give(system, path, value, way)
    except InputError as problem:
        return _refused(system, changed, path, str(problem))
    if not same_results(system, changed):
        return "changes results"
    return "changes numbers of the model" if differ(system, changed) else f"FAULT {path}: {way} accepts it"


def _give(system, path, value, way):
    if way == "set":
        load_system(argparse.Namespace(file=str(system.experiment.source), set=[f"{path}={value!r}"]))
    elif way == "vary":
        check_varied(system, path, [system.value(path), value], "--vary")
    else:
        answers = Answers(Session(system, 5.0, 5.0), controls(system), Path())
        reply = answers.answer("run", {"values": {path: value}})
        if "no number of the model" in reply.get("error", ""):
            raise InputError("page", path, reply["problem"])


def _refused(system, changed, path, said):
    """Check a refusal: the value changes no result, and paths that it names do."""
    if "changes no number of the model" not in said:
        return f"FAULT {path}: {said}"
    owner = path.split(".")[2] if path.startswith("sdf.frames.") else ""
    asked = {name.rpartition(".")[0] for name in system.experiment.outputs}
    if not same_results(system, changed, path.startswith("sdf.")) and (not owner or owner in asked):
        return f"FAULT {path} changes results, but: {said}"
    named = [word.rstrip(",;.") for word in said.partition("model: ")[2].split() if word.startswith("sdf.")]
    for other in named:
        if not differ(system, system.replaced({other: near(system, other)[1]})):
            return f"FAULT {path}: {other} changes nothing either"
    for joint in re.findall(r"joints\.(\S+)\.model", said):
        if joint in system.experiment.play:
            return f"FAULT {path}: {joint} has a model"
    return "is refused with the path that acts" if named or ".model" in said else "is refused: no path acts"


@pytest.mark.slow
def test_random_values_change_a_number_or_are_refused():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of implausible values
        ends = Counter(trial(number, 1, 12) for number in range(30))
    assert not [end for end in ends if end.startswith("FAULT")], ends
    assert ends["changes results"] > 5
    assert sum(count for end, count in ends.items() if end.startswith("is refused")) > 3


def script() -> int:
    """Try many random values; prints how they end, and returns 1 if any has no effect and is accepted."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=200, help="default: %(default)s")
    parser.add_argument("--machines", type=int, default=20, help="default: %(default)s")
    parser.add_argument("--seed", type=int, default=1, help="default: %(default)s")
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    ends = Counter()
    for number in range(options.count):
        end = trial(number, options.seed, options.machines)
        ends[end] += 1
        if end.startswith("FAULT"):
            print(number, end, flush=True)
    print(f"{options.count} values of {len(machines(options.machines))} machines, seed {options.seed}")
    for text, count in sorted(ends.items()):
        print(f"{count:6d}  {text}")
    return int(any(end.startswith("FAULT") for end in ends))


if __name__ == "__main__":
    sys.exit(script())
