"""Additional states, motors and controllers against closed forms and integrations in plain numpy and scipy."""

import pickle

import cloudpickle
import numpy as np
import pytest
from engines import slow_on_drake
from machines import CONTROL, FLYWHEEL, joint, model, slider_crank, solid
from scipy.integrate import simpson, solve_ivp
from scipy.linalg import expm

from linkages import (
    InputError,
    Status,
    Stepper,
    integral,
    largest_exponent,
    laws,
    linearise,
    load,
    periodic_motion,
    simulate,
    simulate_batch,
)
from linkages.results.extremes import averages

EXACT = "[solver]\nintegrator = 'dormand_prince_5_4'\naccuracy = 1e-9\n"
FREE = "duration = 0.5\n[drives.O]\ntorque = 0.0\n"
R, L, K, B, J, U = 0.5, 0.02, 0.1, 1e-3, 0.02, 12.0  # of the motor, and the flywheel
MOTOR = f"""[motors.M]
joint = "O"
kind = "dc"
voltage = {U}
resistance = {R}
inductance = {L}
torque_constant = {K}
viscous = {B}
"""


def motor_states(times, resistance=R, inductance=L, inertia=J, start=0.7):
    """Current, speed of the flywheel, and a state that follows the speed with a lag of 1/2 s, (nt, 3)."""
    matrix = np.zeros((4, 4))
    matrix[0] = -resistance / inductance, -K / inductance, 0.0, U / inductance
    matrix[1, :2] = K / inertia, -B / inertia
    matrix[2, 1:3] = 1.0, -2.0
    return np.array([expm(matrix * t) @ [0.0, 0.0, start, 1.0] for t in times])[:, :3]


LAGGING = FREE + MOTOR + "[states.z]\nrate = '-2*z + O.rate'\nstart = 0.7\nunit = 'V'\n"
NAMES = ("M.current", "O.rate", "z.value")


def test_a_motor_with_inductance_turns_a_flywheel_as_its_closed_form(run):
    found = run(FLYWHEEL, LAGGING + EXACT)
    times = np.linspace(0.0, 0.5, 23)
    exact, columns = motor_states(times), found.evaluate(times)
    for name, values in zip(NAMES, exact.T, strict=True):
        np.testing.assert_allclose(columns[name], values, atol=1e-9 * np.abs(exact).max())
    np.testing.assert_allclose(columns["M.torque"], K * exact[:, 0] - B * exact[:, 1], atol=1e-9)
    assert found.units["z.value"] == "V"
    assert found.units["M.current"] == "A"
    inside = found["M.energy"][-1] - 0.5 * L * found["M.current"][-1] ** 2 - found["kinetic_energy"][-1]
    fine = np.linspace(0.0, 0.5, 4001)
    assert simpson(found.evaluate(fine)["M.losses"], x=fine) == pytest.approx(inside, rel=1e-8)


def test_the_implicit_method_solves_the_same_equations(system_of):
    implicit = EXACT.replace("dormand_prince_5_4", "radau_iia_5")
    found, times = simulate(system_of(FLYWHEEL, LAGGING + implicit)), np.linspace(0.0, 0.5, 23)
    exact = motor_states(times)
    for name, values in zip(NAMES, exact.T, strict=True):
        np.testing.assert_allclose(found.evaluate(times)[name], values, atol=1e-9 * np.abs(exact).max())


def test_derivatives_with_respect_to_numbers_of_motors_and_starts_of_states(system_of):
    wrt = {
        "motors.M.resistance": ("resistance", R), "motors.M.inductance": ("inductance", L), "states.z.start": ("start", 0.7),
        "sdf.links.wheel.inertia": ("inertia", J),
    }  # fmt: skip
    times = np.linspace(0.0, 0.5, 11)
    found = simulate(system_of(FLYWHEEL, LAGGING + EXACT), wrt=list(wrt)).sensitivity.evaluate(times)
    for path, (key, value) in wrt.items():
        step = 1e-5 * value
        above, below = (motor_states(times, **{key: value + side * step}) for side in (1.0, -1.0))
        slopes = (above - below) / (2 * step)
        for name, exact in zip(NAMES, slopes.T, strict=True):
            np.testing.assert_allclose(found[path][name], exact, atol=1e-8 * np.abs(slopes).max())


