"""The robot's modes and elastic displacements: claims of sections 3.1, 3.2 and 4."""

from __future__ import annotations

import numpy as np

from linkages.base.arrays import Array
from linkages.three_rrr.analysis import RobotResults
from linkages.three_rrr.finite_elements import FiniteElementModel
from linkages.three_rrr.modes import frequencies
from linkages.three_rrr.response import recursion
from linkages.three_rrr.robot import changed
from linkages.three_rrr.stress import platform_stress
from replication import robot_printed as as_printed
from replication import robot_soft as soft
from replication.robot_runs import (
    FROM_REST,
    PRINTED_CRANK,
    PRINTED_ERROR,
    UNITS,
    drifting,
    results,
    robot,
    second,
    shaken,
    stress_bound,
    stresses,
)  # fmt: skip
from replication.verdicts import WITHIN, Claim, Number, Printed, Share, parts

#: Modes that count as low.
LOW = 3
#: Poses of a revolution at which the extremes of the first frequency are found.
SAMPLES = 4001


def modes() -> list[Claim]:
    """List frequencies, shapes and the number of elements: section 3.1, figs. 9 and 10."""
    here = results()
    model = FiniteElementModel(changed(here.robot, model={"elements": 16}))
    fine = frequencies(model, here.motion.part(slice(0, 1)), 6)[0]
    lowest, other = (first_mode(r) for r in (here, second()))
    coarse = here.frequencies[0, :6]
    error = 100.0 * (coarse / fine - 1.0)
    zero = int(np.sum(here.free[0] < 1e-3 * here.free[0].max()))
    loose = here.free[:, zero]
    return [
        Claim(
            "modal frequencies, fig. 9, roots held", "curves only",
            f"first mode {lowest[0]:.2f} Hz at t = 0, {lowest.min():.2f} to {lowest.max():.2f} Hz over the"
            f" revolution (other assembly {other.min():.2f} to {other.max():.2f} Hz);"
            f" first six at t = 0: {', '.join(f'{f:.1f}' for f in coarse)} Hz", [],
            "steel assumed; dense beyond the first, as the paper says", "the material, and numbers on the axes",
        ),
        Claim(
            "the same with the paper's 24 numbers, roots free", "curves only",
            f"{zero} zero modes at every instant; the first other one {loose[0]:.2f} Hz at t = 0,"
            f" {loose.min():.2f} to {loose.max():.2f} Hz over the revolution", [],
            "the mechanism is free; the paper does not mention zero modes", "the number of curves in fig. 9",
        ),
        Claim(
            "one element per link",
            "sufficient (implied)",
            f"six lowest modes at t = 0 {', '.join(f'{e:+.1f}' for e in error)} % against 16 elements",
            [parts(abs(e) < 100.0 * WITHIN for e in error)],
            f"counted by mode, within {100.0 * WITHIN:.0f} %: one element overestimates bending of a pinned rod by"
            f" {100.0 * (np.sqrt(120.0) / np.pi**2 - 1.0):.2f} %",
        ),
        *_soft_parts(),
    ]  # fmt: skip


def first_mode(found: RobotResults) -> Array:
    """Lowest frequency over the revolution at `SAMPLES` poses, (n,) [Hz]: at the default poses its extremes are 0.1 Hz off."""
    state = found.branch.motion(np.linspace(0.0, found.branch.times[-1], SAMPLES))
    return frequencies(found.model, state, 1)[:, 0]


