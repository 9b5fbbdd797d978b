"""Flexible links of described machines: mass, inertia and stiffness of their beams, parameters, refusals."""

from math import pi

import pytest
from documented_machines import documented

import linkages
from linkages import load
from linkages.cli.main import main
from linkages.explore.range_of_motion import movable, travel
from linkages.show.plots.histories import forces_figure

FOUR_BAR = documented("Flexible four-bar")


@pytest.fixture
def made(tmp_path):
    """Makes a machine of a description; returns its experiment's file."""

    def make(text):
        source = tmp_path / "made.machine.toml"
        source.write_text(text, encoding="utf-8")
        assert main(["new", "--from", str(source), "--out", str(tmp_path)]) == 0
        return tmp_path / "made.toml"

    return make


#: Keys of a beam; its area [m2] and second moment of area in the plane [m4].
SECTIONS = [
    ("", 8e-3 * 6e-3, 6e-3 * 8e-3**3 / 12),  # the bars' own section: 8 mm in the plane
    (', rectangle = { width = "3 mm", height = "2*d" }', 3e-3 * 16e-3, 3e-3 * 16e-3**3 / 12),
    (', circle = { diameter = "d" }', pi * 8e-3**2 / 4, pi * 8e-3**4 / 64),
    (', tube = { outer = "d", inner = "6 mm" }', pi * (8e-3**2 - 6e-3**2) / 4, pi * (8e-3**4 - 6e-3**4) / 64),
    (', section = { area = "20 mm2", second_moment = "50 mm4", height = "5 mm" }', 20e-6, 50e-12),
]


@pytest.mark.parametrize(("keys", "area", "moment"), SECTIONS, ids=["bars", "rectangle", "circle", "tube", "section"])
def test_mass_inertia_and_stiffness_are_those_of_the_beam(made, keys, area, moment):
    """m = rho A L, J = m L2 / 12, the mass centre in the middle; w1 = (pi / L)2 sqrt(E I / (rho A)) with pinned ends."""
    text = FOUR_BAR.replace('circle = { diameter = "d" } }', f'density = "2.7 g/cm3"{keys} }}')
    system = load(made(text.replace(", density", ", density", 1).replace('GPa", , ', 'GPa", ')))
    rocker, length, density = system.mechanism.link["rocker"], 0.24, 2700.0
    mass = density * area * length
    assert rocker.mass == pytest.approx(mass, rel=1e-12)
    assert rocker.inertia == pytest.approx(mass * length**2 / 12, rel=1e-9)
    assert rocker.com_local == pytest.approx([length / 2, 0.0, 0.0], abs=1e-12)
    expected = (pi / length) ** 2 * (207e9 * moment / (density * area)) ** 0.5
    assert rocker.beam.elastic().pinned_frequency == pytest.approx(expected, rel=1e-9)
    assert list(system.experiment.deforming) == ["coupler", "rocker"]
    assert system.mechanism.link["coupler"].mass == pytest.approx(7850.0 * 8e-3 * 6e-3 * 0.28, rel=1e-12)


def test_a_beam_follows_its_parameters_and_the_link_bends(made):
    """A softer, longer coupler; the largest deflection, of the rod at rest in its shape, is half for twice the modulus."""
    text = FOUR_BAR.replace("600 r/min", "60 r/min").replace('"8 mm" }', '"8 mm", E = "207 GPa" }')
    text = text.replace(
        'coupler = { points = "A B (M)", beam = { youngs_modulus = "207 GPa"',
        'coupler = { points = "A B (M)", beam = { youngs_modulus = "E"',
    )
    system = load(made(text), {"duration": 1e-4})
    longer = system.replaced({"sdf.parameters.c": 0.29})
    assert longer.mechanism.link["coupler"].mass == pytest.approx(7850.0 * 8e-3 * 6e-3 * 0.29, rel=1e-9)
    assert longer.mechanism.link["coupler"].beam.length == pytest.approx(0.29, rel=1e-9)
    bent = [
        linkages.simulate(each, "compiled")["coupler.deflection"][0]
        for each in (system, system.replaced({"sdf.parameters.E": 414e9}))
    ]
    assert bent[0] > 1e-9
    assert bent[1] / bent[0] == pytest.approx(0.5, rel=1e-3)


