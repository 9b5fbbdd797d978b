"""Mechanisms described in a few lines, as in the documentation: geometry, mass, mobility; values with units."""

import re
from math import atan2, cos, hypot, pi, radians, sin, sqrt
from pathlib import Path

import documented_machines
import numpy as np
import pytest
from machines import four_bar, slider_crank

import linkages
from linkages import InputError, find_file, load
from linkages.cli.main import main
from linkages.cli.options import seconds
from linkages.cli.sweep import parse_range
from linkages.input.files.description import described
from linkages.input.files.drafting import body
from linkages.input.files.formula import parse
from linkages.input.files.unit_conversion import si, without_units

TEXTS = {title.split()[0]: text for title, text in documented_machines.MACHINES.items()}
MACHINES = {"Quick": (5, 7), "Leg": (7, 10), "Scissor": (15, 22), "Six-bar": (5, 7), "Toggle": (5, 7)}
SIMPLE = """duration = 1.0
section = [0.02, 0.01]
density = 7850.0
parameters = { a = "100 mm" }
links = { ground = "O", bar = "O A" }
points = { O = [0, 0], A = ["O", "a", 0] }
"""


@pytest.fixture
def made(tmp_path, capsys):
    """Makes a machine of a description; returns its experiment's file."""

    def make(text, name="made"):
        source = tmp_path / f"{name}.machine.toml"
        source.write_text(text, encoding="utf-8")
        assert main(["new", "--from", str(source), "--out", str(tmp_path)]) == 0, capsys.readouterr().err
        return tmp_path / f"{name}.toml"

    return make


@pytest.mark.parametrize(
    ("com", "place"), [("", (0.05, 0.0)), ('com = "O", ', (0.0, 0.0)), ('com = ["a/4", "-1 mm"], ', (0.025, -1e-3))]
)
def test_a_link_has_the_mass_centre_of_its_key(made, com, place):
    """Without the key the centre is midway between the points; parameters move it, the moment is about the centre."""
    table = f'{{ points = "O A", {com}mass = "12 kg", inertia = "0.2 kg m2" }}'
    file = made(SIMPLE.replace('bar = "O A"', f"bar = {table}"))
    bar = load(file).mechanism.link["bar"]
    assert bar.com == pytest.approx(place, abs=1e-15)
    assert (bar.mass, bar.inertia) == (12.0, pytest.approx(0.2))
    longer = load(file, {"sdf.parameters.a": 0.2}).mechanism.link["bar"]
    assert longer.com == pytest.approx((2.0 * place[0], place[1]), abs=1e-15)


def test_a_wheel_on_its_shaft_loads_it_by_its_weight_alone(made):
    """40 kg at 1,500 r/min about the centre: m g = 392 N; the centre 20 mm aside would pull with 19.7 kN."""
    text = SIMPLE.replace('bar = "O A"', 'bar = { points = "O A", com = "O", mass = 40.0, inertia = 0.5 }')
    file = made(
        'drives = { O = { speed = "1500 r/min" } }\ngravity = [0.0, -9.81, 0.0]\n' + text.replace("1.0", "0.1", 1)
    )
    force = linkages.ideal(load(file))["O.force"]
    np.testing.assert_allclose(force, 40.0 * 9.81, rtol=1e-9)


@pytest.mark.parametrize(
    ("com", "problem"),
    [
        ('"Q"', 'links.bar.com: there is no point "Q"; known are: A, O'),
        ("3.0", 'links.bar.com: is 3.0; give a point, such as "O", or [x, y]'),
        ('["1 kg", 0]', 'links.bar.com: is "1 kg"; it must be measured in m'),
        ('"O", beam = { youngs_modulus = 2e11 }', "links.bar.com: cannot be given with a beam, which determines it"),
    ],
)
def test_a_wrong_mass_centre_is_refused_in_one_line(tmp_path, capsys, com, problem):
    source = tmp_path / "m.machine.toml"
    source.write_text(SIMPLE.replace('bar = "O A"', f'bar = {{ points = "O A", com = {com} }}'))
    assert main(["new", "--from", str(source), "--out", str(tmp_path)]) == 2
    said = capsys.readouterr().err
    assert problem in said
    assert said.count("\n") == 1