def _soft_parts() -> list[Claim]:
    """Section 4, fig. 10: which bodies take part in the modes, and which are soft."""
    held, free = soft.held(), soft.free()
    low, all_ = held.coupler[:LOW], [*held.coupler, *free.coupler]
    calm, busy = held.platform_moves[:LOW], held.platform_moves[-LOW:]
    return [
        Claim(
            "the long rods are the main soft part, section 4", "low and high modes",
            f"couplers' mean share of the strain energy: roots held, modes 1 to {LOW} {soft.listed(low)}"
            f", modes {LOW + 1} to {soft.COUNT} {min(held.coupler[LOW:]):.0%} or more; roots free,"
            f" elastic modes 1 to {len(free.coupler)} {min(free.coupler):.0%} or more",
            [parts(share > 0.5 for share in all_)],
            f"counted by mode. With held roots the lowest three modes bend the short cranks ({soft.listed(held.crank[:LOW])}) at their roots: true only from mode"
            f" {LOW + 1} on, or with free roots", "roots held or free",
        ),
        Claim(
            "in low modes all coordinates move by the same order, section 4", "modes of fig. 10",
            f"platform's corners over crank pins, roots held, modes 1 to {LOW}: {soft.ratios(calm)}",
            [parts(0.1 < ratio < 10.0 for ratio in calm)], "median over the revolution of the largest displacements",
        ),
        Claim(
            "in higher modes the rods move more than the platform, section 4", "modes of fig. 10",
            f"the same ratio, modes {soft.COUNT - LOW + 1} to {soft.COUNT}: {soft.ratios(busy)}",
            [parts(ratio < 1.0 for ratio in busy), parts([np.mean(busy) < np.mean(calm)])], "the rods bend between heavy corners",
        ),
    ]  # fmt: skip


def displacement() -> list[Claim]:
    """Judge the elastic displacements of the platform, fig. 11."""
    static, other = (np.abs(r.static.platform).max(axis=0) for r in (results(), second()))
    low, high = shaken().platform
    both = (low < 0.0) & (high > 0.0)
    moving = np.abs(shaken().platform).max(axis=(0, 1))
    offset = float(np.max(np.abs((low + high).mean(axis=0)) / 2.0 / moving))
    bound = stress_bound(results())
    softer = robot().material.youngs_modulus * bound.platform / PRINTED_ERROR[1]
    return [
        Claim(
            "the motion oscillates about the rigid motion, fig. 11", "curves only",
            f"both signs within {', '.join(f'{100 * s:.0f} %' for s in both.mean(axis=0))} of {len(both)} spans of the revolution (x, y, turning);"
            f" mean of the extremes at most {100.0 * offset:.0f} % of the largest displacement",
            [Share(100.0, 100.0 * float(share), "% of the spans") for share in both.mean(axis=0)],
            "from rest: vibration caused by the start, without damping, about the quasi-static deflection", "a start on the quasi-static motion",
        ),
        *(
            Claim(
                f"elastic displacement of the platform, {name}, fig. 11", f"{scale * printed:.4g} {unit}",
                f"{scale * moving[k]:.3g} {unit} over the revolution from rest; {scale * static[k]:.3g} {unit} quasi-static",
                [Number(scale * printed, scale * moving[k], unit)],
                f"{printed / moving[k]:.2g} times ours; quasi-static on the other assembly {scale * other[k]:.3g}",
                "a material softer by this factor, or free roots", [],
            )
            for k, (printed, (name, unit, scale)) in enumerate(zip(PRINTED_ERROR, UNITS, strict=True))
        ),
        Claim(
            "0.35 MPa against millimetres", f"{1e-6 * PRINTED_CRANK:.3g} MPa with {1e3 * PRINTED_ERROR[1]:.3g} mm",
            f"at that stress a crank bends by {1e6 * bound.crank:.3g} µm and a coupler changes its length by"
            f" {1e6 * bound.axial:.3g} µm; the load that gives it ({bound.scale:.3g} times ours) moves the"
            f" platform by {1e6 * bound.platform:.3g} µm",
            [Printed(1e6 * PRINTED_ERROR[1], 1e6 * bound.platform, "µm")],
            "elastic displacements and stresses of one robot cannot have these values together", f"E = {1e-6 * softer:.2g} MPa",
        ),
    ]  # fmt: skip


