"""Gears, belts and racks: accelerations, tooth torques and paths in closed form, on both engines."""

import numpy as np
import pytest
from machines import bar, joint, model, solid
from scipy.integrate import simpson

from linkages import AssemblyError, InputError, assess, ideal, load, summarize

EXACT = "[solver]\nintegrator = 'dormand_prince_5_4'\naccuracy = 1e-10\n"


def wheel(name, inertia, at):
    return solid(name, 1.0, inertia, f"{at} 0 0 0 0 0")


def gear(joints, ratio, **more):
    rest = "".join(f"{key} = {value}\n" for key, value in more.items())
    return f"[gears.mesh]\njoints = {list(joints)}\nratio = {ratio}\n{rest}"


@pytest.mark.parametrize("axis", ["0 0 1", "0 0 -1"])
@pytest.mark.parametrize("ratio", [-0.4, 2.5])
def test_two_wheels_accelerate_by_the_reduced_inertia(run, axis, ratio):
    """T = (J1 + n^2 J2) a1; the teeth take n J2 a1 from the first wheel's T."""
    sdf = model("pair", wheel("one", 0.2, 0) + wheel("two", 0.05, 0.3) + joint("A", "world", "one")
                + joint("B", "world", "two", axis=axis))  # fmt: skip
    found = run(sdf, "duration = 0.8\n[drives.A]\ntorque = 0.6\n" + gear("AB", ratio) + EXACT)
    rate = 0.6 / (0.2 + ratio**2 * 0.05)
    np.testing.assert_allclose(found["q.A"], 0.5 * rate * found.time**2, atol=1e-9)
    np.testing.assert_allclose(found["q.B"], ratio * found["q.A"], atol=1e-12)
    np.testing.assert_allclose(found["mesh.torque"], 0.05 * ratio * rate, rtol=1e-9)
    assert found["two.omega"][-1] == pytest.approx(ratio * rate * 0.8 * (1 if axis == "0 0 1" else -1), rel=1e-9)
    np.testing.assert_allclose(found["mesh.power"], 0.05 * ratio**2 * rate**2 * found.time, atol=1e-9)
    assert found.provenance["loop_error"] < 1e-12


@pytest.mark.parametrize("first", ["pinion", "rack"])
def test_a_rack_moves_as_if_its_mass_were_at_the_pitch_circle(run, first):
    """Pinion of radius r: the rack's force is m r a; given the other way round the torque on the pinion is -r times it."""
    body = wheel("pinion", 0.02, 0) + wheel("rack", 1.0, 0)
    sdf = model("rack", body + joint("A", "world", "pinion") + joint("S", "world", "rack", "prismatic", "0 1 0"))
    radius = 0.05
    mesh = gear("AS", radius) if first == "pinion" else gear("SA", 1 / radius)
    found = run(sdf, "duration = 0.5\n[drives.A]\ntorque = 0.3\n" + mesh + EXACT)
    rate = 0.3 / (0.02 + 1.0 * radius**2)
    np.testing.assert_allclose(found["rack.y"], 0.5 * radius * rate * found.time**2, atol=1e-10)
    if first == "pinion":
        np.testing.assert_allclose(found["mesh.force"], 1.0 * radius * rate, rtol=1e-9)
    else:
        np.testing.assert_allclose(found["mesh.torque"], -1.0 * radius**2 * rate, rtol=1e-9)


def test_a_wheel_that_rolls_in_a_ring_of_twice_its_size_draws_a_straight_line(system_of, run):
    """Cardan's circles: on the carrier the planet turns back twice as fast; its rim goes to and fro on a diameter."""
    body = bar("carrier", 0.1, "__model__") + bar("planet", 0.1, "carrier_tip")
    sdf = model("cardan", body + joint("O", "world", "carrier") + joint("P", "carrier_tip", "planet"))
    text = "duration = 1.0\n[drives.O]\nformula = '4*sin(2*t)'\n" + gear("OP", -2.0)
    angle = 4 * np.sin(2 * np.linspace(0, 1, 21))
    exact = ideal(system_of(sdf, text)).evaluate(np.linspace(0, 1, 21))
    found = run(sdf, text + EXACT).evaluate(np.linspace(0, 1, 21))
    for columns, accuracy in ((exact, 1e-14), (found, 1e-9)):
        np.testing.assert_allclose(columns["planet_tip.x"], 0.2 * np.cos(angle), atol=accuracy)
        np.testing.assert_allclose(columns["planet_tip.y"], 0.0, atol=accuracy)
    for name in ("O.torque", "mesh.torque", "O.fx", "P.fy"):
        np.testing.assert_allclose(found[name], exact[name], atol=1e-8 * np.abs(exact[name]).max(), err_msg=name)


