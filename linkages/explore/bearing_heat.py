"""Temperature of a bearing's oil from a heat balance: a lumped model, one temperature for the whole film.

The friction power heats the oil that leaves at the ends and flows by conduction into the surroundings:

    P(T) = rho(T) c_p Q(T) (T - T_inlet) + G (T - T_surroundings).

All of the oil has the temperature T at which it leaves. The true film is hotter where it is thin, and the oil that a
cavity carries around mixes with fresh oil: the model has neither.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from linkages.errors import InputError, RunError
from linkages.explore.bearing import CELLS, COARSE, Bearing, bearing
from linkages.laws.viscosity import DENSITY_15, ISO_VG, density, iso_vg_viscosity

#: Temperatures at which oils are taken [degC]: below 2 mm2/s Walther's equation needs further terms.
COLDEST, HOTTEST = -50.0, 250.0
#: Specific heat capacity of a mineral oil [J/(kg K)]. Assumed, typical.
SPECIFIC_HEAT = 2000.0
_NEAR = 0.01  # accuracy of the temperature [K]


@dataclass(frozen=True)
class Heat:
    """Oil and surroundings of a bearing.

    Attributes
    ----------
    grade : int
        ISO VG grade; the viscosity follows from Walther's equation.
    inlet : float
        Temperature of the oil that enters [degC].
    conductance : float
        G, into the surroundings [W/K].
    surroundings : float or None
        Temperature of the surroundings [degC]; None: the inlet's.
    specific_heat : float
        c_p of the oil [J/(kg K)].
    density_15 : float
        Density of the oil at 15 degC [kg/m3].
    """

    grade: int
    inlet: float
    conductance: float = 0.0
    surroundings: float | None = None
    specific_heat: float = SPECIFIC_HEAT
    density_15: float = DENSITY_15

    @property
    def outside(self) -> float:
        """Temperature of the surroundings [degC]."""
        return self.inlet if self.surroundings is None else self.surroundings

    def viscosity(self, celsius: float) -> float:
        """Dynamic viscosity at a temperature [Pa s]."""
        return iso_vg_viscosity(self.grade, celsius, self.density_15)

    def removed(self, celsius: float, flow: float) -> tuple[float, float]:
        """Heat that the flow [m3/s] and conduction remove at a temperature [W]."""
        mass = density(celsius, self.density_15) * max(flow, 0.0)
        return mass * self.specific_heat * (celsius - self.inlet), self.conductance * (celsius - self.outside)


@dataclass(frozen=True, eq=False)
class WarmBearing:
    """An operating point at the temperature of its heat balance [degC]."""

    bearing: Bearing
    heat: Heat
    temperature: float

    @property
    def content(self) -> dict[str, Any]:
        """Return the numbers of ``bearing.json``: the bearing's, and the heat balance."""
        content = self.bearing.content
        by_flow, by_conduction = self.heat.removed(self.temperature, content["flow"])
        return content | {
            "temperature": self.temperature,
            "viscosity": self.bearing.case.viscosity,
            "heat": {"model": "lumped", "by_flow": by_flow, "by_conduction": by_conduction},
        }


def warm_bearing(heat: Heat, *dimensions: float, cells: tuple[int, int] = CELLS, **options: Any) -> WarmBearing:
    """Find the operating point at the temperature where friction power and removed heat are equal.

    Parameters
    ----------
    heat : Heat
    *dimensions : float
        diameter, length, clearance [m], speed [rad/s], load [N]: as for `linkages.bearing`, without the viscosity.
    cells : (int, int)
    **options
        Of `linkages.bearing`.

    Raises
    ------
    InputError
        If a value is out of range.
    RunError
        If there is no equilibrium below `HOTTEST`, or the warm film is too thin.

    Examples
    --------
    >>> import linkages
    >>> heat = linkages.Heat(46, 40.0, conductance=5.0)
    >>> warm = linkages.warm_bearing(heat, 0.1, 0.05, 1e-4, 100.0, 1000.0, cells=(72, 6))
    >>> 40.0 < warm.temperature < 80.0
    True
    """
    _check(heat)
    diameter, length, clearance, speed, load = dimensions

    def point(celsius: float, mesh: tuple[int, int]) -> Bearing:
        return bearing(diameter, length, clearance, heat.viscosity(celsius), speed, load, cells=mesh, **options)

    def excess(celsius: float, mesh: tuple[int, int]) -> float:
        content = point(celsius, mesh).content
        if content["flow"] is None:
            raise InputError("bearing", "film", "the heat balance needs the flow: choose film finite")
        return float(content["power"]) - sum(heat.removed(celsius, content["flow"]))

    low = min(heat.inlet, heat.outside)
    high, step = low, 5.0
    while excess(high, COARSE) > 0.0:
        low, high, step = high, high + step, 2.0 * step
        if high > HOTTEST:
            raise RunError(f"bearing: no heat balance below {HOTTEST:g} degC: raise the flow or the conductance")
    temperature = _root(lambda celsius: excess(celsius, COARSE), low, high)
    width = 1.0
    low, high = temperature - width, temperature + width
    if excess(low, cells) > 0.0 > excess(high, cells):  # the finer mesh moves the balance by less
        temperature = _root(lambda celsius: excess(celsius, cells), low, high)
    return WarmBearing(point(temperature, cells), heat, temperature)


def _root(function: Any, low: float, high: float) -> float:
    """Find the root of a falling function between two temperatures."""
    from scipy.optimize import brentq

    return low if low == high else float(brentq(function, low, high, xtol=_NEAR))


def _check(heat: Heat) -> None:
    if heat.grade not in ISO_VG:
        raise InputError("bearing", "grade", f"ISO VG {heat.grade}: must be one of {', '.join(map(str, ISO_VG))}")
    for name, value in (("inlet", heat.inlet), ("surroundings", heat.outside)):
        if not COLDEST <= value <= HOTTEST:
            raise InputError("bearing", name, f"{value:g} degC: must be from {COLDEST:g} to {HOTTEST:g}")
    for name, value in (("specific_heat", heat.specific_heat), ("density_15", heat.density_15)):
        if not (math.isfinite(value) and value > 0.0):
            raise InputError("bearing", name, f"{value:g}: must be positive")
    if not (math.isfinite(heat.conductance) and heat.conductance >= 0.0):
        raise InputError("bearing", "conductance", f"{heat.conductance:g} W/K: must not be negative")