@pytest.mark.parametrize("title", MACHINES)
def test_the_machines_of_the_page_have_one_degree_of_freedom_and_close_as_drawn(title, made):
    """Gruebler's count: 3 for each link, less 2 for each pin or guide."""
    system = load(made(TEXTS[title]))
    links, joints = MACHINES[title]
    assert (len(system.mechanism.links), len(system.mechanism.joints)) == (links, joints)
    assert 3 * links - 2 * joints == system.assembly.mobility == 1
    gaps = [joint.on_parent - joint.on_child for joint in system.mechanism.joints]
    assert np.abs(gaps).max() < 1e-12
    assert np.abs(system.assembly.q).max() < 1e-9  # nothing to close
    lines = [
        line for line in TEXTS[title].splitlines() if not re.match("title|duration|outputs|drives|gravity|forces", line)
    ]
    assert len(lines) <= 15


def test_a_scissor_lift_rises_as_pythagoras_says(made):
    system = load(made(TEXTS["Scissor"]), {"duration": 2.0})
    motion = linkages.ideal(system)
    foot = 0.6 * cos(radians(20)) - 0.05 * motion.time
    assert np.allclose(motion["platform.y"], 6 * np.sqrt(0.36 - foot**2), atol=1e-9)


def test_a_quick_return_moves_as_its_lever_points(made):
    motion = linkages.ideal(load(made(TEXTS["Quick"])))
    crank = radians(30) + pi * motion.time
    lever = np.arctan2(0.2 + 0.08 * np.sin(crank), 0.08 * np.cos(crank))
    assert np.allclose(
        motion["ram.x"], 0.45 * np.cos(lever) + np.sqrt(0.18**2 - (0.44 - 0.45 * np.sin(lever)) ** 2), atol=1e-9
    )


def test_a_leg_has_the_lengths_that_are_published(made):
    """Jansen's eleven bars, in mm."""
    mechanism = load(made(TEXTS["Leg"])).mechanism
    pins = {joint.name: joint.on_child for joint in mechanism.joints}
    pins |= {name: mechanism.point[name].origin for name in ("toe",)}
    bars = {"OA": 15, "AC": 50, "BC": 41.5, "BD": 40.1, "CD": 55.8, "AE": 61.9, "BE": 39.3, "DF": 39.4, "EF": 36.7}
    for (first, second), length in bars.items():
        assert hypot(*(pins[first] - pins[second])) == pytest.approx(length * 1e-3)
    assert hypot(*(pins["E"] - pins["toe"])) == pytest.approx(0.049)
    assert pins["toe"][1] < pins["E"][1] < pins["B"][1] < pins["C"][1]  # the toe is lowest


def test_a_triangle_of_bars_weighs_what_a_triangle_of_bars_weighs():
    """Three bars of mass m and length a: m a^2 / 2 about the middle, and the width of the bars; polar = sum of both."""
    corners = np.array([[0.0, 0.0], [0.3, 0.0], [0.15, 0.3 * sqrt(0.75)]])
    found, part = body(corners, 0.0, (0.02, 0.01), 7850.0), 7850.0 * 0.02 * 0.01 * 0.3
    assert found.mass == pytest.approx(3 * part)
    assert np.allclose(found.centre, corners.mean(axis=0))
    assert found.inertia[2, 2] == pytest.approx(part * 0.3**2 / 2 + 3 * part * 0.02**2 / 12)
    assert found.inertia[0, 0] == pytest.approx(found.inertia[1, 1])  # no axis is preferred
    block = body(corners[:1], 0.7, (0.02, 0.01), 7850.0)
    assert block.inertia[2, 2] == pytest.approx(block.mass * (0.04**2 + 0.02**2) / 12)


