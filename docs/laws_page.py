"""The registries of laws as tables: law -> formula -> valid for -> source; and two computed tables."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from linkages.laws.contact.contact_laws import CONTACTS
from linkages.laws.declared import users
from linkages.laws.film.closed_form import half_film_long, short_bearing
from linkages.laws.film.films import FILMS
from linkages.laws.film.map_nodes import finite_force
from linkages.laws.friction import FRICTIONS


class Law(NamedTuple):
    """Row of a table: formula, valid range and source of a law."""

    formula: str
    valid: str
    source: str


#: Films in closed form that are compared with the finite film.
_CLOSED = {"long": half_film_long, "short": short_bearing}
#: Motions of the journal for which they are compared: name -> (deps, ew/2).
MOTIONS = {"rotation": (0.0, 1.0), "approach": (1.0, 0.0), "separation": (-1.0, 0.0)}
#: L/D, by film, and eccentricity ratios of the figure; the tables have every second one.
SLENDERNESSES = {"long": (0.5, 1.0, 4.0 / 3.0, 2.0, 4.0, 8.0), "short": (0.25, 0.5, 1.0)}
RATIOS = (0.05, 0.3, 0.5, 0.7, 0.9, 0.95)

_FINITE = {
    "finite, guembel": Law(
        "2D Reynolds equation on the whole film, max(p, 0)",
        "any L/D, eps <= 0.999",
        "Guembel's half-Sommerfeld condition",
    ),
    "finite, reynolds": Law(
        "2D Reynolds equation with p >= 0 as complementarity",
        "any L/D, eps <= 0.999",
        "Swift-Stieber condition; Butenschoen 1976",
    ),
}
_MIXED = {
    "blend": Law(
        "F_L + clip((abs(e) - c)/E_0, 0, 1) (F_D - F_L), film at eps <= eps_max",
        "numerical transition; E_0 is not physical",
        "Chen 2025 eq. (15), made continuous",
    ),
    "greenwood-tripp": Law(
        "p = 16 sqrt(2) pi/15 (n beta sigma)^2 sqrt(sigma/beta) E' F_5/2(h/sigma), integrated over the gap",
        "Gaussian summits, h > 0",
        "Greenwood and Tripp, Proc. IMechE 185, 1970",
    ),
}
_VISCOSITY = {
    "walther": Law("log10 log10(nu + 0.7) = A - B log10 T", "nu > 2 mm2/s", "ASTM D341; Walther 1931"),
    "ISO VG grade": Law(
        "walther through nu(40 C) = grade and nu(100 C)", "mineral oil, index 95", "ISO 3448, ASTM D2270"
    ),
}


def markdown() -> str:
    """Tables of all laws, in the order of the registries, as Markdown."""
    parts = [
        "# Force laws",
        "",
        "Reference for users who choose a film, contact, friction or mixed law: formula, valid range and source of"
        " every law, and two computed comparisons. `python docs/make_laws.py` writes this page. [Theory](theory.md)"
        " defines the symbols; [add a force law](extend.md) explains how to add one.",
        "",
    ]
    films = {name: film for name, film in FILMS.items() if film.force is not None}  # the map's rules have rows
    parts += _section("Films", films | _FINITE)
    parts += _closed_form_errors()
    parts += _section("Contact", CONTACTS)
    parts += [
        "E' is the contact modulus, L the length, DR = R_b - R_j, S = pi E' L. A contact never pulls: a negative"
        " force is set to zero. ddelta0 is the approach speed of the contact. The ratio ddelta/ddelta0 is limited to"
        " [-1, 1] unless `clip = false`: in a contact that never separates the damping would otherwise be unbounded.",
        "",
    ]
    parts += _parameters(CONTACTS)
    parts += _restitution()
    parts += _section("Friction", FRICTIONS)
    parts += _parameters(FRICTIONS)
    parts += _section("Between film and contact", _MIXED)
    parts += _section("Viscosity", _VISCOSITY)
    return "\n".join(parts)


def _section(title: str, laws: Mapping[str, Any]) -> list[str]:
    lines = [f"## {title}", "", "| law | formula | valid for | source |", "|---|---|---|---|"]
    for name, law in laws.items():
        chi = getattr(law, "chi", "")
        formula = f"{law.formula}, chi = {chi}" if chi not in ("", "0") else law.formula
        lines.append(f"| {name} | {formula} | {law.valid} | {law.source} |")
    return [*lines, ""]


def _parameters(laws: Mapping[str, Any]) -> list[str]:
    """Return the sources of the parameters' defaults, and their order; the list of keys has everything else."""
    sources: dict[str, list[str]] = {}
    for p, names in users(laws).items():
        sources.setdefault(p.source, []).append(
            f"`{p.name}` of {', '.join(names)}" if len(names) < 3 else f"`{p.name}`"
        )
    above = dict.fromkeys(f" `{p.name}` is above `{p.above}`." for p in users(laws) if p.above)
    said = "; ".join(f"{', '.join(names)} ({source})" for source, names in sources.items())
    return [f"[Parameters](experiment.md#all-keys), and the sources of their defaults: {said}.{''.join(above)}", ""]


def _restitution() -> list[str]:
    """Say which restitution a nominal one gives, for the laws with an hysteresis factor."""
    return [
        "### Effective restitution",
        "",
        "The restitution e' of a free impact under F = F_e(delta) (1 + chi ddelta/ddelta0) satisfies"
        " chi - ln(1 + chi) = -chi e' - ln(1 - chi e'), for every stiffness, mass and speed"
        " (`linkages.laws.contact.material.effective_restitution`).",
        "",
        "![Effective restitution](figures/restitution.png)",
        "",
    ]


def bearing_ratio(film: str, slenderness: float, eps: float, motion: str) -> float:
    """Compute the force of the long or short half film over the finite film's, for a motion in `MOTIONS` (Guembel)."""
    deps, half_ew = MOTIONS[motion]
    f_n, f_t, _ = _CLOSED[film](eps, deps, 2.0 * half_ew, slenderness)
    return math.hypot(f_n, f_t) / math.hypot(*finite_force(eps, slenderness, deps, half_ew))


def _closed_form_errors() -> list[str]:
    """Tables of the error of the long and the short bearing."""
    lines = [
        "### Error of the long and the short film",
        "",
        "The tables give the force of the exact long half film, or of the short film, divided by the force of the "
        "finite film (2D Reynolds equation, Guembel's condition). In rotation and approach the long film errs by at "
        "most 14 % from L/D = 8 on, the short film by at most 16 % up to L/D = 1/4 and eps = 0.7. The long film tends "
        "to the finite one with L/D in rotation only: the half film has p = 0 on two lines half a turn apart, but the "
        "open ends of a long film fix the mean of p, weighted with h^3, at zero. The force on a separating journal is "
        "then much smaller. Columns: motion, eccentricity ratio.",
        "",
        "![Error of the long-bearing assumption](figures/long_bearing_error.png)",
        "",
    ]
    for film, slendernesses in SLENDERNESSES.items():
        columns = [(motion, eps) for motion in MOTIONS for eps in RATIOS[::2]]
        lines.append(f"| {film} film, L/D | " + " | ".join(f"{motion}, {eps}" for motion, eps in columns) + " |")
        lines.append("|---" * (len(columns) + 1) + "|")
        for slenderness in slendernesses:
            values = (bearing_ratio(film, slenderness, eps, motion) for motion, eps in columns)
            lines.append(f"| {slenderness:.4g} | " + " | ".join(f"{value:.3g}" for value in values) + " |")
        lines.append("")
    return lines
