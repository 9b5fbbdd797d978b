"""Links with beams: data of the file, derived mass; flexible links in experiments."""

import re

import numpy as np
import pytest
from machines import PLANES, STEEL, bar, beam, elastic_bar, joint, model

import linkages
from linkages import InputError, load_experiment, load_mechanism
from linkages.cli.main import main
from linkages.elements.flexible_link import LinkModel
from linkages.input.model.beam_interfaces import interfaces
from linkages.input.model.check import check
from linkages.mechanics.flexible.beam import Beam
from linkages.mechanics.flexible.component_modes import component_modes

LENGTH, AREA, DENSITY = 0.3, 6.4e-5, 7870.0
MASS = DENSITY * AREA * LENGTH
ROD = elastic_bar("rod", LENGTH, "crank_tip", 0.4)


def crank_and_rod(rod=ROD, plane="xy", extra=""):
    """A double pendulum whose second link has a beam."""
    links = f"{bar('crank', 0.15, '__model__')}{rod}"
    return model("pendulum", f"{links}{joint('O', 'world', 'crank')}{joint('A', 'crank_tip', 'rod')}{extra}", plane)


@pytest.mark.parametrize("plane", PLANES)
def test_a_link_with_a_beam_has_its_mass_and_drake_reads_the_same(mechanism_of, plane):
    """In every plane: of a thin rod between its ends."""
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant

    text = crank_and_rod(plane=plane)
    mechanism = mechanism_of(text)
    link = mechanism.link["rod"]
    ends = mechanism.point["rod"].origin, mechanism.point["rod_tip"].origin
    np.testing.assert_allclose([link.beam.start, link.beam.end], ends, atol=1e-15)
    assert (link.mass, link.inertia) == pytest.approx((MASS, MASS * LENGTH**2 / 12), rel=1e-12)
    np.testing.assert_allclose(link.com, np.mean(ends, axis=0), atol=1e-15)
    elastic = link.beam.elastic()
    stiffness = elastic.axial, elastic.bending, elastic.line_density
    assert stiffness == pytest.approx((1.28e7, 2e11 * 0.008**4 / 12, DENSITY * AREA), rel=1e-12)
    plant = MultibodyPlant(0.0)
    Parser(plant).AddModelsFromString(text, "sdf")
    plant.Finalize()
    inertia = plant.GetBodyByName("rod").default_spatial_inertia()
    assert inertia.get_mass() == pytest.approx(link.mass, rel=1e-12)
    about = inertia.Shift(inertia.get_com()).CalcRotationalInertia().CopyToFullMatrix3()
    np.testing.assert_allclose(about, link.inertia_local, atol=1e-12 * link.inertia)


@pytest.mark.parametrize(
    ("section", "area", "second_moment", "height"),
    [
        ({"rectangle": {"width": 0.02, "height": 0.01}}, 2e-4, 0.02 * 0.01**3 / 12, 0.01),
        ({"circle": {"diameter": 0.01}}, np.pi * 0.25e-4, np.pi * 0.01**4 / 64, 0.01),
        ({"tube": {"outer": 0.02, "inner": 0.01}}, np.pi * 0.75e-4, np.pi * (0.02**4 - 0.01**4) / 64, 0.02),
        ({"section": {"area": 1e-4, "second_moment": 3e-9, "height": 0.03}}, 1e-4, 3e-9, 0.03),
    ],
)  # fmt: skip
def test_sections_have_the_constants_of_handbooks(mechanism_of, section, area, second_moment, height):
    ((kind, sizes),) = section.items()
    inner = "".join(f"<linkages:{key}>{value}</linkages:{key}>" for key, value in sizes.items())
    written = beam("rod", "rod_tip", f"<linkages:{kind}>{inner}</linkages:{kind}>")
    found = mechanism_of(crank_and_rod(bar("rod", LENGTH, "crank_tip", mass=DENSITY * area * LENGTH, inner=written)))
    of = found.link["rod"].beam
    assert (of.area, of.second_moment, of.height) == pytest.approx((area, second_moment, height), rel=1e-12)
    for key, value in sizes.items():
        assert found.value(f"links.rod.beam.{key}") == value


def test_sections_material_and_ends_are_values_and_the_mass_follows(mechanism_of):
    text = crank_and_rod()
    changed = mechanism_of(text, {"links.rod.beam.height": 0.016, "links.rod.beam.density": 2700.0})
    link = changed.link["rod"]
    assert link.mass == pytest.approx(2700.0 * 2 * AREA * LENGTH, rel=1e-12)
    assert link.beam.second_moment == pytest.approx(8 * 0.008**4 / 12, rel=1e-12)
    assert changed.value("links.rod.mass") == link.mass
    assert link.inertia == pytest.approx(link.mass * LENGTH**2 / 12, rel=1e-12)
    longer = mechanism_of(text, {"frames.rod_tip.pose.x": 0.6, "links.rod.beam.youngs_modulus": 7e10}).link["rod"]
    assert (longer.mass, longer.beam.elastic().axial) == pytest.approx((2 * MASS, 7e10 * AREA), rel=1e-12)
    assert np.linalg.norm(longer.com - longer.origin) == pytest.approx(0.3, rel=1e-12)