def test_lengths_and_masses_follow_a_parameter(made):
    file = made(TEXTS["Quick"])
    longer = load(file, {"sdf.parameters.R": "500 mm"})
    anew = load(made(TEXTS["Quick"].replace('R = "450 mm"', 'R = "500 mm"'), "anew"))
    assert longer.value("sdf.parameters.R") == 0.5
    with pytest.raises(InputError, match=r'sdf\.parameters\.R: is "0.5 kg"; it must be measured in m'):
        load(file, {"sdf.parameters.R": "0.5 kg"})
    assert longer.value("sdf.links.lever.mass") == pytest.approx(7850 * 0.03 * 0.012 * 0.5)
    assert longer.mechanism.values == anew.mechanism.values
    assert load(file).value("sdf.links.lever.mass") == pytest.approx(7850 * 0.03 * 0.012 * 0.45)
    assert longer.replaced({"sdf.links.lever.mass": 2.0}).value("sdf.parameters.R") == 0.5


def test_links_keep_their_order(made):
    """A link with its own values comes before others in the file: its joints and the parameters stay the same."""
    text = SIMPLE.replace('bar = "O A"', 'bar = { points = "O A", mass = 0.3 }, tail = "A P"')
    other = load(made(text.replace("points = { ", "points = { P = [1, 1], ")), {"sdf.parameters.a": 0.2})
    assert [link.name for link in other.mechanism.links] == ["bar", "tail"]
    assert other.mechanism.joint["A"].parent == "bar"


