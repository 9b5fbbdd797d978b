"""Reynolds' equation on the film of a finite journal bearing: finite volumes in two dimensions.

With h = 1 + eps*cos(theta) (theta = 0 is the widest gap), z the axial coordinate from the middle of the
bearing over its half length, lam = L/D, and the pressure in units of mu*R^2/c^2, the film obeys

    d/dtheta (h^3 dp/dtheta) + 1/lam^2 d/dz (h^3 dp/dz) = 12*(b*cos(theta) - w*sin(theta)),
    p = 0 at z = 1, dp/dz = 0 at z = 0,

with b = deps and w = ew/2 (see `linkages.laws.film`). The force on the journal, in units of mu*L*R^3/c^2,
is (f_n, f_t) = integral of p*(cos, sin)(theta) dtheta dz, and its power is -integral of h^3 |grad p|^2 / 12.

Two rules of cavitation: *guembel* solves the whole film and drops negative pressure; *reynolds* solves the
complementarity problem p >= 0, h^3-Laplacian of p <= 12*(...), p * (difference) = 0. Both are homogeneous
of degree one in (b, w), and both give a passive film, in the discrete equations too. The ring is closed:
only an open end, or a groove that is asked for, holds the pressure at ambient. Under *reynolds* the middle of
a long bearing (from L/D of about 2 on) fills all around, and with L/D its force tends to the force of the full
film without cavitation, of which the open ends shift the pressure and nothing else.

The mesh is graded: half of its circumferential lines are spread evenly in theta, half in Sommerfeld's
angle, d(psi)/d(theta) = sqrt(1 - eps^2)/h, which resolves the thin film at any eps; the axial lines are
the points of z = sin(pi/2 * eta), which crowd at the open end. The scheme is of second order on both.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from linkages.kernel import Array
from linkages.laws.film.surface.obstacle import obstacle

#: Lines of the default mesh around the film and along its half length.
AROUND, ALONG = 240, 20


class Mesh(NamedTuple):
    """Finite-volume mesh of half the film's length, all around it; one row of unknowns per theta line."""

    eps: float
    slenderness: float
    theta: Array  # lines of unknowns, theta[0] = 0 [rad], shape (around,)
    width: Array  # widths of their cells [rad], shape (around,)
    rate_b: Array  # integral of 12*cos(theta) over each cell, shape (around,)
    rate_w: Array  # integral of -12*sin(theta) over each cell, shape (around,)
    force_n: Array  # integral of cos(theta) over each cell, shape (around,)
    force_t: Array  # integral of sin(theta) over each cell, shape (around,)
    along_theta: Array  # conductance from line i to line i + 1, per unit z, shape (around,)
    cube: Array  # integral of h^3 over each cell, shape (around,)
    z: Array  # axial positions of the unknowns, z = 1 excluded, shape (along,)
    height: Array  # lengths of their cells, shape (along,)
    along_z: Array  # conductance from row j to row j + 1 per unit of `cube`, shape (along,)


class Pressure(NamedTuple):
    """Pressure on a mesh, and the results from it."""

    mesh: Mesh
    p: Array  # shape (around, along), >= 0
    f_n: float
    f_t: float
    flow: float  # out of both ends, in units of c*R^2
    extent: float  # axial mean of the integral of dtheta/h over the film that carries pressure


