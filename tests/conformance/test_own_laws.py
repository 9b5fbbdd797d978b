"""User-defined laws with parameters: set in a file, varied and optimised, on both engines, in closed form."""

import math

import numpy as np
import pytest
from engines import slow_on_drake
from machines import BEARING, joint, model, solid
from scipy.optimize import minimize_scalar

from linkages import extremes, find_file, laws, load, simulate, simulate_batch
from linkages.laws import Parameter
from optim import Evaluator, load_study, optimise
from optim.evaluate.single_runs import run_on_drake

MASS, SPEED, GRAVITY = 2.0, 0.5, 9.81
EXACT = "[solver]\nintegrator = 'dormand_prince_5_4'\naccuracy = 1e-9\nmax_step = 1e-3\n"


def damped_spring(delta, ddelta, ddelta0, joint):
    return joint.my_stiffness * delta + joint.my_damping * ddelta


def rising(v, joint):
    return math.copysign(joint.base + joint.slope * abs(v), v)


def damped_cushion(eps, deps, ew, slenderness, joint):
    """The same in all directions, where nothing turns."""
    return -joint.drag * deps - joint.cushion * eps, 0.5 * joint.drag * ew, 0.0


@pytest.fixture(autouse=True)
def _own_laws(own_registries):
    laws.register_contact(
        "damped spring",
        damped_spring,
        parameters=[
            Parameter("my_stiffness", "N/m", None, "stiffness", gt=0.0),
            Parameter("my_damping", "N s/m", 0.0, "damping", ge=0.0),
        ],
    )
    laws.register_friction(
        "rising",
        rising,
        parameters=[
            Parameter("base", "1", 0.1, "coefficient at rest", ge=0.0, le=1.0),
            Parameter("slope", "s/m", None, "rise of the coefficient over the speed", gt=0.0),
        ],
    )
    laws.register_film(
        "cushion",
        damped_cushion,
        parameters=[
            Parameter("drag", "1", 1.0, "force over the rate of the eccentricity ratio", gt=0.0),
            Parameter("cushion", "1/s", None, "force over the eccentricity ratio", ge=0.0),
        ],
    )


#: A block that meets a stop, a point that slides on the ground, a journal that falls in its bearing.
MACHINES = {
    "contact": (
        model("block", solid("block", MASS) + joint("slide", "world", "block", "prismatic", "1 0 0")),
        f"""duration = 0.02  # after 2 ms at the wall, the largest force within 16 ms
[drives.slide]
force = 0.0
speed = {SPEED}
[stops.wall]
joint = "slide"
side = "upper"
limit = 0.001
[stops.wall.contact]
law = "damped spring"
my_stiffness = "30 N/mm"  # measured
my_damping = 40.0
""",
    ),
    "friction": (
        model(
            "block",
            solid("carrier", MASS).replace(f"{MASS}", "1e-9")
            + solid("block", MASS)
            + joint("along", "world", "carrier", "prismatic", "1 0 0")
            + joint("up", "carrier", "block", "prismatic", "0 1 0"),
        ),
        f"""duration = 0.1
gravity = [0.0, {-GRAVITY}, 0.0]
[drives.along]
force = 0.0
speed = {SPEED}
[contacts.foot]
point = "block"
anchor = [0.0, 0.0]
[contacts.foot.contact]
law = "damped spring"
my_stiffness = 2e4
my_damping = 400.0
[contacts.foot.friction]
law = "rising"
slope = 0.2
""",
    ),
    "film": (
        model("bowl", solid("disc", MASS) + joint("J", "world", "disc", inner=BEARING)),
        f"""duration = 0.1
gravity = [0.0, {-GRAVITY}, 0.0]
[joints.J]
model = "lubricated"
clearance = 1e-3
viscosity = 1.0
shear_torque = false
film = "cushion"
cushion = 3e3
""",
    ),
}
SCALE = 1.0 * 0.02 * 0.01**3 / 1e-3**2  # viscosity*L*R^3/c^2 [N s]: times a film's force, which is in 1/s


def peak_of_wall(stiffness, damping):
    """Largest force of a mass that meets a spring with a damper at its side."""
    omega, ratio = math.sqrt(stiffness / MASS), damping / (2.0 * math.sqrt(stiffness * MASS))
    root = math.sqrt(1.0 - ratio * ratio)
    t = np.linspace(0.0, math.pi / (root * omega), 20001)
    x = SPEED / (root * omega) * np.exp(-ratio * omega * t) * np.sin(root * omega * t)
    v = SPEED * np.exp(-ratio * omega * t) * (np.cos(root * omega * t) - ratio / root * np.sin(root * omega * t))
    return float((stiffness * x + damping * v).max())


def speed_after(base, slope):
    """Speed at the end, under a normal force that is m g but for the settling of the contact: dv/dt = -g mu(v)."""
    return (SPEED + base / slope) * math.exp(-GRAVITY * slope * 0.1) - base / slope


def peak_of_journal(drag, cushion):
    """Largest eccentricity ratio of a journal that falls on a spring with a damper: the overshoot."""
    stiffness, damping = SCALE * cushion / 1e-3, SCALE * drag / 1e-3
    ratio = damping / (2.0 * math.sqrt(stiffness * MASS))
    return MASS * GRAVITY / stiffness / 1e-3 * (1.0 + math.exp(-math.pi * ratio / math.sqrt(1.0 - ratio * ratio)))