REFUSED = [
    (
        'beam = { youngs_modulus = "207 GPa" }',
        'beam = { youngs_modulus = "207 mm" }',
        "links.coupler.beam.youngs_modulus",
    ),
    ('beam = { youngs_modulus = "207 GPa" }', "beam = {}", "links.coupler.beam"),
    ('beam = { youngs_modulus = "207 GPa" }', 'beam = { youngs_modulus = "-1 GPa" }', "it must be positive"),
    (
        'beam = { youngs_modulus = "207 GPa" }',
        'mass = "1 kg", beam = { youngs_modulus = "2 GPa" }',
        "links.coupler.mass",
    ),
    ('diameter = "d"', 'diameter = "d", height = "2 mm"', "links.rocker.beam.circle: has the keys"),
    ('circle = { diameter = "d" }', 'tube = { outer = "8 mm", inner = "9 mm" }', "links.rocker.beam.tube.inner"),
    ('circle = { diameter = "d" }', "poisson = 0.5", "links.rocker.beam.poisson"),
    ('circle = { diameter = "d" }', "circle = { diameter = 1 }, tube = { outer = 2, inner = 1 }", "has 2 sections"),
    (
        'circle = { diameter = "d" }',
        'points = "B A"',
        'links.rocker.beam.points: is "B A"; give two points of the link',
    ),
    ('M = ["A", "c/2", "B"]', 'M = ["A", "c/2", "0 deg"]', "links.coupler.beam: M is not on the line from A to B"),
    ('ground  = "O Q"', 'ground = { points = "O Q", beam = { youngs_modulus = 2e11 } }', "links.ground.beam"),
    (
        '"A B (M)", beam = {',
        '"A B (M)", beam = { points = "A M",',
        "links.coupler.beam: B lies 0.14 m off the beam from A to M",
    ),
]


@pytest.mark.parametrize(("old", "new", "said"), REFUSED)
def test_a_wrong_beam_is_refused_in_one_line(tmp_path, capsys, old, new, said):
    source = tmp_path / "wrong.machine.toml"
    assert old in FOUR_BAR
    source.write_text(FOUR_BAR.replace(old, new), encoding="utf-8")
    assert main(["new", "--from", str(source), "--out", str(tmp_path)]) == 2
    error = capsys.readouterr().err.strip()
    assert said in error
    assert len(error.splitlines()) == 1
    assert not (tmp_path / "wrong.sdf").exists()


def test_a_point_beside_the_beam_is_carried_by_it(made):
    """A coupler point off the line: the beam's ends are named, and the machine moves."""
    text = FOUR_BAR.replace('M = ["A", "c/2", "B"]', 'M = ["A", "c/2", "0 deg"]')
    system = load(made(text.replace("beam = { youngs", 'beam = { points = "A B", youngs', 1)), {"duration": 1e-3})
    assert linkages.simulate(system, "compiled").status is linkages.Status.OK


LEG = """duration = "0.32 s"
outputs = ["F.x"]
drives = { O = { speed = "60 r/min" } }
section = ["12 mm", "6 mm"]
density = "7850 kg/m3"
[links]
ground = "O P Q"
crank = "O A"
coupler = "A B C"
rocker = "P B"
upper = "Q D"
leg = { points = "D C F", beam = { youngs_modulus = "206 GPa", density = "7850 kg/m3" } }
[points]
O = [0, 0]
P = ["-62 mm", "-25 mm"]
Q = ["-58 mm", "60 mm"]
A = ["O", "26 mm", "20 deg"]
B = ["A", "70 mm", "P", "45 mm"]
C = ["A.x + 1.9*(B.x-A.x)", "A.y + 1.9*(B.y-A.y)"]
D = ["C", "90 mm", "Q", "85 mm"]
F = ["D.x + 2.2*(C.x-D.x)", "D.y + 2.2*(C.y-D.y)"]
"""


def test_a_dead_point_of_a_linkage_with_a_flexible_link(made):
    """Upper and leg are in line at both ends: forces and bending are unbounded; D reverses between them only."""
    system = load(made(LEG), {"solver.accuracy": 1e-4})
    study = linkages.assess(system, error_estimate=False)
    ideal = linkages.summarize(study)["ideal"]
    assert ideal["status"] == "locked"
    assert {quantity: entry["peak"] for quantity, entry in ideal["links"]["leg"].items()} == dict.fromkeys(
        ("deflection", "bending", "stress")
    )
    forces = forces_figure(study).axes[2 * list(system.joints).index("O")]  # above its difference
    assert forces.get_ylim()[1] == pytest.approx(1.1e-3 * study.run["O.force"].max())  # not the ideal force's 1e25 kN
    way = travel(movable(system.mechanism, {"O": 0.0}), "O")
    turns = next(one.turns for one in way.transmissions if one.joint == "D")
    assert len(turns) == 1
    assert turns[0] == pytest.approx(-0.446, abs=1e-3)
