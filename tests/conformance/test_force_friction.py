"""Friction from the joint force: pendulum, wedge, long slider, Painleve's paradox in closed form, on both engines."""

import numpy as np
import pytest
from engines import slow_on_drake
from machines import LUBRICATED, RUBBING_CRANK, bar, four_bar, joint, model, slider_crank, solid
from scipy.integrate import simpson
from scipy.optimize import brentq

from linkages import InputError, RunError, Status, simulate, simulate_batch
from linkages.results.extremes import integral

EXACT = "[solver]\nintegrator = 'dormand_prince_5_4'\naccuracy = 1e-9\n"
WEIGHT = "gravity = [0.0, -9.81, 0.0]\n"
G = 9.81


@slow_on_drake
def test_a_pendulum_with_a_dry_pin(run):
    """Force and friction of the pin solve one equation at each instant; Stribeck's law and a constant part."""
    mass, length, radius, slow = 1.5, 0.4, 0.05, 0.3
    inertia, half = mass * length**2 / 3.0, 0.5 * length
    sdf = model("arm", bar("arm", length, "__model__", mass=mass) + joint("O", "world", "arm"))
    text = f"duration = 0.6\n{WEIGHT}[drives.O]\ntorque = 0.0\nspeed = 5.0\n[frictions.pin]\njoint = 'O'\n"
    text += f"constant = 0.05\ncoefficient = 0.3\nradius = {radius}\nspeed = {slow}\nstatic_coefficient = 0.6\n"
    found = run(sdf, text + "stribeck_speed = 2.0\n" + EXACT, {"solver.accuracy": 1e-12})
    for k in range(0, len(found.time), 7):
        angle, rate = found["q.O"][k], found["O.rate"][k]
        along, mu = np.tanh(rate / slow), 0.3 + 0.3 * np.exp(-((rate / 2.0) ** 2))

        def force(torque, angle=angle, rate=rate):
            second = (torque - mass * G * half * np.cos(angle)) / inertia
            ax = -half * (second * np.sin(angle) + rate**2 * np.cos(angle))
            ay = half * (second * np.cos(angle) - rate**2 * np.sin(angle))
            return mass * np.hypot(ax, ay + G)

        load = brentq(lambda n: n - force(-(0.05 + mu * radius * n) * along), 0.0, 1e4, xtol=1e-13)
        assert found["O.force"][k] == pytest.approx(load, rel=1e-9)
        assert found["pin.torque"][k] == pytest.approx(-(0.05 + mu * radius * load) * along, rel=1e-9, abs=1e-12)
    times = np.linspace(0.0, 0.6, 4001)
    swing = found.evaluate(times)
    energy = swing["kinetic_energy"] + swing["potential_energy"]
    assert simpson(swing["pin.power"], x=times) == pytest.approx(energy[-1] - energy[0], abs=1e-8 * energy.max())


def wedge(angle):
    """A wedge on the ground, on its slope a load that slides up and down a wall: three sliders in a loop."""
    body = solid("wedge", 2.0) + solid("load", 3.0)
    body += joint("ground", "world", "wedge", "prismatic", "1 0 0") + joint(
        "wall", "world", "load", "prismatic", "0 1 0"
    )
    return model("wedge", body + joint("slope", "wedge", "load", "prismatic", f"{np.cos(angle)} {np.sin(angle)} 0"))


def wedge_text(mu, force, rate):
    text = f"duration = 0.05\n{WEIGHT}[drives.ground]\nforce = {force}\nspeed = {rate}\n" + EXACT
    for name in ("ground", "wall", "slope"):
        text += f"[frictions.on_{name}]\njoint = '{name}'\ncoefficient = {mu}\nspeed = 1e-3\n"
    return text


def wedge_acceleration(angle, mu, force, sense):
    """Acceleration of the moving wedge along x, with Coulomb friction at its ground, slope and wall.

    Unknown: acceleration a, normal forces on the ground g, on the slope s, on the wall w. The load rises with
    -a tan(angle); the sense is that of the wedge's speed.
    """
    sine, cosine, tangent = np.sin(angle), np.cos(angle), np.tan(angle)
    # on the load: s along (-sine, cosine), friction along the slope against its speed relative to the wedge, -sense
    fx, fy = -sine + sense * mu * cosine, cosine + sense * mu * sine
    matrix = np.array(
        [
            [2.0, sense * mu, fx, 0.0],  # wedge along x
            [0.0, 1.0, -fy, 0.0],  # wedge along y
            [0.0, 0.0, fx, 1.0],  # load along x
            [-3.0 * tangent, 0.0, -fy, -sense * mu],  # load along y
        ]
    )
    a, ground, slope, wall = np.linalg.solve(matrix, [force, 2.0 * G, 0.0, -3.0 * G])
    assert ground > 0.0
    assert slope > 0.0
    return a, abs(wall)


