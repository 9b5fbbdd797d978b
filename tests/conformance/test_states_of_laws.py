"""Contact and friction laws with states of their own, registered in a script, against independent integrations."""

import math
import re
from functools import cache

import numpy as np
import pytest
from engines import slow_on_drake
from machines import joint, model, solid
from scipy.integrate import solve_ivp

from linkages import InputError, extremes, laws, linearise, load, simulate, simulate_batch
from linkages.engines.compiled.stepping import Stepper
from linkages.laws import Parameter, State

MASS, SPEED, GAP = 2.0, 0.5, 0.001
EXACT = "[solver]\naccuracy = 1e-10\nmax_step = 1e-4\n"
HERTZ, BRANCH, DAMPER = 1e7, 2e5, 300.0


def maxwell(delta, ddelta, ddelta0, creep, joint):
    """Hertz's spring beside a spring and a damper in series, whose length is the state."""
    branch = joint.branch * (delta - creep)
    return joint.hertz * delta * math.sqrt(delta) + branch, branch / joint.damper


@pytest.fixture(autouse=True)
def _own_laws(own_registries):
    laws.register_contact(
        "my maxwell",
        maxwell,
        parameters=[
            Parameter("hertz", "N/m^1.5", None, "Hertz's stiffness", gt=0.0),
            Parameter("branch", "N/m", None, "stiffness of the spring in series", ge=0.0),
            Parameter("damper", "N s/m", None, "damping of the damper in series", gt=0.0),
        ],
        states=[State("creep", "m", lambda values: values["damper"] / values["branch"] * 0.1, "length of the damper")],
    )


BLOCK = model("block", solid("block", MASS) + joint("slide", "world", "block", "prismatic", "1 0 0"))
TOML = f"""duration = 0.03
outputs = ["wall.force", "block.x", "block.vx"]
[drives.slide]
force = 0.0
speed = {SPEED}
[stops.wall]
joint = "slide"
side = "upper"
limit = {GAP}
[stops.wall.contact]
"""
#: The law of a script, and the one of the package, with the same numbers.
LAWS = {
    "script": f"law = 'my maxwell'\nhertz = {HERTZ}\nbranch = {BRANCH}\ndamper = {DAMPER}\n",
    "package": f"law = 'maxwell'\nstiffness = {HERTZ}\nbranch_stiffness = {BRANCH}\nrelaxation = {DAMPER / BRANCH}\n",
}
OWNERS = pytest.mark.parametrize("owner", LAWS)
TIMES = np.array([0.001, 0.004, 0.008, 0.012, 0.016, 0.03])  # before, within, and after the impact


@cache
def expected(branch=BRANCH, damper=DAMPER):
    """Place and velocity of the block, and the force of the wall, (3, nt): three equations."""

    def force_of(x, creep):
        return max(HERTZ * x * math.sqrt(x) + branch * (x - creep), 0.0) if x > 0.0 else 0.0

    def slopes(_, y):
        x, v, creep = y
        return v, -force_of(x, creep) / MASS, branch * (max(x, 0.0) - creep) / damper

    began = GAP / SPEED
    options = {"rtol": 1e-12, "atol": 1e-15, "max_step": 1e-5, "t_eval": TIMES[1:]}
    x, v, creep = solve_ivp(slopes, (began, TIMES[-1]), [0.0, SPEED, 0.0], "DOP853", **options).y
    forces = [force_of(*each) for each in zip(x, creep, strict=True)]
    return np.column_stack([(SPEED * TIMES[0] - GAP, SPEED, 0.0), (x, v, forces)])


def check(columns, right):
    scale = np.array([1e-3, SPEED, right[2].max()])
    found = np.array([columns["block.x"] - GAP, columns["block.vx"], columns["wall.force"]])
    np.testing.assert_allclose(found / scale[:, None], right / scale[:, None], atol=2e-6)


@pytest.fixture
def system_with(experiment_file):
    return lambda owner: load(experiment_file(BLOCK, TOML + LAWS[owner] + EXACT))


@slow_on_drake
@OWNERS
def test_a_maxwell_contact_is_its_three_equations(system_with, owner, engine):
    run = simulate(system_with(owner), engine)
    right = expected()
    assert -right[1, -1] / SPEED < 0.9  # the damper has an effect
    check(run.evaluate(TIMES), right)


@pytest.mark.parametrize(
    ("owner", "key", "values"),
    [("script", "damper", [3.0, 300.0, 60000.0]), ("package", "relaxation", [1e-5, 1.5e-3, 0.3])],
)
def test_a_batch_of_a_law_with_a_state_equals_single_runs_in_every_bit(system_with, owner, key, values):
    system, path = system_with(owner).replaced({"solver.accuracy": 1e-6}), f"stops.wall.contact.{key}"
    batch = simulate_batch(system, [path], [[value] for value in values], ["wall.force"])
    single = [extremes(simulate(system.replaced({path: value}), "compiled"), ["wall.force"]) for value in values]
    np.testing.assert_array_equal(batch.peak[:, 0, 0], [each["wall.force"].peak for each in single])


#: Keys of the laws by owner, and the arguments of `expected` for a share of their values.
KEYS = {
    ("script", "branch"): lambda share: {"branch": share * BRANCH},
    ("script", "damper"): lambda share: {"damper": share * DAMPER},
    ("package", "branch_stiffness"): lambda share: {"branch": share * BRANCH, "damper": share * DAMPER},
    ("package", "relaxation"): lambda share: {"damper": share * DAMPER},
}