def test_a_batch_of_motors_has_the_statistics_of_single_runs(system_of):
    system, values = system_of(FLYWHEEL, LAGGING + EXACT), np.array([[0.4], [0.6]])
    batch = simulate_batch(system, ["motors.M.resistance"], values, ["M.current"])
    for row, (value,) in zip(batch.peak, values, strict=True):
        times = np.linspace(0.0, 0.5, 20001)
        assert row[0] == pytest.approx(motor_states(times, resistance=value)[:, 0].max(), rel=1e-8)


def test_a_rotor_acts_by_the_square_of_its_ratio(run):
    """Without an inductance: J dw/dt = n (k i - b n w), i = (U - k n w)/R, with the rotor's n^2 J_r in J."""
    n, rotor = -3.0, 2e-3
    text = MOTOR.replace(f"inductance = {L}\n", f"ratio = {n}\nrotor_inertia = {rotor}\n")
    found, times = run(FLYWHEEL, FREE + text + EXACT), np.linspace(0.0, 0.5, 11)
    rate = n**2 * (K**2 / R + B) / (J + n**2 * rotor)
    speed = n * K * U / R / (J + n**2 * rotor) / rate * (1.0 - np.exp(-rate * times))
    np.testing.assert_allclose(found.evaluate(times)["O.rate"], speed, atol=1e-9 * np.abs(speed).max())


def test_the_winding_warms_and_the_gearbox_loses_its_share(run):
    text = FREE.replace("torque = 0.0", "speed = 30.0") + MOTOR.replace(f"inductance = {L}\n", "")
    text += "efficiency = 0.8\nthermal_resistance = 2.0\nthermal_capacity = 0.1\nsurroundings = 25.0\n"
    found = run(FLYWHEEL, text + EXACT)
    current, times = (U - 30.0 * K) / R, found.time
    heat = R * current**2
    np.testing.assert_allclose(found["M.torque"], 0.8 * (K * current - 30.0 * B), rtol=1e-12)
    warm = 25.0 + 2.0 * heat * (1.0 - np.exp(-times / 0.2))
    np.testing.assert_allclose(found["M.temperature"], warm, rtol=1e-8)
    whole = found["M.losses"] + 30.0 * found["M.torque"]
    np.testing.assert_allclose(found["M.electrical_power"], whole, rtol=1e-12)


def _inertia(q, crank=0.05, rod=0.12):
    """Moment of inertia of `slider_crank` reduced to its crank, at complex angles."""
    low = np.arcsin(crank * np.sin(q) / rod)
    turn = -crank * np.cos(q) / (rod * np.cos(low))  # angle of the rod per angle of the crank
    half_x = -crank * np.sin(q) + 0.5 * rod * np.sin(low) * turn
    half_y = 0.5 * crank * np.cos(q)
    slide = -crank * np.sin(q) + rod * np.sin(low) * turn
    return 0.3 * crank**2 / 3 + 0.21 * (half_x**2 + half_y**2 + rod**2 / 12 * turn**2) + 0.14 * slide**2


KINDS = {
    "induction": ("breakdown_torque = 1.2\nbreakdown_slip = 0.2\nsynchronous_speed = 157.0\n", 157.0),
    "curve": ("speeds = [-10.0, 0.0, 100.0, 160.0]\ntorques = [0.9, 0.8, 0.6, 0.0]\n", None),
}


