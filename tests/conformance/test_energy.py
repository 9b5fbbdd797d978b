"""Energy balance: the integral of all power columns is the change of energy, for all joint models and loads.

Kinetic and potential energy follow from positions and speeds, powers from forces: the balance fails if a force, a couple
or a power is left out, or belongs to another state. Powers of gears pass from one joint to another and do not count.
"""

import numpy as np
import pytest
from machines import BEARING, bar, four_bar, joint, model, slider_crank
from shipped import shipped

from linkages import Status, ideal, simulate
from linkages.laws import CONTACTS, FILMS, FRICTIONS
from linkages.results.extremes import integral

DRIVE = "[drives.O]\nspeed = 15.0\n"
EXACT = "[solver]\naccuracy = 1e-9\n"


def missing(run, system):
    """Part of the energy that passes by powers for which the change of energy does not account."""
    experiment = system.experiment
    powers = {name: run[name] for name in run.columns if name.endswith(".power") and ".corner" not in name}
    powers = {name: power for name, power in powers.items() if name.partition(".")[0] not in experiment.gears}
    energy = run["kinetic_energy"] + run["potential_energy"]
    for table, free, column in (("springs", "free_length", "length"), ("torsion_springs", "free_angle", "angle")):
        for name, spring in getattr(experiment, table).items():  # power of stiffness and damper
            change = run[f"{name}.{column}" if f"{name}.{column}" in run else f"{name}.displacement"]
            energy = energy - 0.5 * spring.stiffness * (change - getattr(spring, free)) ** 2
    lost = integral(run, run["damping_power"])
    work = sum(integral(run, power) for power in powers.values())
    through = max(integral(run, np.abs(power)) for power in powers.values())
    assert through > 0.0
    return (energy[-1] - energy[0] + lost - work) / through


def check(engine, system, tolerance=1e-5):
    run = simulate(system, engine)
    assert run.status is Status.OK
    assert abs(missing(run, system)) < tolerance
    return run


# --- joints -----------------------------------------------------------------------------------------------------------

FILM = "model = 'lubricated'\nclearance = 1e-4\nviscosity = 0.05\n"
STEEL = "youngs_modulus = 2e11\n"
DRY = "model = 'dry'\nclearance = 1e-4\n"
LANKARANI = "law = 'lankarani-nikravesh'\nrestitution = 0.6\n" + STEEL
RUBBING = "law = 'coulomb'\ncoefficient = 0.1\n"
MIXED = "viscosity = 1e-4\nmodel = 'mixed'\nclearance = 1e-4\n"
ASPERITIES = "law = 'greenwood-tripp'\nroughness = 1e-6\ndensity = 1e11\ntip_radius = 1e-5\n"


def law_of(name):
    return f"law = '{name}'\nrestitution = 0.6\n" + (
        "stiffness = 1e8\ndamping = 100.0\n" if name == "kelvin-voigt" else STEEL
    )


def touching(joint_model, contact=LANKARANI, friction=RUBBING, more=""):
    return f"[joints.A]\n{joint_model}[joints.A.contact]\n{contact}[joints.A.friction]\n{friction}{more}"


JOINTS = {
    **{f"film {name}": f"[joints.A]\n{FILM}film = '{name}'\n" for name in FILMS},
    "film reynolds": f"[joints.A]\n{FILM}film = 'finite'\ncavitation = 'reynolds'\n",
    "film without shear": f"[joints.A]\n{FILM}shear_torque = false\n",
    "film sheared in half": f"[joints.A]\n{FILM}shear_film = 'half'\n",
    "two films": f"[joints.A]\n{FILM}[joints.B]\n{FILM}",
    **{f"contact {name}": touching(DRY, law_of(name)) for name in CONTACTS},
    **{
        f"friction {name}": touching(DRY, friction=f"law = '{name}'\ncoefficient = 0.1\n")
        for name in FRICTIONS
        if name != "none"
    },
    "mixed blend": touching(MIXED, more="[joints.A.mixed]\nlaw = 'blend'\ntransition = 1e-6\n"),
    "mixed asperities": touching(MIXED, more=f"[joints.A.mixed]\n{ASPERITIES}"),
}


