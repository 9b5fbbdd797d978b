"""User-defined laws: called like built-in ones, replaced, rejected, transferred to another process."""

import math
import pickle

import cloudpickle
import numba
import numpy as np
import pytest
from engines import slow_on_drake
from hypothesis import given
from hypothesis import strategies as st
from joint_records import joint
from machines import four_bar
from numba import config
from pydantic import TypeAdapter, ValidationError

import linkages
from linkages.elements.contact_tables import ContactName
from linkages.laws import (
    CONTACTS,
    FRICTIONS,
    Parameter,
    State,
    register_contact,
    register_film,
    register_friction,
    registered,
    restore,
    user_laws,
)
from linkages.laws.contact.contact_laws import contact_force, normal_force
from linkages.laws.film.films import film_force
from linkages.laws.friction import friction_action, friction_coefficient

compiled_only = pytest.mark.skipif(bool(config.DISABLE_JIT), reason="nothing is compiled")


pytestmark = pytest.mark.usefixtures("registries_of_module")


def lankarani_nikravesh(delta, ddelta, ddelta0, joint):
    """The built-in law, written without it."""
    chi = 0.75 * (1.0 - joint.restitution * joint.restitution)
    ratio = min(max(ddelta / max(ddelta0, 1e-6), -1.0), 1.0)
    return joint.stiffness * (delta * math.sqrt(delta)) * (1.0 + chi * ratio)


def long_film(eps, deps, ew, slenderness):
    """The built-in film, written without it."""
    q = 1.0 - eps * eps
    root = math.sqrt(q)
    a = ew / (2.0 + eps * eps)
    speed = math.sqrt(a * a + deps * deps)
    extent = 2.0 * math.atan2(root * speed, -eps * deps) if speed > 0.0 else math.pi
    return (-6.0 * (2.0 * eps * root * speed + deps * extent) / (q * root), 6.0 * a * extent / root, extent / root)


@given(
    delta=st.floats(-1e-5, 1e-4),
    ddelta=st.floats(-5.0, 5.0),
    ddelta0=st.floats(0.0, 2.0),
    restitution=st.floats(0.0, 1.0),
)
def test_a_registered_contact_law_is_the_built_in_one(delta, ddelta, ddelta0, restitution):
    register_contact("mine", lankarani_nikravesh)
    register_contact("by factor", factor=lambda e: 0.75 * (1.0 - e * e))
    built_in, mine, by_factor = (
        contact_force(delta, ddelta, ddelta0, joint(contact=name, restitution=restitution, stiffness=1e10))
        for name in ("lankarani-nikravesh", "mine", "by factor")
    )
    assert mine == built_in == by_factor


@compiled_only
@pytest.mark.parametrize("kind", [int, np.int32, np.float32, bool])
def test_laws_take_numbers_of_any_type(kind):
    """A law's function is called at its address and takes float64: other types must not be passed as they are."""
    law = joint(contact="lankarani-nikravesh", friction="coulomb", film="long", stiffness=2.0, restitution=0.5)
    law = law.copy()
    law["mu_d"] = law["mu_s"] = 0.25
    one, zero = kind(1), kind(0)
    assert contact_force(one, zero, one, law) == contact_force(1.0, 0.0, 1.0, law) == 2.0  # K delta^1.5
    assert friction_coefficient(one, law) == friction_coefficient(1.0, law)
    # at rest in the middle, wedge rate 2: the half film of an infinitely long bearing, f_t = 6 pi
    table, ew = np.zeros(1), kind(2) if kind is not bool else 2
    found = film_force(law, zero, zero, ew, one, table)
    np.testing.assert_allclose(found, film_force(law, 0.0, 0.0, 2.0, 1.0, table), rtol=0)
    assert found[1] == pytest.approx(6.0 * math.pi)


@compiled_only
def test_laws_refuse_complex_numbers():
    with pytest.raises(numba.TypingError, match="takes real numbers"):
        friction_coefficient(1j, joint(friction="coulomb"))