@slow_on_drake
@pytest.mark.parametrize("kind", KINDS)
def test_a_motor_turns_a_slider_crank_as_an_independent_integration(run, kind):
    from scipy.interpolate import PchipInterpolator

    keys, synchronous = KINDS[kind]
    text = f"duration = 0.6\n[drives.O]\ntorque = 0.0\nangle = 0.4\n[motors.M]\njoint = 'O'\nkind = '{kind}'\nratio = 2.0\n"
    found = run(slider_crank(), text + "rotor_inertia = 1e-4\n" + keys + EXACT)
    curve = PchipInterpolator([-10.0, 0.0, 100.0, 160.0], [0.9, 0.8, 0.6, 0.0])

    def torque(speed):
        if synchronous is None:
            return curve(np.clip(speed, -10.0, 160.0))  # a table keeps its end values
        slip = 1.0 - speed / synchronous
        return 2 * 1.2 * slip * 0.2 / (slip**2 + 0.2**2)

    def rates(_, y):
        slope = _inertia(y[0] + 1e-30j).imag / 1e-30
        return y[1], (2.0 * torque(2.0 * y[1]) - 0.5 * slope * y[1] ** 2) / (_inertia(y[0]) + 4e-4)

    times = np.linspace(0.0, 0.6, 301)
    exact = solve_ivp(rates, (0.0, 0.6), (0.4, 0.0), "DOP853", times, rtol=1e-12, atol=1e-12).y
    columns = found.evaluate(times)
    np.testing.assert_allclose(columns["O.rate"], exact[1], atol=1e-6)
    late = times > 0.4
    fluctuation = [np.ptp(speed[late]) / speed[late].mean() for speed in (columns["O.rate"], exact[1])]
    assert fluctuation[0] == pytest.approx(fluctuation[1], abs=1e-6)
    assert fluctuation[1] > 0.05
    losses = columns["M.electrical_power"] - columns["M.torque"] * columns["O.rate"]
    np.testing.assert_allclose(columns["M.losses"], losses, atol=1e-9 * np.abs(losses).max() + 1e-9)


FOLLOWING = """[torques.T]
joint = "O"
formula = "C.output"
[controllers.C]
kind = "pid"
signal = "O.coordinate"
reference = "0.5*(1 - cos(6*t))"
feedforward = "ideal-torque"
joint = "O"
"""


T = 0.01  # between the samples of the controller
SAMPLED = FREE.replace("0.5", "1.0") + CONTROL + f"sample_time = {T}\n" + EXACT


def sampled_states(proportional=0.3, integral=1.5, derivative=0.002, low=-0.4, high=0.4, inertia=J):
    """Speed in the middle between samples and output, (100, 2): the torque is constant there. Values may be complex."""
    speed, part, slope, before, found = 0.0, 0.0, 0.0, 5.0, []  # the first difference of the error is 0
    for _ in range(100):
        error = 5.0 - speed
        slope = (0.01 * slope + error - before) / (0.01 + T)
        wanted = proportional * error + part + derivative * slope
        output = min(max(wanted, low, key=np.real), high, key=np.real)
        found.append((speed + 0.5 * T * output / inertia, output))
        part += T * (integral * error + (output - wanted) * integral / proportional)
        speed, before = speed + T * output / inertia, error
    return np.array(found)


def test_a_sampled_controller_with_saturation_is_its_exact_discretisation(run):
    columns, exact = run(FLYWHEEL, SAMPLED).evaluate(T * (np.arange(100) + 0.5)), sampled_states()
    np.testing.assert_allclose(columns["O.rate"], exact[:, 0], atol=1e-10)
    np.testing.assert_allclose(columns["C.output"], exact[:, 1], atol=1e-10)
    assert 20 < np.count_nonzero(np.abs(exact[:, 1]) == 0.4) < 30


def test_the_derivative_part_of_a_sampled_controller_is_zero_at_the_first_sample(run):
    """The error is 1 from t = 0 on, and rests: 60 V are wanted, of 12 V; e changes by 80 T e + T (12 - 60 - e)/0.1.

    A difference from an error of 0 before the first sample would add 1.5/T = 1500 V, and throw the integral to -15.4.
    """
    keys = "signal = 'O.coordinate'\nreference = '1'\nproportional = 60.0\nintegral = 80.0\nderivative = 1.5\n"
    keys += "tracking_time = 0.1\nlimits = [-12.0, 12.0]\nsample_time = 1e-3\n"
    found, period = run(FLYWHEEL, FREE + "[controllers.C]\nkind = 'pid'\n" + keys + EXACT), 1e-3
    parts = [0.0]
    for _ in range(4):
        parts.append(parts[-1] + period * (80.0 + (12.0 - 60.0 - parts[-1]) / 0.1))
    assert parts[1] == pytest.approx(-0.4)
    columns = found.evaluate(period * (np.arange(4) + 0.5))
    np.testing.assert_allclose(columns["C.integral"], parts[1:], rtol=1e-14)
    np.testing.assert_array_equal(columns["C.output"], 12.0)


