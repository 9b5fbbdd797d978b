"""Limit stops, and points at straight lines: impacts, slides and rests in closed form, on both engines."""

import numpy as np
import pytest
from engines import slow_on_drake
from machines import bar, joint, model, solid
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from linkages import InputError, assess, impacts, load, summarize

EXACT = "[solver]\nintegrator = 'dormand_prince_5_4'\naccuracy = 1e-9\nmax_step = 1e-3\n"


def block(*slides):
    """A block of 2 kg at the origin, on slides along these axes, one carried by the other."""
    body, parent = "", "world"
    for k, axis in enumerate(slides):
        name, mass = ("block", 2.0) if k == len(slides) - 1 else (f"carrier{k}", 1e-9)
        body += solid(name, mass) + joint(f"slide{k}", parent, name, "prismatic", axis)
        parent = name
    return model("block", body)


def stop(name, of, side, limit, law):
    return f"[stops.{name}]\njoint = '{of}'\nside = '{side}'\nlimit = {limit}\n[stops.{name}.contact]\n{law}\n"


HERTZ = "law = 'hertz'\nrestitution = 1.0\nstiffness = 2e5\n"


@slow_on_drake
def test_a_mass_between_two_elastic_stops_goes_to_and_fro(run):
    """Depth and duration of Hertz's impact; between them the mass flies."""
    text = "duration = 0.4\n[drives.slide0]\nforce = 0.0\nspeed = 0.5\n"
    text += stop("right", "slide0", "upper", 0.05, HERTZ) + stop("left", "slide0", "lower", '"-30 mm"', HERTZ)
    found = run(block("1 0 0"), text + EXACT)
    depth = (5 * 2.0 * 0.5**2 / (4 * 2e5)) ** 0.4
    lasts = 2.943275 * depth / 0.5  # J. E. Shigley; Johnson, Contact Mechanics, eq. (11.24)
    rows = impacts(found, ["right", "left"])
    assert [row.joint for row in rows] == ["right", "left"]
    starts = [0.1, 0.1 + lasts + 0.08 / 0.5]
    for row, start in zip(rows, starts, strict=True):
        assert row.start == pytest.approx(start, abs=1e-7)
        assert row.approach_speed == pytest.approx(0.5, rel=1e-6)
        assert row.separation_speed == pytest.approx(0.5, rel=1e-6)
        assert row.duration == pytest.approx(lasts, rel=1e-5)
        assert row.peak_penetration == pytest.approx(depth, rel=1e-6)
        assert row.peak_force == row.peak_normal_force == pytest.approx(2e5 * depth**1.5, rel=1e-6)
    assert found["block.vx"][-1] == pytest.approx(0.5, rel=1e-6)


@slow_on_drake
@pytest.mark.parametrize("axis", ["0 0 1", "0 0 -1"])
@pytest.mark.parametrize(("side", "speed"), [("upper", 3.0), ("lower", -3.0)])
def test_a_bar_bounces_off_a_linear_stop_in_half_a_period(run, axis, side, speed):
    sdf = model("arm", bar("arm", 0.4, "__model__", mass=1.5) + joint("O", "world", "arm", axis=axis))
    law = "law = 'hertz'\nrestitution = 1.0\nstiffness = 800.0\nexponent = 1.0\n"
    text = f"duration = 0.2\n[drives.O]\ntorque = 0.0\nspeed = {speed}\n"
    found = run(sdf, text + stop("end", "O", side, 0.3 * np.sign(speed), law) + EXACT)
    inertia, start = 0.08, 0.1
    frequency = np.sqrt(800.0 / inertia)
    t = found.time
    inside = (t > start) & (t < start + np.pi / frequency)
    assert inside.sum() > 5
    beyond = 3.0 / frequency * np.sin(frequency * (t[inside] - start))
    np.testing.assert_allclose(found["end.penetration"][inside], beyond, atol=1e-7)
    np.testing.assert_allclose(found["end.torque"][inside], 800.0 * beyond, atol=1e-4)
    (impact,) = impacts(found, ["end"])  # of angles and torques
    assert impact.start == pytest.approx(start, abs=1e-7)
    assert impact.duration == pytest.approx(np.pi / frequency, rel=1e-5)
    assert impact.tangential_speed == 0.0
    assert (impact.approach_speed, impact.separation_speed) == pytest.approx((3.0, 3.0), rel=1e-6)
    assert impact.peak_penetration == pytest.approx(3.0 / frequency, rel=1e-6)
    assert impact.peak_force == impact.peak_normal_force == pytest.approx(800.0 * 3.0 / frequency, rel=1e-6)
    assert found["q.O"].max() * np.sign(speed) <= 0.3 + 3.0 / frequency * (1 + 1e-6)
    assert found["O.rate"][-1] == pytest.approx(-speed, rel=1e-6)
    gone = found["end.power"] - found["end.torque"] * -np.sign(speed) * found["O.rate"]
    np.testing.assert_allclose(gone, 0.0, atol=1e-9)


