"""Backlash of gears and couplings: contacts, momentum and limit cycles in closed form, on both engines."""

from itertools import pairwise

import numpy as np
import pytest
from engines import slow_on_drake
from machines import joint, model, slider_crank, solid
from measures import worst
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.optimize import brentq
from shipped import shipped

from linkages import InputError, assess, impacts, load, simulate, simulate_batch, summarize
from linkages.results.extremes import integral
from linkages.results.link_loads import link_loads
from linkages.show.report.answer import answer

J1, J2, K, PLAY, SPEED = 0.2, 0.05, 1e4, 0.02, 2.0
EXACT = "[solver]\nintegrator = 'dormand_prince_5_4'\naccuracy = 1e-11\nmax_step = 1e-3\n"
LINEAR = f"law = 'hertz'\nrestitution = 1.0\nstiffness = {K}\nexponent = 1.0\n"
FREE = f"[drives.A]\ntorque = 0.0\nspeed = {SPEED}\n[drives.B]\ntorque = 0.0\n"


def pair(axis="0 0 1"):
    body = solid("one", 1.0, J1) + solid("two", 1.0, J2, "0.3 0 0 0 0 0")
    return model("pair", body + joint("A", "world", "one") + joint("B", "world", "two", axis=axis))


def rack(axis="1 0 0", backwards=False):
    """The second body slides, or the first one, with masses equal to the pair's inertias."""
    body = solid("one", J1, J1) + solid("two", J2, J2, "0.3 0 0 0 0 0")
    one, two = (("revolute", "0 0 1"), ("prismatic", axis))[:: -1 if backwards else 1]
    return model("rack", body + joint("A", "world", "one", *one) + joint("B", "world", "two", *two))


def mesh(ratio, play=f"play = {PLAY}", law=LINEAR, offset=0.0):
    text = f"[gears.mesh]\njoints = ['A', 'B']\nratio = {ratio}\noffset = {offset}\n"
    return text + f"[gears.mesh.backlash]\n{play}\n[gears.mesh.backlash.contact]\n{law}"


@slow_on_drake
@pytest.mark.parametrize("axis", ["0 0 1", "0 0 -1"])
@pytest.mark.parametrize("ratio", [1.0, -0.5, 3.0])
def test_free_wheels_bounce_between_the_flanks(run, engine, ratio, axis):
    """The difference of both coordinates is a mass between two linear springs: first six contacts, momentum, energy."""
    found = run(pair(axis), "duration = 0.16\n" + FREE + mesh(ratio) + EXACT)
    speed = SPEED * abs(ratio)
    frequency = np.sqrt(K * (1.0 / J2 + ratio**2 / J1))
    rows = impacts(found, ["mesh.upper", "mesh.lower"])[:6]
    starts = 0.5 * PLAY / speed + np.arange(6) * (np.pi / frequency + PLAY / speed)
    assert [row.start for row in rows] == pytest.approx(starts.tolist(), abs=1e-9)
    first, second = ("mesh.lower", "mesh.upper")[:: 1 if ratio > 0.0 else -1]
    assert [row.joint for row in rows] == 3 * [first, second]
    for row in rows:
        assert row.approach_speed == pytest.approx(speed, rel=1e-8)
        assert row.peak_force == pytest.approx(K * speed / frequency, rel=1e-8)
    momentum = J1 * found["A.rate"] + ratio * J2 * found["B.rate"]
    np.testing.assert_allclose(momentum, J1 * SPEED, rtol=1e-9)
    depth = np.maximum(found["mesh.upper.penetration"], found["mesh.lower.penetration"]).clip(0.0)
    energy = found["kinetic_energy"] + 0.5 * K * depth**2
    np.testing.assert_allclose(energy, 0.5 * J1 * SPEED**2, rtol=1e-9 if engine == "compiled" else 1e-8)
    np.testing.assert_allclose(found["mesh.angle"], found["q.B"] - ratio * found["q.A"], atol=1e-12)


