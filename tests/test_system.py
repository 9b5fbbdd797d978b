"""`System`: replaced values against loading again, pickles, numbers by their paths."""

import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from shipped import NAMES, shipped

from linkages import InputError, find_file, load
from linkages.system.system import System

ARRAYS = ("laws", "tables", "film_limits", "touching", "gravity")
OF_TREE = (
    "drawn", "closure_rows", "loop_rows", "ends", "free_dofs", "driven_dofs", "powered_dofs",
)  # fmt: skip


def arrays(system: System) -> dict:
    """Every array that an engine reads."""
    tree, assembly = system.tree, system.assembly
    found = {name: getattr(system, name) for name in ARRAYS}
    found |= {f"tree.{name}": getattr(tree, name) for name in OF_TREE}
    found |= {f"tree.bodies.{name}": getattr(tree.bodies, name) for name in ("records", "shapes")}
    found |= {"q": assembly.q, "v": assembly.v, "quality": assembly.quality, "mobility": assembly.mobility}
    found |= {name: getattr(system.arrays, name) for name in ("joints", "driven_bodies", "powered_bodies")}
    found |= {f"law_states.{name}": x for name, x in system.law_states._asdict().items()}
    found["ideal joints"] = system.ideal_arrays.joints
    for name in ("motions", "torques"):
        found |= {f"{name}{k}": x for k, x in enumerate(getattr(system, name).arrays)}
    return found | {f"loads{k}": x for k, x in enumerate((*system.loads, *system.elements))}


def assert_same(one: System, other: System) -> None:
    assert one.experiment == other.experiment
    assert one.mechanism.values == other.mechanism.values
    expected = arrays(other)
    for name, found in arrays(one).items():
        np.testing.assert_array_equal(found, expected[name], err_msg=name)


#: Replaced values of the seven-bar.
CHANGES = {
    "mass": {"sdf.links.link2.mass": 0.4},
    "inertia": {"sdf.links.crank4.inertia": 2e-4, "sdf.links.slider7.mass": 0.2},
    "length": {"sdf.frames.crank1_A.pose.x": 0.085},
    "length and mass": {"sdf.frames.crank1_A.pose.x": 0.085, "sdf.links.link2.mass": 0.4},
    "bearing": {"sdf.joints.A.bearing.radius": 0.016},
    "clearance": {"joints.A.clearance": 2e-4, "joints.B.viscosity": 0.3},
    "offset": {"joints.A.offset": [1e-4, -5e-5]},
    "table with an offset": {
        "joints.A": {"model": "lubricated", "clearance": 1e-4, "viscosity": 0.1, "offset": [5e-5, 0.0]}
    },
    "model": {"joints.B": {"model": "ideal"}},
    "film": {"joints.A.film": "finite"},
    "drive": {"drives.O1.speed": 7.0, "drives.O4.angle": 0.3},
    "gravity": {"gravity": [0.0, -9.81, 0.0]},
    "accuracy": {"solver.accuracy": 1e-5, "duration": 0.5},
    "machine": {"mechanism": "slider_crank.sdf", "drives": {}, "joints": {}, "outputs": []},
}


@pytest.mark.parametrize("change", CHANGES)
def test_replacing_is_loading_anew(change):
    values = CHANGES[change]
    anew = load(find_file("seven_bar.toml"), values)
    nominal = shipped("seven_bar")
    arrays(nominal)  # computed properties may be kept or not
    assert_same(nominal.replaced(values), anew)
    assert_same(shipped("seven_bar").replaced(values), anew)


def test_replacing_twice_is_replacing_once(seven_bar):
    first, second = CHANGES["length and mass"], CHANGES["clearance"] | {"sdf.links.link2.mass": 0.5}
    assert_same(seven_bar.replaced(first).replaced(second), seven_bar.replaced(first | second))


def test_variants_share_only_what_they_have_in_common(seven_bar):
    """Values that change and change back, one after the other."""
    for name in ("film", "mass", "clearance", "bearing", "drive", "clearance", "model"):
        assert_same(seven_bar.replaced(CHANGES[name]), load(find_file("seven_bar.toml"), CHANGES[name]))


