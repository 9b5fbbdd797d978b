"""Runs of the flexible 3-RRR robot of Lu et al. (2010), and the numbers that the paper prints."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.input.files.shipped import find_file
from linkages.mechanics.flexible.response import quasi_static as solve
from linkages.three_rrr.analysis import RobotResults, analyse
from linkages.three_rrr.finite_elements import FiniteElementModel
from linkages.three_rrr.response import Response, recursion
from linkages.three_rrr.robot import Robot, changed, load_robot
from linkages.three_rrr.stress import link_stress, platform_stress
from linkages.three_rrr.vibration import Vibration, vibrate
from replication import robot_printed as as_printed

Array = NDArray[np.floating]

PRINTED_ERROR = (6.456e-3, 9.158e-3, np.deg2rad(1.2630))  # m, m, rad: section 4, platform
PRINTED_CRANK = 3.4671e5  # Pa: section 4, A_2 B_2
PRINTED_COUPLER = 1.3799e5  # Pa: section 4, B_2 C_2
PRINTED_PLATFORM = (-5.5301e4, 6.0095e4)  # Pa: section 4, normal stress
PRINTED_SHEAR = 2.7085e3  # Pa: section 4, platform
UNITS = (("x", "mm", 1e3), ("y", "mm", 1e3), ("turning", "deg", 180.0 / np.pi))
FROM_REST = 1.0  # s, in which both recursions are run
_STEPS_PER_PERIOD = 20.0  # of the vibration; 40 change no row by more than some per cent
_STEPS = 500  # per second, of the recursion with free roots: with twice as many it changes by 1e-4


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


class Stresses(NamedTuple):
    """Largest stresses of a model [Pa]: A_2 B_2, B_2 C_2, the platform's least and largest normal stress, its shear."""

    crank: float
    coupler: float
    low: float
    high: float
    shear: float


@cache
def robot() -> Robot:
    """Load the robot of the paper."""
    return load_robot(find_file("three_rrr.toml"))


@cache
def results(branch: float | None = None) -> RobotResults:
    """Analyse it on its branch, or on another one [deg]."""
    return analyse(robot() if branch is None else changed(robot(), branch=branch))


def second() -> RobotResults:
    """Analyse it on the other assembly that lasts."""
    other = min(results().assemblies.x, key=lambda x: abs(np.angle(np.exp(1j * (x[0] - np.deg2rad(-87.51))))))
    return results(float(np.rad2deg(other[0])))


@cache
def shaken() -> Vibration:
    """Run the whole revolution from rest, with vibration."""
    return vibrate(results().model, results().branch, steps_per_period=_STEPS_PER_PERIOD)


@cache
def drifting() -> tuple[FiniteElementModel, Response]:
    """Run the 24 numbers, crank roots free, by eq. (13) as printed over the revolution."""
    model = FiniteElementModel(changed(robot(), drives={"roots": "free"}))
    end = robot().duration
    return model, recursion(model, results().branch, np.linspace(0.0, end, round(_STEPS * end) + 1), printed=True)


def stress_bound(found: RobotResults) -> StressBound:
    """Compute how far the platform can move elastically at the printed stresses."""
    e, d = found.robot.material.youngs_modulus, found.robot.sections.crank_diameter
    length = float(found.robot.geometry.crank[1])
    crank = PRINTED_CRANK * length**2 / (3.0 * e * 0.5 * d)  # sigma = E (d/2) 3 delta/l^2 of a cantilever
    axial = PRINTED_COUPLER / e * float(found.robot.geometry.coupler[1])
    scale = PRINTED_CRANK / float(found.stress[2].largest.max())
    moved = scale * float(np.hypot(*found.static.platform.T[:2]).max())
    return StressBound(crank, axial, moved, scale)


def stresses(model: FiniteElementModel, response: Response) -> Stresses:
    """Find the largest stresses of a response."""
    links, plate = link_stress(model, response), platform_stress(model, response)
    peaks = (links[2].largest.max(), links[3].largest.max(), plate.second.min(), plate.first.max())
    return Stresses(*map(float, (*peaks, plate.largest_shear.max())))


@cache
def loaded_as_printed() -> Response:
    """Compute the quasi-static response, roots held, to the loads of section 2.2 as printed."""
    model, state = results().model, results().motion
    k, _ = model.matrices(state)
    u = solve(k, as_printed.load(model, state)[:, model.kept])
    return Response(state, u, 0.0 * u, 0.0 * u, model.platform_displacement(state, u))