def make_mesh(eps: float, slenderness: float, around: int = AROUND, along: int = ALONG) -> Mesh:
    """Build the graded mesh for an eccentricity ratio in [0, 1) and L/D > 0.

    Raises
    ------
    ValueError
        If eps, L/D or the numbers of lines are out of range.
    """
    if not 0.0 <= eps < 1.0:
        raise ValueError(f"eccentricity ratio {eps!r}: must be in [0, 1)")
    if not (slenderness > 0.0 and math.isfinite(slenderness)):
        raise ValueError(f"slenderness L/D {slenderness!r}: must be positive")
    if around < 8 or around % 2 or along < 2:
        raise ValueError(f"mesh {around} x {along}: needs an even number >= 8 around and >= 2 along")
    lines = _graded(eps, np.linspace(0.0, 2.0 * math.pi, 2 * around + 1))
    theta, face = lines[0:-1:2], lines[1::2]
    low = np.concatenate(([face[-1] - 2.0 * math.pi], face[:-1]))
    # Simpson's rule on the film between two lines: the conductance is 1 / integral of dtheta/h^3
    step = lines[2::2] - theta
    left, middle, right = (_film(eps, t) ** -3 for t in (theta, 0.5 * (theta + lines[2::2]), lines[2::2]))
    eta = np.arange(2 * along + 1) / (2.0 * along)
    position = np.sin(0.5 * math.pi * eta)
    edge = np.concatenate(([0.0], position[1::2]))
    return Mesh(
        eps=eps,
        slenderness=slenderness,
        theta=theta,
        width=face - low,
        rate_b=12.0 * (np.sin(face) - np.sin(low)),
        rate_w=12.0 * (np.cos(face) - np.cos(low)),
        force_n=np.sin(face) - np.sin(low),
        force_t=np.cos(low) - np.cos(face),
        along_theta=6.0 / (step * (left + 4.0 * middle + right)),
        cube=_cube_integral(eps, face) - _cube_integral(eps, low),
        z=position[0:-1:2],
        height=np.diff(edge),
        along_z=1.0 / (np.diff(position[0::2]) * slenderness * slenderness),
    )


def _film(eps: float, theta: Array) -> Array:
    return 1.0 + eps * np.cos(theta)


def _cube_integral(eps: float, theta: Array) -> Array:
    """Integral of (1 + eps*cos(theta))^3 from 0."""
    sine = np.sin(theta)
    return (
        theta * (1.0 + 1.5 * eps * eps)
        + 3.0 * eps * sine
        + 0.75 * eps * eps * np.sin(2.0 * theta)
        + eps**3 * (sine - sine**3 / 3.0)
    )


def _sommerfeld(eps: float, theta: Array) -> Array:
    """Sommerfeld's angle."""
    return 2.0 * np.arctan2(math.sqrt((1.0 - eps) / (1.0 + eps)) * np.sin(0.5 * theta), np.cos(0.5 * theta))


def _graded(eps: float, xi: Array) -> Array:
    """Solve (theta + psi(theta))/2 = xi for theta, psi Sommerfeld's angle: symmetric about pi."""
    low, high = np.zeros_like(xi), np.full_like(xi, math.pi)
    mirror = np.where(xi > math.pi, 2.0 * math.pi - xi, xi)
    for _ in range(60):  # bisection: the sum is monotonic, and this is not where the time goes
        middle = 0.5 * (low + high)
        above = 0.5 * (middle + _sommerfeld(eps, middle)) > mirror
        high, low = np.where(above, middle, high), np.where(above, low, middle)
    theta = 0.5 * (low + high)
    theta[mirror <= 0.0] = 0.0
    return np.where(xi > math.pi, 2.0 * math.pi - theta, theta)


def solve_half(mesh: Mesh, load: Array, parity: int) -> Array:
    """Solve -div(h^3 grad p) = load for p even (parity 1) or odd (parity -1) about theta = 0 and pi.

    Parameters
    ----------
    load : array of shape (around/2 + parity, along)
        Integrals over the cells of the lines from 0 to pi, of which the first and the last are half cells; for odd p
        over those of the lines strictly between.

    Returns
    -------
    p : array of shape (around, along)

    Notes
    -----
    The film depends on theta alone, so that the modes of the axial operator separate the equation (fast
    diagonalisation: Lynch, Rice and Thomas 1964).
    """
    half, k = mesh.theta.size // 2, mesh.along_theta
    if parity > 0:
        lines, cube = slice(0, half + 1), mesh.cube[: half + 1].copy()
        cube[[0, -1]] *= 0.5
        forward, backward = np.append(k[:half], 0.0), np.append(0.0, k[:half])
    else:
        lines, cube = slice(1, half), mesh.cube[1:half]
        forward, backward = k[1:half], k[: half - 1]
    root = np.sqrt(mesh.height)
    along = np.diag(mesh.along_z) - np.diag(mesh.along_z[:-1], 1) - np.diag(mesh.along_z[:-1], -1)
    along[1:, 1:] += np.diag(mesh.along_z[:-1])
    decay, shapes = np.linalg.eigh(along / np.outer(root, root))
    parts = _tridiagonal((forward + backward)[:, None] + cube[:, None] * decay, -forward, load / root @ shapes)
    p = np.zeros((mesh.theta.size, mesh.z.size))
    p[lines] = parts @ shapes.T / root
    p[half + 1 :] = parity * p[half - 1 : 0 : -1]
    return p


