"""Temperature of the oil in a bearing from a heat balance: a lumped model, one temperature for the whole film.

The friction power heats the oil that leaves at the ends and flows by conduction into the surroundings:

    P(T) = rho(T) c_p Q(T) (T - T_inlet) + G (T - T_surroundings).

All of the oil has the temperature T at which it leaves. The true film is hotter where it is thin, and the oil that a
cavity carries around mixes with fresh oil: the model has neither. Q is the flow out of the ends times the share that
fresh oil replaces: 1 in a bearing that is fed, 0 in a sealed one. Temperatures are in degrees Celsius.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from linkages.laws.parameters import Parameter
from linkages.laws.viscosity import DENSITY_15, ISO_VG, density, iso_vg_viscosity

#: Temperatures at which oils are taken [degC]: below 2 mm2/s Walther's equation needs further terms.
COLDEST, HOTTEST = -50.0, 250.0
#: Accuracy of the temperature of a balance [K].
NEAR = 0.01

INLET = Parameter("inlet", "degC", None, "temperature of the oil that enters", ge=COLDEST, le=HOTTEST)
CONDUCTANCE = Parameter("conductance", "W/K", 0.0, "heat conducted into the surroundings per kelvin", ge=0.0)
SURROUNDINGS = Parameter(
    "surroundings", "degC", None, "temperature of the surroundings; default: the inlet's", ge=COLDEST, le=HOTTEST
)
SPECIFIC_HEAT = Parameter(
    "specific_heat", "J/(kg K)", 2000.0, "specific heat capacity of the oil", gt=0.0, source="assumed: mineral oils"
)
FRESH = Parameter("fresh", "1", 1.0, "share of the flow out of the ends that fresh oil replaces", ge=0.0, le=1.0)
_DENSITY = Parameter("density_15", "kg/m3", DENSITY_15, "density of the oil at 15 degC", gt=0.0)


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
    fresh : float
        Share of the flow out of the ends that fresh oil replaces [1].
    """

    grade: int
    inlet: float
    conductance: float = 0.0
    surroundings: float | None = None
    specific_heat: float = SPECIFIC_HEAT.default or 0.0
    density_15: float = DENSITY_15
    fresh: float = FRESH.default or 0.0

    def faults(self) -> Iterator[tuple[str, str]]:
        """Yield name and problem of each invalid value."""
        if self.grade not in ISO_VG:
            yield "grade", f"ISO VG {self.grade}: must be one of {', '.join(map(str, ISO_VG))}"
        for parameter in (INLET, CONDUCTANCE, SURROUNDINGS, SPECIFIC_HEAT, _DENSITY, FRESH):
            value = getattr(self, parameter.name)
            if value is not None and not parameter.admits(value):
                yield parameter.name, f"{value:g} {parameter.unit}: must be {parameter.range}"

    @property
    def outside(self) -> float:
        """Temperature of the surroundings [degC]."""
        return self.inlet if self.surroundings is None else self.surroundings

    def viscosity(self, celsius: float) -> float:
        """Dynamic viscosity at a temperature [Pa s]."""
        return iso_vg_viscosity(self.grade, celsius, self.density_15)

    def removed(self, celsius: float, flow: float) -> tuple[float, float]:
        """Heat that the flow out of the ends [m3/s] and conduction remove at a temperature [W]."""
        mass = density(celsius, self.density_15) * self.fresh * max(flow, 0.0)
        return mass * self.specific_heat * (celsius - self.inlet), self.conductance * (celsius - self.outside)

    def balance(self, excess: Callable[[float], float]) -> float:
        """Find the temperature of the heat balance [degC], to `NEAR`.

        Parameters
        ----------
        excess : callable
            Power less the removed heat at a temperature [W]; it falls with the temperature.

        Raises
        ------
        ArithmeticError
            If there is no equilibrium below `HOTTEST`.

        Examples
        --------
        >>> from linkages.laws.heat import Heat
        >>> heat = Heat(46, 40.0, conductance=2.0)  # 30 W by conduction alone: 15 K
        >>> round(heat.balance(lambda celsius: 30.0 - sum(heat.removed(celsius, 0.0))), 2)
        55.0
        """
        low = high = min(self.inlet, self.outside)
        step = 5.0
        while excess(high) > 0.0:
            low, high, step = high, high + step, 2.0 * step
            if high > HOTTEST:
                raise ArithmeticError(f"no heat balance below {HOTTEST:g} degC: raise the flow or the conductance")
        return root(excess, low, high)


def root(function: Callable[[float], float], low: float, high: float) -> float:
    """Find the root of a falling function between two temperatures, to `NEAR`."""
    from scipy.optimize import brentq

    return low if low == high else float(brentq(function, low, high, xtol=NEAR))
