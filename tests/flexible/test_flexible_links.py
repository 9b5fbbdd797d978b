"""Flexible links in mechanisms: equations of motion, statics, natural frequencies, published runs."""

import numpy as np
import pytest
from linearised import slope
from machines import bar, circle_intersection, elastic_bar, elastic_slider_crank, joint, model, solid
from scipy.integrate import trapezoid
from shipped import shipped
from spun_beams import SPIN, SPUN, spun, tip_of

from linkages import InputError, Status, modes, simulate, simulate_batch
from linkages.base.kernel.by_reference import packed
from linkages.engines.compiled.run.runner import Runner
from linkages.mechanics.planar.bodies import make_motion, make_pose
from linkages.mechanics.planar.closure import closure_jacobian
from linkages.mechanics.planar.closure_rows import row_rate
from linkages.mechanics.planar.contacts import WIDTH
from linkages.mechanics.planar.kinematics import body_accelerations, body_positions, body_states, body_velocities
from linkages.mechanics.planar.singularities import smooth_dynamics
from linkages.mechanics.planar.workspace import make_workspace
from linkages.results.outputs.columns import columns

FLEXIBLE = """duration = {duration}
[drives.O]
speed = 150.0
[links.rod]
model = "flexible"
bending = {bending}
axial = {axial}
{more}
[solver]
accuracy = {accuracy}
"""


def experiment(duration=0.1, bending=6, axial=2, more="", accuracy=1e-9):
    return FLEXIBLE.format(duration=duration, bending=bending, axial=axial, more=more, accuracy=accuracy)


UNDEFORMED = 'start = "undeformed"\nstiffness_damping = 1.5e-5'
#: Lubricated joint B.
FILM = """[joints.B]
model = "lubricated"
clearance = 1e-4
viscosity = 0.1
shear_torque = true
"""


def energies(system, q, v):
    """Kinetic and potential energy at many states (nt, n)."""
    names, contacts = ("kinetic_energy", "potential_energy"), np.zeros((len(q), len(system.ends), WIDTH))
    values = columns(system, np.zeros(len(q)), q, v, np.zeros_like(q), contacts, names)
    return tuple(values[name] for name in names)


def mass_matrices(system, places):
    """Mass matrices (m, n, n) at places (m, n), from the kinetic energy of unit rates and of sums of two."""
    one = np.eye(places.shape[1])
    rates = np.concatenate([one, (one[:, None] + one).reshape(-1, len(one))])
    kinetic = energies(system, np.repeat(places, len(rates), axis=0), np.tile(rates, (len(places), 1)))[0]
    kinetic = kinetic.reshape(len(places), len(rates))
    single, both = kinetic[:, : len(one)], kinetic[:, len(one) :].reshape(len(places), len(one), len(one))
    return both - single[:, :, None] - single[:, None, :]


