"""Contact and friction laws with states of their own, registered in a script, against independent integrations."""

import math
from functools import cache

import numpy as np
import pytest
from engines import slow_on_drake
from machines import joint, model, solid
from scipy.integrate import solve_ivp

from linkages import laws, load, simulate, simulate_batch
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
law = "my maxwell"
hertz = {HERTZ}
branch = {BRANCH}
damper = {DAMPER}
"""
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


@slow_on_drake
def test_a_maxwell_contact_of_a_script_is_its_three_equations(experiment_file, engine):
    run = simulate(load(experiment_file(BLOCK, TOML + EXACT)), engine)
    right = expected()
    assert -right[1, -1] / SPEED < 0.9  # the damper has an effect
    check(run.evaluate(TIMES), right)


def test_a_batch_of_a_law_with_a_state_equals_single_runs_in_every_bit(experiment_file):
    system = load(experiment_file(BLOCK, TOML + EXACT))
    path, values = "stops.wall.contact.damper", [150.0, 300.0, 600.0]
    batch = simulate_batch(system, [path], [[value] for value in values], ["wall.force"])
    for k, value in enumerate(values):
        run = simulate(system.replaced({path: value}), "compiled")
        alone = simulate_batch(system.replaced({path: value}), [path], [[value]], ["wall.force"])
        assert batch.peak[k, 0, 0] == alone.peak[0, 0, 0]
        assert batch.peak[k, 0, 0] == pytest.approx(run["wall.force"].max(), rel=1e-4)


@pytest.mark.parametrize("name", ["branch", "damper"])
def test_the_derivatives_of_a_law_with_a_state_are_those_of_its_equations(experiment_file, name):
    system = load(experiment_file(BLOCK, TOML + EXACT))
    path = f"stops.wall.contact.{name}"
    run = simulate(system, "compiled", wrt=[path])
    found = run.sensitivity.evaluate(TIMES)[path]
    value = {"branch": BRANCH, "damper": DAMPER}[name]
    step = 1e-3 * value
    near = [expected(**{name: value + k * step}) for k in (-2, -1, 1, 2)]
    right = ((near[0] - near[3]) / 12.0 + (near[2] - near[1]) * 2.0 / 3.0) / step
    for row, output in enumerate(("block.x", "block.vx", "wall.force")):
        np.testing.assert_allclose(found[output], right[row], atol=2e-5 * np.abs(right[row]).max(), err_msg=output)


def test_a_run_that_is_stopped_within_a_contact_with_a_state_goes_on_as_if_it_were_not(experiment_file):
    system = load(experiment_file(BLOCK, TOML + EXACT))
    whole, first = Stepper(system), Stepper(system)
    whole.step(TIMES[2])
    saved = whole.state()
    whole.step(TIMES[4])
    first.restore(saved)
    first.step(TIMES[4])
    np.testing.assert_array_equal(first.state().state, whole.state().state)


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
