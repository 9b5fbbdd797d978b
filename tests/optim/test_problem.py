"""Study files: meaning of the keys, and rejected input."""

import math
from pathlib import Path

import numpy as np
import pytest
from shipped import STUDIES_FOLDER

import linkages
from linkages import InputError
from linkages.input.files.shipped import data_folder
from linkages.laws.viscosity import iso_vg_viscosity
from linkages.results.outputs.registry import names
from optim import Evaluator
from optim.problem.load import find_study, load_study
from optim.problem.schema import StudyFile

STUDY = """
experiment = "seven_bar.toml"
[constants]
m_2 = 0.219
[variables.mass]
path = "sdf.links.link2.mass"   # Table 1
relative = true
lower = 0.5
upper = 2.0
[variables.oil]
path = "joints.A.viscosity"
lower = 0.05
upper = 0.6
[linked]
"joints.B.viscosity" = "oil"
[windows.late]
start = 1.0
end = 2.0
[objectives.force]
terms = [{ functional = "peak", output = "A.force", window = "late" }]
[constraints.stroke]
at_least = 0.1
terms = [{ functional = "range", output = "slider7.x" }]
[algorithm]
name = "ga"
"""


@pytest.fixture
def study(tmp_path):
    def write(text=STUDY, **changes):
        for old, new in changes.get("replace", {}).items():
            assert old in text
            text = text.replace(old, new)
        path = tmp_path / "mine.toml"
        path.write_text(text)
        return load_study(path)

    return write


@pytest.mark.parametrize("path", sorted(STUDIES_FOLDER.glob("*.toml")), ids=lambda path: path.stem)
def test_every_number_of_a_shipped_study_has_a_source(path):
    """Values other than bounds, limits and weights: from physics or a paper, or assumed."""
    study = load_study(path)
    for variable in study.file.variables:
        for side in ("lower", "upper"):
            assert study.sources[f"variables.{variable}.{side}"]
    for table in ("constants", "set", "algorithm"):
        for key in getattr(study.file, table):
            assert key == "name" or study.sources[f"{table}.{key}"], key
    assert study.sources["seed"]


def test_table_1():
    """The paper's bounds: masses by factors, inertias of uniform bars about their middle and their end."""
    for name in ("sevenbar_force", "sevenbar_acceleration", "sevenbar_pareto"):
        study = load_study(find_study(name))
        assert study.lower == pytest.approx([0.1095, 0.219 * 0.18**2 / 12, 0.0535, 0.107 * 0.08**2 / 12, 0.0695, 0.05])
        assert study.upper == pytest.approx([0.438, 0.219 * 0.18**2 / 3, 0.214, 0.107 * 0.08**2 / 3, 0.278, 0.6])
        assert study.nominal == pytest.approx([0.219, 7.736e-4, 0.107, 1.179e-4, 0.139, 0.4])
        # Table 6: both optimised designs of the paper lie within
        for design in (
            [0.39752, 17.975e-4, 0.10391, 18.874e-5, 0.069825, 0.24241],
            [0.12678, 96.731e-5, 0.16064, 21.717e-5, 0.073186, 0.41749],
        ):
            assert np.all((study.lower <= design) & (design <= study.upper))


@pytest.mark.parametrize("name", ["fourbar_jitter", "sevenbar_geometry"])
def test_linked_masses_are_the_machines_own_at_the_nominal_design(name):
    """Formulas of the lengths, at the lengths of the SDF file, give the masses and inertias of the SDF file."""
    study = load_study(find_study(name))
    point = study.points[0]
    mechanism = linkages.load_mechanism(point.system.mechanism.source)
    found = dict(zip(point.paths[len(study.paths) :], point.links, strict=True))
    checked = 0
    for path, link in found.items():
        value = link(study.named(study.nominal))
        if path.startswith("sdf.links"):
            _, _, body, key = path.split(".", 3)
            own = mechanism.link[body]
            expected = {"mass": own.mass, "inertia": own.inertia, "com.x": own.com_local[0]}[key]
            assert value == pytest.approx(expected, rel=1e-4)  # the file has five digits
            checked += 1
    assert checked >= 9


