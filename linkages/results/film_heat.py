"""Heat balance of the oil in the joints of a run: power of the film, flow out of its ends, temperature that balances.

The model is lumped, see `linkages.laws.heat`: one temperature for the film of a joint, constant over the cycle, because
a bearing takes many cycles to warm up. Power and flow are means over the cycle.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from linkages.results.extremes import integral
from linkages.results.trajectory import Trajectory
from linkages.results.validity import warning
from linkages.system import System

_UNSETTLED = 0.1  # change of the temperature from run to run that is named in a warning [K]


@dataclass(frozen=True)
class JointHeat:
    """Heat balance of one joint over a part of a run."""

    temperature: float  # of the oil in the run [degC]
    viscosity: float  # at this temperature [Pa s]
    power: float  # mean power that film and contact dissipate [W]
    flow: float  # mean flow out of both ends [m3/s]
    by_flow: float  # heat that the flow removes at this temperature [W]
    by_conduction: float  # heat that conduction removes [W]
    balanced: float  # temperature at which the same motion would be in balance [degC]
    span: tuple[float, float]  # part of the run [s]
    cyclic: bool  # whether the motion repeats from there on

    @property
    def change(self) -> float:
        """Change of the temperature that the next run would bring [K]."""
        return self.balanced - self.temperature

    @property
    def content(self) -> dict[str, Any]:
        """Return the numbers of ``summary.json``."""
        names = ("temperature", "viscosity", "power", "flow", "by_flow", "by_conduction", "change")
        numbers = {name: getattr(self, name) for name in names}
        return {"model": "lumped", **numbers, "from": self.span[0], "to": self.span[1]}


def heated(system: System) -> list[str]:
    """List the joints with a heat balance."""
    joints = system.experiment.joints
    return [name for name, _ in system.tree.contacts if joints[name].heat is not None and joints[name].has_film]


def joint_heat(system: System, run: Trajectory, name: str, span: tuple[float, float], cyclic: bool) -> JointHeat:
    """Compute the heat balance of a joint over a part of a run with dense output; ArithmeticError without a balance."""
    model = system.experiment.joints[name]
    if model.oil is None or model.heat is None:
        raise AssertionError("a joint with a heat balance has oil")
    heat, now = model.heat.of(model.oil), model.oil.temperature
    part = run.within(*span)
    power = -integral(part, f"{name}.power") / (span[1] - span[0])
    flow = integral(part, f"{name}.flow") / (span[1] - span[0])
    viscosity = heat.viscosity(now)

    def excess(celsius: float) -> float:
        """Power of the same motion in another viscosity, less the removed heat."""
        return power * heat.viscosity(celsius) / viscosity - sum(heat.removed(celsius, flow))

    return JointHeat(
        now, viscosity, power, flow, *heat.removed(now, flow), balanced=heat.balance(excess), span=span, cyclic=cyclic
    )


def heat_warnings(heats: dict[str, JointHeat]) -> list[dict[str, Any]]:
    """Warn of temperatures that have not settled, and of balances over a motion that does not repeat."""
    found = []
    restless = [f"{abs(heat.change):.2g} K in {name}" for name, heat in heats.items() if abs(heat.change) > _UNSETTLED]
    if restless:
        what = f"the temperature of the oil still changes from run to run: {', '.join(restless)}"
        found.append(warning("film", None, what, "set oil.temperature near the present one and run again"))
    open_ended = [name for name, heat in heats.items() if not heat.cyclic]
    if open_ended:
        what = f"the heat balance of {', '.join(open_ended)} is a mean over a motion that does not repeat"
        found.append(warning("film", None, what, "raise the duration until the motion is periodic"))
    return found
