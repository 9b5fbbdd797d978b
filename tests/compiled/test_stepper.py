"""The stepper: closed loops against exact discretisation, restarts with equal bits, wrong inputs."""

import copy
import pickle

import numpy as np
import pytest
from machines import joint, model, slider_crank, solid
from shipped import shipped

from linkages import InputError, Status, Stepper, simulate

INERTIA = 0.2
FREE = "duration = 10.0\n[drives.A]\ntorque = 0.0\n[solver]\naccuracy = 1e-12\n"


def wheel():
    return model("wheel", solid("one", 1.0, INERTIA) + joint("A", "world", "one"))


def test_a_sampled_controller_is_the_exact_discretisation(system_of):
    """A PD controller of a wheel, whose torque is held for 10 ms: a double integrator between the samples."""
    stepper = Stepper(system_of(wheel(), FREE), ["drives.A.torque"], ["q.A", "A.rate", "A.torque"])
    angle, rate, sample = 0.0, 0.0, 0.01
    for k in range(200):
        seen = stepper.outputs()
        torque = 8.0 * (1.0 - seen["q.A"]) - 1.6 * seen["A.rate"]
        assert stepper.step((k + 1) * sample, {"drives.A.torque": torque}) is Status.OK
        exact = 8.0 * (1.0 - angle) - 1.6 * rate
        angle += sample * rate + 0.5 * sample**2 * exact / INERTIA
        rate += sample * exact / INERTIA
        seen = stepper.outputs()
        assert seen["q.A"] == pytest.approx(angle, abs=1e-11)
        assert seen["A.rate"] == pytest.approx(rate, abs=1e-10)
        assert seen["A.torque"] == torque
    assert abs(angle - 1.0) < 0.01


def test_a_force_is_an_input_of_two_components(system_of):
    body = solid("carrier", 1e-9) + joint("x", "world", "carrier", "prismatic", "1 0 0")
    body += solid("block", 2.0) + joint("y", "carrier", "block", "prismatic", "0 1 0")
    text = 'duration = 1.0\n[forces.push]\npoint = "block"\nforce = [0.0, 0.0]\n'
    stepper = Stepper(system_of(model("block", body), text), ["forces.push.force"], ["block.ax", "block.ay", "block.x"])
    stepper.step(0.5, {"forces.push.force": (3.0, -4.0)})
    assert stepper.outputs() == pytest.approx({"block.ax": 1.5, "block.ay": -2.0, "block.x": 0.1875}, abs=1e-8)
    stepper.step(0.6)  # inputs hold
    assert stepper.outputs()["block.x"] == pytest.approx(0.27, abs=1e-8)


def test_held_inputs_are_the_same_torque_as_a_formula(system_of):
    """The formula holds the torque between the samples of a state; a constant one is a formula of a number."""
    text = "duration = 0.2\n[drives.O]\nspeed = 20.0\ntorque = 0.0\n[solver]\naccuracy = 1e-11\n"
    names = ["O.rate", "slider.x"]
    held = "[torques.T]\njoint = 'O'\nformula = 'u'\n[states.u]\nnext = '0.1*sin(40*t)'\nsample_time = 0.01\n"
    constant = "[torques.T]\njoint = 'O'\nformula = '0.05'\n"
    cases = (held, lambda k: 0.1 * np.sin(0.4 * k)), (constant, lambda k: 0.05)
    for formula, torque in cases:
        stepper = Stepper(system_of(slider_crank(), text), ["drives.O.torque"], names)
        run, times = simulate(system_of(slider_crank(), text + formula)), 0.01 * np.arange(1, 20)
        exact = run.evaluate(times)
        for k, time in enumerate(times.tolist()):
            stepper.step(time, {"drives.O.torque": torque(k)})
            seen = stepper.outputs()
            assert seen["O.rate"] == pytest.approx(exact["O.rate"][k], abs=1e-10)
            assert seen["slider.x"] == pytest.approx(exact["slider.x"][k], abs=1e-12)