@given(eps=st.floats(0.0, 1.1), deps=st.floats(-50.0, 50.0), ew=st.floats(-50.0, 50.0))
def test_a_registered_film_is_the_built_in_one(eps, deps, ew):
    register_film("mine", long_film)
    table = np.empty(0)
    mine, built_in = (film_force(joint(film=name), eps, deps, ew, 1.0, table) for name in ("mine", "long"))
    assert mine == built_in


def coulomb(v, joint):
    """The built-in law, written without it."""
    return joint.mu_d * math.tanh(v / joint.v_1)


@given(v=st.floats(-1.0, 1.0))
def test_a_registered_friction_law_is_the_built_in_one(v):
    register_friction("mine", coulomb)
    numbers = {"mu_d": 0.1, "v_1": 1e-3}
    mine, built_in = (friction_coefficient(v, joint(friction=name, **numbers)) for name in ("mine", "coulomb"))
    assert mine == built_in


def test_a_registered_friction_law_can_have_bristles():
    """The same as LuGre's law without damping of the bristles."""

    def bristly(v, bristle, joint):
        steady = joint.mu_d + (joint.mu_s - joint.mu_d) * math.exp(-((v / joint.v_1) ** 2))
        rate = v - joint.bristle_stiffness * abs(v) * bristle / steady
        return joint.bristle_stiffness * bristle, rate

    register_friction("bristly", bristly, states=[State("bristle", "m", 1e-6)])
    numbers = {"bristle_stiffness": 1e5, "mu_d": 0.1, "mu_s": 0.14, "v_1": 1e-3}
    mine, built_in = (
        friction_action(0.002, (0.0, 0.0, 0.0, 2e-7), joint(friction=name, **numbers)) for name in ("bristly", "lugre")
    )
    assert mine == pytest.approx(built_in, rel=1e-15)
    assert [state.name for state in FRICTIONS["bristly"].states] == ["bristle"]


def test_a_contact_law_with_a_state_relaxes_without_contact():
    """A spring and a damper in series: no force without penetration, and the damper's rate under the spring's force."""

    def series(delta, ddelta, ddelta0, creep, joint):
        force = joint.branch * (delta - creep)
        return force, force / 50.0

    register_contact("series", series, parameters=[Parameter("branch", "N/m", None, "stiffness")],
                     states=[State("creep", "m", 1e-6)])  # fmt: skip
    law = joint(contact="series", branch=2e4)
    assert normal_force(3e-6, 0.0, (0.1, 1e-6, 0.0, 0.0), law) == pytest.approx((4e-2, 8e-4, 0.0, 0.0), rel=1e-12)
    assert normal_force(-3e-6, 0.1, (0.1, 1e-6, 0.0, 0.0), law) == pytest.approx((0.0, -4e-4, 0.0, 0.0), rel=1e-12)
    assert normal_force(3e-6, 0.0, (0.1, 5e-6, 0.0, 0.0), law)[0] == 0.0  # it does not pull


def test_no_contact_pulls_nor_acts_without_penetration():
    register_contact("glue", lambda delta, ddelta, ddelta0, joint: -1.0)
    register_contact("far", lambda delta, ddelta, ddelta0, joint: 1.0)
    assert contact_force(1e-6, 0.0, 0.0, joint(contact="glue")) == 0.0
    assert contact_force(-1e-6, 0.0, 0.0, joint(contact="far")) == 0.0


def spring(stiffness):
    return lambda delta, ddelta, ddelta0, joint: stiffness * delta


def test_closures_compiled_functions_and_functions_without_a_source_are_laws():
    space = {}
    exec("def typed(delta, ddelta, ddelta0, joint):\n    return 4.0 * delta", space)
    register_contact("closure", spring(2.0))
    register_contact("jitted", numba.njit(spring(3.0)))
    register_contact("typed", space["typed"])
    for name, stiffness in (("closure", 2.0), ("jitted", 3.0), ("typed", 4.0)):
        assert contact_force(0.5, 0.0, 0.0, joint(contact=name)) == 0.5 * stiffness