@slow_on_drake
@pytest.mark.parametrize("backwards", [False, True])
def test_a_rack_and_its_pinion_bounce_as_two_wheels(run, backwards):
    """With masses equal to the inertias the coordinates are those of two wheels: in m and N instead of rad and N m."""
    found = run(rack("0 1 0", backwards), "duration = 0.08\n" + FREE + mesh(-0.5) + EXACT)
    frequency = np.sqrt(K * (1.0 / J2 + 0.25 / J1))
    rows = impacts(found, ["mesh.upper", "mesh.lower"])[:4]
    starts = PLAY / SPEED + np.arange(len(rows)) * (np.pi / frequency + 2.0 * PLAY / SPEED)
    assert [row.start for row in rows] == pytest.approx(starts.tolist(), abs=1e-9)
    assert rows[0].peak_force == pytest.approx(0.5 * K * SPEED / frequency, rel=1e-8)
    np.testing.assert_allclose(J1 * found["A.rate"] - 0.5 * J2 * found["B.rate"], J1 * SPEED, rtol=1e-9)
    name, place = ("mesh.torque", "mesh.angle") if backwards else ("mesh.force", "mesh.displacement")
    accelerated = found["two.alpha"] if backwards else found["two.ay"]
    np.testing.assert_allclose(J2 * accelerated, found[name], atol=1e-9 * rows[0].peak_force)
    np.testing.assert_allclose(found[place], found["q.B"] + 0.5 * found["q.A"], atol=1e-12)


@slow_on_drake
def test_friction_between_teeth_brakes_the_wheels_relative_to_each_other(run):
    """Newton's law of both wheels: the normal force at the base radius, and the friction at its arm."""
    radius, arm, ratio, coefficient = 0.04, 0.006, -0.5, 0.2
    teeth = f"arm = {arm}\n[gears.mesh.backlash.friction]\nlaw = 'coulomb'\ncoefficient = {coefficient}\nv_1 = 1e-3\n"
    law = LINEAR.replace(f"stiffness = {K}", f"stiffness = {K / radius**2}")
    text = "duration = 0.1\n[drives.A]\ntorque = 3.0\nspeed = 2.0\n[torques.T]\njoint = 'B'\ntorque = 0.5\n"
    found = run(pair(), text + mesh(ratio, f"normal = {PLAY * radius}\nradius = {radius}\n" + teeth, law) + EXACT)
    upper, lower = found["mesh.upper.force"], found["mesh.lower.force"]
    drag = -coefficient * arm * (upper + lower) * np.tanh(arm * (found["two.omega"] - found["one.omega"]) / 1e-3)
    tooth = radius * (lower - upper)
    assert (upper + lower).max() > 10.0
    np.testing.assert_allclose(J2 * found["two.alpha"], tooth + drag + 0.5, atol=1e-9 * np.abs(tooth).max())
    np.testing.assert_allclose(J1 * found["one.alpha"], -ratio * tooth - drag + 3.0, atol=1e-9 * np.abs(tooth).max())


@pytest.mark.parametrize("method", ["dormand_prince_5_4", "radau_iia_5"])
def test_derivatives_with_friction_between_teeth(system_of, method):
    """Central differences of runs at a coefficient."""
    teeth = "arm = 0.006\n[gears.mesh.backlash.friction]\nlaw = 'coulomb'\ncoefficient = 0.2\nv_1 = 1e-3\n"
    law = LINEAR.replace(f"stiffness = {K}", f"stiffness = {K / 0.04**2}")
    text = "duration = 0.04\n[drives.A]\ntorque = 3.0\nspeed = 2.0\n[torques.T]\njoint = 'B'\ntorque = 0.5\n"
    text += mesh(-0.5, f"normal = {PLAY * 0.04}\nradius = 0.04\n" + teeth, law)
    system = system_of(pair(), text + EXACT.replace("dormand_prince_5_4", method).replace("1e-11", "1e-10"))
    path = "gears.mesh.backlash.friction.coefficient"
    found = simulate(system, "compiled", wrt=[path]).sensitivity[path]["q.B"][-1]
    ends = [simulate(system.replaced({path: value}), "compiled")["q.B"][-1] for value in (0.19, 0.21)]
    assert found == pytest.approx((ends[1] - ends[0]) / 0.02, rel=1e-3)


