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

from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from linkages.flexible import Array
from linkages.three_rrr.geometry import Geometry
from linkages.three_rrr.kinematics import arms, loop_errors, newton, unit

Complex = NDArray[np.complex128]

_CLOSED = 1e-12  # largest loop error of an assembly, times the robot's size
_NEAR_CIRCLE = 1e-3  # roots this close to |z| = 1 are tried
_SAME = 1e-7  # assemblies closer than this (rad, and size) are one
_FLAT = 1e-5  # conditioning of the linear equations below which P is sought along a line


@dataclass(frozen=True)
class Assemblies:
    """All assemblies at one set of crank angles.

    Attributes
    ----------
    x : (n, 3) array
        Platform positions (theta, x, y) with theta in (-pi, pi], by falling theta [rad, m].
    error : float
        Largest loop error [m].
    roots : int
        Number of distinct real roots of F, counted exactly (Sturm, in rational arithmetic).
    certified : bool
        Whether the exact count equals the number of distinct theta found. False only within round-off of a
        fold, or where two assemblies share theta.
    """

    x: Array
    error: float
    roots: int
    certified: bool

    def __len__(self) -> int:
        return len(self.x)


def polynomial(geometry: Geometry, phi: Array) -> Complex:
    """Coefficients (N, 7) of z^-3 .. z^3 in F, scaled to a largest magnitude of one; F is real on |z| = 1."""
    c = geometry.platform @ np.array([1.0, 1.0j])
    b = (geometry.base + geometry.crank[:, None] * unit(phi)) @ np.array([1.0, 1.0j])
    c, b = c / geometry.size, b / geometry.size
    length = geometry.coupler / geometry.size
    count = len(phi)

    def laurent(**powers: Complex | Array | float) -> Complex:
        result = np.zeros((count, 7), dtype=complex)
        for name, value in powers.items():
            result[:, {"m1": 2, "p0": 3, "p1": 4}[name]] = value
        return result

    w = [laurent(p1=c[r], p0=-b[:, r]) for r in range(3)]
    square = [
        laurent(
            m1=-np.conj(c[r]) * b[:, r],
            p0=np.abs(c[r]) ** 2 + np.abs(b[:, r]) ** 2,
            p1=-c[r] * np.conj(b[:, r]),
        )
        for r in range(3)
    ]
    u2, u3 = w[1] - w[0], w[2] - w[0]
    k2 = laurent(p0=length[1] ** 2 - length[0] ** 2) - square[1] + square[0]
    k3 = laurent(p0=length[2] ** 2 - length[0] ** 2) - square[2] + square[0]
    q = _times(k2, u3) - _times(k3, u2)
    d = _times(_conjugate(u2), u3) - _times(_conjugate(u3), u2)
    cross = _times(q, _conjugate(_times(w[0], d)))
    rest = _times(square[0] - laurent(p0=length[0] ** 2), _times(d, _conjugate(d)))
    f = _times(q, _conjugate(q)) + cross + _conjugate(cross) + rest
    f = 0.5 * (f + _conjugate(f))
    return f / np.max(np.abs(f), axis=1, keepdims=True)


def _conjugate(a: Complex) -> Complex:
    """Conjugate on |z| = 1: z -> 1/z."""
    return np.conj(a[:, ::-1])


def _times(a: Complex, b: Complex) -> Complex:
    """Product of Laurent polynomials with the powers -3 .. 3; higher powers do not occur."""
    result = np.zeros_like(a)
    for i in range(7):
        for j in range(max(0, 3 - i), min(7, 10 - i)):
            result[:, i + j - 3] += a[:, i] * b[:, j]
    return result


def candidates(geometry: Geometry, phi: Array) -> Array:
    """Polished platform positions (N, 12, 3), NaN where a root of F is not an assembly."""
    f = polynomial(geometry, phi)
    count = len(f)
    lead = np.where(np.abs(f[:, 6]) < 1e-15, 1e-15, f[:, 6])
    companion = np.zeros((count, 6, 6), dtype=complex)
    companion[:, np.arange(1, 6), np.arange(5)] = 1.0
    companion[:, :, 5] = -f[:, :6] / lead[:, None]
    z = np.linalg.eigvals(companion)
    theta = np.where(np.abs(np.abs(z) - 1.0) < _NEAR_CIRCLE, np.angle(z), np.nan)
    starts = np.concatenate([theta, theta], axis=1).ravel()
    which = np.repeat(np.arange(count), 12)
    second = np.tile(np.repeat([False, True], 6), count)
    use = np.flatnonzero(np.isfinite(starts))
    guess = _positions(geometry, phi[which[use]], starts[use], second[use])
    use, guess = use[np.isfinite(guess[:, 1])], guess[np.isfinite(guess[:, 1])]
    result = np.full((count * 12, 3), np.nan)
    if len(use):
        x, error = newton(geometry, phi[which[use]], guess, iterations=40)
        near = np.abs(_wrap(x[:, 0] - guess[:, 0])) < 30.0 * _NEAR_CIRCLE
        good = (error <= _CLOSED * geometry.size) & near
        x[:, 0] = _wrap(x[:, 0])
        result[use[good]] = x[good]
    return result.reshape(count, 12, 3)


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