@pytest.mark.parametrize("bent", [("rod",), ("crank",), ("crank", "rod")], ids="-".join)
def test_accelerations_are_those_of_lagranges_equations(system_of, bent):
    """Mass matrix and velocity terms follow from the kinetic energy and its change with position."""
    links = "".join(f'[links.{name}]\nmodel = "flexible"\naxial = 2\ndamping = 0.0\n' for name in bent)
    toml = f"duration = 1.0\ngravity = [0.3, -9.81, 0.0]\n[drives.O]\ntorque = 0.0\nspeed = 0.0\n{links}" + FILM
    system = system_of(elastic_slider_crank(elastic_crank="crank" in bent), toml)
    tree, dice = system.tree, np.random.default_rng(1)
    n, joints = tree.size, len(tree.joint_dofs)
    small = np.where(np.arange(n) < joints, 0.5, 2e-3)
    q, v = dice.normal(size=n) * small, dice.normal(size=n) * 6.0 * small
    h, one = 1e-5, np.eye(n)
    change = (mass_matrices(system, q + h * one) - mass_matrices(system, q - h * one)) / (2 * h)
    up, down = (energies(system, q + side * h * one, 0 * one)[1] for side in (1, -1))
    force = 0.5 * np.einsum("kij,i,j->k", change, v, v) - np.einsum("kij,k,j->i", change, v, v) - (up - down) / (2 * h)
    bodies, w = tree.bodies, make_workspace(len(tree.bodies.records), n, 0, tree.bodies.shapes.shape[2])
    w.q[:], w.v[:] = q, v
    body_states(bodies, q, v, w.pose, w.vel)
    smooth_dynamics(bodies, tree.loop_rows[:0], 0, 1.0, system.gravity, packed(w))
    expected = np.linalg.solve(mass_matrices(system, q[None])[0], force)
    np.testing.assert_allclose(w.a, expected, rtol=0, atol=1e-7 * np.abs(expected).max())

    def velocity(t):  # of all bodies, sections among them
        pose, vel = make_pose(bodies), make_motion(bodies)
        body_positions(bodies, q + v * t + 0.5 * w.a * t * t, pose)
        body_velocities(bodies, pose, v + w.a * t, vel)
        return vel

    acc, step = make_motion(bodies), 1e-7
    body_accelerations(bodies, w.pose, w.vel, v, w.a, acc)
    numeric = (velocity(step) - velocity(-step)) / (2.0 * step)
    np.testing.assert_allclose(acc[1:], numeric[1:], rtol=0, atol=1e-5 * np.abs(acc).max())


def test_a_loop_that_closes_on_one_flexible_link_moves_with_its_modes(system_of):
    """Two bars join the middle and the tip of a rod: the Jacobian of the closure against the rates of its rows."""
    angle = np.arctan2(0.1, 0.075)
    body = f"""{elastic_bar("rod", 0.3, "__model__")}
<frame name="middle" attached_to="rod"><pose>0.15 0 0 0 0 0</pose></frame>
{bar("left", 0.125, "middle", angle)}{bar("right", 0.125, "left_tip", -2 * angle)}
{joint("O", "world", "rod")}{joint("A", "middle", "left")}
{joint("B", "left_tip", "right")}{joint("C", "right_tip", "rod_tip")}"""
    system = system_of(model("braced", body), 'duration = 0.1\n[links.rod]\nmodel = "flexible"\nstart = "undeformed"\n')
    tree, dice = system.tree, np.random.default_rng(2)
    pose, vel, v = make_pose(tree.bodies), make_motion(tree.bodies), dice.normal(size=tree.size)
    body_states(tree.bodies, system.assembly.q, v, pose, vel)
    rates = [row_rate(row, pose, vel) for row in tree.loop_rows]
    assert np.abs(rates).min() > 0.1
    jacobian = np.empty((len(tree.loop_rows), tree.size))
    closure_jacobian(tree.bodies, tree.loop_rows, pose, jacobian)
    assert np.abs(jacobian[:, len(tree.joint_dofs) :]).max() > 0.1
    np.testing.assert_allclose(jacobian @ v, rates, rtol=0, atol=1e-12)


#: Geometrically exact beam, extrapolated (absolute nodal coordinates, 8 and 16 elements): deflection of the rod's
#: middle [mm] and place of the slider [m] at 10, 20, 40, 60, 80, 100 ms.
TIMES = np.array([0.01, 0.02, 0.04, 0.06, 0.08, 0.1])
DEFLECTION = [0.728228, -0.051044, -0.896558, -0.010993, -1.449295, 0.143169]
#: The same for an independent floating frame with these modes, its inertia summed over points of the rod.
FLOATING = [0.7284164, -0.0506477, -0.8957451, -0.0107873, -1.4488674, 0.1426924]
SLIDER = [0.270623094, 0.150746248, 0.441092782, 0.156884564, 0.415575358, 0.169737082]
LARGEST = 1.751043