def test_normal_backlash_is_measured_along_the_line_of_action(system_of):
    """A radius of 40 mm: force on the teeth, play and stiffness of the angle follow from the lever."""
    radius, ratio = 0.04, -0.5
    law = LINEAR.replace(f"stiffness = {K}", f"stiffness = {K / radius**2}")
    text = (
        "duration = 0.05\n" + FREE + mesh(ratio, f'normal = "{1e3 * PLAY * radius} mm"\nradius = "40 mm"', law) + EXACT
    )
    turned = simulate(system_of(pair(), "duration = 0.05\n" + FREE + mesh(ratio) + EXACT), "compiled")
    found = simulate(system_of(pair(), text), "compiled")
    (along,), (angle,) = impacts(found, ["mesh.upper"])[:1], impacts(turned, ["mesh.upper"])[:1]
    assert along.start == pytest.approx(angle.start, abs=1e-11)
    assert along.peak_penetration == pytest.approx(radius * angle.peak_penetration, rel=1e-9)
    assert along.peak_force == pytest.approx(angle.peak_force / radius, rel=1e-9)
    assert found["q.B"][-1] == pytest.approx(turned["q.B"][-1], abs=1e-10)


@pytest.mark.parametrize("method", ["dormand_prince_5_4", "radau_iia_5"])
def test_derivatives_with_respect_to_the_play(system_of, method):
    """After one contact the difference of coordinates is p/2 - v (t - p/(2v) - pi/w): its derivative by p is 1."""
    ratio = -0.5
    solver = EXACT.replace("dormand_prince_5_4", method).replace("1e-11", "1e-9")
    system = system_of(pair(), "duration = 0.024\n" + FREE + mesh(ratio) + solver)
    found = simulate(system, "compiled", wrt=["gears.mesh.backlash.play"])
    share = J1 / (J1 + ratio**2 * J2)
    slope = found.sensitivity["gears.mesh.backlash.play"]["q.B"]
    assert slope[-1] == pytest.approx(share, rel=1e-5)


def test_a_batch_varies_play_and_ratio(system_of):
    system = system_of(pair(), "duration = 0.03\n" + FREE + mesh(1.0) + EXACT)
    rows = [[0.01, 1.0], [0.02, -0.5]]
    batch = simulate_batch(system, ["gears.mesh.backlash.play", "gears.mesh.ratio"], rows, ["mesh.torque"])
    for (_, ratio), peak in zip(rows, batch.peak[:, 0, 0], strict=True):
        assert peak == pytest.approx(SPEED * abs(ratio) * np.sqrt(K / (1.0 / J2 + ratio**2 / J1)), rel=1e-8)


def test_the_start_within_the_play_and_the_offset(system_of):
    text = "duration = 0.02\n[drives.A]\ntorque = 0.0\nangle = 0.1\n"
    system = system_of(pair(), text + mesh(3.0, f"play = {PLAY}\nstart = 0.004", offset=0.2))
    found = simulate(system, "compiled")
    assert found["q.B"][0] == pytest.approx(3.0 * 0.1 + 0.2 + 0.004, abs=1e-12)
    assert found["mesh.angle"][0] == pytest.approx(0.004, abs=1e-12)


def test_results_of_a_coupling_beside_its_ideal(system_of):
    """An ideal coupling transmits J2 alpha; with play the same torque on average, and a peak of the impact."""
    text = "duration = 0.05\n[drives.A]\ntorque = 10.0\n" + mesh(1.0).replace("gears", "couplings").replace(
        "ratio = 1.0\n", ""
    )
    found = assess(system_of(pair(), text + EXACT), "compiled")
    ideal = J2 * 10.0 / (J1 + J2)
    np.testing.assert_allclose(found.ideal["mesh.torque"], ideal, rtol=1e-9)
    start = np.sqrt(PLAY * J1 / 10.0)  # the first shaft alone turns by half the play
    first = found.contacts[0]
    assert first.joint == "mesh.lower"
    assert first.start == pytest.approx(start, abs=1e-10)
    swing = np.sqrt(K * (1.0 / J1 + 1.0 / J2))  # pushed by the torque's share, met at a speed
    push, speed = ideal / K, 10.0 / J1 * start
    assert first.peak_penetration == pytest.approx(push + np.hypot(push, speed / swing), rel=1e-8)
    summary = summarize(found)
    entry = summary["loads"]["mesh"]
    assert entry["torque"]["peak"] == pytest.approx(K * first.peak_penetration, rel=1e-8)
    assert entry["impacts"] == len(found.contacts)
    touching = sum(row.duration for row in found.contacts)
    assert entry["contact_fraction"] == pytest.approx(touching / 0.05, rel=1e-9)
    assert entry["impacts"] == 1
    told = "All joints are ideal; the flanks of mesh touch once and are in contact for "
    assert answer(summary, "machine.toml")[0].startswith(told)