@pytest.mark.parametrize("value", ["mass", "com.x", "inertia"])
def test_what_follows_from_a_beam_is_not_replaced(mechanism_of, value):
    with pytest.raises(InputError) as info:
        mechanism_of(crank_and_rod(), {f"links.rod.{value}": 0.2})
    follows = "follows from the link's beam; replace its section, its density or the positions of its ends instead"
    assert str(info.value) == f"m.sdf: sdf.links.rod.{value}: {follows}"


BAD = {
    "mass": (
        ROD.replace(f"<mass>{MASS}", "<mass>0.155"),
        "<mass> is 0.155 kg, but the mass of its <linkages:beam> is 0.151104 kg",
    ),
    "centre": (
        ROD.replace("<pose>0.15 0", "<pose>0.154 0"),
        "the mass centre is 0.004 m from the middle of its <linkages:beam>, which is at 0.15 0 0",
    ),
    "inertia": (
        re.sub("<iyy>.*</izz>", "<iyy>0.0012</iyy><izz>0.0012</izz>", ROD),
        "<inertia> is 0.0012 kg m2 about the normal, but the <linkages:beam> has 0.00113328 kg m2",
    ),
    "no section": (
        ROD.replace("linkages:rectangle", "linkages:square"),
        "<square> is unknown; known are: circle, from",
    ),
    "two sections": (
        ROD.replace("<linkages:rect", "<linkages:circle/><linkages:rect", 1),
        "has 2 sections; give one of <linkages:rectangle>",
    ),
    "no end": (re.sub("<linkages:to>.*</linkages:to>", "", ROD), "has no <linkages:to>"),
    "no material": (ROD.replace(STEEL, ""), "has no <linkages:material>"),
    "no modulus": (
        re.sub("<linkages:youngs_modulus>.*s>", "", ROD),
        "<linkages:material>: has no <linkages:youngs_modulus>; give it in Pa",
    ),
    "no prefix": (ROD.replace("linkages:width", "width"), "<linkages:rectangle>: write <linkages:width>, not <width>"),
    "negative": (ROD.replace(">7870<", ">-7870<"), "<linkages:density>: is -7870 kg/m3; it must be positive"),
    "incompressible": (ROD.replace(">0.3<", ">0.5<"), "<linkages:poisson>: is 0.5; it must be below 0.5"),
    "thick tube": (
        re.sub(
            "<linkages:rectangle>.*rectangle>",
            "<linkages:tube><linkages:outer>0.01</linkages:outer><linkages:inner>0.02</linkages:inner></linkages:tube>",
            ROD,
        ),
        "<linkages:inner>: is 0.02 m; it must be smaller than the outer one of 0.01 m",
    ),
    "one place": (ROD.replace("<linkages:to>rod_tip", "<linkages:to>rod"), 'has no length: "rod" and "rod" coincide'),
    "another link's": (
        ROD.replace("<linkages:from>rod<", "<linkages:from>crank_tip<"),
        '<linkages:from>: "crank_tip" is on "crank"; it must be a frame of "rod"',
    ),
    "no frame": (ROD.replace("<linkages:to>rod_tip", "<linkages:to>rod_top"), 'names "rod_top", which does not exist'),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_beams_are_refused_in_one_line(mechanism_of, case):
    text, problem = BAD[case]
    assert text != ROD
    with pytest.raises(InputError) as info:
        mechanism_of(crank_and_rod(text))
    assert str(info.value).startswith('m.sdf: <link name="rod">/<')
    assert problem in str(info.value)
    assert "\n" not in str(info.value)


def test_a_beam_that_leaves_the_plane_is_refused(mechanism_of):
    oblique = ROD.replace('attached_to="rod"><pose>0.3 0 0 ', 'attached_to="rod"><pose>0.29 0 0.0768 ')
    with pytest.raises(InputError, match="does not lie in the plane of motion"):
        mechanism_of(
            crank_and_rod(
                re.sub("<pose>0.15 0 0 0 0 0</pose><mass>", "<pose>0.145 0 0.0384 0 0 0</pose><mass>", oblique)
            )
        )


def test_import_keeps_beams_and_what_is_fixed_to_them_a_link_of_its_own(tmp_path):
    """A sleeve that is fixed to the rod stays; models in models give their names to the ends."""
    sleeve = (
        bar("sleeve", 0.02, "rod_tip")
        + '<joint name="F" type="fixed"><parent>rod</parent><child>sleeve</child></joint>'
    )
    source, out = tmp_path / "theirs.sdf", tmp_path / "ours.sdf"
    inner = crank_and_rod(extra=sleeve)
    inner = inner[inner.index("<model") : inner.index("</sdf>")]
    inner = inner.replace(
        '<joint name="O" type="revolute"><parent>world', '<joint name="O" type="revolute"><parent>base'
    )
    base = '<link name="base"/><joint name="G" type="fixed"><parent>world</parent><child>arm::base</child></joint>'
    inner = inner.replace('<model name="pendulum">', '<model name="arm"><link name="base"/>')
    source.write_text(
        f'<sdf version="1.9" xmlns:linkages="urn:linkages:sdf"><model name="both">{base}{inner}</model></sdf>'.replace(
            '<link name="base"/><joint', "<joint"
        )
    )
    assert main(["import", str(source), "--out", str(out)]) == 0
    mechanism = load_mechanism(out)
    link = mechanism.link["arm::rod"]
    assert link.beam.frames == ("arm::rod", "arm::rod_tip")
    assert (link.mass, link.beam.second_moment) == pytest.approx((MASS, 0.008**4 / 12), rel=1e-12)
    assert (mechanism.link["arm::sleeve"].mass, mechanism.joint["arm::F"].type) == (0.2, "fixed")


@pytest.fixture
def experiment(tmp_path):
    """A pendulum with a flexible rod, and the text after its drive."""

    def write(links, more="", machine=None):
        (tmp_path / "m.sdf").write_text(machine or crank_and_rod())
        path = tmp_path / "e.toml"
        head = 'mechanism = "m.sdf"\nduration = 1.0\n[drives.O]\nspeed = 1.0\n[drives.A]\ntorque = 0.0\n'
        path.write_text(f"{head}{links}\n{more}")
        return load_experiment(path)

    return write


FLEXIBLE = '[links.rod]\nmodel = "flexible"\n'


def test_links_bend_in_the_experiment_alone(experiment):
    given = experiment(FLEXIBLE + '[links.crank]\nmodel = "rigid"\nbending = 3')
    assert list(given.deforming) == ["rod"]
    assert not given.replaced({"links.rod.model": "rigid"}).deforming
    assert not given.ideal().deforming
    assert given.replaced({"links.rod.damping": 0.02}).value("links.rod.damping") == 0.02


def test_a_link_made_rigid_takes_its_bending_along(experiment):
    """Outputs dropped for replaced values, as in a comparison of models; a file with such outputs is rejected."""
    outputs = ["rod.stress", "rod_tip.deflection", "rod_tip.x", "crank.bending"]
    both = FLEXIBLE + FLEXIBLE.replace("rod", "crank")
    crank = elastic_bar("crank", 0.15, "__model__")
    machine = crank_and_rod().replace(bar("crank", 0.15, "__model__"), crank)
    source = experiment(both, machine=machine).source
    source.write_text(f"outputs = {outputs}\n" + source.read_text())
    system = linkages.load(source)
    assert system.experiment.outputs == outputs
    made = {"links.rod.model": "rigid"}
    for one in (system.replaced(made), linkages.load(source, made), system.replaced(made).replaced({"duration": 2.0})):
        assert one.experiment.outputs == ["rod_tip.x", "crank.bending"]
    assert system.replaced({"links.rod.pieces": 2}).experiment.outputs == outputs
    source.write_text(source.read_text().replace("flexible", "rigid", 1))
    with pytest.raises(InputError, match=r'"rod" is rigid; set links\.rod\.model, or remove the output'):
        linkages.load(source)


def test_joints_and_loads_are_where_a_link_needs_modes(experiment):
    """Each place once: the joint, a force, a spring's end at the same place as the force."""
    frame = '<frame name="mid" attached_to="rod"><pose>0.1 0 0 0 0 0</pose></frame>'
    loads = '[forces.F]\npoint = "rod_tip"\nforce = [1.0, 0.0]\n[springs.S]\npoint = "rod_tip"\nto = "mid"\n'
    machine = crank_and_rod(ROD + frame)
    given = experiment(FLEXIBLE, loads.replace('"mid"', '"crank"') + "stiffness = 1.0\nfree_length = 0.1", machine)
    mechanism = load_mechanism(given.mechanism_path)
    assert interfaces(mechanism, given, "rod") == pytest.approx((0.0, 0.3))
    given = experiment(FLEXIBLE, '[forces.F]\npoint = "mid"\nforce = [1.0, 0.0]\n', machine)
    assert interfaces(mechanism, given, "rod") == pytest.approx((0.0, 0.1))


STEEL_ROD = Beam(0.3, 1.28e7, 2e11 * 0.008**4 / 12, 0.50368)


def modes_of(**table):
    """Damping factors of the reference rod's modes, and the modes."""
    modes = component_modes(STEEL_ROD, 0.0, 0.3, [0.3], 0.3, bending=8, axial=2)
    return LinkModel.model_validate({"model": "flexible", **table}).damping_factors(modes, STEEL_ROD), modes


def test_damping_is_that_of_the_first_pinned_mode():
    """A ratio z of a mode is half its factor times its frequency; 1.5e-5 s are 0.957 % of the first mode here."""
    factors, modes = modes_of(damping=0.02)
    assert factors * 0.5 * modes.frequencies[0] == pytest.approx(np.full(10, 0.02), rel=1e-6)
    assert modes_of(stiffness_damping=1.5e-5)[0] == pytest.approx(np.full(10, 1.5e-5))
    assert 0.5 * 1.5e-5 * STEEL_ROD.pinned_frequency == pytest.approx(0.00957515, rel=1e-5)
    assert modes_of()[0] == pytest.approx(0.5 * factors)
    factors, _ = modes_of(axial_damping=0.003)
    assert factors[:8] == pytest.approx(modes_of()[0][:8])
    assert factors[8:] * 0.5 * STEEL_ROD.held_frequency == pytest.approx([0.003, 0.003])
    assert modes.frequencies[8] == pytest.approx(STEEL_ROD.held_frequency, rel=2e-2)


REFUSED = {
    "no such link": ('[links.rot]\nmodel = "flexible"', 'links.rot: m.sdf has no such link; did you mean "rod"?'),
    "no beam": (
        '[links.crank]\nmodel = "flexible"',
        'links.crank.model: "flexible" needs a <linkages:beam> in <link name="crank"> of m.sdf',
    ),
    "few bending modes": (
        FLEXIBLE + 'bending = 1\n[forces.F]\npoint = "rod_tip"\nforce = [1.0, 0.0]',
        "links.rod.bending: is 1; its 2 joints and loads need 2 modes or more, or 0",
    ),
    "no modes": (
        FLEXIBLE + "bending = 0\naxial = 0",
        'links.rod: has no modes; give bending or axial, or model = "rigid"',
    ),
    "two dampings": (
        FLEXIBLE + "damping = 0.1\nstiffness_damping = 1e-5",
        "links.rod: give damping or stiffness_damping, not both",
    ),
    "unknown key": (FLEXIBLE + "modes = 3", 'links.rod.modes: unknown key; did you mean "model"?'),
    "a start": (FLEXIBLE + 'start = "bent"', "links.rod.start: "),
}


@pytest.mark.parametrize("case", REFUSED)
def test_links_that_cannot_bend_so_are_refused(experiment, case):
    links, problem = REFUSED[case]

    def refused():
        given = experiment(links)
        check(load_mechanism(given.mechanism_path), given)

    with pytest.raises(InputError) as info:
        refused()
    assert str(info.value).startswith(f"e.toml: {problem}")


def test_a_joint_beside_the_beam_of_a_link_that_bends_is_refused(experiment):
    """One that is rigid may have joints anywhere."""
    aside = '<frame name="aside" attached_to="rod"><pose>0.1 0.02 0 0 0 0</pose></frame>'
    machine = crank_and_rod(ROD + aside + bar("arm", 0.1, "aside"), extra=joint("B", "aside", "arm"))
    given = experiment(FLEXIBLE, machine=machine)
    mechanism = load_mechanism(given.mechanism_path)
    check(mechanism, given.ideal())
    problem = 'links.rod: is flexible, but its joint "B" lies 0.02 m off its beam from "rod" to "rod_tip"; '
    with pytest.raises(InputError, match=re.escape(problem)):
        check(mechanism, given)


def test_new_writes_a_machine_whose_rod_bends(tmp_path, capsys):
    assert main(["new", "saw", "--flexible", "--out", str(tmp_path)]) == 0
    assert main(["new", "saw", "--flexible", "--model", "dry", "--out", str(tmp_path)]) == 2
    assert "not allowed with" in capsys.readouterr().err
    system = linkages.load(tmp_path / "saw.toml")
    assert (system.mechanism.name, list(system.experiment.deforming)) == ("saw", ["rod"])
    for drawn in system.mechanism.joints:
        np.testing.assert_allclose(drawn.on_parent, drawn.on_child, atol=1e-12)
    text = (tmp_path / "saw.toml").read_text()
    numbers = set(re.findall(r"^(\w+) += [-\d.[]", text, re.M))
    assert numbers <= {path.rpartition(".")[2] for path in system.experiment.sources}  # each has a source
    head, mark, tail = text.partition("# [joints.B]")
    (tmp_path / "oil.toml").write_text(head + (mark + tail).replace("# ", "", 1).replace("\n# ", "\n"))
    assert linkages.load(tmp_path / "oil.toml").experiment.play == ("B",)
