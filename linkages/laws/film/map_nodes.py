"""Film of a bearing at one place of the journal: values of a map's nodes, without grooves and with them.

Without groove the negative pressure of the whole film is dropped, or Reynolds' condition holds. The ring is closed:
only the open ends hold the pressure at ambient. Under Reynolds' condition the middle of a long bearing (from L/D of
about 2 on) fills all around, and with L/D its force tends to the force of the full film without cavitation, of which
the open ends shift the pressure and nothing else.

With grooves and mass conservation the film content is the one of the steady whirl at this place (deps = 0), stationary
seen from the eccentricity. It gives the sources of the pressure: the wedge in the full film, none in the cavity, and
where the cavity ends the volume that the arriving film lacks. The pressure obeys Reynolds' condition with these sources
and the squeeze motion. A content that followed every motion at once would make the force fall with the velocity in some
states: a journal would jump.

In a steady rotation (y = +-pi/2) and small motions about it the force is the one of the film whose content follows the
motion: stiffness and damping are those of `linkages.bearing`. Its weight is sin(y)^8, and less at places where its
force in the steady rotation differs from the one above, as with a groove at the thinnest gap.

A part of the cavity counts as full, to regularise states that are not quasi-static:

- `REST`: otherwise a film with its groove at the thinnest gap does not resist a motion around the bearing. A real film
  is in this state for a part of a turn only, and was fed before.
- CENTRE^2/(eps^2 + CENTRE^2): the eccentricity has no direction at the centre.
- All of it in a film that opens (y near pi), where the whirl changes its sense.

The content has a jump where the whirl changes its sense. A pure squeeze motion has no whirl: it takes the mean of the
contents of both senses, so that a mirrored film has the same friction.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from linkages.base.kernel import Array
from linkages.base.kernel.by_reference import packed
from linkages.laws.film.closed_form import half_film_long
from linkages.laws.film.map_table import CHANNELS
from linkages.laws.film.surface.balance import Balance, Thickness, make_balance
from linkages.laws.film.surface.cavity import solve
from linkages.laws.film.surface.grooves import Groove
from linkages.laws.film.surface.surface_film import integrate_film, outflows
from linkages.laws.film.surface.surface_mesh import surface_mesh

#: Cells around the film and along half its length.
CELLS = (80, 6)
#: The same of a film without groove, by rule of cavitation: its force and flow are extrapolated from this mesh and one
#: with half as many cells along, where the errors are larger.
PLAIN_CELLS = {"guembel": (320, 28), "reynolds": (216, 16)}
#: Eccentricity ratio below which the film content fades towards the content of a full film.
CENTRE = 0.1
#: Least share of the cavity that counts as full for the force.
REST = 0.3
_SOFT = 0.05  # width in cos^2(y) of the transition to a film that opens
_LEAN = 0.05  # width in sin(y) of the transition between the contents of the two senses of whirl
_NEAR = 0.2  # deps over ew/2 of the differences about a steady rotation
_CENTRED = 1e-9  # eccentricity ratio below which the wedge is that of the centre
_NARROW = 8  # power of sin(y): weight of these differences in other motions

_TURN = 2.0 * math.pi


def has_angle(grooves: Sequence[Groove]) -> bool:
    """Whether the film depends on the angle of the grooves: not where all of them are circumferential."""
    return any(groove.extent < _TURN * (1.0 - 1e-12) or groove.hole for groove in grooves)


def is_symmetric(grooves: Sequence[Groove]) -> bool:
    """Whether the grooves are their own mirror image about the angle 0."""

    def images(sign: float) -> list[tuple[float, ...]]:
        return sorted((round(sign * g.angle % _TURN, 9) % round(_TURN, 9), *g[1:]) for g in grooves)

    return images(1.0) == images(-1.0)


class _Place:
    """The film at one place of the journal, seen from the eccentricity, which points along x."""

    def __init__(
        self, eps: float, slenderness: float, grooves: Sequence[Groove], alpha: float, cells: tuple[int, int]
    ) -> None:
        self.eps, self.slenderness = eps, slenderness
        self.grooves = tuple(groove._replace(angle=groove.angle - alpha) for groove in grooves)
        self.mesh = surface_mesh(slenderness, self.grooves, (eps, 0.0), *cells)
        self.closing = self.balance(velocity=(1.0, 0.0), speed=0.0)
        self.whirl = self.balance(velocity=(0.0, -1.0), speed=0.0).gain  # outflow of a full film, for ew/2 = 1
        if grooves and eps > _CENTRED:  # as the film content is carried
            self.whirl = self.outflow(self.balance((0.0, 0.0), 1.0 / eps), np.ones_like(self.whirl))

    def balance(self, velocity: tuple[float, float], speed: float) -> Balance:
        return make_balance(self.mesh, Thickness(self.eps, 0.0), velocity, speed)

    def steady(self, sign: float) -> tuple[Array, float]:
        """Volume that leaves the cells in the steady whirl with ew/2 = 1 or -1 without pressure; extent of its film."""
        balance = self.balance((0.0, 0.0), sign / self.eps)
        z = solve(balance)
        return self.outflow(balance, 1.0 + np.minimum(z, 0.0)), self.integrals(z, balance)[2]

    def near_steady(self, half_ew: float, own: Array) -> tuple[float, Array]:
        """Expand the force of a film whose content follows the motion, about a steady rotation with ew/2 = 1 or -1.

        Return a weight, 1 where its force in this rotation is the one that the map has otherwise, `own` (2,), down to 0
        where they have little in common; and the coefficients of the powers of deps, (3, 2).
        """
        motions = [self.balance((deps, 0.0), half_ew / self.eps) for deps in (-_NEAR, 0.0, _NEAR)]
        before, steady, after = (self.integrals(solve(balance))[:2] for balance in motions)
        weight = max(1.0 - math.hypot(*(steady - own)) / math.hypot(*own), 0.0) ** 4
        bend = (before - 2.0 * steady + after) / (2.0 * _NEAR**2)
        return weight, np.array([steady, (after - before) / (2.0 * _NEAR), bend])

    def outflow(self, balance: Balance, content: Array) -> Array:
        """Volume that leaves the cells by transport of the content."""
        return np.where(self.mesh.groove < 0, outflows(balance, 0.0, np.zeros_like(content), content)[0], 0.0)

    def pressure(
        self, deps: float, half_ew: float, rule: str = "reynolds", guess: Array | None = None, *,
        share: float = 0.0, whirl: Array | float = 0.0,
    ) -> Array:  # fmt: skip
        """Solve where a share of the wedge has the cavity of the steady whirl, the rest none."""
        loss = deps * self.closing.gain + share * abs(half_ew) * whirl + (1.0 - share) * half_ew * self.whirl
        return solve(self.closing._replace(gain=loss), rule=rule, guess=guess)

    def integrals(self, z: Array, balance: Balance | None = None) -> Array:
        """Quantities of a node in a solution: force on the journal (2) and integral of content/h over L/R, flow."""
        fx, fy, _, _, shear, flow = integrate_film(*self.mesh.geometry, packed(balance or self.closing), 0.0, z)
        return np.array([*(0.5 * part / self.slenderness for part in (fx, fy, shear)), flow])

    def fed(self) -> Array:
        """Quantities of the film of a journal at rest, fed by the grooves: force over R L, flow over c^3/mu."""
        known = self.mesh.pressures(np.array([groove.pressure for groove in self.grooves]))
        return self.integrals(solve(self.closing._replace(gain=np.zeros_like(known), known=known), rule="guembel"))

    def pressed(self, p: Array) -> float:
        """Axial mean of the integral of dtheta/h over the film that carries pressure; edges lie between two centres."""
        following, inverse = np.roll(p, -1, axis=0), self.closing.inverse
        total, span = np.maximum(p, 0.0) + np.maximum(following, 0.0), np.abs(p) + np.abs(following)
        part = np.divide(total, span, out=np.zeros_like(p), where=span > 0.0)
        inside = np.sum(part * 0.5 * (inverse + np.roll(inverse, -1, axis=0)), axis=0)
        return float(inside @ self.mesh.height) / (self.slenderness if self.mesh.half else 2.0 * self.slenderness)


def _unit(eps: float, deps: float, half_ew: float) -> float:
    """Force |f_long| that counts as the unit of a node."""
    return math.hypot(*half_film_long(eps, deps, 2.0 * half_ew, 0.0)[:2])


def solve_plain(eps: float, slenderness: float, cavitation: str, angles: Array) -> Array:
    """Solve the film without groove at one eps for directions y = ``angles`` (ny,) of the motion, in small steps.

    Return the quantities of `linkages.laws.film.map_table`, (ny, 4), by the rule guembel or reynolds. Force and flow
    are extrapolated; the extent, which moves from cell to cell, is taken from the finer mesh.
    """
    places, whole = _two_places(eps, slenderness, (), PLAIN_CELLS[cavitation]), cavitation == "guembel"
    parts = [[place.pressure(*motion, "guembel") for motion in ((1.0, 0.0), (0.0, 1.0))] for place in places if whole]
    q, out, guess = 1.0 - eps * eps, np.empty((len(angles), CHANNELS)), None
    for row, y in zip(out, angles, strict=True):
        deps, half_ew = math.cos(y), math.sin(y) / q**0.25
        if whole:
            films = [deps * closing + half_ew * turning for closing, turning in parts]
        else:
            guess = places[0].pressure(deps, half_ew, guess=guess)
            p = places[1].pressure(deps, half_ew, guess=np.repeat(guess, 2, axis=1))
            films = [guess, np.maximum(p, 0.0)]
        row[:] = _extrapolated(places, films)
        row[:2] /= _unit(eps, deps, half_ew)
        row[2] = places[1].pressed(films[1]) * math.sqrt(q)
    return out


def _two_places(eps: float, slenderness: float, grooves: Sequence[Groove], cells: tuple[int, int]) -> list[_Place]:
    """Return the place on a mesh with half as many cells along, and on the mesh itself."""
    around, along = cells
    return [_Place(eps, slenderness, grooves, 0.0, (around, count)) for count in (along // 2, along)]


def _extrapolated(places: Sequence[_Place], films: Sequence[Array]) -> Array:
    """Extrapolate the integrals on two meshes to cells of no length: their error along is of the second order."""
    coarse, fine = (place.integrals(p) for place, p in zip(places, films, strict=True))
    return fine + (fine - coarse) / 3.0


def finite_force(
    eps: float, slenderness: float, deps: float, half_ew: float, cavitation: str = "guembel",
    grooves: Sequence[Groove] = (), cells: tuple[int, int] = PLAIN_CELLS["guembel"],
) -> tuple[float, float]:  # fmt: skip
    """Force of the finite film in one motion, in units of mu*L*R^3/c^2; the motion as in `linkages.laws.film`.

    By the rule guembel or reynolds; grooves have their angles from the eccentricity. Of the cells around and along half
    the length the latter are an even number: the force is extrapolated from this mesh and one half as fine along.
    """
    places = _two_places(eps, slenderness, grooves, cells)
    found = _extrapolated(places, [place.pressure(deps, half_ew, cavitation) for place in places])
    return float(found[0]), float(found[1])


def solve_grooved(
    eps: float, slenderness: float, grooves: Sequence[Groove], alpha: float, cavitation: str, angles: Array,
    cells: tuple[int, int] = CELLS,
) -> Array:  # fmt: skip
    """Solve the film at one place of the journal for directions y = ``angles`` of its motion, and its static part.

    Return the quantities of `linkages.laws.film.map_table`, (ny or ny + 1, 4): the last line is the static part if a
    groove has a pressure. The eccentricity has the angle alpha [rad]; the rule is reynolds or mass-conserving.
    """
    place = _Place(eps, slenderness, grooves, alpha, cells)
    root_q = math.sqrt(1.0 - eps * eps)
    full = place.integrals(np.zeros_like(place.whirl))[2]
    steady = {sign: (sign * place.whirl, full) for sign in (1.0, -1.0)}
    near, seen = dict[float, tuple[float, Array]](), 0.0  # share of the cavity that counts
    out, p = np.empty((len(angles), CHANNELS)), None
    if cavitation == "mass-conserving" and eps > 0.0:
        seen = eps * eps / (eps * eps + CENTRE**2)
        steady = {sign: place.steady(sign) for sign in steady}
        for sign, (whirl, _) in steady.items():
            p = place.pressure(0.0, sign, guess=p, share=(1.0 - REST) * seen, whirl=whirl)
            near[sign] = place.near_steady(sign, place.integrals(p)[:2])
    for row, y in zip(out, angles, strict=True):
        deps, half_ew = math.cos(y), math.sin(y) / math.sqrt(root_q)
        opening = max(-math.cos(y), 0.0) ** 2
        share = seen * (1.0 - opening / math.sqrt(opening + _SOFT))
        whirl, _ = steady[math.copysign(1.0, half_ew)]
        lean = math.tanh(math.sin(y) / _LEAN)
        extent = 0.5 * ((1.0 + lean) * steady[1.0][1] + (1.0 - lean) * steady[-1.0][1])
        p = place.pressure(deps, half_ew, guess=p, share=(1.0 - REST) * share, whirl=whirl)
        row[:] = place.integrals(p)
        if seen > 0.0:
            weight, coefficients = near[math.copysign(1.0, half_ew)]
            weight *= seen * math.sin(y) ** _NARROW
            if weight > 0.0:
                powers = np.array([1.0, deps / abs(half_ew), (deps / half_ew) ** 2])
                row[:2] += weight * (abs(half_ew) * powers @ coefficients - row[:2])
        if share > 0.0:  # no cavity is closed for the flow: what it takes up does not leave at the ends
            p = place.pressure(deps, half_ew, guess=p, share=share, whirl=whirl)
            row[3] = place.integrals(p)[3]
        row[:2] /= _unit(eps, deps, half_ew)
        row[2] = (share * extent + (1.0 - share) * full) * root_q
    return np.vstack([out, place.fed()]) if any(groove.pressure for groove in grooves) else out