@pytest.mark.parametrize("name", JOINTS)
def test_every_joint_model_keeps_the_balance(system_of, name):
    touches = "model = 'lubricated'" not in JOINTS[name]
    text = f"duration = {0.02 if touches else 0.3}\n" + DRIVE + JOINTS[name] + EXACT
    run = check("compiled", system_of(four_bar(), text))
    if touches:
        assert run["A.load"].max() > 0.0


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["film finite", "film sheared in half", "contact flores", "friction lugre", "mixed blend"]
)
def test_joint_models_keep_the_balance_on_drake(system_of, name):
    touches = "model = 'lubricated'" not in JOINTS[name]
    check(
        "drake", system_of(four_bar(), f"duration = {0.01 if touches else 0.1}\n" + DRIVE + JOINTS[name] + EXACT), 3e-5
    )


@pytest.mark.parametrize("name", ["slider_crank_guide", "slider_crank_wear", "seven_bar_rig", "slider_crank_flexible"])
def test_guides_worn_joints_and_flexible_links_keep_the_balance(name):
    system = shipped(name, **{"solver.accuracy": 1e-9})
    check("compiled", system.replaced({"duration": min(system.experiment.duration, 0.02)}))


@pytest.mark.parametrize(("key", "value"), [("clearance", 1e-7), ("viscosity", 1e9)])
@pytest.mark.parametrize("name", ["slider_crank_lubricated", "seven_bar"])
def test_the_thinnest_and_the_stiffest_films_keep_the_balance(name, key, value):
    """A nearly rigid film: joint forces and drive torques equal the ideal ones plus Petroff's torque.

    The forces follow from speeds that are a part of 1e-15 of the linkage's: one digit more is not in the state.
    """
    system = shipped(name)
    system = system.replaced({f"joints.{joint}.{key}": value for joint in system.tree.play})
    run, exact = check("compiled", system, 0.01), ideal(system)
    if name == "seven_bar":  # without shear
        at = exact.evaluate(run.time)
        loaded = run.time > 1e-10  # s; centred journals pass no force yet, and the film loads up within about 1e-14 s
        for column in ("A.force", "B.force", "O1.torque", "O4.torque"):
            noise = (run[column] - at[column])[loaded] / np.abs(at[column]).max()
            assert abs(noise.mean()) < 0.01, column  # no bias
            assert noise.std() < 0.07, column
        return
    law, bearing = system.laws[0], system.mechanism.joint["B"].bearing
    petroff = 2.0 * np.pi * law["viscosity"] * bearing.radius**3 * bearing.length / law["clearance"]
    turning = exact["rod.omega"] - exact["slider.omega"]
    assert integral(run, run["B.power"]) == pytest.approx(-petroff * integral(exact, turning**2), rel=1e-4)
    assert integral(run, run["O.power"]) == pytest.approx(petroff * integral(exact, turning**2), rel=1e-4)


# --- loads and drives -------------------------------------------------------------------------------------------------

WALL = "[{0}.contact]\nlaw = 'flores'\nrestitution = 0.5\nstiffness = 1e6\n"
LOADS = {
    "force": "[forces.P]\npoint = 'coupler_tip'\nforce = [30.0, -20.0]\n",
    "force that turns": "[forces.P]\npoint = 'coupler_tip'\naxes = 'body'\nforce = [30.0, -20.0]\n",
    "force over time": "[forces.P]\npoint = 'coupler'\ntimes = [0.0, 0.1, 0.5]\nforces = [[0, 0], [20, 5], [-9, 3]]\n",
    "force over a position": "[forces.P]\npoint = 'coupler'\nover = 'coupler.x'\nat = [-0.1, 0.1]\nforces = [[0, 0], [20, 5]]\n",
    "force by formulas": "[forces.P]\npoint = 'coupler'\nformula = ['-4*coupler.vx', '5*sin(20*t)']\n",
    "torque": "[torques.T]\nlink = 'follower'\ntorque = -2.0\n",
    "torque in a joint": "[torques.T]\njoint = 'A'\ntorque = -2.0\n",
    "torque by a formula": "[torques.T]\njoint = 'Q'\nformula = '-0.1*Q.rate + 2*cos(15*t)'\n",
    "torque over time": "[torques.T]\nlink = 'coupler'\ntimes = [0.0, 0.1, 0.5]\ntorques = [0.0, 2.0, -1.0]\n",
    "spring": "[springs.S]\npoint = 'coupler_tip'\nanchor = [0.1, -0.3]\nstiffness = 500.0\nfree_length = 0.2\n",
    "damper": "[springs.S]\npoint = 'crank_tip'\nto = 'pivot'\nstiffness = 0.0\nfree_length = 0.1\ndamping = 30.0\n",
    "torsion spring": "[torsion_springs.S]\njoint = 'A'\nstiffness = 4.0\nfree_angle = 0.3\ndamping = 0.1\n",
    "torsion damper": "[torsion_springs.S]\nlinks = ['crank', 'follower']\nstiffness = 1.0\nfree_angle = 0.0\ndamping = 0.2\n",
    "friction": "[frictions.F]\njoint = 'B'\nconstant = 0.5\nviscous = 0.02\nspeed = 0.5\n",
    "friction from the joint force": "[frictions.F]\njoint = 'B'\ncoefficient = 0.3\nradius = 0.02\nspeed = 0.5\n",
    "weight": "",
    "stop": "[stops.E]\njoint = 'Q'\nside = 'upper'\nlimit = 0.05\n" + WALL.format("stops.E"),
    "point at a line": "[contacts.E]\npoint = 'coupler_tip'\nanchor = [0.2, 0.18]\nangle = 3.0\n" + WALL.format("contacts.E")
    + "[contacts.E.friction]\n" + RUBBING,
}  # fmt: skip
DRIVES = {
    "speed": DRIVE,
    "motor": "[drives.O]\ntorque = 0.0\nspeed = 15.0\n[torques.motor]\njoint = 'O'\nformula = '0.6*(1 - O.rate/30)'\n",
    "formula": "[drives.O]\nformula = '15*t + sin(9*t)'\n",
    "torques": "[drives.O]\ntimes = [0.0, 0.3]\ntorques = [0.5, -0.2]\nspeed = 15.0\n",
}
WEIGHT = "duration = 0.3\ngravity = [0.0, -9.81, 0.0]\n"