def test_two_countershafts_share_a_load_that_only_their_sum_determines(engine, system_of):
    """Shaft 0 drives shaft 1 by one gear, and this shaft 4 over 2 and 3: two ways, one of which would do.

    The torques of the four wheels depend on how they were fitted; the torques of the first gear and of the drive follow from
    inertias J, speeds n and the load: T = a sum(J n^2) - n4 M.
    """
    inertias, speeds = [0.01, 0.02, 0.04, 0.06, 0.08], np.array([1.0, -0.5, 0.4, 0.4, -0.3])
    shafts = [
        wheel(f"shaft{i}", inertia, 0.2 * i) + joint(f"S{i}", "world", f"shaft{i}")
        for i, inertia in enumerate(inertias)
    ]
    text = "duration = 0.5\noutputs = ['shaft4.omega']\n[drives.S0]\nformula = '5*t**2'\n[torques.load]\nlink = 'shaft4'\ntorque = 2.0\n"
    for i, j in ((0, 1), (1, 2), (1, 3), (2, 4), (3, 4)):
        text += f"[gears.g{i}{j}]\njoints = ['S{i}', 'S{j}']\nratio = {speeds[j] / speeds[i]}\n"
    torque = 10.0 * np.array(inertias) @ speeds**2 - 2.0 * speeds[4]
    first = (10.0 * np.array(inertias[1:]) @ speeds[1:] ** 2 - 2.0 * speeds[4]) / speeds[1]
    summary = summarize(assess(system_of(model("twin", "".join(shafts)), text), engine))
    shared = {"g12", "g13", "g24", "g34"}
    for numbers in (summary, summary["ideal"]):
        assert numbers["drives"]["S0"]["torque"]["peak"] == pytest.approx(torque, rel=1e-9)
        assert numbers["loads"]["g01"]["torque"]["peak"] == pytest.approx(abs(first), rel=1e-9)
        for name in shared:
            assert numbers["loads"][name] == {"torque": {"peak": None, "time": None}, "work": None}
        assert all(entry["force"]["peak"] == 0.0 for entry in numbers["joints"].values())
    errors = summary["error"]
    assert {key for key, error in errors.items() if error is None} == {f"{name}.torque.peak" for name in shared}
    (warning,) = [entry for entry in summary["warnings"] if entry["kind"] == "indeterminate"]
    assert warning["what"].startswith("g12.torque, g13.torque, g24.torque, g34.torque are statically indeterminate")


FIVE_BAR = (
    '<frame name="pivot" attached_to="world"><pose>0.3 0 0 0 0 0</pose></frame>'
    + bar("left", 0.1, "__model__", 2.0)
    + bar("right", 0.1, "pivot", np.pi - 2.0)
    + bar("up", 0.25, "left_tip", np.arccos((0.15 - 0.1 * np.cos(2.0)) / 0.25))
    + bar("down", 0.25, "right_tip", np.pi - np.arccos((0.15 - 0.1 * np.cos(2.0)) / 0.25))
    + joint("O", "world", "left")
    + joint("Q", "world", "right")
    + joint("A", "left_tip", "up")
    + joint("B", "right_tip", "down")
    + joint("C", "up_tip", "end")
    + '<frame name="end" attached_to="down"><pose>0.25 0 0 0 0 0</pose></frame>'
)


def test_a_geared_five_bar_has_one_freedom_and_keeps_its_energy(system_of, run):
    """Cranks that turn against each other: the pin in the middle stays on the axis of symmetry; work is energy."""
    text = "duration = 0.5\n[drives.O]\ntorque = 0.5\nspeed = 3.0\n" + gear("OQ", -1.0) + EXACT
    system = system_of(model("five", FIVE_BAR), text)
    assert system.assembly.mobility == 1
    found = run(model("five", FIVE_BAR), text)
    assert np.ptp(found["q.O"]) > 2.0
    np.testing.assert_allclose(found["up_tip.x"], 0.15, atol=1e-9)
    energy = found["kinetic_energy"] - found["kinetic_energy"][0]
    np.testing.assert_allclose(energy, 0.5 * (found["q.O"] - found["q.O"][0]), atol=1e-7)
    times = np.linspace(0.0, 0.5, 1001)
    half = found.evaluate(times)
    passed = simpson(half["mesh.power"], x=times)  # by symmetry: half of the work goes to the other side
    assert passed == pytest.approx(0.5 * energy[-1], rel=1e-6)