@pytest.mark.parametrize("method", ["dormand_prince_5_4", "radau_iia_5"])
def test_derivatives_pass_the_samples_of_a_controller_as_those_of_its_discretisation(system_of, method):
    """Between the samples the output is constant; at a sample its derivative jumps, as the formulas of the next one."""
    system = system_of(FLYWHEEL, SAMPLED.replace("dormand_prince_5_4", method))
    wrt = {"sdf.links.wheel.inertia": ("inertia", J)}
    wrt |= {f"controllers.C.{key}": (key, value) for key, value in (("proportional", 0.3), ("integral", 1.5))}
    times = T * (np.arange(100) + 0.5)
    found = simulate(system, wrt=list(wrt)).sensitivity.evaluate(times)
    for path, (key, value) in wrt.items():
        exact = sampled_states(**{key: value + 1e-30j}).imag / 1e-30
        for name, slopes in zip(("O.rate", "C.output"), exact.T, strict=True):
            np.testing.assert_allclose(found[path][name], slopes, atol=1e-8 * np.abs(slopes).max(), err_msg=path)


def test_derivatives_of_a_sampled_slider_crank_are_differences_of_runs(system_of):
    """Samples of two rates meet in one instant; the start of a state and a length act through positions and speeds."""
    text = (
        "duration = 0.1\n[drives.O]\ntorque = 0.0\nspeed = 20.0\n[torques.T]\njoint = 'O'\nformula = 'C.output + y'\n"
    )
    text += CONTROL.split("[controllers.C]")[1].join(("[controllers.C]", "sample_time = 0.01\n"))
    text += "[states.y]\nnext = '0.5*y + slider.vx*slider.x'\nsample_time = 0.005\nstart = 0.1\n"
    system = system_of(slider_crank(), text + EXACT.replace("1e-9", "1e-11"))
    times, names = np.linspace(0.003, 0.099, 13), ["O.rate", "slider.x", "y.value"]
    wrt = ["states.y.start", "sdf.links.rod.mass", "controllers.C.derivative"]
    found = simulate(system, outputs=names, wrt=wrt).sensitivity.evaluate(times)
    for path in wrt:
        step = 1e-4 * system.value(path)
        above, below = (
            simulate(system.replaced({path: system.value(path) + side * step}), outputs=names).evaluate(times)
            for side in (1.0, -1.0)
        )
        for name in names:
            exact = (above[name] - below[name]) / (2.0 * step)
            np.testing.assert_allclose(found[path][name], exact, atol=1e-6 * np.abs(exact).max(), err_msg=path)


def test_a_continuous_controller_is_an_independent_integration(run):
    def rates(_, y):
        speed, integral, lag = y
        error = 5.0 - speed
        wanted = 0.3 * error + integral + 0.002 * (error - lag) / 0.01
        output = min(max(wanted, -0.4), 0.4)
        return output / J, 1.5 * error + (output - wanted) / 0.2, (error - lag) / 0.01

    found, times = run(FLYWHEEL, FREE + CONTROL + EXACT), np.linspace(0.0, 0.5, 51)
    exact = solve_ivp(rates, (0.0, 0.5), np.zeros(3), "DOP853", times, rtol=1e-12, atol=1e-12, max_step=1e-3).y
    columns = found.evaluate(times)
    np.testing.assert_allclose(columns["O.rate"], exact[0], atol=1e-7)
    np.testing.assert_allclose(columns["C.integral"], exact[1], atol=1e-7)


def test_the_ideal_torque_moves_the_machine_along_the_reference(run):
    """Of a pendulum: (m l^2 + J) q'' + m g l cos q; no gain is needed."""
    pendulum = model("arm", solid("arm", 1.0, 0.02, centre="0.2 0 0 0 0 0") + joint("O", "world", "arm"))
    text = "duration = 1.0\ngravity = [0.0, -9.81, 0.0]\n[drives.O]\ntorque = 0.0\n" + FOLLOWING
    found, times = run(pendulum, text + EXACT), np.linspace(0.0, 1.0, 101)
    angle, acceleration = 0.5 * (1.0 - np.cos(6.0 * times)), 18.0 * np.cos(6.0 * times)
    columns = found.evaluate(times)
    np.testing.assert_allclose(columns["C.output"], 0.06 * acceleration + 9.81 * 0.2 * np.cos(angle), atol=1e-6)
    np.testing.assert_allclose(columns["q.O"], angle, atol=1e-6)