@pytest.mark.parametrize("name", LOADS)
def test_every_load_keeps_the_balance(system_of, name):
    """The crank turns by inertia and weight, so that nothing but the load, a film and weight change its energy."""
    text = WEIGHT + DRIVES["motor"] + f"[joints.A]\n{FILM}" * ("'A'" not in LOADS[name]) + LOADS[name] + EXACT
    run = check("compiled", system_of(four_bar(), text))
    for label in {"stop": ["E"], "point at a line": ["E"]}.get(name, []):
        assert run[f"{label}.penetration"].max() > 0.0


@pytest.mark.parametrize("name", DRIVES)
def test_every_drive_keeps_the_balance(system_of, name):
    check("compiled", system_of(four_bar(), WEIGHT + DRIVES[name] + f"[joints.A]\n{FILM}" + EXACT))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["force by formulas", "spring", "torsion damper", "friction", "stop"])
def test_loads_keep_the_balance_on_drake(system_of, name):
    text = WEIGHT.replace("0.3", "0.1") + DRIVES["motor"] + LOADS[name] + EXACT
    check("drake", system_of(four_bar(), text), 3e-5)


def test_loads_of_sliding_joints_keep_the_balance(system_of):
    """Friction, a damped spring and a stop of the slider, and a rack on it that turns a wheel."""
    wheel = bar("wheel", 0.1, "__model__", 1.0) + joint("W", "world", "wheel")
    sdf = slider_crank().replace("</model>", wheel + "</model>")
    text = "duration = 0.3\n[drives.O]\ntorque = 0.5\nspeed = 5.0\n"
    text += "[frictions.F]\njoint = 'guide'\nconstant = 1.0\nviscous = 0.5\nspeed = 0.1\n"
    text += "[torsion_springs.S]\njoint = 'guide'\nstiffness = 30.0\nfree_angle = 0.03\ndamping = 1.0\n"
    text += "[gears.rack]\njoints = ['guide', 'W']\nratio = 20.0\n[stops.E]\njoint = 'guide'\nside = 'lower'\nlimit = -0.05\n"
    run = check("compiled", system_of(sdf, text + WALL.format("stops.E") + EXACT))
    assert np.abs(run["rack.torque"]).max() > 0.0
    assert run["E.penetration"].max() > 0.0


def test_a_geared_pair_with_a_damper_keeps_the_balance(system_of):
    body = bar("one", 0.1, "__model__") + bar("two", 0.2, "__model__", 1.0)
    sdf = model("pair", body + joint("A", "world", "one", inner=BEARING) + joint("B", "world", "two"))
    text = "[drives.A]\ntorque = 0.6\n[gears.mesh]\njoints = ['A', 'B']\nratio = -0.4\n"
    check("compiled", system_of(sdf, WEIGHT + text + "[frictions.F]\njoint = 'B'\nviscous = 0.02\n" + EXACT))