def test_an_offset_turns_the_second_wheel_before_the_start(system_of):
    sdf = model("pair", wheel("one", 0.2, 0) + wheel("two", 0.05, 0.3) + joint("A", "world", "one")
                + joint("B", "world", "two", axis="0 0 -1"))  # fmt: skip
    system = system_of(sdf, "duration = 0.1\n[drives.A]\nspeed = 2.0\nangle = 0.5\n" + gear("AB", -2.0, offset=0.3))
    state = dict(zip(system.tree.coordinates, system.assembly.q, strict=True))
    assert state == pytest.approx({"A": 0.5, "B": -0.7}, abs=1e-13)
    assert system.determinate


def test_gears_in_a_batch_and_by_their_path(system_of):
    from linkages import simulate_batch

    sdf = model("pair", wheel("one", 0.2, 0) + wheel("two", 0.05, 0.3) + joint("A", "world", "one")
                + joint("B", "world", "two"))  # fmt: skip
    system = system_of(sdf, "duration = 0.1\n[drives.A]\ntorque = 0.6\n" + gear("AB", -2.0))
    batch = simulate_batch(system, ["gears.mesh.ratio"], [[-2.0], [3.0]], ["mesh.torque"])
    for ratio, peak in zip((-2.0, 3.0), batch.peak[:, 0, 0], strict=True):
        assert peak == pytest.approx(abs(0.05 * ratio * 0.6 / (0.2 + ratio**2 * 0.05)), rel=1e-9)


def test_a_warning_says_that_pins_are_without_the_force_of_teeth(system_of):
    """The couple of two wheels loads no pin; their teeth would, by torque over radius."""
    sdf = model("pair", wheel("one", 0.2, 0) + wheel("two", 0.05, 0.3) + joint("A", "world", "one")
                + joint("B", "world", "two"))  # fmt: skip
    text = "duration = 0.1\n[drives.A]\ntorque = 0.6\n"
    summary = summarize(assess(system_of(sdf, text + gear("AB", -2.0)), "compiled"))
    assert summary["loads"]["mesh"]["torque"]["peak"] > 0.01
    assert summary["joints"]["A"]["force"]["peak"] == summary["joints"]["B"]["force"]["peak"] == 0.0
    (warning,) = summary["warnings"]
    assert warning["kind"] == "gear"
    assert warning["what"].startswith("the forces in A, B exclude the tooth or belt forces of mesh")
    assert summarize(assess(system_of(sdf, text + "[drives.B]\ntorque = 0.0\n"), "compiled"))["warnings"] == []


CONTRADICTION = "".join(
    f"[gears.{name}]\njoints = {list(joints)}\nratio = {ratio}\n"
    for name, joints, ratio in (("g1", "AB", -0.5), ("g2", "AC", 2.0), ("g3", "BC", -3.0), ("g4", "CD", 2.0))
)


def four_wheels():
    body = "".join(wheel(f"w{k}", 0.1, 0.3 * k) + joint(name, "world", f"w{k}") for k, name in enumerate("ABCD"))
    return model("train", body)


@pytest.mark.parametrize("drive", ["", "[drives.A]\nspeed = 6.0\n", "[drives.D]\ntorque = 1.0\n"])
def test_gears_that_contradict_each_other_are_named(system_of, drive):
    """c = 2 a, b = -a/2, c = -3 b = 1.5 a: none can turn. The fourth gear follows, and contradicts nothing."""
    system = system_of(four_wheels(), f"duration = 0.1\n{drive}{CONTRADICTION}")
    if drive:
        with pytest.raises(InputError, match="gears: g1, g2 and g3: contradict each other"):
            _ = system.assembly
        return
    first, _ = summarize(assess(system, "compiled"))["warnings"]
    assert first["kind"] == "gear"
    assert first["what"] == "the gears g1, g2, g3 contradict each other, or the loops: A, B, C cannot move"


def test_a_gear_and_a_coupling_that_contradict_each_other_are_both_named(system_of):
    text = "[gears.g]\njoints = ['A', 'B']\nratio = 2.0\n[couplings.c]\njoints = ['A', 'B']\n"
    sdf = model("pair", wheel("one", 0.2, 0) + wheel("two", 0.05, 0.3) + joint("A", "world", "one")
                + joint("B", "world", "two"))  # fmt: skip
    with pytest.raises(InputError, match="gears and couplings: g and c: contradict each other"):
        _ = system_of(sdf, f"duration = 0.1\n[drives.A]\nspeed = 6.0\n{text}").assembly