def test_ranges_of_a_parameter_are_in_a_unit_of_its_kind(made, tmp_path, capsys):
    """The commands, studies and identifications ask the machine for the unit, as a replaced value does."""
    file = made(TEXTS["Quick"])
    path, values = parse_range("sdf.parameters.R=450 mm:480 mm:4", load(file))
    assert (path, values) == ("sdf.parameters.R", pytest.approx([0.45, 0.46, 0.47, 0.48]))
    assert load(file).value_unit("sdf.parameters.R") == "m"
    bound = 'path = "sdf.parameters.R"\nlower = "400 s"\nupper = "500 s"\n'
    study = f'experiment = "{file.name}"\nalgorithm = {{ name = "ga" }}\n[variables.R]\n{bound}[objectives.x]\n'
    (tmp_path / "study.toml").write_text(f'{study}terms = [{{ output = "ram.x", functional = "peak" }}]\n')
    (tmp_path / "fit.toml").write_text(f'experiment = "{file.name}"\n[unknowns.R]\n{bound}')
    out = ["--out", str(tmp_path / "out")]
    for words in (
        ["sweep", str(file), "--vary", "sdf.parameters.R=400 s:500 s:3"],
        ["continue", str(file), "--vary", "sdf.parameters.R=400 s:500 s"],
        ["optimise", str(tmp_path / "study.toml")],
        ["identify", str(tmp_path / "fit.toml"), "--plan"],
    ):
        assert main([*words, *out]) == 2
        error = capsys.readouterr().err
        assert 'is "400 s"; it must be measured in m' in error, words
        assert error.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_a_machine_that_was_edited_takes_no_other_parameters(made):
    file = made(SIMPLE)
    machine = file.with_suffix(".sdf")
    machine.write_text(machine.read_text().replace("<mass>", "<mass>1"))
    assert load(file).value("sdf.parameters.a") == 0.1
    with pytest.raises(InputError, match="no longer agrees with its description"):
        load(file, {"sdf.parameters.a": 0.2})


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ('a = "100 mm"', 'a = "2*b", b = "a"', "depends on itself"),
        ('a = "100 mm"', 'a = "2 a"', r'parameters\.a: "2 a" is a quantity, or lacks a \*'),
        ('"100 mm"', '"100 blah"', 'the unit "blah" is unknown'),
        ("bar =", "sin =", "cannot be a name"),
        ('bar = "O A"', 'bar = "O B"', r'there is no point "B"'),
        ('bar = "O A"', 'bar = "O"', r"points\.A: is on no link"),
        ('bar = "O A"', 'bar = "O A along rail"', 'there is no link "rail"'),
        ('["O", "a", 0]', '["O", "a", "O", 0.05]', "no point is 0.1 m from O and 0.05 m from O"),
        ('["O", "a", 0]', '["A", "a", 0]', "depends on itself"),
        ('["O", "a", 0]', '["O"]', r"give \[x, y\]"),
        ("density = 7850.0\n", "", "has no mass; give density"),
        ("[0.02, 0.01]", "[0.02, -0.01]", "section: is -0.01; it must be positive"),
        ('ground = "O", ', "", 'has no "ground"'),
        ("duration = 1.0\n", "", "duration: is missing"),
        ("duration", "duratoin", 'did you mean "duration"'),
        ("density", "desnity", "desnity: unknown key"),
        ('O = [0, 0]', '"O{k=2..1}" = [0, 0]', "must count upwards"),
        ('"a", 0]', '"a", 40]', r'points\.A: the angle 40 has no unit; write "40 deg" or "40 rad"'),
        ('"a", 0]', '"a", "-40.5"]', r'points\.A: the angle -40.5 has no unit; write "-40.5 deg" or "-40.5 rad"'),
        ('"a", 0]', '"a", "30 deg + 40"]', r"points\.A: the angle 30 deg \+ 40 has no unit"),
        ('"a", 0]', '"a", "sin(30 deg)"]', r"points\.A: the angle sin\(30 deg\) has no unit"),
        ('"a", 0]', '"a", "a"]', r"points\.A: the angle a has no unit"),
        ('"a", 0]', '"a", "40 mm"]', r'points\.A: the angle is "40 mm"; it must be measured in rad or deg'),
        ('bar = "O A"', 'bar = "O A", b = "A along bar at 40"', r'links\.b: the angle 40 has no unit'),
        ('"100 mm"', '"a990", a0 = 0.1, "a{k=1..990}" = "a{k-1}"', "refer to each other in a chain"),
        ('"a", 0]', '"30 deg", 0]', r'points\.A: is "30 deg"; it must be measured in m'),
        ("[0.02, 0.01]", '["2 kg", 0.01]', r'section: is "2 kg"; it must be measured in m'),
        ("7850.0", '"7850 kg"', r'density: is "7850 kg"; it must be measured in kg/m3'),
        ('"a", 0]', '"a/2 mm", 0]', r'points\.A: "a/2 mm" can be read in two ways'),
        ('"a", 0]', '"5 mm**2", 0]', r'points\.A: "5 mm\*\*2" can be read in two ways'),
        ('O = [0, 0]', 'O = [0, 0], "B{k=0..1}" = ["{1/k}", 0]', "has no finite value for k = 0"),
    ],
)  # fmt: skip
def test_a_wrong_description_gets_one_line(old, new, problem, tmp_path, capsys):
    assert old in SIMPLE
    source = tmp_path / "wrong.toml"
    source.write_text(SIMPLE.replace(old, new))
    assert main(["new", "made", "--from", str(source), "--out", str(tmp_path)]) == 2
    error = capsys.readouterr().err.strip()
    assert error.startswith("error: wrong.toml: ")
    assert re.search(problem, error)
    assert "\n" not in error
    assert [*tmp_path.iterdir()] == [source]


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [("0.1 mm", "m", 1e-4), ("300 r/min", "rad/s", 10 * pi), ("300 rpm", "rad/s", 10 * pi), ("30°", "rad", pi / 6),
     ("7.85 g/cm3", "kg/m3", 7850.0), ("-9.81 m/s2", "m/s2", -9.81), ("207 GPa", "Pa", 2.07e11), ("2 N mm", "N m", 2e-3),
     ("1e-3 mm3/N/m", "m2/N", 1e-12), ("313.15 K", "degC", 40.0), ("46 cSt", "mm2/s", 46.0)],
)  # fmt: skip
def test_units_are_those_of_the_si_brochure_and_the_workshop(text, unit, value):
    assert si(text, unit) == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize(
    ("text", "unit"), [("50 Hz", "rad/s"), ("3 kg", "m"), ("2 N", "N m"), ("1 blah", "m"), ("1 m/", "m")]
)
def test_a_unit_of_another_kind_is_refused(text, unit):
    with pytest.raises(ValueError, match=r"must be measured in|is unknown|give a number"):
        si(text, unit)


