"""Operating point of a bearing at the temperature of its heat balance; see `linkages.laws.heat` for the model."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from linkages.base.errors import InputError, RunError
from linkages.explore.bearing import CELLS, COARSE, BearingPoint, bearing
from linkages.laws.heat import Heat, root


@dataclass(frozen=True, eq=False)
class WarmBearing:
    """An operating point at the temperature of its heat balance; made by `warm_bearing`.

    Attributes
    ----------
    bearing : BearingPoint
        With the viscosity at this temperature.
    heat : Heat
    temperature : float
        Temperature of the oil [degC].
    """

    bearing: BearingPoint
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


def warm_bearing(
    heat: Heat,
    diameter: float,
    length: float,
    clearance: float,
    speed: float,
    load: float,
    *,
    cells: tuple[int, int] = CELLS,
    **options: Any,
) -> WarmBearing:
    """Find the operating point at the temperature where friction power and removed heat are equal.

    Parameters
    ----------
    heat : Heat
    diameter, length, clearance, speed, load, cells, **options
        As for `linkages.bearing`; the viscosity follows from the temperature.

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
    for name, problem in heat.faults():
        raise InputError("bearing", name, problem)

    def point(celsius: float, mesh: tuple[int, int]) -> BearingPoint:
        return bearing(diameter, length, clearance, heat.viscosity(celsius), speed, load, cells=mesh, **options)

    def excess(celsius: float, mesh: tuple[int, int]) -> float:
        content = point(celsius, mesh).content
        if content["flow"] is None:
            raise InputError("bearing", "film", "the heat balance needs the flow: choose film finite")
        return float(content["power"]) - sum(heat.removed(celsius, content["flow"]))

    try:
        temperature = heat.balance(lambda celsius: excess(celsius, COARSE))
    except ArithmeticError as problem:
        raise RunError(f"bearing: {problem}") from None
    low, high = temperature - 1.0, temperature + 1.0
    if excess(low, cells) > 0.0 > excess(high, cells):  # the finer mesh moves the balance by less
        temperature = root(lambda celsius: excess(celsius, cells), low, high)
    return WarmBearing(point(temperature, cells), heat, temperature)