def test_transmission_angle_of_the_four_bar():
    """The law of cosines against the drawn linkage: coupler and follower where the crank lies along the ground."""
    study = load_study(find_study("fourbar_jitter"))
    for name, sign in (("least_transmission_angle", 1.0), ("largest_transmission_angle", -1.0)):
        crank = np.array([0.2 * sign, 0.0])
        pivot = np.array([0.1, 0.0])
        d = pivot - crank
        # where circles about the crank's pin (180 mm) and the pivot (220 mm) meet
        along = (0.18**2 - 0.22**2 + d @ d) / (2.0 * np.hypot(*d))
        across = math.sqrt(0.18**2 - along**2)
        meet = crank + along * d / np.hypot(*d) + across * np.array([-d[1], d[0]]) / np.hypot(*d)
        u, v = crank - meet, pivot - meet
        expected = u @ v / np.hypot(*u) / np.hypot(*v)
        assert study.formulas[name](study.named(study.nominal)) == pytest.approx(expected, rel=1e-12)


def test_windows_of_revolutions():
    study = load_study(find_study("fourbar_jitter_steady"))
    for point in study.points:
        assert point.windows["steady"] == pytest.approx(np.column_stack([np.arange(2, 12), np.arange(3, 13)]) * 0.1)
    assert [point.system.experiment.drives["O"].angle for point in study.points] == pytest.approx(
        np.arange(4) * math.pi / 2
    )


def test_values(study):
    found = study()
    assert found.lower == pytest.approx([0.1095, 0.05])
    assert found.sources["variables.mass.path"] == "Table 1"
    point = found.points[0]
    assert point.paths == ("sdf.links.link2.mass", "joints.A.viscosity", "joints.B.viscosity")
    assert point.links[0](found.named(np.array([0.2, 0.33]))) == 0.33
    assert point.windows["run"].tolist() == [[0.0, 2.0]]


