"""The flexible 3-RRR robot of Lu et al. (2010): what the paper prints beside ours, computed when the page is made."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.three_rrr.branch import follow, shortest, travel
from linkages.three_rrr.direct import assemblies, count
from linkages.three_rrr.finite_elements import FiniteElementModel
from linkages.three_rrr.modes import frequencies
from linkages.three_rrr.response import Response, generalised_alpha, quasi_static_response, recursion
from linkages.three_rrr.results import RobotResults, analyse
from linkages.three_rrr.robot import Robot, changed
from linkages.three_rrr.stress import link_stress, platform_stress
from replication.claims import table

Array = NDArray[np.floating]

PRINTED_ERROR = (6.456e-3, 9.158e-3, np.deg2rad(1.2630))  # m, m, rad: section 4, platform
PRINTED_CRANK = 3.4671e5  # Pa: section 4, A_2 B_2
PRINTED_COUPLER = 1.3799e5  # Pa: section 4, B_2 C_2
PRINTED_PLATFORM = (-5.5301e4, 6.0095e4)  # Pa: section 4, normal stress
PRINTED_SHEAR = 2.7085e3  # Pa: section 4, platform
_SAME = 0.01  # of the peak: two recursions of first order that differ by less are the same
_FROM_REST = 2.0  # s, of the motion that is run with vibration


class Row(NamedTuple):
    """One line of the table: what the paper prints, what we compute, and what follows."""

    quantity: str
    printed: str
    ours: str
    verdict: str


class StressBound(NamedTuple):
    """The largest elastic displacement that goes with the printed stresses."""

    #: Deflection of B_2 across the crank, clamped at A_2, when its root carries the printed stress [m].
    crank: float
    #: Change of the coupler's length at the printed coupler stress [m].
    axial: float
    #: Displacement of the platform's centre, in this model, when the quasi-static load of the worst pose is
    #: `scale` times as large, at which the crank of leg 2 carries its printed stress [m].
    platform: float
    scale: float


def stress_bound(results: RobotResults) -> StressBound:
    """Compute how far the platform can move elastically at the printed stresses."""
    robot = results.robot
    e, d = robot.material.youngs_modulus, robot.sections.crank_diameter
    length = float(robot.geometry.crank[1])
    crank = PRINTED_CRANK * length**2 / (3.0 * e * 0.5 * d)  # sigma = E (d/2) 3 delta/l^2 of a cantilever
    axial = PRINTED_COUPLER / e * float(robot.geometry.coupler[1])
    scale = PRINTED_CRANK / float(results.stress[2].largest.max())
    moved = scale * float(np.hypot(*results.static.platform.T[:2]).max())
    return StressBound(crank, axial, moved, scale)


def rows(robot: Robot) -> list[Row]:
    """Compute the table for the robot of the paper."""
    results = analyse(robot)
    other = min(results.assemblies.x, key=lambda x: abs(np.angle(np.exp(1j * (x[0] - np.deg2rad(-87.51))))))
    second = analyse(changed(robot, branch=float(np.rad2deg(other[0]))))
    return [*_kinematics(results), *_modes(results, second), *_response(results, second)]


def _kinematics(results: RobotResults) -> list[Row]:
    robot, motion = results.robot, results.motion
    times = np.linspace(0.0, robot.duration, 4001)
    number = count(robot.geometry, robot.cranks(times)[0])
    share = 100.0 * np.mean(number == 4)
    start = assemblies(robot.geometry, robot.phi0)
    angles = ", ".join(f"{np.rad2deg(a):.2f}" for a in start.x[:, 0])
    branches = [follow(robot.geometry, robot.cranks, x, robot.duration) for x in start.x]
    paths = ", ".join(f"{travel(b, 'path'):.4f}" for b in branches)
    best = shortest(robot.geometry, robot.cranks, robot.duration, "path")
    rate = np.max(np.abs(motion.dx[:, 0]))
    speed, acceleration = (1e3 * np.max(np.linalg.norm(x[:, 1:], axis=1)) for x in (motion.dx, motion.ddx))
    instants = sum(s.type == 1 for s in results.branch.singularities)
    return [
        Row(
            "position equation, eq. (2)", "degree 8 in t", "degree 6 times (1 + t²)",
            "the factor has no real roots: at most six assemblies",
        ),
        Row(
            "assemblies at every instant", "4",
            f"{number.min()} to {number.max()} (4 during {share:.1f} % of the revolution); at t = 0: {len(start)}"
            f" (θ = {angles} deg)",
            "not reproduced",
        ),
        Row(
            '"shortest travel" assembly', "not named",
            f"paths of the platform's centre {paths} m; shorter from θ = {np.rad2deg(best.x[0, 0]):.2f} deg",
            "needs a named metric; both are close",
        ),
        Row(
            "velocities and accelerations, figs. 7 and 8", "curves only",
            f"largest dθ/dt {rate:.4f} rad/s, speed {speed:.2f} mm/s, acceleration {acceleration:.2f} mm/s²",
            f"smooth, as the paper says; eq. (3) is singular at {instants} instants, the rows used here are not",
        ),
    ]  # fmt: skip


def _modes(results: RobotResults, second: RobotResults) -> list[Row]:
    model = FiniteElementModel(changed(results.robot, model={"elements": 16}))
    fine = frequencies(model, results.motion.part(slice(0, 1)), 6)[0]
    lowest, other = (r.frequencies[:, 0] for r in (results, second))
    coarse = results.frequencies[0, :6]
    error = 100.0 * (coarse / fine - 1.0)
    return [
        Row(
            "modal frequencies, fig. 9", "curves only, material not given",
            f"first mode {lowest[0]:.2f} Hz at t = 0, {lowest.min():.2f} to {lowest.max():.2f} Hz over the"
            f" revolution (other assembly {other.min():.2f} to {other.max():.2f} Hz);"
            f" first six at t = 0: {', '.join(f'{f:.1f}' for f in coarse)} Hz",
            "steel assumed; dense beyond the first, as the paper says",
        ),
        Row(
            "one element per link", "sufficient (implied)",
            f"first mode {error[0]:+.2f} %, fourth to sixth {error[3:].min():+.1f} to"
            f" {error[3:].max():+.1f} % against 16 elements",
            "good for the first mode only: one element overestimates bending of a pinned rod by"
            f" {100.0 * (np.sqrt(120.0) / np.pi**2 - 1.0):.2f} %",
        ),
    ]  # fmt: skip


def _response(results: RobotResults, second: RobotResults) -> list[Row]:
    times = np.linspace(0.0, _FROM_REST, 8001)
    shaken = generalised_alpha(results.model, results.branch, times, radius=1.0)
    static, other, moving = (np.abs(r.platform).max(axis=0) for r in (results.static, second.static, shaken))
    right = recursion(results.model, results.branch, times)
    paper = recursion(results.model, results.branch, times, printed=True)
    apart = np.max(np.abs(paper.platform - right.platform) / np.abs(right.platform).max(axis=0))
    bound, elastic = stress_bound(results), 1e3 * PRINTED_ERROR[1]
    zero = np.sum(results.free < 1e-3 * results.free.max())
    drift = np.sqrt(2.0 * PRINTED_ERROR[1] / abs(results.motion.ddx[0, 2]))
    units = (("x", "mm", 1e3), ("y", "mm", 1e3), ("turning", "deg", 180.0 / np.pi))
    return [
        *(
            Row(
                f"elastic displacement of the platform, {name}", f"{scale * printed:.4g} {unit}",
                f"{scale * static[k]:.3g} {unit} quasi-static ({scale * other[k]:.3g} on the other assembly);"
                f" {scale * moving[k]:.3g} {unit} started from rest",
                f"{printed / static[k]:.2g} times too large; contradicts the printed stress, see below",
            )
            for k, (printed, (name, unit, scale)) in enumerate(zip(PRINTED_ERROR, units, strict=True))
        ),
        Row(
            "0.35 MPa against millimetres", f"{1e-6 * PRINTED_CRANK:.3g} MPa with {elastic:.3g} mm",
            f"at that stress a crank bends by {1e6 * bound.crank:.3g} µm and a coupler changes its length by"
            f" {1e6 * bound.axial:.3g} µm; the load that gives it ({bound.scale:.3g} times ours) moves the"
            f" platform by {1e6 * bound.platform:.3g} µm",
            "the printed displacements and stresses cannot go together",
        ),
        Row(
            "24 equations, crank roots free", "all modes used in eq. (13)",
            f"{zero} zero modes, for which F/p² has no value; a mechanism that nothing drives lags"
            f" {elastic:.4g} mm behind its prescribed motion {drift:.2g} s after t = 0",
            "a possible origin of the millimetres: rigid drift, not elasticity (our reading)",
        ),
        Row(
            "time recursion, eq. (13)", "back with the next step's basis",
            f"with modes that keep their order and signs it stays within {100.0 * apart:.1g} % of the peak displacement of"
            f" the recursion with one basis in each step, for {_FROM_REST:g} s",
            "holds as printed" if apart < _SAME else "does not hold as printed",
        ),
        *_stresses(results, shaken),
    ]  # fmt: skip


def _stresses(results: RobotResults, shaken: Response) -> list[Row]:
    dynamic = link_stress(results.model, shaken)
    plate = platform_stress(results.model, quasi_static_response(results.model, results.motion))
    low, high = PRINTED_PLATFORM
    crank, coupler = (1e3 * link.s[np.argmax(link.largest) % len(link.s)] for link in results.stress[2:4])
    return [
        *(
            Row(
                f"largest stress of {name}", f"{1e-3 * value:.4g} kPa",
                f"{1e-3 * results.stress[index].largest.max():.3g} kPa quasi-static,"
                f" {1e-3 * dynamic[index].largest.max():.3g} kPa started from rest",
                "printed axial stress lacks E, inertia loads have the wrong sign; material assumed here",
            )
            for index, name, value in ((2, "A₂B₂", PRINTED_CRANK), (3, "B₂C₂", PRINTED_COUPLER))
        ),
        Row(
            "platform, normal stress", f"{1e-3 * low:.4g} to {1e-3 * high:.4g} kPa",
            f"{1e-3 * plate.second.min():.3g} to {1e-3 * plate.first.max():.3g} kPa (principal, quasi-static)",
            "the triangle's printed load lacks its translational acceleration",
        ),
        Row(
            "platform, largest shear stress", f"{1e-3 * PRINTED_SHEAR:.4g} kPa",
            f"{1e-3 * plate.largest_shear.max():.3g} kPa", "printed with E/(1 + ν²) in place of E/(2(1 + ν))",
        ),
        Row(
            "where the stress is largest", "input rods, at an end",
            f"crank 2 at {crank:.0f} mm (its root); coupler 2 at {coupler:.0f} mm"
            f" of {1e3 * results.robot.geometry.coupler[1]:.0f} mm",
            "right for the crank; a pinned coupler bends most near mid-span",
        ),
    ]  # fmt: skip


def page(robot: Robot, found: Sequence[Row]) -> str:
    """Return the page with the table of the robot's `rows`."""
    m = robot.material
    return f"""# Replication: the flexible 3-RRR robot

Lu, Shi, Gao and Dan, *Elastic-dynamics of planar flexile parallel mechanism*, Transactions of the Chinese Society
for Agricultural Machinery 41(6), 2010, pp. 208-215. The paper gives no material; assumed here: \
{m.name}, E = {m.youngs_modulus:.3g} Pa,
{m.density:g} kg/m³, ν = {m.poisson:g}; the crank has the diameter d₁, the coupler d₂; crank roots held; \
{robot.model.elements} element in each link.

This page is written by `python docs/make_replication_3rrr.py`; its numbers are computed.

{table(Row._fields, found)}
The calculation of the row *0.35 MPa against millimetres*: a crank is clamped at A₂ and hinged at B₂, so its root
stress is σ = 3 E (d₁/2) δ / l₁² for a deflection δ of B₂; at the printed σ this is the first length. A coupler is
hinged at both ends and carries the platform by its axial force alone: σ l₂ / E is the second. The third takes the
model's own ratio of platform displacement to crank stress over the revolution.
"""
