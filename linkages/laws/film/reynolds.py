"""Reynolds' equation on the film of a finite journal bearing: finite volumes in two dimensions.

With h = 1 + eps*cos(theta) (theta = 0 is the widest gap), z the axial coordinate from the middle of the
bearing over its half length, lam = L/D, and the pressure in units of mu*R^2/c^2, the film obeys

    d/dtheta (h^3 dp/dtheta) + 1/lam^2 d/dz (h^3 dp/dz) = 12*(b*cos(theta) - w*sin(theta)),
    p = 0 at z = 1, dp/dz = 0 at z = 0,

with b = deps and w = ew/2 (see `linkages.laws.film`). The force on the journal, in units of mu*L*R^3/c^2,
is (f_n, f_t) = integral of p*(cos, sin)(theta) dtheta dz, and its power is -integral of h^3 |grad p|^2 / 12.

Two rules of cavitation: *guembel* solves the whole film and drops negative pressure; *reynolds* solves the
complementarity problem p >= 0, h^3-Laplacian of p <= 12*(...), p * (difference) = 0. Both are homogeneous
of degree one in (b, w), and both give a passive film, in the discrete equations too.

The mesh is graded: half of its circumferential lines are spread evenly in theta, half in Sommerfeld's
angle, d(psi)/d(theta) = sqrt(1 - eps^2)/h, which resolves the thin film at any eps; the axial lines are
the points of z = sin(pi/2 * eta), which crowd at the open end. The scheme is of second order on both.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solveh_banded

from linkages.kernel import Array

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
    """Pressure on a mesh, and what follows from it."""

    mesh: Mesh
    p: Array  # shape (around, along), >= 0
    f_n: float
    f_t: float
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


def _banded(forward: Array, backward: Array, cube: Array, mesh: Mesh) -> Array:
    """Lower band of -div(h^3 grad) on successive theta lines, given their conductances and `cube`.

    The pressure is zero on the lines beyond the first and the last; a zero conductance is a mirror.
    """
    along = mesh.z.size
    axial = cube[:, None] * mesh.along_z
    band = np.zeros((along + 1, axial.size))
    diagonal = (forward + backward)[:, None] * mesh.height + axial
    diagonal[:, 1:] += axial[:, :-1]
    band[0] = diagonal.ravel()
    band[along] = (-forward[:, None] * mesh.height).ravel()
    band[along, -along:] = 0.0
    axial[:, -1] = 0.0  # the open end is in the diagonal only
    band[1] = -axial.ravel()
    return band


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
    """
    half, k = mesh.theta.size // 2, mesh.along_theta
    if parity > 0:
        lines, cube = slice(0, half + 1), mesh.cube[: half + 1].copy()
        cube[[0, -1]] *= 0.5
        band = _banded(np.append(k[:half], 0.0), np.append(0.0, k[:half]), cube, mesh)
    else:
        lines = slice(1, half)
        band = _banded(k[lines], k[: half - 1], mesh.cube[lines], mesh)
    p = np.zeros((mesh.theta.size, mesh.z.size))
    p[lines] = solveh_banded(band, load.ravel(), lower=True, check_finite=False).reshape(load.shape)
    p[half + 1 :] = parity * p[half - 1 : 0 : -1]
    return p


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
    Without a groove the circle is cut where the film opens fastest, which is always cavitated: there the
    complementarity condition holds with p = 0. Primal-dual active set: Hintermueller, Ito and Kunisch 2003.
    """
    around, along = mesh.theta.size, mesh.z.size
    cut = 0
    if not ambient_at_widest:
        cut = int(np.argmax((deps * mesh.rate_b + half_ew * mesh.rate_w) / mesh.width))
    index = (cut + 1 + np.arange(around - 1)) % around
    band = _banded(mesh.along_theta[index], mesh.along_theta[index - 1], mesh.cube[index], mesh)
    load = -((deps * mesh.rate_b + half_ew * mesh.rate_w)[index, None] * mesh.height)
    wet = np.ones((around - 1, along), dtype=bool) if guess is None else guess[index] > 0.0
    p = np.zeros((around, along))
    for _ in range(100):
        inner = _solve_wet(band, load, wet)
        excess = _multiply(band, inner) - load
        following = np.where(wet, inner > 0.0, excess < 0.0)
        if np.array_equal(following, wet):
            p[index] = np.where(wet, inner, 0.0)
            return _integrate(mesh, p)
        wet = following
    raise ArithmeticError(f"film at eps = {mesh.eps!r}: the active set did not settle in 100 steps")


def _solve_wet(band: Array, load: Array, wet: NDArray[np.bool_]) -> Array:
    """Solve on the wet cells, with p = 0 on the others."""
    inner = np.zeros_like(load)
    rows = np.flatnonzero(wet.any(axis=1))
    if rows.size == 0:
        return inner
    along = load.shape[1]
    part = slice(rows[0], rows[-1] + 1)
    on = wet[part].ravel()
    small = band[:, rows[0] * along : (rows[-1] + 1) * along].copy()
    small[0, ~on] = 1.0
    for step in (1, along):
        small[step, :-step] *= on[:-step] & on[step:]
        small[step, -step:] = 0.0
    right = np.where(on, load[part].ravel(), 0.0)
    inner[part] = solveh_banded(small, right, lower=True, check_finite=False).reshape(-1, along)
    return inner


def _multiply(band: Array, p: Array) -> Array:
    """Product of the banded matrix with a pressure of shape (lines, along)."""
    flat, along = p.ravel(), p.shape[1]
    out = band[0] * flat
    for step in (1, along):
        out[step:] += band[step, :-step] * flat[:-step]
        out[:-step] += band[step, :-step] * flat[step:]
    return out.reshape(p.shape)


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
    return Pressure(mesh, positive, float(mesh.force_n @ mean), float(mesh.force_t @ mean), extent)