def test_operating_points(study):
    text = (
        STUDY
        + '[points.worn.set]\n"joints.A.clearance" = 5e-4\n[points.hot]\nlinked.joints.A.clearance = "3e-4 + 0 * oil"\n'
    )
    found = study(text)
    assert [point.name for point in found.points] == ["worn", "hot"]
    assert found.points[0].system.experiment.joints["A"].clearance == 5e-4
    assert found.points[1].paths[-1] == "joints.A.clearance"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("[variables.mass]", "[variable.mass]", 'variable: unknown key; did you mean "variables"'),
        ("output =", "outptu =", r'terms.0.outptu: unknown key; did you mean "output"'),
        ("lower = 0.5", "lower = true", "variables.mass.lower: is True; give a number, or a formula"),
        ("lower = 0.5", "lower = -inf", "variables.mass.lower: is -inf; a number must be finite"),
        ('"peak"', '"peek"', "it should be 'peak', 'max'"),
        (
            '"A.force"',
            '"A.farce"',
            r'^mine.toml: objectives.force.terms\[0\]: .*output "A.farce": is unknown; did you mean "A.force"',
        ),
        ('"slider7.x"', '"slider8.x"', 'output "slider8.x": is unknown; did you mean "slider7.x"'),
        ('"slider7.x"', '"A.film_thickness.jitter"', "jitter exists only for the motion of a link or frame"),
        (
            "joints.A.viscosity",
            "joints.A.viscocity",
            'variables.oil.path: .*has no "viscocity"; did you mean "viscosity"',
        ),
        ("joints.A.viscosity", "joints.AA.viscosity", 'has no "AA"; did you mean "A"'),
        ("joints.A.viscosity", "joints.A.model", "is not a number"),
        ("joints.A.viscosity", "solver.max_step", "has no value in the experiment"),
        ("sdf.links.link2.mass", "sdf.links.link22.mass", 'there is no such value; did you mean "links.link2"'),
        ("sdf.links.link2.mass", "sdf.links.link2.weight", "there is no such value"),
        ("sdf.links.link2.mass", "sdf.link.link2.mass", 'did you mean "links.link2"'),
        ("upper = 2.0", "upper = 0.4", "lower, 0.1095, must be below upper, 0.0876"),
        ("upper = 2.0", "upper = 0.9", "its nominal value 0.219 is not between"),
        ("lower = 0.5", 'lower = "m_3 / 2"', 'variables.mass.lower: "m_3" is unknown; did you mean "m_2"'),
        ("lower = 0.5", 'lower = "log(0)"', "has no finite value"),
        ('= "oil"', '= "oli"', 'linked.joints.B.viscosity: "oli" is unknown; did you mean "oil"'),
        ('= "oil"', '= "-oil"', "joints.B.viscosity"),
        ('= "oil"', '= "log(-oil)"', "has no finite value at the nominal design"),
        ('= "oil"', "= 0.3", "write a formula between quotes"),
        ('"joints.B.viscosity"', '"joints.A.viscosity"', "joints.A.viscosity is set by variables.oil already"),
        ('"joints.B.viscosity"', '"joints.B.stickiness"', "unknown key"),
        ('window = "late"', 'window = "lat"', '"lat" is unknown; did you mean "late"'),
        ("end = 2.0", "end = 0.5", "end, 0.5, must be after start, 1"),
        ("end = 2.0", "end = 3.0", "windows.late: ends at 3 s, after the run's 2 s"),
        ("end = 2.0", 'end = 2.0\nrevolutions_of = "O2"', 'no drive "O2"; did you mean "O'),
        ("at_least = 0.1", "at_least = 0.2\nat_most = 0.1", "at_least must be below at_most"),
        ("at_least = 0.1", "", "give at_most, at_least or both"),
        ("at_least = 0.1", "at_least = 0.1\nequals = 0.2", "or equals alone"),
        ("at_least = 0.1", 'at_least = 0.1\nformula = "oil"', "give either terms or formula"),
        ("[constraints.stroke]", "[constraints.force]", '"force" names an objective and a constraint'),
        ("[variables.oil]", '[variables."my oil"]', '"my oil" cannot be used in formulas'),
        ("[variables.oil]", "[variables.sqrt]", '"sqrt" is taken'),
        ('"seven_bar.toml"', '"eight_bar.toml"', "eight_bar.toml: cannot be read"),
        ('experiment = "seven_bar.toml"', "", "experiment: is missing"),
        ('experiment = "seven_bar.toml"', 'experiment = "none"', "experiment: none: cannot be read"),
        (
            "[constants]",
            "set.duratoin = 1.0\n[constants]",
            '^mine.toml: set: duratoin: unknown key; did you mean "duration"',
        ),
        ("[constants]", "set.duration = 1.5\n[constants]", "ends at 2 s, after the run's 1.5 s"),
        ("[windows.late]", "[windows.run]", 'the window "run" is all of the run'),
        (
            "[algorithm]",
            "[points.worn]\nset.joints.A.clearance = -1.0\n[algorithm]",
            "^mine.toml: points.worn: joints.A.clearance: ",
        ),
        (
            "[algorithm]",
            '[points.worn]\nset."joints.A.viscosity" = 1.0\n[algorithm]',
            "points.worn.set.joints.A.viscosity: joints.A.viscosity is set by variables.oil already",
        ),
    ],
)
def test_refused(study, old, new, message):
    with pytest.raises(InputError, match=message) as problem:
        study(replace={old: new})
    assert "\n" not in str(problem.value)


def test_the_description_is_json_and_tells_problems_apart(study):
    import json

    first = study().description()
    assert json.loads(json.dumps(first))["problem"]["linked"] == {"joints.B.viscosity": "oil"}
    assert study().description() == first
    for old, new in (("upper = 0.6", "upper = 0.7"), ("at_least = 0.1", "at_least = 0.11"), ('"peak"', '"rms"')):
        assert study(replace={old: new}).description() != first
    assert study("title = 'another'\nseed = 4\n" + STUDY).description() == first


