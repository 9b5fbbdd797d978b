"""Craig-Bampton modes of a straight uniform beam, and the integrals by which it moves with a floating frame.

The frame's origin lies on the beam, its first axis along it; s is the abscissa from the origin. With modal
coordinates eta a section is at (s + a eta - eta' H eta / 2, b eta) and rotated by b' eta: a(s) and b(s) are the shapes
along and across the beam, H(s) is the integral of b' b'^T from 0 to s, the axial shortening by rotated sections. Thus
the strain is a' eta, the curvature b'' eta, and the stiffness is constant. The beam is Euler-Bernoulli's: no shear, no
rotary inertia.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.polynomial import legendre

from linkages.base.arrays import Array
from linkages.base.errors import InputError
from linkages.mechanics.flexible.beam import Beam
from linkages.mechanics.flexible.modes import dense_modes

_SAME = 1e-9  # relative to the beam's length: closer nodes coincide
_SPARE = 8  # polynomials per interval in addition to two per fixed-interface mode: frequencies converge to 1e-11
_SAMPLES = 400  # samples per interval in the search for a shape's largest value
_NODAL = {1: (0, (0, 3)), 2: (1, (1, 2, 4, 5))}  # component and nodal displacements of `Beam.shapes`, by order


@dataclass(frozen=True, eq=False)
class _Series:
    """Functions on a beam: between neighbouring nodes (n + 1,), Legendre series (n, degree + 1, functions)."""

    nodes: Array
    terms: Array

    def __call__(self, s: Array, derivative: int = 0) -> Array:
        """Evaluate a derivative (len(s), functions); at a node, where it may jump, the following interval's value."""
        piece = np.clip(np.searchsorted(self.nodes, s, side="right") - 1, 0, len(self.nodes) - 2)
        half = 0.5 * np.diff(self.nodes)[piece]
        terms = legendre.legder(self.terms, derivative, axis=1)
        values = legendre.legvander((s - self.nodes[piece]) / half - 1.0, terms.shape[1] - 1)
        return np.einsum("qd,qdm->qm", values, terms[piece]) / half[:, None] ** derivative

    def gauss(self, edges: Array) -> tuple[Array, Array]:
        """Points and weights that integrate products of two of the functions from edge to edge, in their direction."""
        x, weight = legendre.leggauss(self.terms.shape[1])
        half = 0.5 * np.diff(edges)[:, None]
        return (edges[:-1, None] + half * (x + 1.0)).ravel(), (half * weight).ravel()


@dataclass(frozen=True, eq=False)
class ComponentModes:
    """Modes of a beam and the constants of its equations of motion; nf modes, bending ones first.

    Shapes are dimensionless with the largest value 1: coordinates are displacements [m] of the points of largest value.
    The modes are orthogonal in mass and stiffness. The terms of H are zero without stiffening.
    """

    names: tuple[str, ...]  # "bending1", ..., "axial1", ..., each kind by rising frequency
    frequencies: Array  # of each mode alone, sqrt(k / m0), (nf,) [rad/s]
    mass: float  # of the undeformed beam [kg]; then its moments about the origin
    first_moment: float  # [kg m]
    second_moment: float  # [kg m2]
    sa: Array  # integrals of a times the line density, (nf,) [kg]
    sb: Array  # of b [kg]
    ca: Array  # of s a [kg m]
    cb: Array  # of s b [kg m]
    m0: Array  # modal masses, (nf,) [kg]
    k: Array  # modal stiffnesses, (nf,) [N/m]
    g: Array  # integral of b a^T - a b^T, for Coriolis and Euler forces between axial and bending modes, (nf, nf) [kg]
    c: Array  # integral of H, (nf, nf) [kg/m]
    d: Array  # integral of s H, (nf, nf) [kg]
    stiffening: bool
    _axial: _Series = field(repr=False)
    _bending: _Series = field(repr=False)

    @property
    def bending(self) -> int:
        """Number of bending modes, which come first."""
        return int(self._bending.terms.shape[2])

    def shapes(self, s: Array, derivative: int = 0) -> tuple[Array, Array]:
        """Shapes along and across, (n, nf) each, at abscissas s (n,) [m], or their derivatives [1/m^derivative].

        The first derivatives are the strains and section rotations, the second of b the curvatures, per unit
        of each coordinate.
        """
        s = np.asarray(s, dtype=float)
        along, across = self._axial(s, derivative), self._bending(s, derivative)
        return np.hstack([np.zeros_like(across), along]), np.hstack([across, np.zeros_like(along)])

    def moments(self) -> tuple[tuple[Array, Array, Array], tuple[Array, Array, Array], Array, Array]:
        """Split a, b and H over the mass: means, parts linear in s, and integrals of the remainders.

        The parts linear in s multiply the distance from the middle over the radius of gyration. With the remainders of
        a and b, the integrals (nf, nf) are over a a^T + b b^T and over b a^T - a b^T [kg].
        """
        middle = self.first_moment / self.mass
        spread = np.sqrt(self.mass * self.second_moment - self.first_moment**2)
        a0, b0, h0 = self.sa / self.mass, self.sb / self.mass, self.c / self.mass
        a1, b1, h1 = (
            (self.ca - middle * self.sa) / spread,
            (self.cb - middle * self.sb) / spread,
            (self.d - middle * self.c) / spread,
        )
        rest, twist = np.diag(self.m0), self.g.copy()
        for a, b in ((a0, b0), (a1, b1)):
            rest = rest - self.mass * (np.outer(a, a) + np.outer(b, b))
            twist -= self.mass * (np.outer(b, a) - np.outer(a, b))
        return (a0, b0, h0), (a1, b1, h1), rest, twist

    def at(self, s: float) -> tuple[Array, Array, Array, Array]:
        """Return a, b, b' (nf,) and H (nf, nf), zero without stiffening, at an abscissa s [m]; [1, 1, 1/m, 1/m]."""
        a, b = self.shapes(np.array([s]))
        slope = self.shapes(np.array([s]), 1)[1]
        nodes = self._bending.nodes
        inner = nodes[(nodes - s) * nodes < 0.0]
        edges = np.array([0.0, *(inner if s > 0.0 else inner[::-1]), s])
        points, weight = self._bending.gauss(edges)
        turn = self.shapes(points, 1)[1]
        return a[0], b[0], slope[0], float(self.stiffening) * (turn.T * weight) @ turn