def test_redundant_gears_that_agree_contradict_nothing(system_of):
    text = f"duration = 0.1\n[drives.A]\nspeed = 6.0\n{CONTRADICTION.replace('-3.0', '-4.0')}"
    summary = summarize(assess(system_of(four_wheels(), text), "compiled"))
    assert not any("contradict" in warning["what"] for warning in summary["warnings"])
    assert summary["loads"]["g4"]["torque"]["peak"] == pytest.approx(0.0, abs=1e-9)


def planetary(sun=("world", "sun"), more=""):
    """Sun and carrier turn about O in the housing, the planet on the carrier; the sun's joint by parent and child."""
    body = (
        solid("car", 1.0, 0.05, centre="0.1 0 0 0 0 0")
        + wheel("sun", 0.002, 0)
        + solid("pla", 0.3, 0.001, "0.3 0 0 0 0 0")
    )
    return model("planetary", body + joint("C", "world", "car") + joint("S", *sun) + joint("P", "car", "pla") + more)


def planetary_accelerations(along_sun, along_carrier, torque=0.2):
    """Accelerations of sun and carrier under a torque on the sun, where w_pla = a w_sun + b w_car: T = 1/2 w'Mw."""
    own, turn = np.diag([0.002, 0.05 + 1.0 * 0.1**2 + 0.3 * 0.3**2]), np.array([along_sun, along_carrier])
    return np.linalg.solve(own + 0.001 * np.outer(turn, turn), [torque, 0.0])


@pytest.mark.parametrize("sun", [("world", "sun"), ("sun", "world")])
def test_a_planetary_gear_obeys_willis_from_its_carrier(run, sun):
    """Willis: w_pla - w_car = n (w_sun - w_car), so w_pla = n w_sun + (1 - n) w_car; here 35.56 and 2.222 rad/s."""
    ratio = -2.0 if sun[0] == "world" else 2.0
    text = (
        "duration = 1.0\noutputs = ['sun.omega', 'car.omega', 'pla.omega']\n[torques.T]\nlink = 'sun'\ntorque = 0.2\n"
    )
    found = run(planetary(sun), text + gear("SP", ratio, carrier="'car'") + EXACT)
    faster, slower = planetary_accelerations(-2.0, 3.0)
    assert (faster, slower) == pytest.approx((35.5556, 2.2222), rel=1e-4)
    assert found["sun.omega"][-1] == pytest.approx(faster, rel=1e-8)
    assert found["car.omega"][-1] == pytest.approx(slower, rel=1e-8)
    np.testing.assert_allclose(found["pla.omega"], -2.0 * found["sun.omega"] + 3.0 * found["car.omega"], atol=1e-9)
    np.testing.assert_allclose(found["mesh.torque"], 0.001 * (-2.0 * faster + 3.0 * slower), rtol=1e-8)


def test_a_mimic_joint_follows_the_other_joints_own_coordinate(run):
    """The planet's angle in the carrier is n times the sun's in the housing: w_pla = n w_sun + w_car."""
    text = "duration = 1.0\noutputs = ['sun.omega', 'car.omega']\n[torques.T]\nlink = 'sun'\ntorque = 0.2\n"
    found = run(planetary(), text + gear("SP", -2.0, mimic="true") + EXACT)
    faster, slower = planetary_accelerations(-2.0, 1.0)
    assert (found["sun.omega"][-1], found["car.omega"][-1]) == pytest.approx((faster, slower), rel=1e-8)


def test_an_epicyclic_reducer_has_the_ratio_of_its_teeth(system_of):
    """A ring of 50 teeth at rest and a sun of 20: the sun turns 1 + 50/20 times as fast as the carrier."""
    text = "duration = 0.5\noutputs = ['car.angle', 'pla.angle']\n[drives.S]\nspeed = 7.0\n" + gear(
        "SP", -20 / 15, carrier="'car'"
    )
    text += f"[gears.ring]\njoints = ['R', 'P']\nratio = {50 / 15}\ncarrier = 'car'\n[drives.R]\nspeed = 0.0\n"
    ring = wheel("annulus", 0.1, 0) + joint("R", "world", "annulus")
    system = system_of(planetary(more=ring), text)
    assert system.determinate
    found = ideal(system)
    assert found["car.angle"][-1] == pytest.approx(0.5 * 7.0 / 3.5, abs=1e-12)
    assert found["pla.angle"][-1] == pytest.approx(0.5 * 2.0 * (1 - 50 / 15), abs=1e-12)


