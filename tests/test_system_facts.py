"""What rooms above `linkages.system` ask a system: settings, names, joints, links, named elements."""

import numpy as np
import pytest
from shipped import NAMES, shipped

from linkages import find_file, load


def test_settings_are_those_of_the_file_and_of_replaced_values():
    values = {
        "duration": 0.3,
        "solver.accuracy": 1e-6,
        "outputs": ["slider7.x"],
        "windows.late": {"start": 0.1, "end": 0.2},
    }
    settings = load(find_file("seven_bar.toml")).replaced(values).settings
    assert (settings.duration, settings.accuracy, settings.outputs) == (0.3, 1e-6, ("slider7.x",))
    assert settings.windows == {"late": (0.1, 0.2)}
    assert (settings.integrator, settings.max_step, settings.report, settings.start) == (
        None,
        None,
        "steady",
        "centred",
    )


@pytest.mark.parametrize(("title", "heading"), [("A press", "A press"), ("", "seven_bar")])
def test_a_system_without_a_title_is_named_after_its_file(title, heading):
    described = load(find_file("seven_bar.toml"), {"title": title}).description
    assert (described.title, described.heading, described.stem) == (title, heading, "seven_bar")
    assert (described.source.name, described.machine_source.name) == ("seven_bar.toml", "seven_bar.sdf")


@pytest.mark.parametrize("name", NAMES)
def test_joints_have_the_places_of_the_mechanism_and_the_models_of_the_experiment(name):
    system = shipped(name)
    assert list(system.joints) == [joint.name for joint in system.mechanism.joints]
    for joint in system.mechanism.joints:
        found, model = system.joints[joint.name], system.experiment.joints.get(joint.name)
        assert (found.type, found.parent, found.child) == (joint.type, joint.parent, joint.child)
        np.testing.assert_array_equal([found.on_parent, found.on_child], [joint.on_parent, joint.on_child])
        assert found.model == ("ideal" if model is None else model.model)
        assert found.clearance == (None if model is None else model.clearance)
        assert found.has_drive == (joint.name in system.experiment.drives)


def test_a_joint_has_a_film_and_a_heat_balance_only_as_long_as_it_has_oil():
    oil = {
        "joints.A.oil": {"grade": 46, "temperature": 50.0},
        "joints.A.heat": {"inlet": 40.0},
        "joints.A.film": "finite",
    }
    system = load(find_file("seven_bar_rig.toml"))
    data = {
        "model": "lubricated",
        "clearance": 1e-4,
        "film": "finite",
        "oil": oil["joints.A.oil"],
        "heat": {"inlet": 40.0},
    }
    warm = system.replaced({"joints.A": data}).joints["A"]
    assert (warm.has_film, warm.oil_temperature, warm.heat.inlet) == (True, 50.0, 40.0)
    dry = system.replaced({"joints.A": data | {"model": "ideal"}}).joints["A"]
    assert (dry.has_film, dry.heat, dry.clearance) == (False, None, 1e-4)


def test_gears_with_backlash_are_apart_from_those_without():
    rattle = load(find_file("gear_rattle.toml"))
    assert (list(rattle.parts["gears"]), list(rattle.tree.coupled), list(rattle.tree.loose)) == (["mesh"], [], ["mesh"])
    ideal = rattle.ideal()
    assert (list(ideal.tree.coupled), list(ideal.tree.loose)) == (["mesh"], [])
    assert rattle.named_loads == (("frictions", "drag"),)


def test_a_system_answers_for_its_links_in_the_colours_of_drawings():
    system = load(find_file("seven_bar.toml"))
    assert set(system.colors) == set(system.places) == {*system.points, *system.joints}
    assert system.colors["A"] == system.colors[system.joints["A"].child]  # a joint has the colour of its child
    assert all(system.colors[name] == link.color for name, link in system.links.items())  # the file has visuals


def test_the_longest_start_of_a_drive_counts():
    system = load(find_file("seven_bar.toml"))
    assert system.ramp == 0.0
    assert system.replaced({"drives.O1.ramp": 0.1, "drives.O4.ramp": 0.3}).ramp == 0.3