def component_modes(
    beam: Beam,
    start: float,
    end: float,
    interfaces: Sequence[float],
    chord: float | None = None,
    bending: int | None = None,
    axial: int | None = None,
    stiffening: bool = True,
) -> ComponentModes:
    """Compute the modes of a beam with joints and loads at some points.

    The space is Craig and Bampton's (1968): the shapes that follow from displacements and, in bending, rotations of the
    interfaces, exact for any static loads there, and the lowest modes with all interfaces clamped. The modes are the
    natural modes within this space for a fixed frame. Cubics with higher polynomials between the nodes replace a fine
    mesh: their frequencies converge exponentially.

    Parameters
    ----------
    beam : Beam
        The whole Euler-Bernoulli beam, from start to end.
    start, end : float
        Abscissas of the ends, start <= 0 <= end [m].
    interfaces : sequence of float
        Abscissas of joints and loads [m]; the origin is always included.
    chord : float, optional
        Abscissa of the point towards which the frame's axis points: b = 0 there and at the origin. Default: the axis is
        the tangent at the origin, b = b' = 0 there.
    bending, axial : int, optional
        Number of modes. Default: the interfaces' modes, plus two clamped-interface modes in bending. Without an
        axial mode the beam is inextensible.
    stiffening : bool
        Whether H acts: the stiffening, or softening, of bending by axial forces.

    Raises
    ------
    InputError
        If a nonzero number of modes is too small for the interfaces, a point is outside the beam, or it has shear.

    Examples
    --------
    >>> from linkages.mechanics.flexible.beam import Beam
    >>> from linkages.mechanics.flexible.component_modes import component_modes
    >>> rod = Beam(length=0.3, axial=1.28e7, bending=68.26667, line_density=0.50368)
    >>> modes = component_modes(rod, 0.0, 0.3, [0.0, 0.3], chord=0.3, bending=4, axial=1)
    >>> modes.names, round(modes.frequencies[0])
    (('bending1', 'bending2', 'bending3', 'bending4', 'axial1'), 1277)
    """
    if np.isfinite(beam.shear) or beam.rotary:
        raise InputError("beam", "shear", "component modes need an Euler-Bernoulli beam; remove shear and rotary")
    length = end - start
    if abs(beam.length - length) > _SAME * length:
        raise InputError("beam", "length", f"is {beam.length:g} m; from start to end it is {length:g} m")
    nodes, held = np.zeros(1), [0.0, *interfaces, *([] if chord is None else [chord])]
    for point in (start, end, *held):
        if not start - _SAME * length <= point <= end + _SAME * length:
            raise InputError("beam", "interfaces", f"{point:g} m lies outside the beam from {start:g} to {end:g} m")
        if np.min(np.abs(nodes - point)) > _SAME * length:
            nodes = np.append(nodes, point)
    nodes = np.sort(nodes)
    places = sorted({_nearest(nodes, point) for point in held})
    origin = _nearest(nodes, 0.0)
    away = 2 * origin + 1 if chord is None else 2 * _nearest(nodes, chord)
    across = _modes_of(beam, nodes, 2, places, {2 * origin, away}, bending, 2)
    along = _modes_of(beam, nodes, 1, places, {origin}, axial, 0)
    return _constants(beam, along, across, stiffening)


def _nearest(nodes: Array, point: float) -> int:
    return int(np.argmin(np.abs(nodes - point)))