def test_a_law_registered_again_is_the_new_one_and_records_made_before_keep_theirs():
    register_contact("again", spring(2.0))
    before = joint(contact="again")
    register_contact("again", spring(3.0))
    assert contact_force(1.0, 0.0, 0.0, joint(contact="again")) == 3.0
    assert contact_force(1.0, 0.0, 0.0, before) == 2.0


@pytest.mark.parametrize(
    ("register", "name"), [(register_contact, "hertz"), (register_film, "long"), (register_friction, "none")]
)
def test_built_in_laws_cannot_be_replaced(register, name):
    with pytest.raises(ValueError, match=f'law "{name}" is built in: register yours under another name$'):
        register(name, spring(1.0))


def helper(x):
    return x


UNFIT = [
    (register_contact, lambda delta, ddelta: 1.0, r"must take \(delta, ddelta, ddelta0, joint\)"),
    (register_contact, math.sqrt, "is not a Python function"),
    (register_contact, None, "give a force, a factor, or both"),
    (register_film, lambda eps, deps, ew: (1.0, 1.0, 1.0), r"must take \(eps, deps, ew, slenderness\)"),
    (register_friction, lambda v: v, r"must take \(v, joint\)"),
]
UNCOMPILABLE = [
    (register_contact, lambda delta, ddelta, ddelta0, joint: (1.0, 2.0), "must return float64"),
    (register_contact, lambda delta, ddelta, ddelta0, joint: joint.hardness, "hardness"),
    (register_contact, lambda delta, ddelta, ddelta0, joint: helper(delta), "helper"),
    (register_film, lambda eps, deps, ew, slenderness: (eps, ew), "must return UniTuple"),
    (register_film, lambda eps, deps, ew, slenderness: eps, "must return UniTuple"),
]


@compiled_only
@pytest.mark.parametrize(
    ("states", "law", "reason"),
    [
        (
            [State("x", "m", 1.0)],
            lambda delta, ddelta, ddelta0, x, joint: delta,
            r"returns float64; must return UniTuple",
        ),
        (
            [State("x", "m", 1.0)],
            lambda delta, ddelta, ddelta0, joint: delta,
            r"must take \(delta, ddelta, ddelta0, x, joint",
        ),
        (4 * [State("x", "m", 1.0)], lambda delta, ddelta, ddelta0, x, joint: delta, "at most 3 are possible"),
        (2 * [State("x", "m", 1.0)], lambda delta, ddelta, ddelta0, x, joint: delta, "no other state's"),
        (["x"], lambda delta, ddelta, ddelta0, x, joint: delta, r"'x' is not a linkages\.laws\.State"),
    ],
)
def test_unfit_states_are_refused_in_one_line(states, law, reason):
    with pytest.raises(ValueError, match=reason) as refused:
        register_contact("unfit", law, states=states)
    assert len(str(refused.value).splitlines()) == 1
    assert not registered(["unfit"])


@pytest.mark.parametrize(
    ("register", "function", "reason"), [*UNFIT, *(pytest.param(*case, marks=compiled_only) for case in UNCOMPILABLE)]
)
def test_unfit_functions_are_refused_in_one_line(register, function, reason):
    with pytest.raises(ValueError, match=reason) as refused:
        register("unfit", function)
    assert '"unfit"' in str(refused.value)
    assert len(str(refused.value).splitlines()) == 1
    assert not registered(["unfit"])


def test_a_factor_that_fails_is_refused():
    with pytest.raises(ValueError, match=r'contact law "unfit": ZeroDivisionError: float division by zero$'):
        register_contact("unfit", factor=lambda e: 1.0 / (e - e))


def test_an_experiment_can_name_a_law_registered_later():
    name = TypeAdapter(ContactName)
    with pytest.raises(ValidationError, match='"later" is unknown'):
        name.validate_python("later")
    register_contact("later", spring(1.0))
    assert name.validate_python("later") == "later"
    with pytest.raises(ValidationError, match="later"):  # among the nearest
        name.validate_python("lateer")