@slow_on_drake
@pytest.mark.parametrize("law", ["flores", "lankarani-nikravesh", "hunt-crossley"])
def test_a_damped_stop_returns_the_mass_at_the_speed_of_its_law(run, law):
    """m v dv = -K d^n (1 + chi v/v0) dd, over d from 0 to 0: v/c - ln(1 + c v)/c^2 is the same, c = chi/v0."""
    e, v0 = 0.7, 0.5
    chi = {"flores": 8 * (1 - e) / (5 * e), "lankarani-nikravesh": 0.75 * (1 - e * e), "hunt-crossley": 1.5 * (1 - e)}
    text = f"duration = 0.15\n[drives.slide0]\nforce = 0.0\nspeed = {v0}\n"
    contact = f"law = '{law}'\nrestitution = {e}\nstiffness = 2e5\n"
    found = run(block("1 0 0"), text + stop("end", "slide0", "upper", 0.05, contact) + EXACT)
    assert found["block.vx"][-1] == pytest.approx(-returned(v0, chi[law]), rel=1e-6)


def returned(v0, chi):
    """Speed after an impact at v0 [m/s] with damping of the factor chi."""
    c = chi / v0

    def path(v):
        return v / c - np.log1p(c * v) / c**2

    return brentq(lambda v: path(-v) - path(v0), 1e-3 * v0, min(v0, (1 - 1e-9) / c))


LANKARANI = "law = 'lankarani-nikravesh'\nrestitution = 0.3\nstiffness = 1e8\n"
CHI = 0.75 * (1.0 - 0.3**2)


@pytest.mark.parametrize("limit", [0.0, -1e-12, 1e-12])
def test_an_impact_at_the_start_is_damped_as_any_other(run, limit):
    """The mass touches the stop at t = 0, or overlaps by rounding: it closes in, so the contact begins there."""
    text = "duration = 5e-3\n[drives.slide0]\nforce = 0.0\nspeed = 0.5\n"
    found = run(block("1 0 0"), text + stop("end", "slide0", "upper", limit, LANKARANI) + EXACT)
    assert found["end.penetration"][-1] < 0.0
    assert found["block.vx"][-1] == pytest.approx(-returned(0.5, CHI), rel=1e-6)


@slow_on_drake
def test_a_mass_set_down_on_the_ground_rests_there(run):
    """The contact begins at t = 0 with no approach speed: the law's limit for a drop from a height that goes to zero."""
    floor = FLOOR.format(angle=0.0, law=LANKARANI).replace("-0.2", "0.0")
    found = run(block("0 1 0"), "duration = 6e-3\ngravity = [0.0, -9.81, 0.0]\n" + floor + EXACT.replace("-9", "-10"))

    def load(depth, rate):
        return 1e8 * max(depth, 0.0) ** 1.5 * (1.0 + CHI * np.clip(rate / 1e-6, -1.0, 1.0))  # approach of 1e-6 m/s

    fall = solve_ivp(
        lambda t, y: (y[1], 9.81 - load(*y) / 2.0), (0.0, 6e-3), (0.0, 0.0), "Radau", rtol=1e-9, atol=1e-13
    )
    assert -found["block.y"][-1] == pytest.approx(fall.y[0, -1], rel=1e-6)
    assert found["foot.force"][-1] == pytest.approx(2.0 * 9.81, rel=1e-3)
    assert found["foot.force"].max() == pytest.approx(2.5 * 2.0 * 9.81, rel=1e-6)  # by energy, at the largest depth


