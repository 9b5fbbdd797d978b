"""Calls by address, so that callers are compiled without what they call.

Compiled code contains all that it calls: at every level of calls, what is below is optimised and written once more. The
integrator is many levels above the laws. Here these are compiled once, to C functions, of which the equations hold the
addresses (`linkages.engines.compiled.model.Calls`); a call costs some nanoseconds. What a model does not need is not
compiled.
"""

from __future__ import annotations

from typing import Any

from numba.core import types

from linkages.engines.compiled.model import Equations
from linkages.integrate.stepper import Stepper
from linkages.kernel import Array, caller, kernel

VECTOR, MATRIX = types.Array(types.float64, 1, "C"), types.Array(types.float64, 2, "C")
PAIR = types.UniTuple(types.float64, 2)


_call_for_nothing, _call_for_bool, _call_for_pair = (caller(kind) for kind in (types.none, types.boolean, PAIR))


def signatures(equations: Any, stepper: Any) -> dict[str, Any]:
    """Return the signatures of the functions below, for the types of equations and of a stepper (references)."""
    time = size = types.float64
    return {
        "solve": types.none(equations, time, VECTOR),
        "jacobian": types.none(equations, time, VECTOR, MATRIX, MATRIX),
        "project": types.boolean(equations, VECTOR),
        "attempt": PAIR(equations, stepper, time, size, VECTOR, types.boolean),
        "loads": types.none(equations, time),
        "loads_tangent": types.none(equations, time, MATRIX, MATRIX, MATRIX),
    }


@kernel
def solve(equations: Equations, t: float, y: Array) -> None:
    """Call `linkages.engines.compiled.equations.solve_state`."""
    _call_for_nothing(equations.calls.solve, (equations, t, y))


@kernel
def jacobian(equations: Equations, t: float, y: Array, mass: Array, out: Array) -> None:
    """Call `linkages.engines.compiled.jacobian.jacobian`."""
    _call_for_nothing(equations.calls.jacobian, (equations, t, y, mass, out))


@kernel
def project(equations: Equations, y: Array) -> bool:
    """Call `linkages.engines.compiled.projection.project_state`."""
    return bool(_call_for_bool(equations.calls.project, (equations, y)))


@kernel
def attempt(equations: Equations, s: Stepper, t: float, h: float, y: Array, exact: bool) -> tuple[float, float]:
    """Call the ``attempt`` of the method, see `linkages.integrate.radau`."""
    error, factor = _call_for_pair(equations.calls.attempt, (equations, s, t, h, y, exact))
    return error, factor


@kernel
def loads(equations: Equations, t: float) -> None:
    """Call `linkages.engines.compiled.equations.add_loads`."""
    _call_for_nothing(equations.calls.loads, (equations, t))


@kernel
def loads_tangent(equations: Equations, t: float, dpose: Array, dvel: Array, out: Array) -> None:
    """Call `linkages.engines.compiled.jacobian.add_loads_tangent`."""
    _call_for_nothing(equations.calls.loads_tangent, (equations, t, dpose, dvel, out))
