"""Applied loads: forces and pushes along coordinates, from body states to wrenches.

Loads are packed as ``(records, signals, states, breaks, coefficients, segments)``: arrays of `LOAD`, `SIGNAL` and
`STATE`, and `Motions.arrays` with the values of forces and torques, and the rates of states. The inputs of these are
the time, the states and the signals; see `linkages.system.load_records.pack_loads`.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from linkages.base.kernel import Array, Indices, Records, inlined_kernel, kernel, lazy_kernel
from linkages.base.kernel.dual import number
from linkages.laws.control import call_controller
from linkages.mechanics.planar.closure_rows import add_term_wrench, term_rate, term_value
from linkages.mechanics.planar.markers import add_force, arm, marker_velocity, turned
from linkages.mechanics.planar.motion import Curves, function_jet
from linkages.mechanics.planar.record_types import FORCE, PUSH

Loads = tuple[Records, Records, Records, Array, Array, Indices]

#: Quantities of each load at a state. Force: fx, fy in plane axes [N]; push: torque [N m] or force [N], and 0. Then the
#: power that it delivers to the bodies [W], and the energy that it stores [J].
LOAD_OUTPUTS = ("value", "second", "power", "energy")
VALUE, SECOND, POWER, ENERGY = range(len(LOAD_OUTPUTS))


@lazy_kernel(makes_arrays=True)
def load_wrenches(loads: Loads, t: float, v: Array, pose: Array, vel: Array, wrench: Array) -> None:
    """Add the wrenches of all loads at time t [s] to the bodies' wrenches."""
    records, curves = loads[0], loads[3:]
    inputs = np.zeros(inputs_shape(loads[1], loads[2]), vel.dtype)
    fill_inputs(loads[1], loads[2], t, v, pose, vel, inputs)
    for k in range(len(records)):
        load = records[k]
        if load.kind == FORCE:
            fx, fy = _force(load, curves, inputs, pose)
            rx, ry = arm(pose, load.a)
            add_force(wrench, load.a.body, rx, ry, fx, fy)
        elif load.kind == PUSH:
            add_term_wrench(load.term, pose, load.sign * function_jet(curves, load.motion, inputs)[0], wrench)


@lazy_kernel(makes_arrays=True)
def load_outputs(loads: Loads, efforts: Array, t: float, v: Array, pose: Array, vel: Array, outputs: Array) -> None:
    """Fill ``outputs`` (nl, 4) with `LOAD_OUTPUTS` of each load.

    ``efforts`` (nl,): see `linkages.mechanics.planar.reactive_loads.ReactiveLoads`; read for these loads alone.
    """
    records, curves = loads[0], loads[3:]
    inputs = np.zeros(inputs_shape(loads[1], loads[2]), vel.dtype)
    fill_inputs(loads[1], loads[2], t, v, pose, vel, inputs)
    for k in range(len(records)):
        load = records[k]
        second = 0.0
        if load.kind == PUSH:
            value = function_jet(curves, load.motion, inputs)[0]
            if load.joint >= 0:
                value += efforts[k]
            power = value * load.sign * term_rate(load.term, pose, vel)
        elif load.kind == FORCE:
            value, second = _force(load, curves, inputs, pose)
            rx, ry = arm(pose, load.a)
            vx, vy = marker_velocity(vel, load.a.body, rx, ry)
            power = value * vx + second * vy
        else:
            value, power = function_jet(curves, load.motion, inputs)[0], 0.0
        outputs[k, VALUE], outputs[k, SECOND], outputs[k, POWER], outputs[k, ENERGY] = value, second, power, 0.0


def acting_functions(loads: Loads) -> NDArray[np.bool_]:
    """Return which functions the motion always depends on: all but functions of quantities and of sampled states."""
    records, _, states, _, _, segments = loads
    acts = np.zeros(len(segments), bool)
    acts[records["motion"][(records["kind"] == FORCE) | (records["kind"] == PUSH)]] = True
    acts[records["motion"][records["kind"] == FORCE] + 1] = True
    acts[records["share"][records["joint"] >= 0]] = True
    acts[states["function"][states["period"] == 0.0]] = True
    return acts


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


@lazy_kernel(makes_arrays=True)
def state_rates(loads: Loads, t: float, v: Array, pose: Array, vel: Array, a: Array) -> None:
    """Fill the last entries of ``a`` (n + nz,) with the rates of the states; sampled ones rest between samples."""
    states, before = loads[2], len(v) - len(loads[2])
    inputs = np.zeros(inputs_shape(loads[1], states), vel.dtype)
    fill_inputs(loads[1], states, t, v, pose, vel, inputs)
    for k in range(len(states)):
        if states[k].period > 0.0:
            a[before + k] = 0.0
        else:
            a[before + k] = function_jet(loads[3:], states[k].function, inputs)[0]


_TICK = 1e-12  # relative error of a sampling time that counts as rounding


@inlined_kernel
def is_due(t: float, due: float) -> bool:
    """Whether a sampling time has come, but for rounding."""
    return t * (1.0 + _TICK) >= due


@inlined_kernel
def next_due(t: float, period: float) -> float:
    """Return the first sampling time after those that have come."""
    return (math.floor(t * (1.0 + _TICK) / period) + 1.0) * period


@lazy_kernel(makes_arrays=True)
def sample_states(loads: Loads, due: Array, t: float, v: Array, pose: Array, vel: Array) -> None:
    """Give sampled states whose times ``due`` (nz,) [s] have come their next values, all from the values before."""
    states, before = loads[2], len(v) - len(loads[2])
    inputs = np.zeros(inputs_shape(loads[1], states), vel.dtype)
    fill_inputs(loads[1], states, t, v, pose, vel, inputs)
    for k in range(len(states)):
        if is_due(t, due[k]):
            state = states[k]
            if state.controller == 0:
                v[before + k] = function_jet(loads[3:], state.function, inputs)[0]
            elif state.results > 0:
                count = 1 + state.arguments
                numbers = np.empty(count + state.results)
                numbers[0] = number(t)
                for i in range(1, count):
                    numbers[i] = number(function_jet(loads[3:], state.function + i - 1, inputs)[0])
                call_controller(state.controller, (numbers.ctypes.data, count, state.results))
                for i in range(state.results):
                    v[before + k + i] = numbers[count + i]


@kernel
def _force(load: np.record, curves: Curves, inputs: Array, pose: Array) -> tuple[float, float]:
    """Components of a force in plane axes."""
    x, _, _ = function_jet(curves, load.motion, inputs)
    y, _, _ = function_jet(curves, load.motion + 1, inputs)
    ux, uy = load.ux, load.uy
    if load.turns:
        ux, uy = turned(pose, load.a.body, ux, uy)
    return ux * x - uy * y, uy * x + ux * y