# -- limit cycles ------------------------------------------------------------------------------------------------------


def piecewise(gain, damping, y, end):
    """Exact motion of motor and load, with a controller of the load's angle, at changes of contact and at the end.

    The state is [angles (2), rates (2)] of motor and load; phases are linear, so that each has a matrix exponential.
    """
    t, found, side = 0.0, [], 0.0
    middle = {0.0: 0.0, 1.0: 0.5 * PLAY, -1.0: -0.5 * PLAY}

    def matrix(side):
        stiff = K * abs(side)
        rates = [[-stiff / J1, (stiff - gain) / J1, 0.0, -damping / J1], [stiff / J2, -stiff / J2, 0.0, 0.0]]
        constant = np.array([-stiff * middle[side] / J1, stiff * middle[side] / J2])
        return np.block([
            [np.zeros((2, 2)), np.eye(2), np.zeros((2, 1))], [np.array(rates), constant[:, None]], [np.zeros((1, 5))],
        ])  # fmt: skip

    def at(side, y, time):
        return (expm(matrix(side) * time) @ np.append(y, 1.0))[:4]

    def over(y):  # torque of the contact, or distance beyond the play: zero at a change of phase
        return (y[1] - y[0] - middle[side]) if side else abs(y[1] - y[0]) - 0.5 * PLAY

    while t < end:
        times = np.linspace(0.0, end - t, 4001)
        step = expm(matrix(side) * times[1])
        walk, values = np.append(y, 1.0), []
        for _ in times:
            values.append(over(walk[:4]) * (side or 1.0))
            walk = step @ walk
        signs = np.array(values) > 0.0
        change = np.flatnonzero(signs[1:-1] != signs[2:]) if side == 0.0 else np.flatnonzero(signs[1:-1] & ~signs[2:])
        if not len(change):
            return np.array(found), at(side, y, end - t)
        k = change[0] + 1
        span = brentq(lambda s: over(at(side, y, s)), times[k], times[k + 1], xtol=1e-15)
        y, t = at(side, y, span), t + span
        side = float(np.sign(y[1] - y[0])) if side == 0.0 else 0.0
        found.append(t)
    raise AssertionError


@pytest.mark.parametrize(("gain", "damping"), [(20.0, 0.0), (20.0, 1.5)])
def test_a_controlled_load_behind_backlash_swings_as_its_exact_solution(system_of, gain, damping):
    """A P and a PD controller of the load's angle act on the motor: a torque formula of angle and rate."""
    text = f"duration = 1.0\n[drives.A]\ntorque = 0.0\nspeed = {SPEED}\n[drives.B]\ntorque = 0.0\n"
    law = f'"-{gain}*B.coordinate - {damping}*B.rate"'
    text += f"[torques.controller]\njoint = 'A'\nformula = {law}\n" + mesh(1.0) + EXACT
    found = simulate(system_of(pair(), text), "compiled")
    changes, last = piecewise(gain, damping, np.array([0.0, 0.0, SPEED, 0.0]), 1.0)
    rows = impacts(found, ["mesh.upper", "mesh.lower"])
    met = sorted([row.start for row in rows] + [row.start + row.duration for row in rows])
    assert len(changes) > 8
    np.testing.assert_allclose(met[: len(changes)], changes, rtol=1e-6, atol=0.0)
    np.testing.assert_allclose([found["q.A"][-1], found["q.B"][-1]], last[:2], atol=1e-6 * np.abs(found["q.B"]).max())


# -- a driven pinion -------------------------------------------------------------------------------------------------