def _tridiagonal(diagonal: Array, beside: Array, right: Array) -> Array:
    """Solve symmetric tridiagonal systems, one for each column; `beside`, (n,), joins line i to line i + 1."""
    diagonal, x = diagonal.copy(), right.copy()
    for i in range(1, len(x)):
        factor = beside[i - 1] / diagonal[i - 1]
        diagonal[i] -= factor * beside[i - 1]
        x[i] -= factor * x[i - 1]
    x[-1] /= diagonal[-1]
    for i in range(len(x) - 2, -1, -1):
        x[i] = (x[i] - beside[i] * x[i + 1]) / diagonal[i]
    return x


def full_film(mesh: Mesh) -> tuple[Array, Array]:
    """Solve the film without cavitation for unit deps (even) and for unit ew/2 (odd).

    Returns
    -------
    p_b, p_w : arrays of shape (around, along)
    """
    half = mesh.theta.size // 2
    rate_b = mesh.rate_b[: half + 1].copy()
    rate_b[[0, -1]] *= 0.5
    p_b = solve_half(mesh, -rate_b[:, None] * mesh.height, 1)
    p_w = solve_half(mesh, -mesh.rate_w[1:half, None] * mesh.height, -1)
    return p_b, p_w


def guembel(mesh: Mesh, films: tuple[Array, Array], deps: float, half_ew: float) -> Pressure:
    """Drop the negative pressure of the full film (half Sommerfeld): `films` from `full_film`."""
    return _integrate(mesh, films[0] * deps + films[1] * half_ew)


def reynolds(
    mesh: Mesh, deps: float, half_ew: float, *, ambient_at_widest: bool = False, guess: Array | None = None
) -> Pressure:
    """Solve the film with Reynolds' (Swift-Stieber) condition: pressure and its slope vanish where it ends.

    Parameters
    ----------
    ambient_at_widest : bool
        Hold an axial line at the widest gap at ambient pressure (a groove there: Butenschoen's tables).
    guess : array of shape (around, along), optional
        A pressure of a neighbouring state, to start from.

    Raises
    ------
    ArithmeticError
        If the active set does not settle (it is monotonic for this matrix; none is known to fail).

    Notes
    -----
    A film may be wet all around, as the middle of a long bearing is: the ring is never cut where it is wet.
    The active set wets one more line of cells in a step, so that it starts, without a guess, from the film on a mesh
    half as fine.
    """
    load = -((deps * mesh.rate_b + half_ew * mesh.rate_w)[:, None] * mesh.height)
    count, rows = load.shape
    wet = np.ones(load.shape, dtype=bool)
    if guess is not None:
        wet = guess > 0.0
    elif count % 4 == 0 and count >= 32 and rows % 2 == 0 and rows >= 4:
        coarse = make_mesh(mesh.eps, mesh.slenderness, count // 2, rows // 2)
        film = reynolds(coarse, deps, half_ew, ambient_at_widest=ambient_at_widest)
        wet = (film.p > 0.0).repeat(2, axis=0).repeat(2, axis=1)
    free = np.ones_like(wet)
    free[0] = not ambient_at_widest
    # conductances from each cell to the next around the film, and along it
    around, along = mesh.along_theta[:, None] * mesh.height, mesh.cube[:, None] * mesh.along_z
    return _integrate(mesh, obstacle(around, along, np.zeros(count), load, free, wet))


def _integrate(mesh: Mesh, p: Array) -> Pressure:
    """Force and extent of the positive part of p; the film's edge is interpolated between two lines."""
    positive = np.maximum(p, 0.0)
    mean = positive @ mesh.height
    following = np.roll(p, -1, axis=0)
    total = np.maximum(p, 0.0) + np.maximum(following, 0.0)
    span = np.abs(p) + np.abs(following)
    part = np.divide(total, span, out=np.zeros_like(p), where=span > 0.0)
    turn = np.diff(np.append(_sommerfeld(mesh.eps, mesh.theta), 2.0 * math.pi))
    extent = float(turn @ part @ mesh.height) / math.sqrt(1.0 - mesh.eps**2)
    flow = float(mesh.cube @ positive[:, -1]) * float(mesh.along_z[-1]) * mesh.slenderness / 6.0
    return Pressure(mesh, positive, float(mesh.force_n @ mean), float(mesh.force_t @ mean), flow, extent)