def test_a_contact_under_way_at_the_start_is_not_damped(run):
    """A mass is released at a depth of 10 um: its contact began earlier with unknown speed; all energy returns."""
    text = "duration = 0.02\n[drives.slide0]\nforce = 0.0\n"
    found = run(block("1 0 0"), text + stop("end", "slide0", "upper", -1e-5, LANKARANI) + EXACT)
    assert found["block.vx"][-1] == pytest.approx(-np.sqrt(2.0 * 1e8 * 1e-5**2.5 / 2.5 / 2.0), rel=1e-6)


FLOOR = """[contacts.foot]
point = "block"
anchor = [0.3, -0.2]
angle = {angle}
[contacts.foot.contact]
{law}
"""


def test_a_point_falls_on_the_ground_and_returns_to_where_it_was_dropped(run):
    text = "duration = 0.5\ngravity = [0.0, -9.81, 0.0]\n" + FLOOR.format(angle=0.0, law=HERTZ) + EXACT
    found = run(block("0 1 0"), text)
    (first,) = impacts(found, ["foot"])
    assert first.start == pytest.approx(np.sqrt(2 * 0.2 / 9.81), rel=1e-7)
    assert first.approach_speed == pytest.approx(np.sqrt(2 * 9.81 * 0.2), rel=1e-7)
    apex = 2 * first.start + first.duration
    top = found.evaluate(np.array([apex]))
    assert top["block.y"][0] == pytest.approx(0.0, abs=1e-7)
    assert top["block.vy"][0] == pytest.approx(0.0, abs=1e-6)


@slow_on_drake
def test_friction_takes_its_part_of_the_normal_impulse(run):
    """A point thrown at the ground: as long as it slides, m dvx = -mu (m dvy + m g T)."""
    friction = "[contacts.foot.friction]\nlaw = 'coulomb'\ncoefficient = 0.15\nv_0 = 1e-5\nv_1 = 1e-4\n"
    text = "duration = 0.25\ngravity = [0.0, -9.81, 0.0]\n[drives.slide0]\nforce = 0.0\nspeed = 3.0\n"
    found = run(block("1 0 0", "0 1 0"), text + FLOOR.format(angle=0.0, law=HERTZ) + friction + EXACT)
    (first,) = impacts(found, ["foot"])
    at = found.evaluate(np.array([first.start, first.start + first.duration]))
    rise, lost = np.diff(at["block.vy"])[0], -np.diff(at["block.vx"])[0]
    assert lost == pytest.approx(0.15 * (rise + 9.81 * first.duration), rel=1e-6)
    assert first.tangential_speed == pytest.approx(3.0, rel=1e-9)


@slow_on_drake
@pytest.mark.parametrize("line", ["anchor", "frame"])
def test_a_point_slides_down_an_incline_as_coulomb_says(run, line):
    """Once the contact has settled: acceleration g (sin a - mu cos a), normal force m g cos a."""
    slope, mu = 0.5, 0.2
    law = "law = 'kelvin-voigt'\nrestitution = 0.5\nstiffness = 2e4\ndamping = 400.0\n"
    sdf = block("1 0 0", "0 1 0")
    text = FLOOR.format(angle=-slope, law=law).replace("[0.3, -0.2]", "[0.0, 0.0]")
    if line == "frame":
        frame = f'<frame name="hill" attached_to="world"><pose>0 0 0 0 0 {-slope}</pose></frame></model>'
        sdf = sdf.replace("</model>", frame)
        text = text.replace(f"anchor = [0.0, 0.0]\nangle = {-slope}", 'line = "hill"')
    text += f"[contacts.foot.friction]\nlaw = 'coulomb'\ncoefficient = {mu}\nv_0 = 1e-5\nv_1 = 1e-4\n"
    found = run(sdf, "duration = 0.4\ngravity = [0.0, -9.81, 0.0]\n" + text + EXACT)
    pull = 9.81 * (np.sin(slope) - mu * np.cos(slope))
    assert found["block.ax"][-1] == pytest.approx(pull * np.cos(slope), rel=1e-5)
    assert found["block.ay"][-1] == pytest.approx(-pull * np.sin(slope), rel=1e-5)
    assert found["foot.load"][-1] == pytest.approx(2.0 * 9.81 * np.cos(slope), rel=1e-5)
    assert found["foot.force"][-1] == pytest.approx(np.hypot(1.0, mu) * 2.0 * 9.81 * np.cos(slope), rel=1e-5)


