"""Functions of time, states and signals: the formulas and tables of a machine at a state of its motion.

A record refers to a function by its index. The values of all functions follow from the same inputs, so that a kernel
fills the inputs once for all records that it treats (`given_at`), and then asks for values (`value_of`). The inputs
are numbers of the kind of the velocities: with dual numbers the derivatives of functions follow.
"""

from __future__ import annotations

import numpy as np

from linkages.base.kernel import Array, Indices, Records, inlined_kernel, kernel
from linkages.mechanics.planar.closure_rows import term_rate, term_value
from linkages.mechanics.planar.motion import Curves, function_jet

#: Signals (`SIGNAL`), states (`STATE`), and `linkages.mechanics.planar.motion.Curves` of the functions. Inputs of the
#: functions are the time, the states, then the signals.
Functions = tuple[Records, Records, Array, Array, Indices]

#: Functions with the values of their inputs.
Given = tuple[Curves, Array]


@kernel
def inputs_shape(signals: Records, states: Records) -> tuple[int, int]:
    """Return the shape of the inputs of functions: time, states and signals, with two derivatives."""
    return 1 + len(states) + len(signals), 3


@kernel
def fill_inputs(signals: Records, states: Records, t: float, v: Array, pose: Array, vel: Array, inputs: Array) -> None:
    """Fill time, states and signals into zeros of `inputs_shape`; the states are the last entries of v."""
    first, before = 1 + len(states), len(v) - len(states)
    inputs[0, 0] = t
    for k in range(len(states)):
        inputs[1 + k, 0] = v[before + k]
    for k in range(len(signals)):
        signal = signals[k]
        if signal.rate:
            inputs[first + k, 0] = signal.scale * term_rate(signal.term, pose, vel)
        else:
            inputs[first + k, 0] = signal.scale * (term_value(signal.term, pose) - signal.offset)


@inlined_kernel(makes_arrays=True)
def given_at(functions: Functions, t: float, v: Array, pose: Array, vel: Array) -> Given:
    """Return the functions with their inputs at time t [s] and a state; `v` ends with the additional states."""
    signals, states, breaks, coefficients, segments = functions
    inputs = np.zeros(inputs_shape(signals, states), vel.dtype)
    fill_inputs(signals, states, t, v, pose, vel, inputs)
    return (breaks, coefficients, segments), inputs


@inlined_kernel
def value_of(given: Given, i: int) -> float:
    """Return the value of function i."""
    return function_jet(given[0], i, given[1])[0]