def test_a_slider_crank_follows_by_its_ideal_torque(run):
    text = "duration = 0.3\n[drives.O]\ntorque = 0.0\n" + FOLLOWING.replace("0.5*(1 - cos(6*t))", "40*t**2")
    found = run(slider_crank(), text + "proportional = 5.0\n" + EXACT)
    assert np.abs(found["C.error"]).max() < 1e-6
    work = simpson(found.evaluate(np.linspace(0.0, 0.3, 4001))["T.power"], x=np.linspace(0.0, 0.3, 4001))
    assert work == pytest.approx(found["kinetic_energy"][-1], rel=1e-6)


def test_the_linear_model_has_the_poles_of_the_motor(system_of):
    found = linearise(system_of(FLYWHEEL, LAGGING + EXACT))
    assert found.states == ("q.O", "v.O", "s.z", "s.M.current", "s.M.energy")
    exact = [*np.linalg.eigvals([[-R / L, -K / L], [K / J, -B / J]]), -2.0, 0.0, 0.0]
    np.testing.assert_allclose(np.sort(np.linalg.eigvals(found.A).real), np.sort(exact), atol=1e-9)


def test_only_the_current_of_a_driven_motor_is_free_in_a_periodic_motion(system_of):
    """Its multiplier is exp(-R T/L). No formula reads the energy, which grows: it is no unknown."""
    text = "duration = 0.5\n[drives.O]\nspeed = 200.0\n" + MOTOR
    found = periodic_motion(system_of(slider_crank(), text + EXACT))
    np.testing.assert_allclose(found.multipliers, [np.exp(-R / L * 2.0 * np.pi / 200.0)], rtol=1e-7)
    at_once = system_of(slider_crank(), text.replace(f"inductance = {L}\n", "") + EXACT)
    with pytest.raises(InputError, match="they determine the whole motion"):
        periodic_motion(at_once)


def test_the_lyapunov_exponent_of_a_driven_machine_is_that_of_its_states(system_of):
    """The drive determines the crank; two states follow z" + 4 z' + 3 z = slider.vx, with the roots -1 and -3."""
    text = "duration = 0.5\n[drives.O]\nspeed = 20.0\n[states.z]\nrate = 'w'\n[states.w]\nrate = '-4*w - 3*z + slider.vx'\n"
    found = largest_exponent(system_of(slider_crank(), text + EXACT), revolutions=10, transient=20)
    assert found.value == pytest.approx(-1.0, rel=1e-4)


def test_means_over_sampling_instants_are_those_of_steps(system_of):
    """The torque is 1, 2, ... N m for 0.1 s each: alpha is constant between the instants, at which windows end too."""
    text = "duration = 0.5\n[drives.O]\ntorque = 0.0\n[torques.T]\njoint = 'O'\nformula = 'n'\n"
    text += "[states.n]\nnext = 'n + 1'\nsample_time = 0.1\n"
    system, windows = system_of(FLYWHEEL, text + EXACT), [[0.0, 0.5], [0.05, 0.3]]
    path, right = "sdf.links.wheel.inertia", np.array([[3.0, np.sqrt(11.0)], [2.2, np.sqrt(5.4)]]) / J
    batch = simulate_batch(system, [path], [[J]], ["wheel.alpha"], windows, wrt=[path])
    np.testing.assert_allclose(np.stack([batch.mean[0, :, 0], batch.rms[0, :, 0]], axis=1), right, rtol=1e-9)
    np.testing.assert_allclose(batch.sensitivity[path]["mean"][0, :, 0], -right[:, 0] / J, rtol=1e-7)
    run = simulate(system)
    for k, window in enumerate(windows):
        part = run.within(*window)
        assert averages(part, "wheel.alpha") == (batch.mean[0, k, 0], batch.rms[0, k, 0])
        assert integral(part, "wheel.alpha") == pytest.approx(np.ptp(part["O.rate"]), rel=1e-9)
    assert integral(run, "T.power") == pytest.approx(run["kinetic_energy"][-1], rel=1e-9)


