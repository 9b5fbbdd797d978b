"""Rules on the validity of the model of a flexible link in a run."""

from __future__ import annotations

import math

import numpy as np

from linkages.elements.flexible import numerics
from linkages.elements.validity import Observed, Rules, Violation

#: Slope against the frame's axis with a stiffness error of 1 % (half the squared slope) [rad].
SLOPE = math.sqrt(2.0 * 0.01)
#: Compressive force over the pinned beam's Euler load that doubles the deflections [1].
BUCKLING = 0.5
#: Number of axial modes for accurate impact peaks. Errors for a 0.3 m steel rod when its dry joint closes: a third with
#: one mode, 10 % with two, 0.1 % with four (docs/flexible_theory.md, Limits).
AXIAL = 4
#: Smallest ratio of the highest kept bending frequency to the excitation frequency [1].
ABOVE = 10.0

RULES = Rules[Observed]()


@RULES.rule(
    "flexible",
    "the deflection of a link exceeds the validity of its model: its largest slope is",
    "make it stiffer, or give it more `pieces`",
)
def _slope(case: Observed) -> Violation | None:
    largest = np.zeros(len(case.run.time))
    for part in case.bodies:
        eta = np.array([case.run[f"q.{name}"] for name in part.coordinates])
        first, last = part.ends
        slopes = part.slopes(np.linspace(first, last, numerics.VALIDITY_SAMPLES)) @ eta
        largest = np.maximum(largest, np.max(np.abs(slopes), axis=0))
    worst = int(np.argmax(largest))
    value = float(largest[worst])
    text = f"the relative error of the stiffness is half its square, 1 % at {SLOPE:.3g}"
    text += f"; the link has `pieces` = {len(case.bodies)}"
    return Violation(value, float(case.run.time[worst]), text) if value > SLOPE else None


@RULES.rule(
    "flexible",
    "the compressive load of a link nears the Euler buckling load: their ratio is",
    "make it stiffer or shorter",
)
def _strut(case: Observed) -> Violation | None:
    force = case.run[f"{case.name}.compression"]
    worst, elastic = int(np.argmax(force)), case.bodies[0].beam.elastic()
    euler = math.pi**2 * elastic.bending / elastic.length**2
    value = float(force[worst]) / euler
    text = f"half doubles the deflection; the Euler load with pinned ends is {euler:.3g} N"
    return Violation(value, float(case.run.time[worst]), text) if value > BUCKLING else None


@RULES.rule(
    "flexible",
    "impacts on a link need more axial modes, as axial waves determine the peaks: the number is",
    f"set its axial = {AXIAL} or more",
)
def _wave(case: Observed) -> Violation | None:
    count = sum(len(part.modes.names) - part.modes.bending for part in case.bodies)
    if count >= AXIAL or not case.impacts:
        return None
    return Violation(count, min(hit.start for hit in case.impacts), f"{AXIAL} or more")


@RULES.rule(
    "flexible",
    "a contact is shorter than one period of the fastest mode of a link: ratio",
    "keep more modes, axial ones first, until the peaks converge",
)
def _impact(case: Observed) -> Violation | None:
    shortest = min(case.impacts, key=lambda hit: hit.duration, default=None)
    if shortest is None or not shortest.duration > 0.0:
        return None
    highest = max(float(np.max(part.modes.frequencies)) for part in case.bodies) / (2.0 * math.pi)
    value = highest * shortest.duration
    text = f"at least 1; a contact lasts {shortest.duration:.3g} s, the fastest mode has {highest:.3g} Hz"
    return Violation(value, shortest.start, text) if value < 1.0 else None


@RULES.rule(
    "flexible", "the fastest bending mode of a link is close to the drive frequency: ratio", "keep more bending modes"
)
def _drive(case: Observed) -> Violation | None:
    rates = [np.abs(rate) for rate in case.rates]
    bending = [part.modes.frequencies[: part.modes.bending] for part in case.bodies if part.modes.bending]
    if not rates or not bending:
        return None
    fastest = np.max(rates, axis=0)
    worst = int(np.argmax(fastest))
    if not fastest[worst] > 0.0:
        return None
    value = max(float(np.max(frequencies)) for frequencies in bending) / float(fastest[worst])
    return Violation(value, float(case.run.time[worst]), f"{ABOVE:g} or more") if value < ABOVE else None