@pytest.mark.parametrize(("owner", "key"), KEYS)
def test_the_derivatives_of_a_law_with_a_state_are_those_of_its_equations(system_with, owner, key):
    system, path, step = system_with(owner), f"stops.wall.contact.{key}", 1e-3
    found = simulate(system, "compiled", wrt=[path]).sensitivity.evaluate(TIMES)[path]
    near = [expected(**KEYS[owner, key](1.0 + k * step)) for k in (-2, -1, 1, 2)]
    right = ((near[0] - near[3]) / 12.0 + (near[2] - near[1]) * 2.0 / 3.0) / (step * system.value(path))
    for row, output in enumerate(("block.x", "block.vx", "wall.force")):
        np.testing.assert_allclose(found[output], right[row], atol=2e-5 * np.abs(right[row]).max(), err_msg=output)


@OWNERS
def test_a_run_that_is_stopped_within_a_contact_with_a_state_goes_on_as_if_it_were_not(system_with, owner):
    system = system_with(owner)
    whole, first = Stepper(system), Stepper(system)
    whole.step(TIMES[2])
    saved = whole.state()
    whole.step(TIMES[4])
    first.restore(saved)
    first.step(TIMES[4])
    np.testing.assert_array_equal(first.state().state, whole.state().state)
    assert saved.state[-1] > 1e-4  # the damper is long


def test_the_laws_of_a_contact_have_room_for_three_states(experiment_file):
    states = [State(name, "m", 1e-6) for name in "abc"]
    laws.register_friction("three", lambda v, a, b, c, joint: (0.1 * v, v - a, v - b, v - c), states=states)
    text = TOML.replace("stops.wall", "contacts.foot") + LAWS["package"] + "[contacts.foot.friction]\nlaw = 'three'\n"
    place = "point = 'block'\nanchor = [0.0, 0.0]\n"
    text = re.sub(r"joint = .*\nside = .*\nlimit = .*\n", place, text).replace("wall.force", "foot.force")
    with pytest.raises(InputError, match="maxwell has 1 states and three 3; the laws of a contact can have 3"):
        load(experiment_file(BLOCK, text + "coefficient = 0.1\n"))


PULLED = model(
    "block",
    solid("carrier", MASS).replace(f"{MASS}", "1e-9")
    + solid("block", MASS)
    + joint("along", "world", "carrier", "prismatic", "1 0 0")
    + joint("up", "carrier", "block", "prismatic", "0 1 0"),
)
PULL, SIGMA, STEADY, GROUND, DASHPOT = 4.5, 2e3, 0.2, 2e4, 400.0


def dahl(v, bristle, joint):
    """Dahl's friction: the bristles are a spring that yields at the steady coefficient."""
    return joint.sigma * bristle, v - joint.sigma * abs(v) * bristle / joint.steady


def slid(times):
    """Place and velocity of a block that a constant force pulls, while it settles on the ground under its weight."""

    def slopes(_, y):
        _, v, depth, sinking, bristle = y
        load = max(GROUND * depth + DASHPOT * sinking, 0.0)
        rate = v - SIGMA * abs(v) * bristle / STEADY
        return v, (PULL - load * SIGMA * bristle) / MASS, sinking, 9.81 - load / MASS, rate

    return solve_ivp(slopes, (0.0, times[-1]), np.zeros(5), "Radau", t_eval=times, rtol=1e-10, atol=1e-14).y[:2]


@slow_on_drake
def test_a_friction_law_with_bristles_of_a_script_is_its_three_equations(experiment_file, engine):
    laws.register_friction(
        "dahl",
        dahl,
        parameters=[
            Parameter("sigma", "1/m", None, "stiffness of the bristles", gt=0.0),
            Parameter("steady", "1", None, "coefficient of steady sliding", gt=0.0),
        ],
        states=[State("bristle", "m", lambda values: values["steady"] / values["sigma"], "deflection of the bristles")],
    )
    text = f"""duration = 0.05
gravity = [0.0, -9.81, 0.0]
outputs = ["block.x", "block.vx"]
[drives.along]
force = {PULL}
[contacts.foot]
point = "block"
anchor = [0.0, 0.0]
contact = {{law = "kelvin-voigt", restitution = 0.5, stiffness = {GROUND}, damping = {DASHPOT}}}
friction = {{law = "dahl", sigma = {SIGMA}, steady = {STEADY}}}
"""
    times = np.array([0.005, 0.02, 0.05])
    x, v = slid(times)
    run = simulate(load(experiment_file(PULLED, text + EXACT)), engine).evaluate(times)
    np.testing.assert_allclose(run["block.x"], x, atol=1e-6 * abs(x).max())
    np.testing.assert_allclose(run["block.vx"], v, atol=1e-6 * abs(v).max())


@OWNERS
def test_a_linear_model_has_the_state_of_an_open_contact(system_with, owner):
    """The damper returns to its length by itself: a pole at the inverse of the relaxation time."""
    linear = linearise(system_with(owner))
    place = linear.states.index("z.wall")
    expected = np.zeros(len(linear.states))
    expected[place] = -BRANCH / DAMPER
    np.testing.assert_allclose(linear.A[place], expected, rtol=1e-9, atol=1e-9)
    assert np.abs(np.delete(linear.A[:, place], place)).max() == 0.0