def test_flanks_of_a_planetary_gear_that_turns_as_one_body_never_touch(run):
    text = "duration = 0.5\n[drives.S]\ntorque = 0.0\nspeed = 5.0\n[drives.C]\ntorque = 0.0\nspeed = 5.0\n"
    slack = "[gears.mesh.backlash]\nplay = 0.01\n[gears.mesh.backlash.contact]\nlaw = 'hunt-crossley'\nrestitution = 0.9\nstiffness = 1e4\n"
    found = run(planetary(), text + gear("SP", -2.0, carrier="'car'") + slack + "[solver]\nmax_step = 1e-3\n")
    np.testing.assert_allclose(found["mesh.angle"], 0.0, atol=1e-9)
    np.testing.assert_allclose(found["mesh.torque"], 0.0, atol=1e-9)
    assert found["pla.omega"][-1] == pytest.approx(5.0, abs=1e-9)


def test_links_that_fixed_joints_make_one_body_are_one_carrier(system_of):
    """Wheels in two bearing brackets that are fixed to the housing turn by the ratio, without a carrier."""
    bracket = solid("bracket", 1.0) + joint("weld", "world", "bracket", "fixed")
    body = bracket + wheel("one", 0.2, 0) + wheel("two", 0.05, 0.3)
    sdf = model("pair", body + joint("A", "world", "one") + joint("B", "bracket", "two"))
    system = system_of(sdf, "duration = 0.1\n[drives.A]\nspeed = 1.0\n" + gear("AB", -2.0))
    assert dict(zip(system.tree.coordinates, system.assembly.v, strict=True))["B"] == pytest.approx(-2.0)


#: case -> (gear of a planetary gear, expected part of the message)
PLANETARY_REFUSED = {
    "no carrier": (
        gear("SP", -2.0),
        'gears.mesh.joints: "S" and "P" share no link, so that their angles are seen from',
    ),
    "both": (gear("SP", -2.0, carrier="'car'", mimic="true"), "gears.mesh: give either carrier or mimic"),
    "unknown carrier": (gear("SP", -2.0, carrier="'cart'"), 'gears.mesh.carrier: "cart" is not in machine.sdf'),
    "rack elsewhere": (gear("XP", -2.0, carrier="'car'"), 'is "car", but "X" is prismatic; name a link that it joins'),
}


@pytest.mark.parametrize("case", PLANETARY_REFUSED)
def test_a_gear_that_can_be_meant_in_two_ways_is_refused_with_the_remedy(system_of, case):
    text, reason = PLANETARY_REFUSED[case]
    rack = wheel("rack", 1.0, 0) + joint("X", "world", "rack", "prismatic", "0 1 0")
    with pytest.raises(InputError) as problem:
        system_of(planetary(more=rack), "duration = 1.0\n" + text)
    assert reason in str(problem.value)
    assert "\n" not in str(problem.value)


#: case -> (text, expected part of the message)
REFUSED = {
    "no ratio": ("[gears.mesh]\njoints = ['A', 'B']\n", "gears.mesh.ratio: is missing"),
    "ratio of zero": (gear("AB", 0.0), "gears.mesh: ratio is 0; the second joint would not move"),
    "one joint": (gear("A", 1.0), "gears.mesh.joints"),
    "twice the same": (gear("AA", 1.0), 'gears.mesh: both joints are "A"'),
    "unknown joint": (gear("AC", 1.0), 'gears.mesh.joints: "C" is not in machine.sdf; known are: A, B'),
    "name of a joint": (gear("AB", 1.0).replace("mesh", "A"), "gears.A: is also the name of"),
    "two drives": (
        gear("AB", 2.0) + "[drives.A]\nspeed = 1.0\n[drives.B]\nspeed = 2.0\n",
        "2 drives for 1 degree of freedom",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_wrong_gears_are_refused_in_one_line(experiment_file, case):
    text, reason = REFUSED[case]
    sdf = model("pair", wheel("one", 0.2, 0) + wheel("two", 0.05, 0.3) + joint("A", "world", "one")
                + joint("B", "world", "two"))  # fmt: skip
    with pytest.raises((InputError, AssemblyError)) as problem:
        load(experiment_file(sdf, "duration = 1.0\n" + text)).assembly  # noqa: B018
    assert reason in str(problem.value)
    assert "\n" not in str(problem.value)