@pytest.mark.parametrize(
    ("text", "value"),
    [("1/2 mm", 0.5e-3), ("100 mm - 1/4 mm", 99.75e-3), ("2*1/2 mm", 1e-3), ("-3/4 mm", -0.75e-3), ("5 mm/2", 2.5e-3),
     ("a/(5 mm)", 20.0), ("(5 mm)**2", 25e-6), ("3 1/mm", 3000.0)],
)  # fmt: skip
def test_a_fraction_is_a_number_before_its_unit(text, value):
    """As the SI brochure has it: the value of a quantity is a number times a unit."""
    assert parse(without_units(text, {"a"}))({"a": 0.1}) == pytest.approx(value, rel=1e-14)


def test_a_fraction_is_a_number_in_experiments_too(experiment_file):
    assert load(experiment_file(four_bar(), 'duration = "1/4 s"\n')).experiment.duration == 0.25
    assert si("1/3 mm", "m") == pytest.approx(1e-3 / 3.0, rel=1e-15)
    with pytest.raises(ValueError, match="divided by 0"):
        si("1/0 mm", "m")


@pytest.mark.parametrize(
    ("formula", "value"),
    [("{k*0.123456789}", 1000001 * 0.123456789), ("{k}", 1000001.0), ("{k/3} mm", 1000001 / 3000.0),
     ("{k-1000002}**2", 1.0), ("{k - 1e6 - 1.5} * 2", -1.0), ("{k*1e12}", 1000001e12)],
)  # fmt: skip
def test_a_counted_number_keeps_all_its_digits(formula, value):
    points = {"O": [0, 0], "P{k=1000001..1000001}": [formula, 0]}
    data = {"section": [0.02, 0.01], "points": points, "links": {"ground": "O", "bar": "O P1000001"}, "density": 1.0}
    drawn = described(Path("m.toml"), "m", data)
    place = drawn.model.frames["P1000001"][1].translation
    assert place[0] == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize(
    ("angle", "value"),
    [("40 deg", radians(40)), ("0.7 rad", 0.7), ("0", 0.0), ("asin(0.5)", pi / 6), ("2*pi/7", 2 * pi / 7),
     ("phi", radians(20)), ("3*phi - 30 deg", radians(30)), ("(a/0.2)*1 rad", 0.5), ("-atan2(1, 2)", -atan2(1, 2)),
     ("max(phi, 0.1 rad)", radians(20))],
)  # fmt: skip
def test_an_angle_is_a_quantity_or_follows_from_angles(angle, value, made):
    """The angle of a point and of a slider's way; the machine's file keeps it, whatever parameters it then has."""
    text = SIMPLE.replace('a = "100 mm"', 'a = "100 mm", phi = "20 deg"').replace('"a", 0]', f'"a", "{angle}"]')
    file = made(text.replace('bar = "O A"', f'bar = "O A", block = "A along ground at {angle}"'))
    for length in (0.1, 0.2) if "a/" not in angle else (0.1,):
        mechanism = load(file, {"sdf.parameters.a": length}).mechanism
        assert mechanism.link["bar"].angle == pytest.approx(value, abs=1e-15)
        assert mechanism.joint["A"].on_parent == pytest.approx([length * cos(value), length * sin(value)], abs=1e-15)
        assert mechanism.joint["block_guide"].direction == pytest.approx([cos(value), sin(value)], abs=1e-15)


def test_values_of_experiments_have_units(experiment_file):
    text = 'duration = "20 ms"\ngravity = [0, "-981 cm/s2", 0.0]\n[drives.O]\nspeed = "300 r/min"\nangle = "30 deg"\n'
    system = load(experiment_file(four_bar(), text), {"sdf.links.crank.mass": "250 g", "drives.O.ramp": "5 ms"})
    experiment = system.experiment
    assert (experiment.duration, experiment.gravity) == (0.02, [0.0, pytest.approx(-9.81), 0.0])
    assert (experiment.drives["O"].speed, experiment.drives["O"].angle) == (
        pytest.approx(10 * pi),
        pytest.approx(pi / 6),
    )
    assert (system.value("sdf.links.crank.mass"), experiment.drives["O"].ramp) == (0.25, pytest.approx(0.005))
    with pytest.raises(InputError, match=r'drives\.O\.speed: is "3 m"; it must be measured in rad/s'):
        system.replaced({"drives.O.speed": "3 m"})
    with pytest.raises(InputError, match=r'sdf\.links\.crank\.mass: is "3 m"; it must be measured in kg'):
        system.replaced({"sdf.links.crank.mass": "3 m"})