def test_simeons_slider_crank_is_that_of_other_codes(system_of):
    """Floating frames alike; a geometrically exact beam to the square of the slope, 5e-4 of the largest deflection."""
    result = simulate(system_of(elastic_slider_crank(), experiment(more=UNDEFORMED)), "compiled")
    found = result.evaluate(TIMES)
    np.testing.assert_allclose(1e3 * found["middle.deflection"], FLOATING, rtol=0, atol=1e-5 * LARGEST)
    np.testing.assert_allclose(1e3 * found["middle.deflection"], DEFLECTION, rtol=0, atol=5e-4 * LARGEST)
    np.testing.assert_allclose(found["slider.x"], SLIDER, rtol=0, atol=5e-8)
    largest = 1e3 * np.abs(result.evaluate(np.linspace(0.035, 0.037, 401))["middle.deflection"]).max()
    assert largest == pytest.approx(1.7508360, rel=1e-5)  # the floating frame's
    assert largest == pytest.approx(LARGEST, rel=3e-4)


def test_without_stiffening_it_is_that_of_linear_codes(system_of):
    """Deflections [mm] of a floating frame with six sines about the chord, without foreshortening: 6e-5 converged."""
    result = simulate(
        system_of(elastic_slider_crank(), experiment(bending=10, more=UNDEFORMED + "\nstiffening = false")), "compiled"
    )
    expected = [0.7824056, -0.0508498, -1.0008697, -0.0226943, -1.5779132, 0.1053237]
    found = 1e3 * result.evaluate(TIMES)["middle.deflection"]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-4 * 1.8487346)


def test_drake_refuses_a_link_that_does_not_stiffen(system_of):
    soft = system_of(elastic_slider_crank(), experiment(bending=2, more="\nstiffening = false"))
    with pytest.raises(
        InputError, match=r"links\.\w+\.stiffening: is false, but Drake's rigid segments always stiffen"
    ):
        simulate(soft, "drake")


def test_energy_goes_where_it_is_accounted_for(system_of):
    """Work of the drive is kinetic and strain energy, and what film and material take: to 1e-6 of that work."""
    result = simulate(system_of(elastic_slider_crank(), experiment(0.05, 4, 1, accuracy=1e-10) + FILM), "compiled")
    times = np.linspace(0.0, 0.05, 20001)
    found = result.evaluate(times)
    power = found["O.power"] + found["B.power"] - found["damping_power"]
    stored = found["kinetic_energy"] + found["potential_energy"]
    work = np.concatenate(
        [[0.0], np.cumsum(power[1:-1:2] * 4 + power[:-2:2] + power[2::2]) * (times[2] - times[0]) / 6]
    )
    exchanged = trapezoid(np.abs(found["O.power"]), times)
    assert exchanged > 5.0
    np.testing.assert_allclose(stored[::2] - stored[0], work, rtol=0, atol=1e-6 * exchanged)
    assert found["damping_power"].min() >= 0.0
    assert trapezoid(found["damping_power"], times) > 1e-3


CANTILEVER = model("cantilever", elastic_bar("rod", 0.4, "__model__") + joint("O", "world", "rod"))
#: Clamped at the left, tip force P across and X along: P L2/EI, X L2/EI, and w/L of the linear beam-column.
STATICS = [
    (0.5, 0.0, 0.166666667), (0.1, -1.0, 0.055740772), (0.1, -2.0, 0.173944931),
    (0.1, 2.0, 0.018590827), (0.1, 10.0, 0.006849034), (1.0, 5.0, 0.112577592),
]  # fmt: skip


@pytest.mark.parametrize(("across", "along", "expected"), STATICS)
def test_a_cantilever_bends_as_a_beam_column(system_of, across, along, expected):
    """The shape at rest; and the bending moment and stress at the clamp, from equilibrium."""
    unit = 2e11 * 0.008**4 / 12 / 0.4**2
    toml = f"""duration = 1e-4
[drives.O]
speed = 0.0
[forces.P]
point = "rod_tip"
force = [{along * unit}, {across * unit}]
[links.rod]
model = "flexible"
bending = 14
axial = 0
"""
    system = system_of(CANTILEVER, toml)
    result = simulate(system, "compiled")
    assert result["rod_tip.y"][0] / 0.4 == pytest.approx(expected, rel=2e-7, abs=5e-9)
    moment = unit * (across * result["rod_tip.x"][0] - along * result["rod_tip.y"][0])
    assert result["rod.bending"][0] == pytest.approx(abs(moment), rel=1e-6)
    stress = abs(along) * unit / 0.008**2 + abs(moment) * 6 / 0.008**3
    assert result["rod.stress"][0] == pytest.approx(stress, rel=1e-6)
    assert result["rod.stress_place"][0] == pytest.approx(0.0, abs=1e-6)
    assert result["rod.compression"][0] == pytest.approx(max(-along, 0.0) * unit, rel=1e-3)  # along the deflected rod


