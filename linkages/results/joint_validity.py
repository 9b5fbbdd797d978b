"""Validity of joint laws in a run: rules in `RULES`. `linkages.results.validity` has those for flexible links.

Limits of a law for L/D or the restitution e are in the text ``valid`` of its registry entry.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from linkages.elements.validity import Rules, Violation
from linkages.input.files.raw_model import BearingSize
from linkages.input.model.experiment_tables import ContactTable, JointModel
from linkages.laws import CONTACTS, FILMS
from linkages.laws.contact.material import modulus_of
from linkages.laws.film.map_nodes import CENTRE
from linkages.laws.viscosity import DENSITY_15, density
from linkages.results.films import film_error
from linkages.results.impacts import Impact
from linkages.results.shape import RunWarning
from linkages.results.trajectory import Trajectory
from linkages.results.validity import of_elements, warned
from linkages.system import System
from linkages.system.joints import SystemJoint

#: Taylor vortices between cylinders with a rotating inner one start at rho omega R c/mu = 41.1 sqrt(R/c).
#: Taylor, Phil. Trans. R. Soc. A 223, 1923.
TAYLOR = 41.1
#: Reduced Reynolds number rho omega c^2/mu, of inertia over viscous forces: lubrication theory assumes a small value.
INERTIA = 1.0
#: Half-width of a contact over the journal's radius. Hertz's theory needs a small value (parabolas instead of circles,
#: half-spaces): Johnson, Contact Mechanics, 1985, section 5.3. Assumed: 0.5, a contact of 30 degrees to each side.
HALF_WIDTH = 0.5
#: Largest pressure of a line contact over the yield strength at first yield, below the surface (Tresca).
#: Johnson, Contact Mechanics, 1985, eq. (6.4).
YIELD = 1.67
#: Penetration of a contact over the journal's radius; contact laws need a small value (half-spaces). Assumed: 1 %;
#: circles overlap over 30 degrees to each side if the clearance is 6 % of the radius, and over more otherwise.
DEPTH_OF_JOURNAL = 0.01
#: Penetration of a block's corner over its height. Assumed: the yield strain of steel.
DEPTH_OF_BLOCK = 0.001
#: Share of the cavity of a map that counts as full, above which the threshold of whirl is not the one of the bearing.
#: Measured: up to 0.1 the critical mass is within 8 % of `linkages.bearing`, at 0.34 up to 57 % too large.
FADED = 0.1


class JournalCase(NamedTuple):
    """A journal in its bearing in one run.

    `law` is its record of `linkages.laws.PARAMETERS`, `film_end` the largest eccentricity ratio covered by its film.
    """

    joint: SystemJoint
    bearing: BearingSize
    model: JointModel
    law: Any
    film_end: float
    run: Trajectory
    impacts: Sequence[Impact]


class Touch(NamedTuple):
    """A clearance joint with contact in one run: contacts, and the reference length of their depths."""

    contacts: Sequence[str]
    size: float  # reference length [m]
    most: float  # largest depth over the reference length [1]
    of: str  # name of the reference length
    run: Trajectory


RULES, DEPTH_RULES = Rules[JournalCase](), Rules[Touch]()


def outside(system: System, run: Trajectory, impacts: Sequence[Impact]) -> list[RunWarning]:
    """Warn of laws and elements used outside their validity in a run, one entry for each rule."""
    cases = []
    for k, ((name, _), model) in enumerate(zip(system.tree.contacts, system.models, strict=False)):
        joint = system.joints[name]
        if joint.bearing is not None:
            own = [impact for impact in impacts if impact.joint == name]
            end = float(system.film_limits[k])
            cases.append((name, JournalCase(joint, joint.bearing, model, system.laws[k], end, run, own)))
    found = [*RULES.broken(cases), *DEPTH_RULES.broken(list(_touches(system, run)))]
    return [*warned(found), *of_elements(system, run, impacts)]


def _touches(system: System, run: Trajectory) -> Iterator[tuple[str, Touch]]:
    """Yield the clearance joints that can touch, each with its name."""
    models = {name: model for (name, _), model in zip(system.tree.contacts, system.models, strict=False)}
    for name, model in models.items():
        joint = system.joints[name]
        contacts = [label for owner, label in system.tree.contacts if owner == name]
        if not model.can_touch:
            continue
        if joint.bearing is not None:
            radius = joint.bearing.radius - (model.clearance or 0.0)
            yield name, Touch(contacts, radius, DEPTH_OF_JOURNAL, "the journal's radius", run)
        elif joint.slot is not None:
            yield name, Touch(contacts, joint.slot.height, DEPTH_OF_BLOCK, "the block's height", run)


@RULES.rule(
    "film",
    "the film content of a mass-conserving film has no history: its cavities can be emptier or fuller than "
    "real ones; largest eccentricity ratio:",
    "the map holds for motions that are slow compared with the filling time (linkages bearing); a table "
    "joints.NAME.history gives the film a history (compiled engine)",
)
def film_content(case: JournalCase) -> Violation | None:
    """Find a film whose content a map takes from a steady whirl."""
    model = case.model
    if not (model.has_film and model.feed and model.cavitation == "mass-conserving") or model.has_history:
        return None
    ratio = case.run[f"{case.joint.name}.eccentricity_ratio"]
    faded = CENTRE**2 / (ratio[-1] ** 2 + CENTRE**2)
    limit = "its map is quasi-static"
    if faded > FADED:
        limit += (
            f"; {faded:.0%} of its cavity counts as full at the last ratio, {ratio[-1]:.2g}: whirl can begin too late"
        )
    return Violation(float(np.max(ratio)), None, limit)


def _choice(key: str, value: str) -> Callable[[JournalCase], dict[str, Any]]:
    """Return the change of a joint's key to another value."""
    return lambda case: {f"joints.{case.joint.name}.{key}": value}


