"""Lagrange's equations of planar linkages whose points are sums of turning vectors: an independent model for tests.

Every body turns by ``s_b . q`` with s_b a row of ones and zeros, and every point is ``sum_k r_k exp(i s_b(k) . q)``: a
complex number whose derivatives are written down at once. Loops are closed by multipliers at the level of
accelerations, without stabilisation. Shares nothing with the package.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp


@dataclass(frozen=True)
class Body:
    """A rigid body: mass [kg], inertia about the mass centre [kg m2], its mass centre as a sum of vectors."""

    mass: float
    inertia: float
    turn: int
    centre: dict


@dataclass(frozen=True)
class Sums:
    """A linkage.

    Attributes
    ----------
    turns : (nb, n) array
        Angle of body b is ``turns[b] @ q``.
    bodies : list of Body
        A point is ``{b: r}``: complex vectors r, each fixed to body b; body None does not turn.
    loops : list of points
        Sums that vanish.
    force : callable
        Generalised force (n,) at (q, v), besides gravity.
    gravity : complex
        [m/s2]
    """

    turns: np.ndarray
    bodies: list
    loops: list
    force: object
    gravity: complex = 0.0

    def point(self, vectors, q, v):
        """Position, its derivatives to q (n,), and the part of its acceleration that comes from the speeds."""
        position, slope, centripetal = 0.0j, np.zeros(len(q), complex), 0.0j
        for b, r in vectors.items():
            turn = np.zeros(len(q)) if b is None else self.turns[b]
            turned = r * np.exp(1j * (turn @ q))
            position += turned
            slope += 1j * turned * turn
            centripetal -= turned * (turn @ v) ** 2
        return position, slope, centripetal

    def closure(self, q):
        """Error of the loops (nl,)."""
        return np.array([self.point(loop, q, 0 * q)[0] for loop in self.loops])

    def accelerations(self, q, v):
        """Accelerations (n,) and the multipliers of the loops, x and y of each (2 nl,)."""
        n = len(q)
        mass, load = np.zeros((n, n)), self.force(q, v)
        for body in self.bodies:
            turn = self.turns[body.turn]
            _, slope, centripetal = self.point(body.centre, q, v)
            mass += body.mass * np.real(np.outer(slope.conj(), slope)) + body.inertia * np.outer(turn, turn)
            load = load + body.mass * np.real(slope.conj() * (self.gravity - centripetal))
        if not self.loops:
            return np.linalg.solve(mass, load), np.zeros(0)
        rows, right = [], []
        for loop in self.loops:
            _, slope, centripetal = self.point(loop, q, v)
            rows += [slope.real, slope.imag]
            right += [-centripetal.real, -centripetal.imag]
        G = np.array(rows)
        system = np.block([[mass, G.T], [G, np.zeros((len(G), len(G)))]])
        solution = np.linalg.solve(system, np.concatenate([load, right]))
        return solution[:n], solution[n:]

    def energy(self, q, v):
        """Kinetic energy and potential energy of gravity [J]."""
        kinetic, potential = 0.0, 0.0
        for body in self.bodies:
            position, slope, _ = self.point(body.centre, q, v)
            kinetic += 0.5 * body.mass * abs(slope @ v) ** 2
            kinetic += 0.5 * body.inertia * (self.turns[body.turn] @ v) ** 2
            potential -= body.mass * (np.conj(self.gravity) * position).real
        return kinetic, potential

    def solve(self, q, v, times, tolerance=1e-12):
        """Coordinates and rates (nt, n) by DOP853."""
        n = len(q)
        run = solve_ivp(
            lambda t, s: np.concatenate([s[n:], self.accelerations(s[:n], s[n:])[0]]),
            (0.0, times[-1]),
            np.concatenate([q, v]),
            method="DOP853",
            t_eval=times,
            rtol=tolerance,
            atol=tolerance,
        )
        assert run.success
        return run.y[:n].T, run.y[n:].T
