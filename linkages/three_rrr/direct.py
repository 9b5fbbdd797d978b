"""Direct kinematics: every assembly of the robot at given crank angles.

With complex numbers for plane vectors, z = exp(i theta), w_r = z c_r - B_r, the loops are |P + w_r|^2 =
l_r^2. The differences of loops 2, 3 and loop 1 are linear in P and its conjugate: P = Q/D. Put into loop 1
this leaves

    F(theta) = |Q|^2 + 2 Re(Q conj(w_1 D)) + (|w_1|^2 - l_1^2) |D|^2 = 0,

a real trigonometric polynomial of degree three: Q has the powers z^-1 .. z^2 and D the powers z^-1 .. z^1.
So there are at most six assemblies. The paper's octic, eq. (2), in t = tan(theta/2) is this polynomial
times (1 + t^2).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

import numpy as np
from numpy.polynomial.polynomial import polyder, polydiv, polymul, polypow
from numpy.typing import NDArray

from linkages.base.arguments import Count, validated
from linkages.base.arrays import Array
from linkages.three_rrr.geometry import Geometry
from linkages.three_rrr.kinematics import arms, determinants, loop_errors, newton, unit

Complex = NDArray[np.complex128]

_CLOSED = 1e-12  # largest loop error of an assembly, times the robot's size
_NEAR_CIRCLE = 1e-3  # roots this close to |z| = 1 are tried
_SAME = 1e-7  # assemblies closer than this (rad, and size) are one
_FLAT = 1e-5  # conditioning of the linear equations below which P is sought along a line
_BATCH = 4096


@dataclass(frozen=True)
class Assemblies:
    """All assemblies at one set of crank angles; made by `assemblies`.

    Attributes
    ----------
    x : (n, 3) array
        Platform positions (theta, x, y) with theta in (-pi, pi], by falling theta [rad, m].
    error : float
        Largest loop error [m].
    roots : int
        Number of distinct real roots of F, counted exactly (Sturm, in rational arithmetic).
    certified : bool
        Whether the exact count equals the number of distinct theta found. False only within round-off of a fold, or
        where two assemblies share theta.
    """

    x: Array
    error: float
    roots: int
    certified: bool

    def __len__(self) -> int:
        return len(self.x)


def polynomial(geometry: Geometry, phi: Array) -> Complex:
    """Coefficients (N, 7) of z^-3 .. z^3 in F, scaled to a largest magnitude of one; F is real on |z| = 1.

    They are the Fourier transform of its values at nine angles, whose powers -4 and 4 are round-off.
    """
    plane = np.array([1.0, 1.0j]) / geometry.size
    z = np.exp(2j * np.pi / 9.0 * np.arange(9))
    b = (geometry.base + geometry.crank[:, None] * unit(phi)) @ plane
    w = z[:, None] * (geometry.platform @ plane) - b[:, None]
    gap = np.abs(w) ** 2 - (geometry.coupler / geometry.size) ** 2
    (u2, u3), (k2, k3) = (np.moveaxis(v[..., 1:] - v[..., :1], -1, 0) for v in (w, gap))
    q = k3 * u2 - k2 * u3
    d = 2j * np.imag(np.conj(u2) * u3)
    f = np.abs(q) ** 2 + 2.0 * np.real(q * np.conj(w[..., 0] * d)) + gap[..., 0] * np.abs(d) ** 2
    coefficients = np.fft.fftshift(np.fft.fft(f), axes=1)[:, 1:8]
    return coefficients / np.max(np.abs(coefficients), axis=1, keepdims=True)


def candidates(geometry: Geometry, phi: Array) -> Array:
    """Polished platform positions (N, 12, 3), NaN where a root of F is not an assembly."""
    f = polynomial(geometry, phi)
    lead = np.where(np.abs(f[:, 6]) < 1e-15, 1e-15, f[:, 6])
    companion = np.zeros((len(f), 6, 6), dtype=complex)
    companion[:, np.arange(1, 6), np.arange(5)] = 1.0
    companion[:, :, 5] = -f[:, :6] / lead[:, None]
    z = np.linalg.eigvals(companion)
    theta = np.tile(np.where(np.abs(np.abs(z) - 1.0) < _NEAR_CIRCLE, np.angle(z), np.nan), 2)
    row, column = np.nonzero(np.isfinite(theta))
    guess = _positions(geometry, phi[row], theta[row, column], column >= 6)
    tried = np.isfinite(guess[:, 1])
    row, column, guess = row[tried], column[tried], guess[tried]
    x, error = newton(geometry, phi[row], guess, iterations=40)
    good = (error <= _CLOSED * geometry.size) & (np.abs(_wrap(x[:, 0] - guess[:, 0])) < 30.0 * _NEAR_CIRCLE)
    x[:, 0] = _wrap(x[:, 0])
    result = np.full((*theta.shape, 3), np.nan)
    result[row[good], column[good]] = x[good]
    return result


def _positions(geometry: Geometry, phi: Array, theta: Array, second: NDArray[np.bool_]) -> Array:
    """Platform positions for known theta: the radical centre of the three circles.

    Where the circles' centres are nearly in line the radical centre is badly determined; then P is the
    intersection of the first circle with the common chord: two points, of which `second` picks one. NaN for
    a second point elsewhere.
    """
    centre = geometry.base + geometry.crank[:, None] * unit(phi) - arms(geometry, theta)
    u = 2.0 * (centre[:, 1:] - centre[:, :1])
    square = np.sum(centre**2, axis=-1) - geometry.coupler**2
    k = square[:, 1:] - square[:, :1]
    left, values, right = np.linalg.svd(u)
    rhs = np.einsum("nji,nj->ni", left, k)
    flat = values[:, 1] < _FLAT * geometry.size
    safe = np.where(values > 1e-300, values, 1e-300)
    chord = right[:, 1]
    point = right[:, 0] * (rhs[:, 0] / safe[:, 0])[:, None]
    regular = point + chord * (rhs[:, 1] / safe[:, 1])[:, None]
    gap = point - centre[:, 0]
    middle = np.sum(gap * chord, axis=1)
    inside = np.maximum(middle**2 - np.sum(gap**2, axis=1) + geometry.coupler[0] ** 2, 0.0)
    along = -middle + np.where(second, -1.0, 1.0) * np.sqrt(inside)
    position = np.where(flat[:, None], point + chord * along[:, None], regular)
    position[second & ~flat] = np.nan
    return np.column_stack([theta, position])


def distinct(x: Array, size: float) -> NDArray[np.bool_]:
    """Which (N, n) of the platform positions (N, n, 3), see `candidates`, are assemblies not met before."""
    new = np.isfinite(x[..., 0])
    for k in range(1, x.shape[1]):
        gap = x[:, :k] - x[:, k : k + 1]
        same = np.abs(_wrap(gap[..., 0])) < _SAME
        same &= np.max(np.abs(gap[..., 1:]), axis=-1) < _SAME * size
        new[:, k] &= ~np.any(same & new[:, :k], axis=1)
    return new


def assemblies(geometry: Geometry, phi: Array) -> Assemblies:
    """Find all assemblies at one set of crank angles (3,) [rad]."""
    phi = np.asarray(phi, dtype=float)[None]
    found = candidates(geometry, phi)
    x = found[distinct(found, geometry.size)]
    x = x[np.argsort(-x[:, 0], kind="stable")]
    error = float(np.max(np.abs(loop_errors(geometry, np.repeat(phi, len(x), 0), x)), initial=0.0))
    roots = count_roots(polynomial(geometry, phi)[0])
    angles = int(np.count_nonzero(distinct(x[None] * [1.0, 0.0, 0.0], geometry.size)))
    return Assemblies(x, error, roots, roots == angles)


def count(geometry: Geometry, phi: Array) -> NDArray[np.int64]:
    """Return the number of assemblies (N,) at each row of crank angles (N, 3), vectorised."""
    return np.count_nonzero(distinct(candidates(geometry, phi), geometry.size), axis=1)


def _wrap(angle: Array) -> Array:
    """Angles in (-pi, pi]."""
    return np.pi - np.mod(np.pi - angle, 2.0 * np.pi)


def count_roots(f: Complex) -> int:
    """Count the distinct real roots theta in one turn of the polynomial with coefficients f (7,), exactly.

    F is written in t = tan((theta - theta_0)/2), with theta_0 such that no root is near t = infinity, and
    Sturm's sequence is evaluated in rational arithmetic: the count is exact for the given coefficients.
    """
    power = np.arange(-3, 4)
    tries = np.linspace(0.0, 2.0 * np.pi, 36, endpoint=False)
    values = np.real(np.exp(1j * np.outer(tries, power)) @ f)
    shifted = f * np.exp(1j * power * (tries[np.argmax(np.abs(values))] - np.pi))
    coefficients = np.zeros(7)
    for k, value in zip(power, shifted, strict=True):
        term = polymul(polypow([1.0, 1.0j], 3 + k), polypow([1.0, -1.0j], 3 - k))
        coefficients += np.real(value * term)
    return _sturm(np.array([Fraction(c) for c in coefficients.tolist()]))


def _sturm(p: NDArray[np.object_]) -> int:
    """Distinct real roots of a polynomial, coefficients by rising power."""
    chain = [p, polyder(p)]
    while len(chain[-1]) > 1:
        rest = polydiv(chain[-2], chain[-1])[1]
        if not np.any(rest):
            break
        chain.append(-rest / np.max(np.abs(rest)))
    above = [q[-1] > 0 for q in chain]
    below = [(q[-1] > 0) == (len(q) % 2 == 1) for q in chain]
    return sum(a != b for a, b in pairwise(below)) - sum(a != b for a, b in pairwise(above))


@dataclass(frozen=True)
class DriveMap:
    """Values over phi_1 (columns) and phi_2 (rows) at one phi_3; made by `drive_map`.

    Attributes
    ----------
    angles : (n,) array
        Grid of both angles [rad].
    phi3 : float
        Angle of the third crank [rad].
    count : (n, n) array of int
        Number of assemblies.
    fold : (n, n) array
        Least |det Jx| over the assemblies (dimensionless, see `linkages.three_rrr.kinematics.determinants`): zero at a
        type-2 singularity; NaN without an assembly.
    reach : (n, n) array
        Least |sine| between crank and coupler over assemblies and legs: zero at a type-1 singularity.
    """

    angles: Array
    phi3: float
    count: NDArray[np.int64]
    fold: Array
    reach: Array


@validated
def drive_map(
    geometry: Geometry, phi3: float, points: Count = 121, progress: Callable[[float], None] | None = None
) -> DriveMap:
    """Solve the direct kinematics on a grid of `points` by `points` drive angles over a full turn of each."""
    angles = np.linspace(-np.pi, np.pi, points)
    first, second = np.meshgrid(angles, angles)
    phi = np.column_stack([first.ravel(), second.ravel(), np.full(first.size, phi3)])
    number = np.zeros(len(phi), dtype=np.int64)
    fold, reach = np.full((2, len(phi)), np.nan)
    for start in range(0, len(phi), _BATCH):
        part = slice(start, start + _BATCH)
        x = candidates(geometry, phi[part])
        found = np.isfinite(x[..., 0])
        where, _ = np.nonzero(found)
        two, one = determinants(geometry, phi[part][where], x[found])
        np.fmin.at(fold[part], where, np.abs(two))
        np.fmin.at(reach[part], where, np.min(np.abs(one), axis=1))
        number[part] = np.count_nonzero(distinct(x, geometry.size), axis=1)
        if progress is not None:
            progress(min(start + _BATCH, len(phi)) / len(phi))
    shape = first.shape
    return DriveMap(angles, phi3, number.reshape(shape), fold.reshape(shape), reach.reshape(shape))
