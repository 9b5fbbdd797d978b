"""Heat balance of the oil in the joints of a run: power of the film, flow out of its ends, temperature that balances.

The model is lumped, see `linkages.laws.heat`: one temperature for the film of a joint, constant over the cycle, because
a bearing takes many cycles to warm up. Power and flow are means over the cycle.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from linkages.arrays import Array
from linkages.laws.film.groove_map import quasi_static_film
from linkages.laws.film.surface.grooves import Groove
from linkages.laws.film.surface.surface_mesh import surface_mesh
from linkages.laws.film.tilted_film import tilted_action
from linkages.results.extremes import integral
from linkages.results.trajectory import Columns, Trajectory
from linkages.results.warnings import warning
from linkages.system import System

#: States of a cycle at which the flow is computed, and cells of its mesh: 1 % of the flow.
_STATES, _CELLS = 96, (72, 6)
_STEP = 1e-4  # of the time between these states: velocities are differences of positions
_UNSETTLED = 0.1  # change of the temperature from run to run that is named in a warning [K]


@dataclass(frozen=True)
class JointHeat:
    """Heat balance of one joint over a part of a run.

    Attributes
    ----------
    temperature : float
        Of the oil in the run [degC].
    viscosity : float
        At this temperature [Pa s].
    power : float
        Mean power that film and contact dissipate [W].
    flow : float
        Mean flow out of both ends [m3/s].
    by_flow, by_conduction : float
        Heat that they remove at this temperature [W].
    balanced : float
        Temperature at which the same motion would be in balance [degC].
    span : (float, float)
        Part of the run [s].
    cyclic : bool
        Whether the motion repeats from there on.
    """

    temperature: float
    viscosity: float
    power: float
    flow: float
    by_flow: float
    by_conduction: float
    balanced: float
    span: tuple[float, float]
    cyclic: bool

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
    """Compute the heat balance of a joint over a part of a run with dense output.

    Raises
    ------
    ArithmeticError
        If no temperature balances.
    """
    model = system.experiment.joints[name]
    if model.oil is None or model.heat is None:
        raise AssertionError("a joint with a heat balance has oil")
    heat, now = model.heat.of(model.oil), model.oil.temperature
    part = run.within(*span)
    power = -integral(part, f"{name}.power") / (span[1] - span[0])
    flow = float(np.mean(end_flows(system, run, name, span)))
    viscosity = heat.viscosity(now)

    def excess(celsius: float) -> float:
        """Power of the same motion in another viscosity, less the removed heat."""
        return power * heat.viscosity(celsius) / viscosity - sum(heat.removed(celsius, flow))

    return JointHeat(
        now, viscosity, power, flow, *heat.removed(now, flow), balanced=heat.balance(excess), span=span, cyclic=cyclic
    )


def end_flows(system: System, run: Trajectory, name: str, span: tuple[float, float]) -> Array:
    """Compute the flow out of both ends of a joint's film at evenly spaced times of a run, (`_STATES`,) [m3/s]."""
    joint, model = system.mechanism.joint[name], system.experiment.joints[name]
    if joint.bearing is None or model.clearance is None or run.evaluate is None:
        raise AssertionError("a joint with a heat balance is a bearing; its run has dense output")
    k = [label for _, label in system.contacts].index(name)
    c, radius, most = model.clearance, joint.bearing.radius, float(system.film_limits[k])
    between = (span[1] - span[0]) / _STATES
    times: Array = span[0] + between * np.arange(0.5, _STATES)
    middle, ahead, behind = (run.evaluate(times + sign * _STEP * between) for sign in (0.0, 1.0, -1.0))
    e, e_ahead, e_behind = (np.column_stack([at[f"{name}.ex"], at[f"{name}.ey"]]) / c for at in (middle, ahead, behind))
    v = (e_ahead - e_behind) / (2.0 * _STEP * between)
    eps = np.hypot(*e.T)
    n = np.where(eps[:, None] > 0.0, e / np.where(eps > 0.0, eps, 1.0)[:, None], (1.0, 0.0))
    deps, v_t = np.sum(v * n, axis=1), v[:, 1] * n[:, 0] - v[:, 0] * n[:, 1]
    half_ew = 0.5 * eps * (_rate(middle, joint.parent) + _rate(middle, joint.child)) - v_t
    turned = np.arctan2(n[:, 1], n[:, 0])
    if joint.parent != "world":
        turned -= middle[f"{joint.parent}.angle"] - system.mechanism.place[joint.parent].angle
    if model.is_tilted:
        law, args = (
            system.laws[k],
            (c * eps, c * deps, c * v_t, _rate(middle, joint.parent), _rate(middle, joint.child)),
        )
        return np.array([tilted_action(law, *at)[5] for at in zip(*args, turned, strict=True)])
    slenderness, groove = 0.5 * joint.bearing.length / radius, model.groove
    flows = np.empty(_STATES)
    for i, ratio in enumerate(np.minimum(eps, most)):
        placed = () if groove is None else (Groove(groove.angle - turned[i], groove.extent, groove.length),)
        mesh = surface_mesh(slenderness, placed, (float(ratio), 0.0), *_CELLS)
        film = quasi_static_film(mesh, float(ratio), placed, model.cavitation, float(deps[i]), float(half_ew[i]))
        flows[i] = film.end_flow
    return c * radius**2 * flows


def _rate(columns: Columns, link: str) -> Array:
    """Angular velocity of a link [rad/s]."""
    return columns[f"{link}.omega"] if link != "world" else np.zeros(_STATES)


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