def test_the_energy_of_a_motor_does_not_count_in_the_lyapunov_exponent(system_of):
    """A wheel on a damped spring beside the motor's: the exponent is the slow root of its equation."""
    wheels = (
        solid("wheel", 1.0, 0.02) + joint("O", "world", "wheel") + solid("other", 1.0, J) + joint("Q", "world", "other")
    )
    text = "duration = 1.0\n[drives.O]\nspeed = 50.0\n[drives.Q]\ntorque = 0.0\n" + MOTOR
    text += "[torques.spring]\njoint = 'Q'\nformula = '-5*Q.coordinate - Q.rate'\n"
    found = largest_exponent(system_of(model("wheels", wheels), text + EXACT), revolutions=3, transient=6)
    np.testing.assert_allclose(found.growth, np.roots([J, 1.0, 5.0]).max(), rtol=1e-4)


def test_sampled_states_change_together_and_rest_between(run):
    """Fibonacci's numbers by two states, every 0.1 s, from the instant 0; a third one counts every 0.2 s."""
    text = "[states.a]\nnext = 'b'\nsample_time = 0.1\nstart = 0.0\n[states.b]\nnext = 'a + b'\nsample_time = 0.1\nstart = 1.0\n"
    text += "[states.c]\nnext = 'c + 1'\nsample_time = 0.2\n"
    columns = run(FLYWHEEL, FREE + text + EXACT).evaluate(0.1 * np.arange(5) + 0.05)
    np.testing.assert_array_equal(columns["a.value"], [1.0, 1.0, 2.0, 3.0, 5.0])
    np.testing.assert_array_equal(columns["b.value"], [1.0, 2.0, 3.0, 5.0, 8.0])
    np.testing.assert_array_equal(columns["c.value"], [1.0, 1.0, 2.0, 2.0, 3.0])


def test_a_state_loads_a_machine_with_prescribed_motion(run):
    """A force that lags behind the slider's speed, in the torque of the drive: its power, as the crank stores it."""
    text = "duration = 0.1\n[drives.O]\nspeed = 40.0\n[states.f]\nrate = '200*(-3*slider.vx - f)'\n"
    text += "[forces.F]\npoint = 'slider'\nformula = ['f', '0']\n"
    found = run(slider_crank(), text + EXACT)
    fine = np.linspace(0.0, 0.1, 4001)
    columns = found.evaluate(fine)
    work = simpson(columns["O.power"] + columns["F.power"], x=fine)
    assert work == pytest.approx(np.ptp(columns["kinetic_energy"][[0, -1]]) * np.sign(work), rel=1e-7, abs=1e-9)
    np.testing.assert_allclose(columns["F.fx"], columns["f.value"], rtol=1e-12)


WRONG = {
    "neither": ("[states.z]\n", "states.z: give either rate, or next with sample_time"),
    "no sample time": ("[states.z]\nnext = 'z'\n", "next and sample_time belong together"),
    "unknown name": ("[states.z]\nrate = 'y'\n", '"y" has "y"; it may have t, the time, POINT.x, JOINT.rate'),
    "name of a function": ("[states.sin]\nrate = '1'\n", "states.sin: cannot be a name in formulas"),
    "name of a link": ("[states.wheel]\nrate = '1'\n", "states.wheel: is also the name of a link"),
    "no number": (
        "[states.z]\nrate = 'log(z)'\nstart = -1\n",
        "states.z: its value or its rate is not a number at t = 0",
    ),
    "itself": (CONTROL.replace('"O.rate"', '"C.output"'), "which needs itself; use a state between"),
    "kind": ("[motors.M]\njoint = 'O'\nkind = 'curve'\n", "speeds is missing"),
    "other kind": (MOTOR + "speeds = [0.0, 1.0]\n", 'speeds belongs to kind "curve"'),
    "joint": (MOTOR.replace('"O"', '"P"'), 'motors.M.joint: "P" is not in'),
    "filter": (CONTROL.replace("filter_time = 0.01\n", ""), "filter_time is missing"),
    "feedforward": (CONTROL + "feedforward = 'ideal-torque'\n", "and joint belong together"),
    "limits": (CONTROL.replace("[-0.4, 0.4]", "[0.4, 0.4]"), "limits must increase"),
}