def forget(name):
    for kind, law in list(user_laws._registered):
        if law == name:
            del user_laws.REGISTRIES[kind][name], user_laws._registered[kind, name]


def test_laws_go_to_another_process():
    """As Dask sends them: functions by value."""
    register_contact("sent", spring(5.0), source="a page")
    sent = cloudpickle.dumps(registered(["sent", "hertz"]))
    forget("sent")
    restore(pickle.loads(sent))
    assert contact_force(1.0, 0.0, 0.0, joint(contact="sent")) == 5.0
    assert CONTACTS["sent"].source == "a page"


def test_a_system_takes_the_laws_of_its_elements_and_contacts_along(system_of):
    register_contact("stop", spring(5.0))
    register_contact("touch", spring(6.0))
    register_contact("teeth", spring(7.0))
    toml = """duration = 1e-3
[drives.O]
speed = 1.0
[drives.O.backlash]
play = 0.01
contact = {law = "teeth", restitution = 1.0, stiffness = 1e5}
[stops.end]
joint = "O"
side = "upper"
limit = 3.0
contact = {law = "stop", restitution = 1.0, stiffness = 1e5}
[contacts.floor]
point = "coupler"
anchor = [0.0, -1.0]
contact = {law = "touch", restitution = 1.0, stiffness = 1e5}
"""
    sent = cloudpickle.dumps(system_of(four_bar(), toml))
    names = ["stop", "touch", "teeth"]
    for name in names:
        forget(name)
    pickle.loads(sent)
    assert [law.name for law in registered(names)] == names


def test_what_comes_from_another_process_replaces_older_laws_alone():
    register_contact("shared", spring(1.0))
    old = registered(["shared"])
    here = CONTACTS["shared"]
    restore(old)
    assert CONTACTS["shared"] is here
    register_contact("shared", spring(2.0))
    new = registered(["shared"])
    restore(old)
    assert contact_force(1.0, 0.0, 0.0, joint(contact="shared")) == 2.0
    forget("shared")
    restore(old)
    restore(new)
    assert contact_force(1.0, 0.0, 0.0, joint(contact="shared")) == 2.0


def test_records_hold_plain_functions():
    register_contact("plain", numba.njit(spring(1.0)))
    (record,) = registered(["plain"])
    assert type(record.arguments["force"]) is type(spring)


LAWS = {"joints.B.contact.law": "mine", "joints.B.friction.law": "mine"}


@slow_on_drake
@compiled_only
def test_a_run_with_registered_laws_is_the_run_with_the_built_in_ones(engine):
    """The slider-crank's first impact, to the last bit."""

    def ambrosio(v, joint):
        ramp = min(max((abs(v) - joint.v_0) / (joint.v_1 - joint.v_0), 0.0), 1.0)
        return math.copysign(joint.mu_d * ramp, v)

    register_contact("mine", lankarani_nikravesh)
    register_friction("mine", ambrosio)
    file, duration = linkages.find_file("slider_crank_dry.toml"), {"duration": 0.002}
    built_in, mine = (linkages.simulate(linkages.load(file, duration | laws), engine).columns for laws in ({}, LAWS))
    assert built_in["B.force"].max() > 0.0
    assert built_in.keys() == mine.keys()
    for name, column in built_in.items():
        np.testing.assert_array_equal(mine[name], column, err_msg=name)


@compiled_only
def test_a_run_with_a_registered_film_is_the_run_with_the_built_in_one():
    register_film("mine", long_film)
    file = linkages.find_file("seven_bar.toml")
    built_in, mine = (
        linkages.simulate(
            linkages.load(file, {"duration": 0.005, "joints.A.film": film, "joints.B.film": film}), "compiled"
        ).columns
        for film in ("long", "mine")
    )
    assert built_in["A.force"].max() > 0.0
    for name, column in built_in.items():
        np.testing.assert_array_equal(mine[name], column, err_msg=name)