def _modes_of(
    beam: Beam, nodes: Array, order: int, places: list[int], removed: set[int], count: int | None, further: int
) -> _Series:
    """Compute the shapes of one kind: axial (order 1: the strain is the first derivative) or bending (order 2)."""
    held = sorted({order * place + turn for place in places for turn in range(order)} - removed)
    least = len(held)
    count = least + further if count is None else count
    if 0 < count < least:
        kind, joints = ("axial", "bending")[order - 1], len(places)
        raise InputError("beam", kind, f"is {count}; {joints} joints and loads need {least} such modes or more, or 0")
    if count == 0:
        return _Series(nodes, np.zeros((len(nodes) - 1, order + 1, 0)))
    basis = _basis(beam, nodes, order, 2 * (count - least) + _SPARE)
    points, weight = basis.gauss(nodes)
    value, strain = basis(points), basis(points, order)
    k = (beam.axial, beam.bending)[order - 1] * (strain.T * weight) @ strain
    m = beam.line_density * (value.T * weight) @ value
    inner = [i for i in range(len(k)) if i not in removed and i not in held]
    space = np.zeros((len(k), count))
    space[held, range(least)] = 1.0
    space[inner, :least] = -np.linalg.solve(k[np.ix_(inner, inner)], k[np.ix_(inner, held)])
    _, clamped = dense_modes(k[None][:, inner][:, :, inner], m[None][:, inner][:, :, inner], count - least)
    space[inner, least:] = clamped[0]
    _, mixed = dense_modes((space.T @ k @ space)[None], (space.T @ m @ space)[None], count)
    return _largest_one(_Series(nodes, basis.terms @ space @ mixed[0]))


def _basis(beam: Beam, nodes: Array, order: int, bubbles: int) -> _Series:
    """Shape functions of the beam element, and between nodes integrals of Legendre polynomials, which vanish there."""
    pieces, nodal = len(nodes) - 1, order * len(nodes)
    component, columns = _NODAL[order]
    terms = np.zeros((pieces, bubbles + 2 * order, nodal + pieces * bubbles))
    ends = 2 * order
    x = legendre.leggauss(ends)[0]
    for piece, length in enumerate(np.diff(nodes)):
        values = replace(beam, length=float(length)).shapes(0.5 * (x + 1.0))[0][:, component, columns]
        terms[piece, :ends, order * piece : order * piece + ends] = np.linalg.solve(
            legendre.legvander(x, ends - 1), values
        )
        inner = legendre.legint(np.eye(bubbles + order)[:, order:], order, lbnd=-1)
        terms[piece, :, nodal + piece * bubbles :][:, :bubbles] = inner
    return _Series(nodes, terms)


def _largest_one(shapes: _Series) -> _Series:
    """Scale shapes to the largest value 1; its first place decides the sign."""
    samples = np.concatenate(
        [np.linspace(*ends, _SAMPLES) for ends in zip(shapes.nodes[:-1], shapes.nodes[1:], strict=True)]
    )
    values = shapes(samples)
    size = np.max(np.abs(values), axis=0)
    first = np.argmax(np.abs(values) > (1.0 - 1e-6) * size, axis=0)
    return _Series(shapes.nodes, shapes.terms / values[first, range(len(size))])


def _constants(beam: Beam, along: _Series, across: _Series, stiffening: bool) -> ComponentModes:
    """Compute the integrals over the beam; for H the order of integration is exchanged, so that only b' is needed."""
    nodes, density = across.nodes, beam.line_density
    nb, na = across.terms.shape[2], along.terms.shape[2]
    s, weight = max(across, along, key=lambda series: series.terms.shape[1]).gauss(nodes)
    a, b = np.hstack([np.zeros((len(s), nb)), along(s)]), np.hstack([across(s), np.zeros((len(s), na))])
    strain, curvature = along(s, 1), across(s, 2)
    turn = np.hstack([across(s, 1), np.zeros((len(s), na))]) * float(stiffening)
    mass = density * weight
    tip = np.where(s > 0.0, nodes[-1], nodes[0])
    outward, leverage = density * weight * (tip - s), 0.5 * density * weight * (tip**2 - s**2)
    mixed = (a.T * mass) @ b
    m0 = mass @ (a**2 + b**2)
    k = np.concatenate([beam.bending * weight @ curvature**2, beam.axial * weight @ strain**2])
    return ComponentModes(
        names=(*(f"bending{i + 1}" for i in range(nb)), *(f"axial{i + 1}" for i in range(na))),
        frequencies=np.sqrt(k / m0),
        mass=float(np.sum(mass)),
        first_moment=float(mass @ s),
        second_moment=float(mass @ s**2),
        sa=mass @ a,
        sb=mass @ b,
        ca=(mass * s) @ a,
        cb=(mass * s) @ b,
        m0=m0,
        k=k,
        g=mixed.T - mixed,
        c=(turn.T * outward) @ turn,
        d=(turn.T * leverage) @ turn,
        stiffening=stiffening,
        _axial=along,
        _bending=across,
    )