#: By kind: the paths of its two parameters, output and functional, closed form, tolerance, pairs of values, bounds.
CASES = {
    "contact": (
        ("stops.wall.contact.my_stiffness", "stops.wall.contact.my_damping"),
        ("wall.force", "peak"),
        peak_of_wall,
        1e-6,
        [(3e4, 40.0), (3e4, 0.0), (2e4, 100.0)],
        [(2e4, 4e4), (20.0, 300.0)],
    ),
    "friction": (
        ("contacts.foot.friction.base", "contacts.foot.friction.slope"),
        ("block.vx", "min"),
        speed_after,
        1e-4,  # the contact settles at another depth than it begins
        [(0.1, 0.2), (0.2, 0.2), (0.1, 0.8)],
        [(0.05, 0.2), (0.1, 0.5)],
    ),
    "film": (
        ("joints.J.drag", "joints.J.cushion"),
        ("J.eccentricity_ratio", "peak"),
        peak_of_journal,
        1e-5,
        [(1.0, 3e3), (4.0, 3e3), (1.0, 6e3)],
        [(1.0, 5.0), (2e3, 5e3)],
    ),
}
KINDS = pytest.mark.parametrize("kind", CASES)


@slow_on_drake
@KINDS
def test_parameters_of_a_file_and_by_path_act_as_the_law_says(experiment_file, kind, engine):
    paths, (output, functional), expected, tolerance, pairs, _ = CASES[kind]
    system = load(experiment_file(MACHINES[kind][0], MACHINES[kind][1] + EXACT))
    assert tuple(map(system.value, paths)) == pairs[0]
    for pair in pairs:
        run = simulate(system.replaced(dict(zip(paths, pair, strict=True))), engine)
        found = getattr(extremes(run, [output])[output], functional)
        assert found == pytest.approx(expected(*pair), rel=tolerance)


@KINDS
def test_a_batch_varies_the_parameters(experiment_file, kind):
    paths, (output, functional), expected, tolerance, pairs, _ = CASES[kind]
    system = load(experiment_file(MACHINES[kind][0], MACHINES[kind][1] + EXACT))
    batch = simulate_batch(system, paths, pairs, [output])
    found = batch.minimum if functional == "min" else batch.peak
    np.testing.assert_allclose(found[:, 0, 0], [expected(*pair) for pair in pairs], rtol=tolerance)


STUDY = """experiment = "experiment.toml"
set.solver.accuracy = 1e-7  # a tenth of a per mille is asserted
[variables.first]
path = "{0}"
lower = {2}
upper = {3}
[variables.second]
path = "{1}"
lower = {4}
upper = {5}
[objectives.worst]
terms = [{{functional = "{7}", output = "{6}"}}]
[algorithm]
name = "grg"
tolerance = 1e-5  # of the optimum: far less than is asserted
"""


@slow_on_drake
@KINDS
def test_a_study_finds_the_best_parameters(experiment_file, tmp_path, kind, engine):
    paths, asked, expected, tolerance, _, bounds = CASES[kind]
    experiment_file(MACHINES[kind][0], MACHINES[kind][1] + EXACT)
    (tmp_path / "study.toml").write_text(STUDY.format(*paths, *bounds[0], *bounds[1], *asked))
    study = load_study(tmp_path / "study.toml")
    evaluator = Evaluator(study, engine=run_on_drake) if engine == "drake" else None
    best = optimise(study, evaluator=evaluator)["best"]
    if kind == "contact":  # the softest spring, and the damper whose first force is not yet the largest
        found = minimize_scalar(lambda damping: peak_of_wall(2e4, damping), bounds=bounds[1], options={"xatol": 1e-3})
        least = found.fun
    else:  # the most friction; the stiffest film with the most drag
        least = expected(*(high for _, high in bounds))
    assert best["objectives"]["worst"] == pytest.approx(least, rel=max(tolerance, 1e-4))


def test_a_law_may_divide_by_the_approach_speed():
    """The same as Hunt and Crossley's with e = 0.8, whose factor is 0.3."""
    laws.register_contact(
        "ratio",
        lambda delta, ddelta, ddelta0, joint: joint.my_stiffness * delta * (1.0 + 0.3 * ddelta / ddelta0),
        parameters=[Parameter("my_stiffness", "N/m", None, "stiffness", gt=0.0)],
    )
    built_in = {"law": "hunt-crossley", "restitution": 0.8, "exponent": 1.0, "clip": False, "stiffness": 2e7}
    times, found = np.linspace(0.0, 0.0006, 7), []
    for contact in ({"law": "ratio", "my_stiffness": 2e7}, built_in):
        system = load(find_file("slider_crank_dry.toml"), {"duration": 0.0006, "joints.B.contact": contact})
        run = simulate(system, "compiled", outputs=["B.ex"])
        assert run.status.name == "OK"
        found.append(run.evaluate(times)["B.ex"])
    np.testing.assert_allclose(*found, rtol=1e-9)