@slow_on_drake
@pytest.mark.parametrize(("force", "rate"), [(40.0, 0.4), (-80.0, -0.5)])
def test_a_wedge_lifts_its_load(run, force, rate):
    angle, mu = np.radians(25.0), 0.1
    found = run(wedge(angle), wedge_text(mu, force, rate))
    sense = np.sign(rate)
    expected, wall = wedge_acceleration(angle, mu, force, sense)
    early = (np.abs(found["ground.rate"]) > 0.02) & (np.sign(found["ground.rate"]) == sense)
    assert early.sum() > 5
    np.testing.assert_allclose(found["wedge.ax"][early], expected, rtol=1e-8)
    np.testing.assert_allclose(found["wall.force"][early], wall, rtol=1e-8)


@slow_on_drake
@pytest.mark.parametrize(("degrees", "locks"), [(10.0, True), (45.0, False)])
def test_a_flat_wedge_locks_itself(run, degrees, locks):
    """Its load cannot push it out where the equations of a moving wedge would slow it down; else it moves as they say."""
    angle, mu = np.radians(degrees), 0.15
    found = run(wedge(angle), wedge_text(mu, 0.0, 0.0))
    outwards, _ = wedge_acceleration(angle, mu, 0.0, 1.0)
    assert (outwards < 0.0) == locks
    if locks:
        assert 0.0 < found["ground.rate"][-1] < 1e-3  # it creeps, slower than the speed of the law
        assert abs(found["wedge.ax"][-1]) < 1e-3
    else:
        assert found["wedge.ax"][-1] == pytest.approx(outwards, rel=1e-6)


@slow_on_drake
@pytest.mark.parametrize("offset", [0.1, 0.22, 0.3])
def test_a_slider_pushed_beside_its_guide(run, offset):
    """Ends of a slider of length l carry F e/l each: a = F (1 - 2 mu e/l)/m; above e = l/(2 mu) it locks."""
    mass, length, mu, force = 2.0, 0.1, 0.2, 5.0
    handle = f'<frame name="handle" attached_to="slider"><pose>0 {offset} 0 0 0 0</pose></frame>'
    sdf = model("slider", solid("slider", mass) + handle + joint("guide", "world", "slider", "prismatic", "1 0 0"))
    text = "duration = 0.3\n[drives.guide]\nforce = 0.0\nspeed = 0.1\n[forces.push]\npoint = 'handle'\n"
    text += f"force = [{force}, 0.0]\n[frictions.rail]\njoint = 'guide'\ncoefficient = {mu}\nlength = {length}\nspeed = 1e-3\n"
    found = run(sdf, text + EXACT)
    np.testing.assert_allclose(np.abs(found["guide.moment"]), force * offset, rtol=1e-9)
    if 2.0 * mu * offset < length:
        np.testing.assert_allclose(found["slider.ax"], force / mass * (1.0 - 2.0 * mu * offset / length), rtol=1e-8)
    else:
        last, ratio = found["guide.rate"][-1], length / (2.0 * mu * offset)
        assert last == pytest.approx(1e-3 * np.arctanh(min(ratio, 1.0)), rel=1e-4) if offset > 0.25 else last > 0.0


def jamming(light, heavy, mu, rate):
    """A light slider on a rail, with a heavy point on a rod at 20 degrees from the vertical."""
    at = f"0 0 0 0 0 {np.radians(20.0) - 0.5 * np.pi}"
    body = solid("slider", light, 1e-4) + solid("rod", heavy, 1e-9, at, centre="0.3 0 0 0 0 0")
    body += joint("slide", "world", "slider", "prismatic", "1 0 0") + joint("P", "slider", "rod")
    text = f"duration = 1e-3\n{WEIGHT}[drives.slide]\nforce = 0.0\nspeed = {rate}\n[frictions.rail]\njoint = 'slide'\n"
    return model("jam", body), f"{text}coefficient = {mu}\nspeed = 1e-3\n" + EXACT


