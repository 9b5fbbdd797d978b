"""Measured pendulums that swing down to rest: amplitudes and half periods, predicted from a fit to the first half.

Source of the measurements: GitHub, nielsSkov/masterThesisMatlab (a master's thesis on a cart with two pendulums),
parameterEstimation/data: pend1test/test1pend1.csv, pend2test/test1pend2.csv; 150 samples a second, encoder step 2 pi/2000.
Half swings are counted from the release; the fits (`docs/measured_pendulums.py`) begin with half swing 10.
"""

from itertools import pairwise

import numpy as np
import pytest
from machines import joint, model, solid

import linkages

#: Half swing: amplitude [rad], half period [s].
MEASURED = {
    1: {
        10: (1.995, 0.7497), 20: (1.605, 0.6727), 30: (1.319, 0.6339), 40: (1.087, 0.6099), 50: (0.886, 0.5944),
        60: (0.707, 0.5830), 70: (0.543, 0.5760), 80: (0.386, 0.5701), 90: (0.239, 0.5671), 100: (0.091, 0.5604),
    },
    2: {
        10: (1.904, 0.5813), 20: (1.470, 0.5204), 30: (1.140, 0.4900), 40: (0.858, 0.4720), 50: (0.606, 0.4606),
        60: (0.371, 0.4544), 70: (0.138, 0.4504),
    },
}  # fmt: skip
FIRST = 10
STEP = 2.0 * np.pi / 2000.0  # of the encoder [rad]


def swings(system_of, mass, angle, rate, length, duration, **friction):
    """Amplitude [rad] and half period [s] of each half swing, found as in the record: 150 samples a second."""
    arm = solid("arm", mass, 1e-9, centre=f"0 {-length} 0 0 0 0")
    text = f"duration = {duration}\ngravity = [0.0, -9.82, 0.0]\n[drives.O]\ntorque = 0.0\nangle = {angle}\nspeed = {rate}\n"
    text += "[frictions.pin]\njoint = 'O'\nspeed = 0.01\nradius = 0.004\n"
    text += "".join(f"{name} = {value}\n" for name, value in friction.items())
    system = system_of(model("pendulum", arm + joint("O", "world", "arm")), text + "[solver]\naccuracy = 1e-8\n")
    run = linkages.simulate(system, "compiled")
    times = np.arange(0.0, duration, 1.0 / 150.0)
    angles = run.evaluate(times)["q.O"]
    passed = np.flatnonzero(angles[1:] * angles[:-1] < 0.0)
    at = times[passed] - angles[passed] / (angles[passed + 1] - angles[passed]) / 150.0
    amplitudes = [np.abs(angles[a : b + 1]).max() for a, b in pairwise(passed)]
    return np.array(amplitudes), np.diff(at)


#: Fits to the first half of the records from half swing 10 on: with the joint force, and without; SI units.
FITS = {
    1: (
        {"mass": 0.2235, "angle": -0.018684, "rate": 9.4018, "length": 0.31835, "constant": 2.8416e-3, "coefficient": 0.24666},
        {"mass": 0.2235, "angle": -0.025377, "rate": 9.3932, "length": 0.31839, "constant": 3.5291e-3, "viscous": 5.7802e-4},
    ),
    2: (
        {"mass": 0.2642, "angle": -0.030218, "rate": 11.479, "length": 0.20196, "constant": 5.126e-3, "coefficient": 0.0744},
        {"mass": 0.2642, "angle": -0.031753, "rate": 11.475, "length": 0.20196, "constant": 5.3915e-3, "viscous": 1.6104e-4},
    ),
}  # fmt: skip


@pytest.mark.parametrize("pendulum", MEASURED)
def test_friction_from_the_joint_force_predicts_a_measured_decay(system_of, pendulum):
    """Amplitudes to two encoder steps (reading, rest position), half periods to 0.1 % and the time of such a step."""
    count = np.array([*MEASURED[pendulum]]) - FIRST
    amplitude, half = np.transpose([*MEASURED[pendulum].values()])
    errors = []
    for fit in FITS[pendulum]:
        found, periods = swings(system_of, duration=62.0 if pendulum == 1 else 37.0, **fit)
        errors.append(np.abs(found[count] - amplitude))
        if "coefficient" in fit:
            assert np.all(np.abs(periods[count] - half) < 1e-3 * half + 1.5 * STEP * half / (np.pi * amplitude))
    late = count > 0.5 * count[-1]  # predicted, not fitted
    assert errors[0].max() < 2.0 * STEP
    assert errors[1][late].max() > 2.0 * errors[0][late].max()  # without the joint force