def _thicker(case: JournalCase) -> dict[str, Any]:
    """Return the double viscosity; nothing for an oil, whose grade gives it."""
    viscosity = case.model.viscosity
    return {f"joints.{case.joint.name}.viscosity": 2.0 * viscosity} if viscosity else {}


@RULES.rule(
    "film",
    "a film law is used at an L/D outside its validity",
    'film = "finite" is valid for any L/D',
    _choice("film", "finite"),
)
def _slenderness(case: JournalCase) -> Violation | None:
    """Compare L/D with the film's range; the finding states the estimated error of force and eccentricity."""
    if not case.model.has_film:
        return None
    ratio = 0.5 * case.bearing.length / case.bearing.radius
    finding = _beyond_own(case.model.film, FILMS[case.model.film].valid, "L/D", ratio)
    if finding is None:
        return None
    e, force = (np.column_stack([case.run[f"{case.joint.name}.{name}{axis}"] for axis in "xy"]) for name in "ef")
    if case.model.can_touch:  # of a mixed joint only the film's force counts
        alone = case.run[f"{case.joint.name}.load"] == 0.0
        e, force = e[alone], force[alone]
    error = film_error(case.law, ratio, e, force)
    if error is None:
        return finding
    text = (
        f"; estimated, a finite film: force {error.force:.2g} times too large, "
        f"eccentricity ratio {error.eccentricity:.3g} instead of {error.finite:.2g}"
    )
    return finding._replace(limit=finding.limit + text)


def _beyond_own(law: str, valid: str, symbol: str, value: float) -> Violation | None:
    """Compare a number with the limit in a law's text, such as "L/D > 8, half film"."""
    found = re.search(rf"(?<!\w){symbol} ([<>]) (\d+(?:[./]\d+)?)", valid)
    if found is None:
        return None
    sign, limit = found[1], float(Fraction(found[2]))
    inside = value >= limit if sign == ">" else value <= limit
    return None if inside else Violation(value, None, f"{law}: {found[0]}")


@RULES.rule(
    "film",
    "the flow in a film is not laminar, its Reynolds number rho omega R c/mu is too large",
    "real forces and friction are larger: raise the viscosity, or lower the speed or the clearance",
    _thicker,
)
def _turbulence(case: JournalCase) -> Violation | None:
    ratio = case.bearing.radius / (case.model.clearance or math.inf)
    return _reynolds(case, ratio, TAYLOR * math.sqrt(ratio), "laminar below 41.1 sqrt(R/c) =")


@RULES.rule(
    "film",
    "the inertia of a film, which the film laws neglect, is not small: rho omega c^2/mu is",
    "raise the viscosity, or lower the speed or the clearance",
    _thicker,
)
def _inertia(case: JournalCase) -> Violation | None:
    return _reynolds(case, 1.0, INERTIA, "small below")