def rattled(count):
    """Starts, approach speeds and peak penetrations of the first contacts of gear_rattle.toml, phase by phase."""
    inertia, ratio, base, half, stiff, e = 3.2e-3, -0.5, 0.0564, 0.5 * 50e-6, 5e8, 0.6
    chi = 8.0 * (1.0 - e) / (5.0 * e)

    def apart(t, y):  # of the flanks from the middle, and its rate
        drive, speed = 80.0 * t + 0.01 * np.sin(251.3 * t), 80.0 + 2.513 * np.cos(251.3 * t)
        return base * (y[0] - ratio * drive), base * (y[1] - ratio * speed)

    def rates(t, y, side, began):
        at, rate = apart(t, y)
        depth = side * at - half if side else 0.0
        force = stiff * max(depth, 0.0) ** 1.5 * max(1.0 + chi * np.clip(side * rate / began, -1.0, 1.0), 0.0)
        return y[1], (-0.3 * np.tanh(y[1] / 0.5) - side * base * force) / inertia

    def crossing(side, direction):
        def depth(t, y, *_):
            return side * apart(t, y)[0] - half

        depth.terminal, depth.direction = True, direction
        return depth

    def deepest(t, y, side, began):
        return side * apart(t, y)[1]

    deepest.direction = -1
    t, y, rows = 0.0, np.array([0.0, ratio * (80.0 + 2.513)]), []
    tight = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-14, "max_step": 1e-4}
    while len(rows) < count:
        flight = solve_ivp(rates, (t, 0.25), y, args=(0.0, 1.0), events=[crossing(1.0, 1), crossing(-1.0, 1)], **tight)
        side = 1.0 if len(flight.t_events[0]) else -1.0
        t, y = flight.t[-1], flight.y[:, -1]
        began = side * apart(t, y)[1]
        touch = solve_ivp(rates, (t, 0.25), y, args=(side, began), events=[crossing(side, -1), deepest], **tight)
        peak = max(side * apart(*one)[0] - half for one in zip(touch.t_events[1], touch.y_events[1], strict=True))
        rows.append((t, began, peak))
        t, y = touch.t[-1], touch.y[:, -1]
    return np.array(rows)


@slow_on_drake
def test_the_idle_wheel_rattles_as_an_independent_integration(engine):
    """A driven pinion: its angle is prescribed, the contacts act on the wheel alone."""
    system = shipped("gear_rattle", duration=0.06, **{"solver.accuracy": 1e-10, "solver.max_step": 1e-4})
    rows = impacts(simulate(system, engine), ["mesh.upper", "mesh.lower"])
    starts, speeds, depths = rattled(6).T
    assert [row.start for row in rows[:6]] == pytest.approx(starts.tolist(), abs=1e-8)
    assert [row.approach_speed for row in rows[:6]] == pytest.approx(speeds.tolist(), rel=1e-5)
    assert [row.peak_penetration for row in rows[:6]] == pytest.approx(depths.tolist(), rel=1e-5)


# -- gearboxes of drives ---------------------------------------------------------------------------------------------

SWING = "formula = '2*t + 0.05*sin(100*t)'\n"


def gearbox(drive, joint="B", more="", law=LINEAR):
    text = f"[drives.{joint}]\n{drive}[drives.{joint}.backlash]\nplay = {PLAY}\n{more}"
    return text + f"[drives.{joint}.backlash.contact]\n{law}"


@pytest.mark.parametrize("axis", ["0 0 1", "0 0 -1"])
def test_a_gearbox_is_a_driven_wheel_with_a_coupling(system_of, axis):
    """The same motion to the last bit; the drive's torque, with the opposite one on the parent, moves the joint."""
    sdf = model("one", solid("two", 1.0, J2) + joint("B", "world", "two", axis=axis))
    found = simulate(system_of(sdf, "duration = 0.06\n" + gearbox(SWING) + EXACT), "compiled")
    coupling = mesh(1.0).replace("gears", "couplings").replace("ratio = 1.0\n", "")
    other = simulate(system_of(pair(), f"duration = 0.06\n[drives.A]\n{SWING}{coupling}{EXACT}"), "compiled")
    np.testing.assert_array_equal(found["q.B"], other["q.B"])
    first, second = (
        impacts(run, [f"{name}.upper", f"{name}.lower"]) for run, name in ((found, "B.backlash"), (other, "mesh"))
    )
    assert [row.start for row in first] == [row.start for row in second]
    turn = 1.0 if axis == "0 0 1" else -1.0
    np.testing.assert_allclose(J2 * found["two.alpha"] * turn, found["B.torque"], atol=1e-9 * first[0].peak_force)
    np.testing.assert_array_equal(found["B.rate"], turn * found["two.omega"])
    np.testing.assert_allclose(
        found["B.power"], found["B.torque"] * (2.0 + 5.0 * np.cos(100.0 * found.time)), atol=1e-9
    )


