"""Linear state-space models of linkages that no moving drive prescribes: x' = A x + B u, y = C x + D u.

x, u and y are changes from the operating point. The states x are minimal coordinates (`local_coordinates`), so closed
loops leave no spurious poles. The inputs u are torques of drives and applied loads, the outputs y any outputs of the
registry. Conventions as in python-control: continuous time, G(s) = C (s I - A)^-1 B + D.

A holds exact derivatives of the mechanics, and derivatives of contact laws by differences of the fourth order. Forces
change accelerations linearly, so B is exact as well. C and D are central differences, extrapolated twice.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from linkages.base.arguments import Names, validated
from linkages.base.arrays import Array
from linkages.base.brief import Brief, counted
from linkages.base.errors import InputError, nearest
from linkages.explore.local_coordinates import LocalCoordinates
from linkages.explore.numerics import LINEARISATION_LEAST, LINEARISATION_STEP
from linkages.explore.operating_point import LinearisationPoint, Observed, at_rest
from linkages.results.outputs.registry import pack, unit
from linkages.system import System
from linkages.system.linear_systems import disturbed
from linkages.system.linear_systems import inputs as inputs_of


@dataclass(frozen=True, eq=False, repr=False)
class StateSpace(Brief):
    """A linear model; made by `linearise`: nx states, nu inputs, ``no`` outputs, SI units.

    Attributes
    ----------
    A, B, C, D : (nx, nx), (nx, nu), (no, nx), (no, nu) arrays
        Matrices of dx/dt = A x + B u and y = C x + D u, for changes from the operating point.
    states, inputs, outputs : tuples of str
        Names: ``q.NAME``, ``v.NAME``, ``z.CONTACT``, ``s.NAME`` for coordinates, their rates, states of laws and
        additional states; inputs as in `linkages.system.linear_systems.inputs`; outputs as in the registry.
    units : dict of str to str
        Units of the inputs and outputs.
    x, y : (nx,), (no,) arrays
        States and outputs at the operating point.
    time : float
        Time at which the run reaches the operating point [s].
    at_rest : bool
        Whether the operating point is an equilibrium.
    error : float
        Error of C and D relative to the largest entry of their row, estimated by the last extrapolation [1].
    """

    A: Array
    B: Array
    C: Array
    D: Array
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    units: dict[str, str]
    x: Array
    y: Array
    time: float
    at_rest: bool
    error: float

    def _facts(self) -> tuple[str, dict[str, str]]:
        parts = ((self.states, "state"), (self.inputs, "input"), (self.outputs, "output"))
        line = ", ".join(counted(len(names), noun) for names, noun in parts)
        return line, {f"{noun}s": ", ".join(names) for names, noun in parts}

    @property
    def poles(self) -> NDArray[np.complex128]:
        """Return the eigenvalues of A (nx,) [1/s], with the largest real part first."""
        found = np.linalg.eigvals(self.A).astype(np.complex128)
        return found[np.lexsort((-found.imag, -found.real))]

    def frequency_response(self, omega: Sequence[float] | Array) -> NDArray[np.complex128]:
        """Compute G(i omega) (no, nu, nw) at angular frequencies omega (nw,) [rad/s], output over input units."""
        s = 1j * np.asarray(omega, dtype=np.float64)[:, None, None]
        inner = np.linalg.solve(s * np.eye(len(self.A)) - self.A, self.B.astype(np.complex128)[None])
        return np.moveaxis((self.C @ inner + self.D).astype(np.complex128), 0, -1)

    def save(self, path: str | Path) -> None:
        """Write the model as a NumPy archive: A, B, C, D, names of states, inputs and outputs, their units, x, y, time.

        The matrices are the arguments of ``control.ss`` of python-control.
        """
        arrays = {key: np.asarray(getattr(self, key)) for key in ("A", "B", "C", "D", "x", "y", "time")}
        for key in ("states", "inputs", "outputs"):
            arrays[key] = np.array(getattr(self, key), dtype=str)
        for key in ("inputs", "outputs"):
            arrays[f"{key}_units"] = np.array([self.units[name] for name in getattr(self, key)], dtype=str)
        np.savez(path, allow_pickle=False, **arrays)


@validated
def linearise(
    system: System,
    outputs: Names | None = None,
    inputs: Names | None = None,
    time: float = 0.0,
    equilibrium: bool = False,
) -> StateSpace:
    """Linearise a linkage about a state of its motion, or about an equilibrium.

    Use `modes` for natural frequencies of a linkage whose joints are ideal and whose drives are held.

    Parameters
    ----------
    system : System
        Its prescribed drives must stand still; drives by torque or force may act.
    outputs : sequence of str, optional
        Outputs (see `linkages.results.outputs.registry`); default: the experiment's, else all independent coordinates.
    inputs : sequence of str, optional
        Inputs, see `linkages.system.linear_systems.inputs`; default: all.
    time : float
        Time at which the run reaches the operating point [s]; loads that depend on time keep their values of then.
    equilibrium : bool
        Whether to find an equilibrium near the state of that time, by Newton's method.

    Raises
    ------
    InputError
        If a drive prescribes a motion, nothing can move, a name is unknown, a dry contact is closed, or a model
        does not support it.
    RunError
        If the run fails before the time, or no equilibrium is found.

    Examples
    --------
    >>> import linkages
    >>> system = linkages.load(linkages.find_file("slider_crank_dry.toml"))
    >>> free = system.replaced({"joints": {}, "drives.O": {"angle": 0.5, "torque": 0.0}})
    >>> model = linkages.linearise(free, outputs=["slider.x"])
    >>> model.states, model.inputs
    (('q.O', 'v.O'), ('O.torque',))
    """
    if time < 0.0:
        raise InputError("argument", "time", f"is {time:g} s, before the start of the run; give 0 or more")
    known = inputs_of(system)
    chosen = tuple(known if inputs is None else inputs)
    for name in chosen:
        if name not in known:
            raise InputError("argument", "inputs", f'"{name}" is unknown; {nearest(name, known)}')
    point = LinearisationPoint(system, time)
    if equilibrium:
        point.settle()
    A, local, rates = point.matrix()
    names = tuple(outputs or system.settings.outputs or [name for name in local.names if name.startswith("q.")])
    pack(system, names)
    C, error_c = _by_state(point, local, names)
    B, D, error_d = _by_inputs(point, local, names, chosen)
    units = {name: unit(system, name) for name in names} | {name: known[name][0] for name in chosen}
    x, y = point.y[local.entries], point.observe(point.y, names).outputs
    rest = at_rest(A, rates, point.scale[local.entries])
    return StateSpace(A, B, C, D, local.names, chosen, names, units, x, y, time, rest, max(error_c, error_d))


def _by_state(point: LinearisationPoint, local: LocalCoordinates, names: tuple[str, ...]) -> tuple[Array, float]:
    """Differentiate outputs with respect to the states; return C and its relative error."""
    columns_of = []
    for way, entry in zip(local.tangent.T, local.entries, strict=True):

        def moved(size: float, way: Array = way) -> Array:
            return point.observe(point.y + size * way, names).outputs

        columns_of.append(extrapolated(moved, LINEARISATION_STEP * point.scale[entry]))
    return _joined(columns_of, len(names), point.scale[local.entries])


def _by_inputs(
    point: LinearisationPoint, local: LocalCoordinates, names: tuple[str, ...], chosen: tuple[str, ...]
) -> tuple[Array, Array, float]:
    """Differentiate accelerations, which are linear in the inputs, and outputs; return B, D and D's error."""
    n, m = len(point.runner.model.free), sum(name.startswith("q.") for name in local.names)
    B, rest = np.zeros((len(local.names), len(chosen))), point.observe(point.y).accelerations
    found, steps = [], []
    usual = np.maximum(np.abs(rest), point.system.motion_rate * point.scale[n : 2 * n])
    for k, name in enumerate(chosen):

        def added(value: float, name: str = name) -> Observed:
            return point.observe(point.y, names, disturbed(point.system, name, value))

        change = added(1.0).accelerations - rest
        B[m : 2 * m, k] = change[local.entries[:m]]
        steps.append(1.0 / max(np.max(np.abs(change) / usual), LINEARISATION_LEAST))
        found.append(extrapolated(lambda value: added(value).outputs, LINEARISATION_STEP * steps[k]))
    return B, *_joined(found, len(names), np.array(steps))


def extrapolated(f: Callable[[float], Array], step: float) -> tuple[Array, Array]:
    """Differentiate f at 0 by central differences with three steps, extrapolated twice (order 6); and their error."""
    first = [(f(h) - f(-h)) / (2.0 * h) for h in (step, 0.5 * step, 0.25 * step)]
    second = [(4.0 * fine - coarse) / 3.0 for coarse, fine in pairwise(first)]
    third = (16.0 * second[1] - second[0]) / 15.0
    return third, np.abs(third - second[1])


def _joined(found: list[tuple[Array, Array]], rows: int, scale: Array) -> tuple[Array, float]:
    """Join columns to a matrix; its error relative to the largest entry of the row, times the columns' scale."""
    if not found:
        return np.zeros((rows, 0)), 0.0
    matrix, error = (np.array(part).T for part in zip(*found, strict=True))
    largest = np.abs(matrix * scale).max(axis=1)
    return matrix, float(np.max(np.abs(error * scale).max(axis=1) / np.where(largest > 0.0, largest, 1.0), initial=0.0))