def drift() -> list[Claim]:
    """Run the 24 numbers of section 2.3, whose crank roots are free, by eq. (13)."""
    model, run = drifting()
    moved, stress = np.abs(run.platform).max(axis=0), stresses(model, run)
    found = [scale * value for value, (_, _, scale) in zip(moved, UNITS, strict=True)]
    passed = [
        float(run.motion.time[np.argmax(np.abs(run.platform[:, k]) > value)]) for k, value in enumerate(PRINTED_ERROR)
    ]
    asked = [scale * value for value, (_, _, scale) in zip(PRINTED_ERROR, UNITS, strict=True)]
    return [
        Claim(
            "24 equations with free roots by eq. (13): displacement", "6.456 mm, 9.158 mm, 1.263 deg",
            f"{found[0]:.0f} mm, {found[1]:.0f} mm, {found[2]:.0f} deg over the revolution",
            [Number(a, b, unit) for a, b, (_, unit, _) in zip(asked, found, UNITS, strict=True)],
            f"three zero modes, for which F/p² has no value; with the limit p → 0 no drive acts, and the mechanism lags behind its prescribed motion: by the printed values after {passed[0]:.2g} s, {passed[1]:.2g} s and {passed[2]:.2g} s."
            " A possible origin of the millimetres: rigid drift, not elasticity (our reading)",
            "the paper's treatment of zero modes, and the time range of fig. 11", [], trial=True,
        ),
        Claim(
            "24 equations with free roots by eq. (13): stress of A₂B₂", f"{1e-3 * PRINTED_CRANK:.4g} kPa",
            f"{1e-3 * stress.crank:.3g} kPa (B₂C₂ {1e-3 * stress.coupler:.3g} kPa)",
            [Number(1e-3 * PRINTED_CRANK, 1e-3 * stress.crank, "kPa")],
            "drift causes no strain: with free roots the cranks carry no drive torque and less stress than with held roots", because=[], trial=True,
        ),
        Claim(
            "the same with one basis in each step", "not printed",
            "; ".join(_one_basis(model, steps) for steps in (2000, 8000)), [],
            "drift in one pose causes strain in the next: printed millimetres and kilopascals can then occur together, but the step determines the stress, not the robot (our reading)",
            "the paper's step",
        ),
    ]  # fmt: skip


def _one_basis(model: FiniteElementModel, steps: int) -> str:
    """Say what the recursion gives after half a second if it returns with the basis of the same step, by section 3.3 with E."""
    run = recursion(model, results().branch, np.linspace(0.0, 0.5, steps + 1))
    moved = 1e3 * np.abs(run.platform[:, :2]).max(axis=0)
    axial, bending = as_printed.rod_stress(model, run)
    rods = 1e-3 * np.max(robot().material.youngs_modulus * axial + bending, axis=0)
    plate = 1e-3 * platform_stress(model, run).first.max()
    return (
        f"{moved[0]:.2g} mm and {moved[1]:.2g} mm after 0.5 s; A₂B₂ {rods[2]:.2g} kPa, B₂C₂ {rods[3]:.2g} kPa, platform"
        f" {plate:.2g} kPa with a step of {500.0 / steps:g} ms"
    )


def recursion_() -> list[Claim]:
    """Judge the recursion of eq. (13)."""
    times = np.linspace(0.0, FROM_REST, 4001)
    right = recursion(results().model, results().branch, times).platform
    theirs = recursion(results().model, results().branch, times, printed=True).platform
    apart = np.max(np.abs(theirs - right) / np.abs(right).max(axis=0))
    peaks = zip(*(np.abs(x).max(axis=0) for x in (theirs, right)), UNITS, strict=True)
    free = results().free[0]
    finite = int(np.sum(free > 1e-3 * free.max()))
    return [
        Claim(
            "time recursion, eq. (13)", "back with the next step's basis",
            f"with modes followed it stays within {100.0 * apart:.1g} % of the peak displacement of"
            f" the recursion with one basis in each step, for {FROM_REST:g} s",
            [Printed(scale * a, scale * b, unit) for a, b, (_, unit, scale) in peaks],
            "both are of first order in the step; the paper does not say that modes must be followed",
        ),
        Claim(
            "eq. (13) for the paper's 24 numbers, crank roots free", "F/p² for all 24 modes",
            f"{finite} modes have p > 0", [Printed(24.0, float(finite), "modes")],
            "the zero modes need the limit F t²/2: see the rows on free roots",
        ),
    ]  # fmt: skip