@pytest.mark.parametrize("case", WRONG)
def test_wrong_tables_are_refused_in_one_line(experiment_file, case):
    text, problem = WRONG[case]
    with pytest.raises(InputError) as found:
        load(experiment_file(FLYWHEEL, FREE + text)).assembly  # noqa: B018
    assert problem in str(found.value)
    assert "\n" not in str(found.value)


def test_the_time_between_samples_has_no_derivative(system_of):
    with pytest.raises(InputError, match=r"controllers\.C\.sample_time: moves the sampling instants: there is no"):
        simulate(system_of(FLYWHEEL, SAMPLED), wrt=["controllers.C.sample_time"])


def pid(t, speed, wanted, gain, part, slope, before):
    """The controller `SAMPLED`; it remembers the integral part, the slope and the error."""
    error = wanted - speed
    slope = (0.01 * slope + error - before) / (0.01 + T)
    whole = gain * error + part + 0.002 * slope
    output = min(max(whole, -0.4), 0.4)
    return output, part + T * (1.5 * error + (output - whole) * 1.5 / gain), slope, error


PYTHON = f"""[torques.T]
joint = "O"
formula = "C.output"
[controllers.C]
kind = "python"
function = "own pid"
inputs = {{wanted = "5", speed = "O.rate"}}
parameters = {{gain = 0.3}}
memory = {{slope = 0.0, part = 0.0, before = 5.0}}
sample_time = {T}
"""
CALLED = FREE.replace("0.5", "1.0") + PYTHON + EXACT


@pytest.fixture
def own_pid(own_registries):
    laws.register_controller("own pid", pid)


def test_a_function_in_python_controls_as_the_exact_discretisation(run, own_pid):
    columns, exact = run(FLYWHEEL, CALLED).evaluate(T * (np.arange(100) + 0.5)), sampled_states()
    np.testing.assert_allclose(columns["O.rate"], exact[:, 0], atol=1e-10)
    np.testing.assert_allclose(columns["C.output"], exact[:, 1], atol=1e-10)


def test_a_function_in_python_controls_batches_in_threads(system_of, own_pid):
    gains = np.linspace(0.2, 0.5, 7)
    system = system_of(FLYWHEEL, CALLED, {"duration": 99.5 * T})
    batch = simulate_batch(system, ["controllers.C.parameters.gain"], gains[:, None], ["C.output"])
    for row, gain in zip(batch.last, gains.tolist(), strict=True):
        assert row[0, 0] == pytest.approx(sampled_states(proportional=gain)[-1, 1], abs=1e-9)


def test_a_function_in_python_goes_to_another_process_with_its_system(system_of, own_pid):
    system = system_of(FLYWHEEL, CALLED)
    sent = cloudpickle.dumps(system)
    del laws.CONTROLLERS["own pid"], laws.user_laws._registered["controller", "own pid"]
    there = simulate(pickle.loads(sent), outputs=["O.rate"])
    np.testing.assert_array_equal(there["O.rate"], simulate(system, outputs=["O.rate"])["O.rate"])


def test_a_stepper_restores_the_memory_of_a_function_in_python(system_of, own_pid):
    stepper = Stepper(system_of(FLYWHEEL, CALLED), outputs=["O.rate"])
    stepper.step(0.093)
    kept = stepper.state()
    stepper.step(0.5)
    first = stepper.outputs()
    stepper.restore(kept)
    stepper.step(0.5)
    assert stepper.outputs() == first


FAILING = {
    "raises": (lambda t, speed: 1.0 / (t - 0.05) if t > 0.045 else 0.0, ZeroDivisionError, "division by zero"),
    "no number": (lambda t, speed: None, ValueError, "returned None at t = 0 s; it must return 1 finite number"),
    "not finite": (
        lambda t, speed: float("nan"),
        ValueError,
        "returned nan at t = 0 s; it must return 1 finite number",
    ),
    "too many": (lambda t, speed: (1.0, 2.0), ValueError, r"returned \(1.0, 2.0\) at t = 0 s; it must return 1 finite"),
}