def test_a_variant_needs_no_file(tmp_path):
    for name in ("seven_bar.toml", "seven_bar.sdf"):
        (tmp_path / name).write_bytes(find_file(name).read_bytes())
    system, anew = (load(tmp_path / "seven_bar.toml", values) for values in ({}, CHANGES["length"]))
    (tmp_path / "seven_bar.sdf").unlink()
    assert_same(pickle.loads(pickle.dumps(system)).replaced(CHANGES["length"]), anew)


def _plausible(value: float) -> float:
    """Replace values below the rounding level by zero."""
    return value if abs(value) > 1e-12 else 0.0


@pytest.mark.slow
@given(
    st.fixed_dictionaries(
        {},
        optional={
            "sdf.links.link2.mass": st.floats(0.01, 1.0),
            "sdf.frames.crank1_A.pose.x": st.floats(0.075, 0.085),
            "joints.A.clearance": st.floats(1e-5, 5e-4),
            "drives.O1.speed": st.floats(-20.0, 20.0).map(_plausible),
            "joints.B.offset": st.tuples(*[st.floats(-1e-4, 1e-4).map(_plausible)] * 2).map(list),
        },
    )
)
def test_any_replacement_is_loading_anew(values):
    if values:
        assert_same(shipped("seven_bar").replaced(values), load(find_file("seven_bar.toml"), values))


def test_replacing_nothing_is_the_same_system(seven_bar):
    assert seven_bar.replaced({}) is seven_bar


@pytest.mark.parametrize("path", ["sdf.links.link22.mass", "joints.A.clearence", "sdf.links.link2.mas", "nothing"])
def test_replacing_refuses_what_loading_refuses(seven_bar, path):
    said = []
    for ask in (lambda: seven_bar.replaced({path: 1.0}), lambda: load(find_file("seven_bar.toml"), {path: 1.0})):
        with pytest.raises(InputError) as caught:
            ask()
        said.append(str(caught.value))
    assert said[0] == said[1]


@pytest.mark.parametrize("name", NAMES)
def test_a_system_can_be_pickled(name):
    system = shipped(name, **{"solver.accuracy": 1e-5})
    assert_same(pickle.loads(pickle.dumps(system)), system)


@pytest.mark.parametrize("name", ["slider_crank_guide", "four_bar_dry", "five_bar_dry", "six_bar_dry", "seven_bar_rig"])
def test_every_number_of_a_machine_is_found_and_replaced_by_its_path(name):
    """Put in place of itself, a number changes nothing; put in place of another, it is found there."""
    system = shipped(name)
    assert system.mechanism.values
    for path, value in system.mechanism.values.items():
        assert system.value(f"sdf.{path}") == value
        more = value * 1.001 + (1e-9 if value == 0.0 else 0.0)
        assert system.replaced({f"sdf.{path}": more}).value(f"sdf.{path}") == pytest.approx(more, rel=1e-12)


def test_numbers_of_the_experiment_are_found_by_their_paths(seven_bar):
    assert seven_bar.value("joints.A.clearance") == 3e-4
    assert seven_bar.value("drives.O1.speed") == pytest.approx(np.pi)
    for path in ("joints.A.clearence", "joints.A.film", "sdf.links.link2.mas", "sdf", ""):
        with pytest.raises(InputError):
            seven_bar.value(path)


def test_the_ideal_system_has_no_contacts(seven_bar):
    assert seven_bar.ideal().tree.contacts == ()
    assert seven_bar.ideal().determinate


@pytest.mark.parametrize("path", ["sdf", "sdf.links", "sdf.links.link2", "sdf.links.link2.mass"])
def test_values_of_the_machine_are_replaced_alone_or_by_tables(path):
    value = 0.3
    for part in reversed("sdf.links.link2.mass".removeprefix(path).split(".")[1:]):
        value = {part: value}
    changed = load(find_file("seven_bar.toml")).replaced({path: value})
    assert changed.value("sdf.links.link2.mass") == 0.3


def test_an_empty_table_takes_an_override_of_the_machine_back():
    path = "sdf.links.link2.mass"
    nominal = load(find_file("seven_bar.toml"))
    assert nominal.replaced({path: 1.0}).replaced({path: {}}).value(path) == nominal.value(path)
