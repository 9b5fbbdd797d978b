"""Films of a run: heat balance of the oil in its joints, error of a closed form against a film of finite length.

The heat balance is lumped, see `linkages.laws.heat`: one temperature for the film of a joint, constant over the cycle,
because a bearing takes many cycles to warm up. Power and flow are means over the cycle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from linkages.base.kernel import Array
from linkages.laws.contact.material import bisect
from linkages.laws.film.films import film_force
from linkages.laws.film.map_nodes import PLAIN_CELLS, finite_force
from linkages.results import numerics
from linkages.results.extremes import integral
from linkages.results.shape import Heat, RunWarning
from linkages.results.trajectory import Trajectory
from linkages.results.validity import warning
from linkages.system import System


@dataclass(frozen=True)
class JointHeat:
    """Heat balance of one joint over a part of a run; made by `joint_heat`.

    Attributes
    ----------
    temperature : float
        Temperature of the oil in the run [degC].
    viscosity : float
        Viscosity at this temperature [Pa s].
    power : float
        Mean power that film and contact dissipate [W].
    flow : float
        Mean flow out of both ends [m3/s].
    by_flow, by_conduction : float
        Heat that the flow and conduction remove at this temperature [W].
    balanced : float
        Temperature at which the same motion would be in balance [degC].
    span : (float, float)
        Start and end of the part of the run [s].
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
    def numbers(self) -> Heat:
        """Return the numbers of a summary."""
        names = ("temperature", "viscosity", "power", "flow", "by_flow", "by_conduction", "change")
        numbers = {name: getattr(self, name) for name in names}
        return Heat(model="lumped", **numbers, **{"from": self.span[0]}, to=self.span[1])


def heated(system: System) -> list[str]:
    """List the joints with a heat balance."""
    return [name for name, _ in system.tree.contacts if system.joints[name].heat is not None]


def joint_heat(system: System, run: Trajectory, name: str, span: tuple[float, float], cyclic: bool) -> JointHeat:
    """Compute the heat balance of a joint over a part of a run with dense output; ArithmeticError without a balance."""
    heat, now = system.joints[name].heat, system.joints[name].oil_temperature
    if heat is None or now is None:
        raise AssertionError("a joint with a heat balance has oil")
    part = run.within(*span)
    column = f"{name}.contact_power"  # of a joint with a drive
    power = -integral(part, column if column in part else f"{name}.power") / (span[1] - span[0])
    flow = integral(part, f"{name}.flow") / (span[1] - span[0])
    viscosity = heat.viscosity(now)

    def excess(celsius: float) -> float:
        """Power of the same motion in another viscosity, less the removed heat."""
        return power * heat.viscosity(celsius) / viscosity - sum(heat.removed(celsius, flow))

    return JointHeat(
        now, viscosity, power, flow, *heat.removed(now, flow), balanced=heat.balance(excess), span=span, cyclic=cyclic
    )


def heat_warnings(heats: dict[str, JointHeat]) -> list[RunWarning]:
    """Warn of temperatures that have not settled, and of balances over a motion that does not repeat."""
    found = []
    restless = [
        f"{abs(heat.change):.2g} K in {name}"
        for name, heat in heats.items()
        if abs(heat.change) > numerics.FILMS_UNSETTLED
    ]
    if restless:
        what = f"the temperature of the oil still changes from run to run: {', '.join(restless)}"
        found.append(warning("film", None, what, "set oil.temperature near the present one and run again"))
    open_ended = [name for name, heat in heats.items() if not heat.cyclic]
    if open_ended:
        what = f"the heat balance of {', '.join(open_ended)} is a mean over a motion that does not repeat"
        found.append(warning("film", None, what, "raise the duration until the motion is periodic"))
    return found


_ROUGH = 160, 14  # mesh with which its eccentricity is sought, before one step of Newton's method with the usual one
_NO_MAP = np.zeros(0)


class FilmError(NamedTuple):
    """Estimated error of a film of infinite or vanishing length in one run."""

    force: float  # force over the finite film's in the same motion, at the largest force
    eccentricity: float  # largest eccentricity ratio of the run
    finite: float  # eccentricity ratio at which a finite film carries the same force at the same speeds


def film_error(record: Any, slenderness: float, e: Array, force: Array) -> FilmError | None:
    """Estimate the effect of a film of finite length (Guembel's condition) on a run; None where no force acts.

    From the record of the joint, L/D, the eccentricities (n, 2) from the bearing's centre to the journal's [m], and the
    forces of the film on the journal (n, 2) [N]. The motion (deps, ew) follows, but for its scale, from the direction
    of the force: a film is homogeneous of degree one. The eccentricity is an estimate: it keeps the speeds deps and
    ew/eps of the moment, and so neglects that a film that carries less is squeezed for longer.
    """
    unit = float(record.viscosity * record.length * record.radius**3 / record.clearance**2)
    ratio, size = np.hypot(*e.T) / record.clearance, np.hypot(*force.T) / unit
    usable = (size > 0.0) & (ratio > 1e-3) & (ratio < numerics.FILMS_LARGEST)
    if not usable.any():
        return None
    strongest, widest = (int(np.argmax(np.where(usable, values, -1.0))) for values in (size, ratio))
    eps, deps, ew = _motion(record, slenderness, e[strongest], force[strongest] / unit)
    excess = float(size[strongest]) / math.hypot(*finite_force(eps, slenderness, deps, 0.5 * ew))
    eps, deps, ew = _motion(record, slenderness, e[widest], force[widest] / unit)
    needed = float(size[widest])

    def spare(other: float, cells: tuple[int, int] = PLAIN_CELLS["guembel"]) -> float:
        half_ew = 0.5 * ew * other / eps
        return math.hypot(*finite_force(other, slenderness, deps, half_ew, cells=cells)) - needed

    near = bisect(lambda other: spare(other, _ROUGH), 0.0, numerics.FILMS_LARGEST, 20)
    slope = (spare(near + numerics.FILMS_STEP, _ROUGH) - spare(near, _ROUGH)) / numerics.FILMS_STEP
    return FilmError(excess, eps, float(np.clip(near - spare(near) / slope, 0.0, numerics.FILMS_LARGEST)))


def _motion(record: Any, slenderness: float, e: Array, force: Array) -> tuple[float, float, float]:
    """Find eps, deps and ew for which the film gives a dimensionless force."""
    eps = float(np.hypot(*e)) / record.clearance
    nx, ny = e / np.hypot(*e)
    aim = math.atan2(force[1] * nx - force[0] * ny, force[0] * nx + force[1] * ny)

    def acting(angle: float) -> tuple[float, float]:
        f_n, f_t, _ = film_force(record, eps, math.cos(angle), 2.0 * math.sin(angle), slenderness, _NO_MAP)
        return math.atan2(f_t, f_n), math.hypot(f_n, f_t)

    # rotation turns the force from -n (approach, angle 0) by way of t to n (separation, angle pi), and is odd in ew
    angle = math.copysign(bisect(lambda angle: acting(angle)[0] - abs(aim), 0.0, math.pi), aim)
    speed = float(np.hypot(*force)) / acting(angle)[1]
    return eps, speed * math.cos(angle), 2.0 * speed * math.sin(angle)