@slow_on_drake
def test_a_pendulum_that_meets_a_wall_on_another_link_keeps_momentum_and_energy(run):
    """A rod swings on a sliding carriage whose wall it meets: no force from outside along the slide, none is lost."""
    wall = '<frame name="wall" attached_to="cart"><pose>0.1 -0.3 0 0 0 1.6</pose></frame>'
    body = solid("cart", 3.0) + wall + bar("rod", 0.4, "cart", -np.pi / 2, mass=1.0)
    body += joint("slide", "world", "cart", "prismatic", "1 0 0") + joint("O", "cart", "rod")
    text = f"""duration = 0.3
[drives.O]
torque = 0.0
speed = 2.0
[contacts.tip]
point = "rod_tip"
line = "wall"
[contacts.tip.contact]
{HERTZ}"""
    found = run(model("cart", body), text + EXACT)
    assert len(impacts(found, ["tip"])) == 1
    rod = 0.5 * (found["rod.vx"] + found["rod_tip.vx"])
    momentum = 3.0 * found["cart.vx"] + rod
    np.testing.assert_allclose(momentum, momentum[0], atol=1e-9)
    apart = found["tip.penetration"] < 0.0
    energy = found["kinetic_energy"][apart]
    np.testing.assert_allclose(energy, energy[0], rtol=1e-7)
    assert found["O.rate"][-1] < -1.0


@slow_on_drake
def test_the_summary_shows_stops_and_contacts(engine, system_of):
    text = "duration = 0.15\n[drives.slide0]\nforce = 0.0\nspeed = 0.5\n" + stop("end", "slide0", "upper", 0.05, HERTZ)
    found = assess(system_of(block("1 0 0"), text + EXACT), engine)
    depth = (5 * 2.0 * 0.5**2 / (4 * 2e5)) ** 0.4
    entry = summarize(found)["loads"]["end"]
    assert entry["force"]["peak"] == pytest.approx(2e5 * depth**1.5, rel=1e-6)
    assert entry["work"] == pytest.approx(0.0, abs=1e-3)


STOP = stop("end", "slide0", "upper", 0.05, HERTZ)
CONTACT = FLOOR.format(angle=0.0, law=HERTZ)
#: case -> (text, expected part of the message)
REFUSED = {
    "unknown joint": (
        STOP.replace("slide0", "slide9"),
        'stops.end.joint: "slide9" is not in machine.sdf; did you mean',
    ),
    "unknown side": (STOP.replace("upper", "uper"), "stops.end.side: is 'uper'; it should be 'upper' or 'lower'"),
    "another unit": (STOP.replace("0.05", '"3 deg"'), 'stops.end.limit: is "3 deg"; it must be measured in m'),
    "no stiffness": (STOP.replace("stiffness = 2e5", "youngs_modulus = 2e11"), "needs a power law and its stiffness"),
    "conformal": (STOP.replace("hertz", "johnson"), "stops.end.contact: a corner at a wall needs a power law"),
    "no law": (STOP.replace("law = 'hertz'", ""), "stops.end.contact.law: is missing"),
    "name of a joint": (STOP.replace("stops.end", "stops.slide0"), "stops.slide0: is also the name of"),
    "unknown point": (CONTACT.replace('"block"', '"blokc"'), 'contacts.foot.point: "blokc" is not in machine.sdf'),
    "no line": (CONTACT.replace("anchor", "# anchor"), "contacts.foot: give either line, a frame, or anchor"),
    "line on the same link": (
        CONTACT.replace("anchor = [0.3, -0.2]\nangle = 0.0", 'line = "block"'),
        'has its point and its line on the same link, "block"',
    ),
    "angle of a frame": (
        CONTACT.replace("anchor = [0.3, -0.2]\nangle = 0.0", 'line = "block"\nangle = 0.1'),
        "angle belongs to anchor",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_wrong_stops_and_contacts_are_refused_in_one_line(experiment_file, case):
    text, reason = REFUSED[case]
    with pytest.raises(InputError) as problem:
        load(experiment_file(block("1 0 0"), "duration = 1.0\n" + text))
    assert reason in str(problem.value)
    assert "\n" not in str(problem.value)
