"""Values that formulas read: `[values]`, against closed forms, in runs, derivatives, batches, steppers and messages."""

import numpy as np
import pytest
from machines import FLYWHEEL
from scipy.integrate import solve_ivp

from linkages import InputError, Stepper, load, simulate, simulate_batch

EXACT = "[solver]\nintegrator = 'dormand_prince_5_4'\naccuracy = 1e-11\n"
J, C, START = 0.02, 0.05, 3.0  # moment of inertia, viscous friction, speed at t = 0
BRAKED = f"duration = 1.0\n[drives.O]\ntorque = 0.0\nspeed = {START}\n[values]\nc = {C}\nd = {C}\n"
BRAKED += "[torques.T]\njoint = 'O'\nformula = '-c*O.rate - 0*d*O.rate'\n" + EXACT
SWUNG = "duration = 1.0\n[drives.O]\nformula = 'a*sin(w*t)'\n[values]\na = '10 deg'\nw = '60 r/min'\n" + EXACT
TIMES = np.linspace(0.05, 0.95, 10)


def speed(times, c=C):
    """Speed of the wheel that a torque -c w brakes [rad/s]."""
    return START * np.exp(-c * times / J)


@pytest.mark.parametrize("c", [C, 0.1])
def test_a_formula_reads_a_value_of_the_file_and_of_the_command_line(run, c):
    found = run(FLYWHEEL, BRAKED, {"values.c": str(c)})
    np.testing.assert_allclose(found.evaluate(TIMES)["O.rate"], speed(TIMES, c), rtol=1e-8)


def test_the_motion_of_a_drive_reads_values_with_units(run):
    """The torque is J times the second derivative of a sin(w t), a = 10 degrees, one turn in a second."""
    a, w = np.pi / 18.0, 2.0 * np.pi
    columns = run(FLYWHEEL, SWUNG).evaluate(TIMES)
    np.testing.assert_allclose(columns["q.O"], a * np.sin(w * TIMES), atol=1e-12)
    np.testing.assert_allclose(columns["O.torque"], -J * a * w**2 * np.sin(w * TIMES), atol=1e-12)


def test_derivatives_with_respect_to_values_in_loads_are_those_of_the_closed_form(system_of):
    """The value d has the number of c and acts nowhere."""
    found = simulate(system_of(FLYWHEEL, BRAKED), wrt=["values.c", "values.d"]).sensitivity.evaluate(TIMES)
    np.testing.assert_allclose(found["values.c"]["O.rate"], -TIMES / J * speed(TIMES), rtol=1e-7)
    np.testing.assert_array_equal(found["values.d"]["O.rate"], 0.0)


def test_derivatives_with_respect_to_values_in_the_motion_of_a_drive_are_those_of_the_closed_form(system_of):
    a, w = np.pi / 18.0, 2.0 * np.pi
    found = simulate(system_of(FLYWHEEL, SWUNG), wrt=["values.a", "values.w"]).sensitivity.evaluate(TIMES)
    torque = J * a * w * (2.0 * np.sin(w * TIMES) + w * TIMES * np.cos(w * TIMES))
    np.testing.assert_allclose(found["values.a"]["q.O"], np.sin(w * TIMES), atol=1e-8)
    np.testing.assert_allclose(found["values.w"]["O.torque"], -torque, atol=1e-7)


def test_a_batch_varies_values(system_of):
    values = np.array([[0.02], [0.1]])
    found = simulate_batch(system_of(FLYWHEEL, BRAKED), ["values.c"], values, ["O.rate"])
    means = START * J / values[:, 0] * (1.0 - np.exp(-values[:, 0] / J))
    np.testing.assert_allclose(found.mean.ravel(), means, rtol=1e-7)


def test_states_motors_and_controllers_read_values(run):
    """z' = -r z; a sampled gain; a voltage behind a resistance: all read the same value r = 2."""
    text = "duration = 1.0\n[drives.O]\ntorque = 0.0\n[values]\nr = 2.0\n[states.z]\nrate = '-r*z'\nstart = 1.0\n"
    text += "[motors.M]\njoint = 'O'\nkind = 'dc'\nformula = '3*r'\nresistance = 0.5\ntorque_constant = 0.1\n"
    text += "[controllers.C]\nkind = 'pid'\nsignal = '0*t'\nreference = 'r'\nproportional = 4.0\nsample_time = 0.1\n"
    columns = run(FLYWHEEL, text + EXACT).evaluate(TIMES)
    np.testing.assert_allclose(columns["z.value"], np.exp(-2.0 * TIMES), rtol=1e-8)
    np.testing.assert_array_equal(columns["M.voltage"], 6.0)
    np.testing.assert_array_equal(columns["C.output"], 8.0)