@pytest.mark.parametrize("drive", ["formula = '30*t + 0.2*sin(50*t)'\n", "torque = 0.2\nspeed = 40.0\n"])
def test_a_crank_behind_a_gearbox_balances_energy_and_loads_on_both_engines(system_of, drive):
    law = "law = 'flores'\nrestitution = 0.5\nstiffness = 2e4\n"
    text = "duration = 0.02\ngravity = [0.0, -9.81, 0.0]\n" + gearbox(drive, "O", "inertia = 1e-4\n", law)
    system = system_of(slider_crank(), text + "[solver]\naccuracy = 1e-10\n")
    ours, theirs = (simulate(system, engine) for engine in ("compiled", "drake"))
    column, difference = worst(*(run.evaluate(np.linspace(0.0, 0.02, 11)) for run in (theirs, ours)))
    assert difference < 1e-8, column
    energy, work = ours["kinetic_energy"] + ours["potential_energy"], integral(ours, ours["O.power"])
    lost = integral(ours, ours["O.backlash.upper.power"] + ours["O.backlash.lower.power"])
    assert lost < -1e-4
    assert energy[-1] - energy[0] == pytest.approx(work + lost, abs=1e-7)
    assert summarize(assess(system, "compiled"))["loads"]["O.backlash"]["impacts"] > 0
    state = tuple(part[0] for part in ours.evaluate.function.states_at(np.array([0.01])))
    assert all(link.imbalance < 1e-12 for link in link_loads(system, 0.01, state).values())


def test_derivatives_and_ideal_of_a_gearbox(system_of):
    sdf = model("one", solid("two", 1.0, J2) + joint("B", "world", "two"))
    system = system_of(sdf, "duration = 0.06\n" + gearbox("speed = 2.0\n", more="start = 0.004\n") + EXACT)
    path = "drives.B.backlash.play"
    found = simulate(system.replaced({"sdf.links.two.inertia": J2}), "compiled", wrt=[path])
    assert found["q.B"][0] == pytest.approx(0.004, abs=1e-14)
    assert found.sensitivity[path]["q.B"][-1] == pytest.approx(0.0, abs=1e-12)  # it coasts within the play
    assert system.ideal().tree.coordinates == ("B",)
    swung = system.replaced({"drives.B": {"formula": "2*t + 0.05*sin(100*t)", "backlash": {
        "play": PLAY, "contact": {"law": "hertz", "restitution": 1.0, "stiffness": K, "exponent": 1.0}}}})  # fmt: skip
    slope = simulate(swung, "compiled", wrt=[path]).sensitivity[path]["q.B"][-1]
    ends = [simulate(swung.replaced({path: PLAY + step}), "compiled")["q.B"][-1] for step in (-1e-6, 1e-6)]
    assert slope == pytest.approx((ends[1] - ends[0]) / 2e-6, rel=1e-4)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (gearbox("torque = 1.0\n"), r"drives\.B: a torque turns the gearbox' output wheel: give backlash its inertia"),
        (gearbox(SWING, "S"), r"drives\.S\.backlash: needs a revolute joint"),
        (gearbox(SWING, more="normal = 1e-4\n"), r"drives\.B\.backlash: give either play, or normal with radius"),
        (
            gearbox(SWING) + "[motors.M]\njoint = 'B'\nkind = 'curve'\nspeeds = [0, 1]\ntorques = [1, 0]\n",
            r'motors\.M\.joint: "B" has a drive with backlash',
        ),
    ],
)
def test_wrong_gearboxes_are_refused(experiment_file, text, reason):
    body = solid("two", 1.0, J2) + solid("slide", 1.0, J2)
    sdf = model("one", body + joint("B", "world", "two") + joint("S", "two", "slide", "prismatic", "1 0 0"))
    with pytest.raises(InputError, match=reason):
        load(experiment_file(sdf, "duration = 1.0\n" + text))