@pytest.mark.parametrize(
    ("name", "path"), [("seven_bar", "sdf.links.link2.mass"), ("slider_crank_guide", "sdf.links.rod.mass")]
)
def test_every_output_can_be_named_and_has_a_value(tmp_path, name, path):
    """The engine computes everything that a study file accepts: joint moments, powers, energies, ideal outputs, jitter."""
    system = linkages.load(linkages.find_file(f"{name}.toml"))
    outputs = [*names(system), *(f"ideal.{output}" for output in names(system, ideal=True))]
    outputs += [f"{point}.vx.jitter" for point in system.mechanism.link]
    terms = ",\n".join(f'{{ functional = "peak", output = "{output}" }}' for output in outputs)
    file = tmp_path / "all.toml"
    file.write_text(
        f'experiment = "{name}.toml"\nset.duration = 0.001\n[variables.x]\npath = "{path}"\nrelative = true\n'
        f'lower = 0.5\nupper = 2.0\n[objectives.all]\nterms = [{terms}]\n[algorithm]\nname = "ga"\n'
    )
    study = load_study(file)
    assert Evaluator(study)(study.nominal[None]).status == ("ok",)


def test_shipped_studies_are_found_by_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shipped = STUDIES_FOLDER / "sevenbar_force.toml"
    assert find_study("sevenbar_force.toml") == find_study("sevenbar_force") == shipped
    assert (
        linkages.find_file("sevenbar_force.toml") == linkages.find_file("optim/studies/sevenbar_force.toml") == shipped
    )
    with pytest.raises(InputError, match=r'did you mean "sevenbar_force.toml"'):
        linkages.find_file("sevenbar_forse.toml")
    (tmp_path / "sevenbar_force.toml").write_text("")
    assert find_study("sevenbar_force.toml").resolve() == tmp_path / "sevenbar_force.toml"
    assert (data_folder() / "seven_bar.toml").exists()


def test_the_example_of_the_documentation(tmp_path):
    text = (Path(__file__).resolve().parents[2] / "docs" / "optimisation.md").read_text(encoding="utf-8")
    path = tmp_path / "example.toml"
    path.write_text(text.split("```toml\n")[1].split("```")[0])
    study = load_study(path)
    assert [point.name for point in study.points] == ["new", "worn", "hot"]
    assert study.points[0].links[1](study.named(np.array([0.2, 0.3]))) == pytest.approx(0.2 * 0.18**2 / 12)


def test_every_key_says_what_it_means():
    from linkages.input.files.table_keys import table_keys

    assert all(meaning for _, meaning in table_keys(StudyFile))


def test_the_oil_of_the_robust_study_follows_the_grades():
    """Its formulas against viscosities by grade and temperature, within the study's bounds."""
    study = load_study(find_study("sevenbar_robust"))
    at = study.names.index("viscosity")
    for point in study.points:
        celsius = float(point.name.partition("_")[2])
        for grade in (68, 100, 150, 220, 320, 460, 680):
            design = study.nominal.copy()
            design[at] = iso_vg_viscosity(grade, 40.0)
            assert study.lower[at] <= design[at] <= study.upper[at]
            values = dict(
                zip(point.paths, [*design, *(link(study.named(design)) for link in point.links)], strict=True)
            )
            assert values["joints.A.viscosity"] == values["joints.B.viscosity"]
            assert values["joints.A.viscosity"] == pytest.approx(iso_vg_viscosity(grade, celsius), rel=0.01)


def test_reference_designs(study):
    """Unnamed values are nominal; they do not change the solved problem."""
    plain = study()
    with_design = study(STUDY + '\n[designs.thin]\n"joints.A.viscosity" = 0.1\n')
    assert with_design.designs["thin"].tolist() == [plain.nominal[0], 0.1]
    assert with_design.description() == plain.description()
    for text, message in (
        ('"joints.B.viscosity" = 0.1', "designs.x.joints.B.viscosity: is set by no variable"),
        ('"joints.A.viscosity" = "thin"', "designs.x.joints.A.viscosity: is 'thin'; give a number"),
    ):
        with pytest.raises(InputError, match=message):
            study(STUDY + f"\n[designs.x]\n{text}\n")


def test_a_point_may_replace_what_a_variable_sets(study):
    found = study(STUDY + '\n[points.cold]\n[points.hot.linked]\n"joints.A.viscosity" = "0.3 * oil"\n')
    cold, hot = (
        dict(
            zip(point.paths, [*found.nominal, *(link(found.named(found.nominal)) for link in point.links)], strict=True)
        )
        for point in found.points
    )
    assert cold["joints.A.viscosity"] == 0.4
    assert hot["joints.A.viscosity"] == pytest.approx(0.12)
    assert hot["joints.B.viscosity"] == 0.4
