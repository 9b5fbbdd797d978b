"""The robot's rigid motion, and the equations that assemble its model: claims of sections 1 and 2.3."""

from __future__ import annotations

import numpy as np

from linkages.three_rrr.branch import follow, travel
from linkages.three_rrr.direct import assemblies, count, polynomial
from linkages.three_rrr.finite_elements import FiniteElementModel
from linkages.three_rrr.kinematics import determinants
from linkages.three_rrr.robot import changed
from replication import robot_printed as as_printed
from replication.robot_runs import results, robot
from replication.verdicts import Claim, Printed, Share, parts


def kinematics() -> list[Claim]:
    """Section 1, the assembly rules of section 2.3, and the speeds of section 4."""
    g, motion = robot().geometry, results().motion
    times = np.linspace(0.0, robot().duration, 4001)
    number = count(g, robot().cranks(times)[0])
    share = 100.0 * float(np.mean(number == 4))
    start = assemblies(g, robot().phi0)
    angles = ", ".join(f"{np.rad2deg(a):.2f}" for a in start.x[:, 0])
    branches = [follow(g, robot().cranks, x, robot().duration) for x in start.x]
    paths = ", ".join(f"{travel(b, 'path'):.4f}" for b in branches)
    best = min(branches, key=lambda branch: travel(branch, "path"))
    degree = polynomial(g, robot().phi0[None]).shape[1] - 1
    rate = np.max(np.abs(motion.dx[:, 0]))
    speed, acceleration = (1e3 * np.max(np.linalg.norm(x[:, 1:], axis=1)) for x in (motion.dx, motion.ddx))
    instants = sum(s.type == 1 for s in results().branch.singularities)
    apart = np.min(np.abs(determinants(g, motion.phi, motion.x)[1]), axis=1) > 0.1
    away = motion.part(np.flatnonzero(apart))
    theirs = as_printed.accelerations(g, away)
    worst = float(np.max(np.abs(theirs - away.ddx)) / np.max(np.abs(away.ddx)))
    where = np.argmax(np.abs(away.ddx[:, 1]))
    rows = float(len(np.atleast_1d(theirs[0, 0])))
    agreed, asked = _places()
    fastest = float(np.max(np.abs(motion.dphi))) / (2.0 * np.pi)
    lowest = float(results().frequencies.min())
    return [
        Claim(
            "position equation, eq. (2): degree in t", "8", f"{degree + 2}: degree {degree}, times 1 + t²",
            [Printed(8.0, degree + 2.0)],
            "right, but the factor has no real roots: two of the eight solutions are t = ±i; at most six are assemblies",
        ),
        Claim(
            "4 of the 8 solutions are assemblies at every instant, section 4", "4",
            f"{number.min()} to {number.max()} (4 during {share:.1f} % of the revolution); at t = 0: {len(start)}"
            f" (θ = {angles} deg)",
            [Share(100.0, share, "% of the revolution")],
            "real roots counted exactly at t = 0, all assemblies closed to round-off at 4,001 times", "other lengths or drive angles",
        ),
        Claim(
            '"shortest travel" assembly', "not named",
            f"paths of the platform's centre {paths} m; shorter from θ = {np.rad2deg(best.x[0, 0]):.2f} deg", [],
            "two assemblies exist during the whole revolution; both paths are close", "a named assembly, or the metric of its travel",
        ),
        Claim(
            "velocities and accelerations, figs. 7 and 8", "curves only",
            f"largest dθ/dt {rate:.4f} rad/s, speed {speed:.2f} mm/s, acceleration {acceleration:.2f} mm/s²", [],
            f"smooth, as the paper says; eq. (3) is singular at {instants} instants, the rows used here are not", "numbers on the axes",
        ),
        Claim(
            "accelerations of the joints by the H matrices, eq. (5)", "none",
            f"{1e3 * theirs[where, 1]:.3f} mm/s² where ours is {1e3 * away.ddx[where, 1]:.3f}, the largest along x;"
            f" everywhere within {'round-off' if worst < 1e-9 else f'{worst:.1g}'}",
            [Printed(1e3 * theirs[where, 1], 1e3 * away.ddx[where, 1], "mm/s²")],
            "solved for the platform with the first row of G, as in (6); away from the singular instants",
        ),
        Claim(
            "right side of eq. (6)", "a number plus a vector of 3", f"{rows:.0f} number for each leg",
            [Printed(3.0, rows, "components")],
            "the index of the first row, which the left side has, is lost; with it (6) is the first row of (5)",
        ),
        Claim(
            "index rules of section 2.3", "p = i + 1 or i + 2; p = 6(r - 1) + i + 5",
            f"{agreed} of {asked} places agree with the numbered displacements",
            [Printed(float(asked), agreed, "places")], "the platform's rule counts i by leg: 2r - 1 and 2r",
        ),
        Claim(
            "operating speeds are far from the natural frequencies, section 3.1", "advice",
            f"largest crank speed {fastest:.3f} Hz, rates of the rigid motion up to its 10th harmonic {10.0 * fastest:.2f} Hz; lowest"
            f" natural frequency {lowest:.0f} Hz", [parts([lowest > 10.0 * 10.0 * fastest])],
            "followed by the example: factor of more than 100 even to the 10th harmonic; the start causes the vibration",
        ),
    ]  # fmt: skip


def _places() -> tuple[int, int]:
    """Count the places that the printed rules give right, and all: rod BC and the platform's corners of each leg."""
    model = FiniteElementModel(changed(robot(), drives={"roots": "free"}))
    found, asked = 0, 0
    for leg in range(3):
        coupler = next(link for link in model.links if link.name == f"coupler{leg + 1}")
        rule = [8 * leg + i + (1 if i <= 2 else 2) for i in range(1, 7)]
        found += sum(int(dof) + 1 == place for dof, place in zip(coupler.dofs[0], rule, strict=True))
        corner = [6 * leg + i + 5 for i in (2 * leg + 1, 2 * leg + 2)]
        found += sum(int(dof) + 1 == place for dof, place in zip(model.c[leg], corner, strict=True))
        asked += len(rule) + len(corner)
    return found, asked
