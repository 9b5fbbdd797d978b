"""Applied loads: pushes along coordinates, from body states to wrenches; additional states.

Loads are packed as ``(records, signals, states, breaks, coefficients, segments)``: an array of `LOAD`, then
`linkages.mechanics.planar.functions.Functions` with the values of loads, of elements, and the rates of states; see
`linkages.system.load_records.pack_loads`.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from linkages.base.kernel import Array, Indices, Records, inlined_kernel, lazy_kernel
from linkages.base.kernel.dual import number
from linkages.laws.control import call_controller
from linkages.mechanics.planar.closure_rows import add_term_wrench, term_rate
from linkages.mechanics.planar.functions import Functions, given_at, value_of

Loads = tuple[Records, Records, Records, Array, Array, Indices]

#: Quantities of each load or element at a state: its values, such as the torque [N m]; the power that it delivers to
#: the bodies [W], and the energy that it stores [J].
LOAD_OUTPUTS = ("value", "second", "power", "energy")
VALUE, SECOND, POWER, ENERGY = range(len(LOAD_OUTPUTS))


@lazy_kernel(makes_arrays=True)
def load_wrenches(loads: Loads, t: float, v: Array, pose: Array, vel: Array, wrench: Array) -> None:
    """Add the wrenches of all loads at time t [s] to the bodies' wrenches."""
    records, given = loads[0], given_at(loads[1:], t, v, pose, vel)
    for k in range(len(records)):
        load = records[k]
        add_term_wrench(load.term, pose, load.sign * value_of(given, load.motion), wrench)


@lazy_kernel(makes_arrays=True)
def load_outputs(loads: Loads, efforts: Array, t: float, v: Array, pose: Array, vel: Array, outputs: Array) -> None:
    """Fill ``outputs`` (nl, 4) with `LOAD_OUTPUTS` of each load.

    ``efforts`` (nl,): see `linkages.mechanics.planar.reactive_loads.ReactiveLoads`; read for these loads alone.
    """
    records, given = loads[0], given_at(loads[1:], t, v, pose, vel)
    for k in range(len(records)):
        load = records[k]
        value = value_of(given, load.motion)
        if load.joint >= 0:
            value += efforts[k]
        power = value * load.sign * term_rate(load.term, pose, vel)
        outputs[k, VALUE], outputs[k, SECOND], outputs[k, POWER], outputs[k, ENERGY] = value, 0.0, power, 0.0


def acting_functions(functions: Functions, told: Indices) -> NDArray[np.bool_]:
    """Return which functions the motion always depends on: all but those of sampled states, and those that are told.

    ``told`` are the indices of functions that are outputs alone.
    """
    _, states, _, _, segments = functions
    acts = np.ones(len(segments), bool)
    acts[told] = False
    for state in states[states["period"] > 0.0]:
        acts[state["function"] : state["function"] + max(state["arguments"], 1)] = False
    return acts


@lazy_kernel(makes_arrays=True)
def state_rates(loads: Loads, t: float, v: Array, pose: Array, vel: Array, a: Array) -> None:
    """Fill the last entries of ``a`` (n + nz,) with the rates of the states; sampled ones rest between samples."""
    states, before = loads[2], len(v) - len(loads[2])
    given = given_at(loads[1:], t, v, pose, vel)
    for k in range(len(states)):
        if states[k].period > 0.0:
            a[before + k] = 0.0
        else:
            a[before + k] = value_of(given, states[k].function)


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
    given = given_at(loads[1:], t, v, pose, vel)
    for k in range(len(states)):
        if is_due(t, due[k]):
            state = states[k]
            if state.controller == 0:
                v[before + k] = value_of(given, state.function)
            elif state.results > 0:
                count = 1 + state.arguments
                numbers = np.empty(count + state.results)
                numbers[0] = number(t)
                for i in range(1, count):
                    numbers[i] = number(value_of(given, state.function + i - 1))
                call_controller(state.controller, (numbers.ctypes.data, count, state.results))
                for i in range(state.results):
                    v[before + k + i] = numbers[count + i]