def test_a_drive_is_measured_as_its_joint_moves(experiment_file):
    """A turning joint in angles, a sliding one in lengths."""
    file = experiment_file(slider_crank(offset=0.01), 'duration = 0.01\n[drives.guide]\nspeed = "-10 cm/s"\n')
    assert load(file).experiment.drives["guide"].speed == pytest.approx(-0.1)
    with pytest.raises(InputError, match=r"drives\.guide\.speed: .* must be measured in m/s"):
        load(file, {"drives.guide.speed": "3 r/s"})
    with pytest.raises(InputError, match=r"drives\.O\.speed: .* must be measured in rad/s"):
        load(file, {"drives.O.speed": "3 m/s"})


def test_values_of_the_command_line_have_units():
    path, values = parse_range("joints.A.clearance=0.1 mm:0.3 mm:3", load(find_file("seven_bar.toml")))
    assert path == "joints.A.clearance"
    assert values == pytest.approx([1e-4, 2e-4, 3e-4])
    assert seconds("20 ms") == pytest.approx(0.02)


def test_an_exponent_is_no_unit():
    """Two parts in ten thousand, and not two of e to the -4."""
    assert (seconds("2e-4"), si("2e-4 mm", "m")) == (2e-4, pytest.approx(2e-7))
    assert parse_range("joints.A.clearance=5e-5:2E-4:2", load(find_file("seven_bar.toml")))[1] == [5e-5, 2e-4]
    assert without_units("2e-4*a + 3e2 mm", {"a"}) == "2e-4*a + 0.3"


#: Described machines with 0.05 mm of clearance in A: viscosity, duration, start of the cycle [s], largest force in A, ideal and
#: with clearance [N], largest e/c. Both engines give these digits.
ROWS = (
    ("Quick", "20 mPa s", "6 s", "1.12", "12.851", "12.870", "0.973"),
    ("Leg", "10 mPa s", "5 s", "0.562", "0.03071", "0.03939", "0.934"),
    ("Six-bar", "100 mPa s", "5 s", "0.833", "4.218", "4.223", "0.868"),
    ("Toggle", "100 mPa s", "1 s", "0.177", "1046", "1047", "0.980"),
)


@pytest.mark.slow
@pytest.mark.parametrize("row", ROWS, ids=[row[0] for row in ROWS])
def test_described_machines_with_clearance_come_to_their_steady_cycle(row, made):
    name, viscosity, duration, since, ideal, peak, ratio = row
    joint = {"model": "lubricated", "clearance": "0.05 mm", "viscosity": viscosity, "film": "finite"}
    values = {"duration": duration} | {f"joints.A.{key}": value for key, value in joint.items()}
    system = load(made(TEXTS[name]), values)
    found = linkages.summarize(linkages.assess(system, "compiled", error_estimate=False))
    assert (found["motion"]["kind"], found["motion"]["periods"], found["report"]) == ("periodic", 1, "steady")
    assert found["motion"]["since"] == pytest.approx(float(since), rel=5e-3)
    cycle = found["windows"]["steady"]
    for text, value in (
        (ideal, cycle["ideal"]["joints"]["A"]["force"]["peak"]),
        (peak, cycle["joints"]["A"]["force"]["peak"]),
        (ratio, cycle["joints"]["A"]["eccentricity_ratio"]["peak"]),
    ):
        assert f"{value:.{len(text.partition('.')[2])}f}" == text


@pytest.mark.slow
@pytest.mark.parametrize("title", MACHINES)
def test_both_engines_move_the_machines_of_the_page(title, made):
    system = load(made(TEXTS[title]), {"duration": 0.1})
    exact = linkages.ideal(system)
    for engine in ("compiled", "drake"):
        run = linkages.simulate(system, engine)
        assert run.status.value == "ok"
        for name in system.experiment.outputs:
            scale = np.abs(exact[name]).max()
            assert np.interp(run.time[-1], exact.time, exact[name]) == pytest.approx(run[name][-1], abs=1e-5 * scale)