@pytest.mark.parametrize("case", FAILING)
def test_errors_of_a_function_in_python_are_raised(system_of, engine, own_registries, case):
    function, error, text = FAILING[case]
    laws.register_controller("failing", function)
    keys = "kind = 'python'\nfunction = 'failing'\ninputs = {speed = 'O.rate'}\nsample_time = 0.01\n"
    system = system_of(FLYWHEEL, FREE + "[controllers.C]\n" + keys)
    with pytest.raises(error, match=text):
        simulate(system, engine)
    with pytest.raises(error, match=text):
        simulate_batch(system, ["sdf.links.wheel.inertia"], [[0.02], [0.03]], ["O.rate"])


OF_PYTHON = {
    "unknown": (
        PYTHON.replace("own pid", "their pid"),
        'controllers.C: function "their pid" is not registered in this process: call',
    ),
    "names": (
        PYTHON.replace("gain =", "gains ="),
        'controllers.C: function "own pid" takes (t, speed, wanted, gain, part, slope, before); inputs, parameters and'
        " memory give wanted, speed, gains, slope, part, before; they must be the same",
    ),
    "not sampled": (PYTHON.replace("sample_time", "filter_time"), 'sample_time is missing: kind "python" needs'),
    "key of pid": (PYTHON + "limits = [0.0, 1.0]\n", 'limits belongs to kind "pid"; remove it'),
    "key of python": (CONTROL + "function = 'own pid'\n", 'function belongs to kind "python"; remove it'),
    "no signal": (CONTROL.replace('signal = "O.rate"\n', ""), "signal is missing"),
    "input": (PYTHON.replace("O.rate", "P.rate"), '"P" is not in'),
}


@pytest.mark.parametrize("case", OF_PYTHON)
def test_wrong_tables_of_functions_in_python_are_refused_in_one_line(experiment_file, own_pid, case):
    text, problem = OF_PYTHON[case]
    with pytest.raises(InputError) as found:
        load(experiment_file(FLYWHEEL, FREE + text)).assembly  # noqa: B018
    assert problem in str(found.value)
    assert "\n" not in str(found.value)


def test_functions_in_python_have_no_derivatives(system_of, own_pid):
    with pytest.raises(InputError, match=r"controllers\.C\.function: is in Python, which has no derivatives"):
        simulate(system_of(FLYWHEEL, CALLED), wrt=["sdf.links.wheel.inertia"])


def test_wrong_controllers_are_refused():
    with pytest.raises(ValueError, match=r'controller law "one": 1\.0 cannot be called'):
        laws.register_controller("one", 1.0)
    with pytest.raises(ValueError, match="must take the time, then inputs, parameters and memory by name"):
        laws.register_controller("one", lambda t, *others: 1.0)


def test_a_stepper_samples_at_the_ends_of_its_steps(system_of):
    """Ends are rounded sums, which may lie before or after the sampling instants."""
    system = system_of(FLYWHEEL, FREE + CONTROL + "sample_time = 0.01\n" + EXACT)
    stepper, time = Stepper(system, outputs=["O.rate"]), 0.0
    for _ in range(49):
        time += 0.01
        stepper.step(time)
    assert stepper.outputs()["O.rate"] == pytest.approx(
        simulate(system).evaluate(np.array([time]))["O.rate"][0], rel=1e-10
    )


def test_diagrams_have_continuous_states_but_refuse_sampled_ones(system_of):
    from pydrake.systems.analysis import Simulator

    from linkages.engines.drake import build_diagram

    diagram, linkage = build_diagram(system_of(FLYWHEEL, LAGGING))
    simulator = Simulator(diagram)
    linkage.set_initial_state(simulator.get_mutable_context())
    assert linkage.advance(simulator, 0.1) is Status.OK
    own = simulator.get_context().get_continuous_state_vector().CopyToVector()[-3:]
    np.testing.assert_allclose(own[:2], motor_states([0.1])[0, [2, 0]], rtol=1e-4)
    with pytest.raises(
        InputError, match=r"controllers\.C\.sample_time: makes sampling instants, which a Drake diagram"
    ):
        build_diagram(system_of(FLYWHEEL, FREE + CONTROL + "sample_time = 0.01\n"))