def test_a_strut_beyond_its_buckling_load_has_no_shape_at_rest(system_of):
    """A clamped beam buckles at pi^2/4 EI/L2; the message names the link."""
    unit = 2e11 * 0.008**4 / 12 / 0.4**2
    toml = """duration = 1e-4
[drives.O]
speed = 0.0
[forces.P]
point = "rod_tip"
force = [{}, 0.0]
[links.rod]
model = "flexible"
"""
    assert np.isfinite(system_of(CANTILEVER, toml.format(-0.99 * np.pi**2 / 4 * unit)).assembly.q).all()
    with pytest.raises(InputError, match=r"links\.rod\.start: the loads at t = 0 exceed its buckling load; set"):
        _ = system_of(CANTILEVER, toml.format(-1.01 * np.pi**2 / 4 * unit)).assembly


@pytest.mark.parametrize("name", SPUN)
def test_a_beam_that_is_spun_up_stiffens(system_of, name):
    data, expected, bound = SPUN[name]
    result = simulate(system_of(spun(*data), SPIN.format(keys="bending = 4\naxial = 1")), "compiled")
    np.testing.assert_allclose(tip_of(result), expected, rtol=bound)


def test_without_stiffening_the_spun_beam_is_lost(system_of):
    """It loses its stiffness to the centrifugal force on what bends: no such beam exists."""
    system = system_of(
        spun(*SPUN["Kane"][0]), SPIN.format(keys="bending = 4\naxial = 1\nstiffening = false"), {"duration": 7.98}
    )
    values = simulate(system, "compiled").evaluate(np.array([5.0, 7.98]))
    tip = values["rod_tip.y"] * np.cos(values["q.O"]) - values["rod_tip.x"] * np.sin(values["q.O"])
    assert tip[0] == pytest.approx(-0.74331, rel=1e-3)
    assert abs(tip[1]) == pytest.approx(8.0, rel=0.02)


#: Natural frequencies [rad/s] of a four-bar whose crank is held, by exact dynamic stiffness (Wittrick and Williams),
#: without and with a mass of 0.05 kg at the pin of coupler and follower.
LOCKED = {
    0.0: (1463.949046, 1990.997490, 5834.855328, 7913.064155),
    0.05: (1463.941636, 1990.964479, 5832.595951, 7901.746908),
}


def locked(mass):
    """Ground 0.3 m, crank 0.06 m at 30 degrees, coupler 0.28 m, follower 0.24 m."""
    a = 0.06 * np.array([np.cos(np.pi / 6), np.sin(np.pi / 6)])
    b = np.array(circle_intersection(a, 0.28, (0.3, 0.0), 0.24))
    coupler, follower = (np.arctan2(*(b - p)[::-1]) for p in (a, np.array([0.3, 0.0])))
    lump = (
        solid("lump", mass, 1e-12, at="follower_tip") + joint("weld", "follower_tip", "lump", "fixed") if mass else ""
    )
    body = f"""
<frame name="pivot" attached_to="world"><pose relative_to="__model__">0.3 0 0 0 0 0</pose></frame>
{bar("crank", 0.06, "__model__", np.pi / 6)}{elastic_bar("coupler", 0.28, "crank_tip", coupler)}
{elastic_bar("follower", 0.24, "pivot", follower)}{lump}
{joint("O", "world", "crank")}{joint("A", "crank_tip", "coupler")}
{joint("Q", "world", "follower")}{joint("B", "coupler_tip", "follower_tip")}"""
    return model("locked", body)