def _reynolds(case: JournalCase, scale: float, limit: float, words: str) -> Violation | None:
    """Compare rho omega c^2/mu times `scale` with a limit; omega is the journal's relative to the bearing."""
    model = case.model
    if not model.has_film or not model.clearance:
        return None
    links = (case.joint.child, case.joint.parent)
    child, parent = (case.run[f"{link}.omega"] if link != "world" else 0.0 for link in links)
    turning = np.abs(child - parent)
    worst = int(np.argmax(turning))
    rho, origin = DENSITY_15, " assumed"
    if model.oil is not None:
        rho, origin = density(model.oil.temperature, model.oil.density), ""
    value = rho * float(turning[worst]) * model.clearance**2 / float(case.law.viscosity) * scale
    text = f"{words} {limit:.3g}, with a density of {rho:.0f} kg/m3{origin}"
    return Violation(value, float(case.run.time[worst]), text) if value > limit else None


@RULES.rule(
    "film",
    "a finite film exceeds its map and is evaluated at the map's end: eccentricity ratio",
    "lower mixed.film_limit to the end of the map",
)
def _film_end(case: JournalCase) -> Violation | None:
    if not (case.model.has_film and case.model.can_touch and case.model.mixed):
        return None
    ratio, held = case.run[f"{case.joint.name}.eccentricity_ratio"], case.model.mixed.film_limit
    worst = int(np.argmax(ratio))
    reached = min(float(ratio[worst]), held)
    limit = f"its map ends at {case.film_end:.4g}"
    return Violation(reached, float(case.run.time[worst]), limit) if reached > case.film_end else None


@RULES.rule(
    "contact",
    "a contact law is used at a restitution outside its validity",
    "choose a law for this coefficient, such as flores",
    _choice("contact.law", "flores"),
)
def _restitution(case: JournalCase) -> Violation | None:
    contact = case.model.contact
    if contact is None or contact.restitution is None or not case.model.can_touch:
        return None
    return _beyond_own(contact.law, CONTACTS[contact.law].valid, "e", contact.restitution)


@RULES.rule(
    "contact",
    "a contact is too wide for Hertz's law: its half-width over the journal's radius is",
    "choose a law for cylinders that conform, such as johnson",
    _choice("contact.law", "johnson"),
)
def _half_width(case: JournalCase) -> Violation | None:
    contact = case.model.contact
    if contact is None or contact.stiffness is not None or CONTACTS[contact.law].conformal:
        return None
    hardest = _hardest(case, contact)
    if hardest is None:
        return None
    value = hardest[0] / (case.bearing.radius - (case.model.clearance or 0.0))
    return Violation(value, hardest[2], f"small below {HALF_WIDTH}") if value > HALF_WIDTH else None


@RULES.rule(
    "contact",
    "a contact yields: its largest pressure over the yield strength is",
    "the model is elastic: lower the impact speed, or use a harder material or a longer bearing",
)
def _yield(case: JournalCase) -> Violation | None:
    contact = case.model.contact
    if contact is None or contact.yield_strength is None or (hardest := _hardest(case, contact)) is None:
        return None
    value = hardest[1] / contact.yield_strength
    limit = f"elastic below {YIELD}; the pressure is {hardest[1]:.3g} Pa"
    return Violation(value, hardest[2], limit) if value > YIELD else None


def _hardest(case: JournalCase, contact: ContactTable) -> tuple[float, float, float] | None:
    """Compute half-width [m], pressure [Pa] and start [s] of the hardest contact (Hertzian line contact).

    a^2 = 4 F R/(pi E' L) and p = 2 F/(pi a L), 1/R = 1/R_j - 1/R_b: Johnson, Contact Mechanics, 1985, eq. (4.43).
    """
    clearance, young = case.model.clearance or 0.0, contact.youngs_modulus
    journal = case.bearing.radius - clearance
    impact = max(case.impacts, key=lambda impact: impact.peak_normal_force, default=None)
    if impact is None or young is None or not impact.peak_normal_force > 0.0 or not clearance > 0.0:
        return None
    line = impact.peak_normal_force / case.bearing.length
    modulus = modulus_of(dict(contact))
    half = math.sqrt(4.0 * line * case.bearing.radius * journal / clearance / (math.pi * modulus))
    return half, 2.0 * line / (math.pi * half), impact.start


@DEPTH_RULES.rule(
    "contact",
    "a contact is too soft, the penetration is deep: penetration over the size of a body",
    "raise contact.stiffness, or use a stiffer material; or lower the impact speed or the load",
)
def _depth(touch: Touch) -> Violation | None:
    depth = np.max([touch.run[f"{label}.penetration"] for label in touch.contacts], axis=0)
    deepest = int(np.argmax(depth))
    value, limit = float(depth[deepest]) / touch.size, f"small below {touch.most} of {touch.of}"
    return Violation(value, float(touch.run.time[deepest]), limit) if value > touch.most else None