# -- wrong input -------------------------------------------------------------------------------------------------------

#: case -> (text, expected part of the message)
REFUSED = {
    "no play": (mesh(1.0, ""), "gears.mesh.backlash: give either play, or normal with radius"),
    "both": (mesh(1.0, "play = 0.1\nnormal = 1e-4\nradius = 0.1"), "give either play, or normal with radius"),
    "no radius": (mesh(1.0, "normal = 1e-4"), "give either play, or normal with radius"),
    "negative": (mesh(1.0, "play = -0.1"), "gears.mesh.backlash.play"),
    "unit": (mesh(1.0, 'play = "1 mm"'), 'gears.mesh.backlash.play: is "1 mm"; it must be measured in rad'),
    "outside": (mesh(1.0, "play = 0.1\nstart = 0.06"), "it must be within half the play, 0.05"),
    "no contact": (mesh(1.0).partition("[gears.mesh.backlash.contact]")[0], "gears.mesh.backlash.contact: is missing"),
    "no stiffness": (
        mesh(1.0, law="law = 'hertz'\nrestitution = 1.0\nyoungs_modulus = 2e11"),
        "power law and its stiff",
    ),
    "ratio of a coupling": (mesh(2.0).replace("gears", "couplings"), "couplings.mesh.ratio"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_wrong_backlash_is_refused_in_one_line(experiment_file, case):
    text, reason = REFUSED[case]
    with pytest.raises(InputError) as problem:
        load(experiment_file(pair(), "duration = 1.0\n" + text))
    assert reason in str(problem.value)
    assert "\n" not in str(problem.value)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (
            mesh(0.1, "normal = 1e-4\nradius = 0.1"),
            r'backlash\.normal: needs a wheel; "B" is prismatic: give play \[m\]',
        ),
        (mesh(0.1, 'play = "1 deg"'), r'backlash\.play: is "1 deg"; it must be measured in m, '),
        (mesh(0.1, "play = 1e-3\narm = 1e-3"), r"backlash: friction and arm, .*, belong together"),
        (mesh(0.1, "play = 1e-3", "law = 'hertz'\nrestitution = 1.0"), r"backlash\.contact"),
    ],
)
def test_wrong_backlash_of_a_rack_is_refused(experiment_file, text, reason):
    with pytest.raises(InputError, match=r"gears\.mesh\." + reason):
        load(experiment_file(rack(), "duration = 1.0\n" + text))


# -- two stops -----------------------------------------------------------------------------------------------------------


def test_coaxial_backlash_is_two_stops(system_of):
    """A second shaft carried by the first: its coordinate is the difference, whose limits are stops."""
    body = solid("one", 1.0, J1) + solid("two", 1.0, J2)
    stops = "".join(
        f"[stops.{side}]\njoint = 'B'\nside = '{side}'\nlimit = {sign * 0.5 * PLAY}\n[stops.{side}.contact]\n{LINEAR}"
        for side, sign in (("upper", 1.0), ("lower", -1.0))
    )
    carried = model("pair", body + joint("A", "world", "one") + joint("B", "one", "two"))
    start = f"[drives.A]\ntorque = 0.0\nspeed = {SPEED}\n[drives.B]\ntorque = 0.0\nspeed = {-SPEED}\n"
    found = impacts(
        simulate(system_of(carried, "duration = 0.1\n" + start + stops + EXACT), "compiled"), ["upper", "lower"]
    )
    other = simulate(system_of(pair(), "duration = 0.1\n" + FREE + mesh(1.0) + EXACT), "compiled")
    rows = impacts(other, ["mesh.upper", "mesh.lower"])
    assert len(rows) > 5
    assert [row.start for row in found] == pytest.approx([row.start for row in rows], abs=1e-11)
    assert all(one.start < two.start for one, two in pairwise(rows))