def test_an_ideal_torque_follows_a_reference_with_a_value_and_keeps_the_loads_that_read_one(run):
    """J q" and the brake c q' for q = a t^3: the controller needs no gain."""
    text = "duration = 1.0\n[drives.O]\ntorque = 0.0\n[values]\na = 0.3\nc = 0.05\n"
    text += "[controllers.C]\nkind = 'pid'\nsignal = 'O.coordinate'\nreference = 'a*t**3'\n"
    text += "feedforward = 'ideal-torque'\njoint = 'O'\n[torques.T]\njoint = 'O'\nformula = 'C.output'\n"
    text += "[torques.brake]\njoint = 'O'\nformula = '-c*O.rate'\n"
    columns = run(FLYWHEEL, text + EXACT).evaluate(TIMES)
    np.testing.assert_allclose(columns["C.output"], J * 1.8 * TIMES + C * 0.9 * TIMES**2, atol=1e-6)
    np.testing.assert_allclose(columns["q.O"], 0.3 * TIMES**3, atol=1e-6)


def test_a_stepper_changes_a_value_at_any_step(system_of):
    stepper = Stepper(system_of(FLYWHEEL, BRAKED), ["values.c"], ["O.rate"])
    stepper.step(0.3)
    stepper.step(0.5, {"values.c": 0.2})
    assert stepper.outputs()["O.rate"] == pytest.approx(speed(0.3) * np.exp(-0.2 * 0.2 / J), rel=1e-8)


@pytest.mark.parametrize(("text", "path"), [(SWUNG, "values.a"), (BRAKED.replace("0*d*", "0*"), "values.d")])
def test_a_stepper_refuses_values_of_motions_and_values_that_no_formula_reads(system_of, text, path):
    with pytest.raises(InputError, match=rf'input "{path}": is no number of a load\'s or state\'s formula alone'):
        Stepper(system_of(FLYWHEEL, text), [path])


def test_coulomb_torques_fall_by_stribecks_law(run):
    """From 0.08 N m at rest to 0.03 N m: an independent integration."""
    text = BRAKED.split("[values]")[0] + "[frictions.pin]\njoint = 'O'\nconstant = 0.03\nstatic_constant = '80 N mm'\n"
    text += "stribeck_speed = 0.5\nspeed = 0.1\nviscous = 2e-3\n" + EXACT

    def rate(_, w):
        return -((0.03 + 0.05 * np.exp(-((w / 0.5) ** 2))) * np.tanh(w / 0.1) + 2e-3 * w) / J

    exact = solve_ivp(rate, (0.0, 1.0), [START], "DOP853", TIMES, rtol=1e-12, atol=1e-13).y[0]
    np.testing.assert_allclose(run(FLYWHEEL, text).evaluate(TIMES)["O.rate"], exact, atol=1e-8)


MOVED = "duration = 1.0\n[drives.O]\n"
#: case -> (text, expected part of the message)
REFUSED = {
    "no number": (BRAKED.replace("0.05\nd", "'five'\nd"), "values.c: is 'five'; it should be a number"),
    "unknown unit": (BRAKED.replace("0.05\nd", "'5 Nmx'\nd"), 'values.c: is "5 Nmx"; the unit "Nmx" is unknown'),
    "unknown name": (BRAKED.replace("-c*", "-k*"), 'torques.T.formula: "-k*O.rate - 0*d*O.rate" has "k"; it may have t'),
    "unknown name of a motion": (
        MOVED + "formula = 'b*t'\n[values]\na = 1.0\n",
        'drives.O.formula: "b*t" has "b"; it may have t, the time, a',
    ),
    "a position in a motion": (MOVED + "formula = 'wheel.x'\n", '"wheel.x" has "wheel.x"; it may have t, the time'),
    "a state in a motion": (
        MOVED + "formula = 'z'\n[states.z]\nrate = '1'\n",
        'drives.O.formula: "z" has "z"; it may have t, the time',
    ),
    "name of a joint": (MOVED + "speed = 1.0\n[values]\nO = 1.0\n", "values.O: is also the name of a link, frame,"),
    "name of a state": (MOVED + "speed = 1.0\n[values]\nz = 1.0\n[states.z]\nrate = '1'\n", "states.z: is also the name"),
    "name of a function": (MOVED + "speed = 1.0\n[values]\nsin = 1.0\n", "values.sin: cannot be a name in formulas"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_wrong_values_are_refused_in_one_line(experiment_file, case):
    text, reason = REFUSED[case]
    with pytest.raises(InputError) as problem:
        load(experiment_file(FLYWHEEL, text))
    assert reason in str(problem.value)
    assert "\n" not in str(problem.value)