@pytest.mark.parametrize(("name", "step", "count"), [("slider_crank_dry", 2e-4, 40), ("seven_bar", 5e-3, 40)])
def test_a_restored_state_gives_equal_bits(name, step, count):
    """Impacts with approach speeds, and stiff films with an implicit method; another stepper continues as well."""
    system = shipped(name)
    stepper = Stepper(system)

    def go(one, first, last, look=True):
        found = []
        for k in range(first, last):
            one.step((k + 1) * step)
            found.append(one.outputs() if look else None)
        return found

    go(stepper, 0, count // 2)
    kept = pickle.dumps(stepper.state())
    rest = go(stepper, count // 2, count)
    end = stepper.state()
    stepper.restore(pickle.loads(kept))
    assert go(stepper, count // 2, count) == rest
    another = Stepper(system)
    another.restore(pickle.loads(kept))
    go(another, count // 2, count, look=False)
    np.testing.assert_array_equal(another.state().state, end.state)
    np.testing.assert_array_equal(another.state().memory, end.memory)
    assert another.outputs() == rest[-1]


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, lambda one: pickle.loads(pickle.dumps(one))])
def test_a_copy_goes_on_by_itself(system_of, copied):
    """It has the state, the inputs and the outputs, and shares no array that a step changes."""
    text = (
        "duration = 1.0\n[drives.O]\ntorque = 0.1\n[joints.B]\nmodel = 'dry'\nclearance = 1e-4\n"
        "contact = {law = 'flores', restitution = 0.5, youngs_modulus = 2e11}\n"
    )
    system = system_of(slider_crank(), text)
    names = ["O.rate", "B.force", "O.torque"]
    first, *others = (Stepper(system, ["drives.O.torque"], names) for _ in range(3))
    for stepper in (first, *others):
        stepper.step(0.1, {"drives.O.torque": 0.3})
    second = copied(first)
    for stepper in (second, others[0]):
        stepper.step(0.25, {"drives.O.torque": -0.2})
    for stepper in (first, others[1]):
        stepper.step(0.2)
    assert [second.outputs(), first.outputs()] == [stepper.outputs() for stepper in others]


def test_steps_join_to_the_run(fast_press):
    """The step ends differ from those of a run: equal within the accuracy."""
    names = ["slider7.x", "A.force"]
    stepper, run = Stepper(fast_press, outputs=names), simulate(fast_press, "compiled", outputs=names)
    peaks = {name: np.abs(run[name]).max() for name in names}
    times = np.linspace(0.0, 0.2 * fast_press.experiment.duration, 21)[1:]
    for time in times:
        stepper.step(time)
        exact = run.evaluate(np.array([time]))
        for name, value in stepper.outputs().items():
            assert value == pytest.approx(exact[name][0], abs=2e-5 * peaks[name])


#: case -> (function, expected part of the message)
REFUSED = {
    "unknown input": (lambda system: Stepper(system, ["drives.B.torque"]), 'input "drives.B.torque": is unknown'),
    "no constant": (lambda system: Stepper(system, ["drives.A.force"]), "is no constant; give drives.A a force"),
    "unknown output": (lambda system: Stepper(system, [], ["one.z"]), 'output "one.z": is unknown'),
    "past": (lambda system: Stepper(system).step(0.0), "time: is 0 s; it must be after 0 s, up to 10 s"),
    "not a time": (lambda system: Stepper(system).step(float("nan")), "time: is nan s; it must be after"),
    "not an input": (lambda system: Stepper(system).step(1.0, {"A": 1.0}), 'values: "A" is no input'),
    "not finite": (
        lambda system: Stepper(system, ["drives.A.torque"]).step(1.0, {"drives.A.torque": float("inf")}),
        'values["drives.A.torque"]: needs 1 finite number; it is inf',
    ),
    "a text": (
        lambda system: Stepper(system, ["drives.A.torque"]).step(1.0, {"drives.A.torque": "1"}),
        "needs 1 finite number; it is '1'",
    ),
    "another machine": (
        lambda system: Stepper(system).restore(Stepper(shipped("slider_crank_dry")).state()),
        "state: is of another system, or of one with other inputs",
    ),
    "other inputs": (
        lambda system: Stepper(system).restore(Stepper(system, ["drives.A.torque"]).state()),
        "state: is of another system, or of one with other inputs",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_wrong_inputs_are_refused_in_one_line(system_of, case):
    function, reason = REFUSED[case]
    with pytest.raises(InputError) as problem:
        function(system_of(wheel(), FREE))
    assert reason in str(problem.value)
    assert "\n" not in str(problem.value)


def test_a_refused_input_leaves_the_others_as_they_are(system_of):
    text = FREE + "[torques.extra]\nlink = 'one'\ntorque = 0.0\n"
    stepper = Stepper(system_of(wheel(), text), ["drives.A.torque", "torques.extra.torque"], ["A.rate"])
    with pytest.raises(InputError, match="needs 1 finite number"):
        stepper.step(0.5, {"drives.A.torque": 7.0, "torques.extra.torque": float("nan")})
    stepper.step(0.5)
    assert stepper.outputs() == {"A.rate": 0.0}


def test_a_motion_that_has_ended_goes_no_further(system_of):
    text = 'duration = 1.0\n[drives.A]\ntorque = 0.0\n[torques.wild]\nlink = "one"\nformula = "1/(0.5 - t)"\n'
    stepper = Stepper(system_of(wheel(), text))
    start = stepper.state()
    assert stepper.step(0.9) is not Status.OK
    assert stepper.time < 0.9
    with pytest.raises(InputError, match="the motion ended with the status"):
        stepper.step(0.95)
    stepper.restore(start)
    assert stepper.step(0.1) is Status.OK