def _distinct(x: Array, size: float) -> Array:
    """Rows of x (n, 3) without repetitions, by falling theta."""
    kept: list[Array] = []
    for row in x:
        if not any(_close(row, other, size) for other in kept):
            kept.append(row)
    return np.array(sorted(kept, key=lambda row: -row[0])).reshape(-1, 3)


def _close(a: Array, b: Array, size: float) -> bool:
    return bool(abs(_wrap(a[0] - b[0])) < _SAME and np.max(np.abs(a[1:] - b[1:])) < _SAME * size)


def assemblies(geometry: Geometry, phi: Array) -> Assemblies:
    """Find all assemblies at one set of crank angles (3,) [rad]."""
    phi = np.asarray(phi, dtype=float)[None]
    found = candidates(geometry, phi)[0]
    x = _distinct(found[np.isfinite(found[:, 0])], geometry.size)
    error = float(np.max(np.abs(loop_errors(geometry, np.repeat(phi, len(x), 0), x)), initial=0.0))
    roots = count_roots(polynomial(geometry, phi)[0])
    angles: list[float] = []
    for theta in x[:, 0]:
        if all(abs(_wrap(theta - other)) > _SAME for other in angles):
            angles.append(theta)
    return Assemblies(x, error, roots, roots == len(angles))


def count(geometry: Geometry, phi: Array) -> NDArray[np.int64]:
    """Return the number of assemblies (N,) at each row of crank angles (N, 3), vectorised."""
    return count_distinct(candidates(geometry, phi), geometry.size)


def count_distinct(x: Array, size: float) -> NDArray[np.int64]:
    """Return the number of different platform positions (N,) among the rows of `candidates` (N, 12, 3)."""
    result = np.zeros(len(x), dtype=np.int64)
    for k in range(x.shape[1]):
        new = np.isfinite(x[:, k, 0])
        for j in range(k):
            near = np.abs(_wrap(x[:, k, 0] - x[:, j, 0])) < _SAME
            near &= np.max(np.abs(x[:, k, 1:] - x[:, j, 1:]), axis=1) < _SAME * size
            new &= ~near
        result += new
    return result


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
    plus, minus = np.array([1.0, 1.0j]), np.array([1.0, -1.0j])
    coefficients = np.zeros(7)
    for k, value in zip(power, shifted, strict=True):
        term = np.array([1.0 + 0.0j])
        for factor in [plus] * (3 + k) + [minus] * (3 - k):
            term = np.convolve(term, factor)
        coefficients += np.real(value * term)
    return _sturm([Fraction(float(c)) for c in coefficients])


def _sturm(p: list[Fraction]) -> int:
    """Distinct real roots of a polynomial, coefficients by rising power."""
    chain = [_trim(p)]
    chain.append(_trim([i * c for i, c in enumerate(chain[0])][1:]))
    while len(chain[-1]) > 1:
        rest = _remainder(chain[-2], chain[-1])
        if not rest:
            break
        scale = max(abs(c) for c in rest)
        chain.append([-c / scale for c in rest])
    above = [q[-1] > 0 for q in chain]
    below = [(q[-1] > 0) == (len(q) % 2 == 1) for q in chain]
    return sum(a != b for a, b in pairwise(below)) - sum(a != b for a, b in pairwise(above))


def _remainder(a: list[Fraction], b: list[Fraction]) -> list[Fraction]:
    a = list(a)
    while len(a) >= len(b):
        factor = a[-1] / b[-1]
        for i, value in enumerate(b):
            a[len(a) - len(b) + i] -= factor * value
        a.pop()
    return _trim(a)


def _trim(p: list[Fraction]) -> list[Fraction]:
    while p and p[-1] == 0:
        p = p[:-1]
    return p