@pytest.mark.parametrize(("mu", "rate"), [(0.3, 1.0), (0.6, 1.0), (1.0, -1.0)])
def test_the_normal_force_of_a_slider_with_a_pendulum(run, mu, rate):
    """N = N_0 - g T with g = m sin cos/(M + m sin^2): at rest of the rod, N = N_0/(1 - sense mu g).

    The last case has a second solution, in which the rail pulls.
    """
    light, heavy, sine, cosine = 0.1, 1.0, np.sin(np.radians(20.0)), np.cos(np.radians(20.0))
    response = heavy * sine * cosine / (light + heavy * sine**2)
    free = light * G + heavy * G * light * cosine**2 / (light + heavy * sine**2)
    found = run(*jamming(light, heavy, mu, rate))
    expected = free / (1.0 - np.sign(rate) * mu * response)
    assert found["slide.force"][0] == pytest.approx(expected, rel=1e-6)
    assert found["rail.force"][0] == pytest.approx(-np.sign(rate) * mu * expected, rel=1e-6)


@pytest.mark.parametrize("engine", ["compiled", "drake"])
def test_painleves_paradox_is_stated(system_of, engine):
    """Beyond mu g = 1, here mu = 0.675, no force satisfies the friction of a slider that moves to this side."""
    system = system_of(*jamming(0.1, 1.0, 1.0, 1.0))
    with pytest.raises(RunError, match=r"^jammed at the start; no accelerations satisfy the friction"):
        simulate(system, engine)


def test_both_engines_agree_on_a_slider_crank(system_of):
    """With friction in all joints, one of which is cut."""
    system = system_of(slider_crank(), RUBBING_CRANK).replaced(
        {"duration": 0.02, "solver.integrator": "dormand_prince_5_4", "solver.accuracy": 1e-11}
    )
    compiled, drake = (simulate(system, engine) for engine in ("compiled", "drake"))
    assert compiled.status is drake.status is Status.OK
    times = np.linspace(0.0, 0.02, 9)
    one, other = compiled.evaluate(times), drake.evaluate(times)
    for name in ("O.rate", "in_O.torque", "in_A.torque", "in_B.torque", "rail.force", "A.force", "guide.moment"):
        np.testing.assert_allclose(one[name], other[name], rtol=1e-6, atol=1e-6 * np.abs(one[name]).max())
    energy = compiled["kinetic_energy"] + compiled["potential_energy"]
    work = sum(integral(compiled, compiled[f"{name}.power"]) for name in ("O", "in_O", "in_A", "in_B", "rail"))
    assert work == pytest.approx(energy[-1] - energy[0], abs=1e-8 * energy.max())


def test_both_engines_agree_with_a_film(system_of):
    """The film's force counts for the forces in the ideal joints, a driven one among them; also in a further diagram."""
    from pydrake.systems.framework import DiagramBuilder

    from linkages.engines.drake import add_linkage

    text = "duration = 0.01\n" + LUBRICATED.replace('outputs = ["follower.omega"]\n', "")
    for name in ("O", "B"):
        text += f"[frictions.in_{name}]\njoint = '{name}'\ncoefficient = 0.2\nradius = 0.01\nspeed = 1.0\n"
    system = system_of(four_bar(), text + "[solver]\naccuracy = 1e-8\n")
    compiled, drake = (simulate(system, engine) for engine in ("compiled", "drake"))
    assert compiled.status is drake.status is Status.OK
    times = np.linspace(0.0, 0.01, 9)
    one, other = compiled.evaluate(times), drake.evaluate(times)
    for name in ("in_O.torque", "in_B.torque", "O.torque", "B.force", "A.force"):
        np.testing.assert_allclose(one[name], other[name], rtol=1e-5, atol=1e-5 * np.abs(one[name]).max())
    with pytest.raises(InputError, match="argument: external: adds forces"):
        add_linkage(DiagramBuilder(), system, external=True)


def test_rows_of_a_batch_equal_single_runs(system_of):
    """A coefficient may be zero."""
    changes = {"duration": 0.02, "solver.integrator": "dormand_prince_5_4"}
    system, paths = (
        system_of(slider_crank(), RUBBING_CRANK).replaced(changes),
        ["frictions.in_A.coefficient", "frictions.rail.length"],
    )
    table, names = np.array([[0.0, 0.02], [0.1, 0.03], [0.3, 0.05]]), ["A.force", "in_A.torque", "rail.force"]
    batch = simulate_batch(system, paths, table, outputs=names)
    for row, values in zip(batch.last[:, 0], table, strict=True):
        run = simulate(system.replaced(dict(zip(paths, values.tolist(), strict=True))), "compiled")
        assert row.tolist() == [run[name][-1] for name in names]