@pytest.mark.parametrize(("bending", "axial", "bound"), [(4, 1, 1e-3), (10, 3, 1e-5)])
@pytest.mark.parametrize("mass", LOCKED)
def test_a_locked_four_bar_has_the_exact_natural_frequencies(system_of, mass, bending, axial, bound):
    links = "".join(
        f'[links.{name}]\nmodel = "flexible"\nbending = {bending}\naxial = {axial}\ndamping = 0.0\n'
        for name in ("coupler", "follower")
    )
    runner = Runner(system_of(locked(mass), f"duration = 1.0\n[drives.O]\nspeed = 0.0\n{links}"))
    n, (matrix, _) = len(runner.model.free), slope(runner.aside(), 0.0, runner.start)
    squares = np.linalg.eigvals(-matrix[n:, :n])
    found = np.sqrt(np.sort(squares[squares.real > 1e3].real))[:4]
    np.testing.assert_allclose(found, LOCKED[mass], rtol=bound)
    np.testing.assert_allclose(2.0 * np.pi * modes(runner.system).frequencies[:4], LOCKED[mass], rtol=bound)


def test_a_stiffer_link_tends_to_the_rigid_one(system_of):
    """With Young's modulus E the difference goes with 1/E; frequencies rise tenfold, the number of steps does not."""
    toml = experiment(0.04, 4, 1, accuracy=1e-8)
    rigid = simulate(system_of(elastic_slider_crank(), toml, {"links.rod.model": "rigid"}), "compiled")
    times = np.linspace(0.0, 0.04, 401)
    exact, away, steps = rigid.evaluate(times)["slider.x"], [], []
    for factor in (1e2, 1e3, 1e4):
        stiff = simulate(
            system_of(elastic_slider_crank(), toml, {"sdf.links.rod.beam.youngs_modulus": 2e11 * factor}), "compiled"
        )
        assert stiff.status is Status.OK
        away.append(np.abs(stiff.evaluate(times)["slider.x"] - exact).max())
        steps.append(stiff.provenance["steps"])
    assert away[0] / away[1] == pytest.approx(10.0, rel=0.15)
    assert away[1] / away[2] == pytest.approx(10.0, rel=0.3)
    assert steps[2] < 1.2 * steps[0]


@pytest.mark.parametrize("factor", [1.0, 10.0])
def test_closing_the_loops_makes_no_stiff_link_ring(factor):
    """Accelerations in a machine of ideal joints are known at the usual tolerance: modes move little in projections."""
    changed = {"joints.B": {"model": "ideal"}, "sdf.links.rod.beam.youngs_modulus": 2e11 * factor}
    system = shipped("slider_crank_flexible", outputs=["slider.ax"], **changed)
    window = [[0.0418879, 0.1256637]]  # the second and third revolution
    jitter = [
        simulate_batch(
            system.replaced({"solver.accuracy": accuracy}), outputs=["slider.ax.jitter"], windows=window
        ).rms[0, 0, 0]
        for accuracy in (1e-6, 1e-9)
    ]
    assert jitter[0] == pytest.approx(jitter[1], rel=0.05)


@pytest.mark.parametrize("speed", [1.0, 15.0])
@pytest.mark.parametrize("method", ["dormand_prince_5_4", "radau_iia_5"])
def test_a_slow_machine_has_the_forces_of_the_rigid_one_at_a_loose_accuracy(speed, method):
    """An explicit method leaves each mode that limits its steps at its tolerance: this is a part of the forces."""
    changed = {"joints.B": {"model": "ideal"}, "drives.O.speed": speed, "duration": 0.1, "gravity": [0.0, -9.81, 0.0]}
    system = shipped("slider_crank_flexible", **changed, **{"solver.accuracy": 1e-4, "solver.integrator": method})
    times = np.linspace(0.0, 0.1, 201)
    bent, exact = (
        simulate(each, "compiled").evaluate(times) for each in (system, system.replaced({"links.rod.model": "rigid"}))
    )
    for name in ("O.force", "A.force", "B.force", "guide.force"):
        assert np.abs(bent[name] - exact[name]).max() < 3e-3 * np.abs(exact[name]).max()
