"""The flexible 3-RRR robot of Lu et al. (2010): what the paper prints beside ours, computed when the page is made."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.files.shipped import find_file
from linkages.flexible.response import quasi_static as solve
from linkages.three_rrr.branch import follow, shortest, travel
from linkages.three_rrr.direct import assemblies, count, polynomial
from linkages.three_rrr.finite_elements import FiniteElementModel
from linkages.three_rrr.kinematics import determinants
from linkages.three_rrr.modes import frequencies
from linkages.three_rrr.response import Response, quasi_static_response, recursion
from linkages.three_rrr.results import RobotResults, analyse
from linkages.three_rrr.robot import Robot, changed, load_robot
from linkages.three_rrr.stress import link_stress, platform_stress
from linkages.three_rrr.vibration import Vibration, vibrate
from replication import robot_printed as as_printed
from replication.verdicts import Claim, Number, Printed, Share, parts

Array = NDArray[np.floating]

PRINTED_ERROR = (6.456e-3, 9.158e-3, np.deg2rad(1.2630))  # m, m, rad: section 4, platform
PRINTED_CRANK = 3.4671e5  # Pa: section 4, A_2 B_2
PRINTED_COUPLER = 1.3799e5  # Pa: section 4, B_2 C_2
PRINTED_PLATFORM = (-5.5301e4, 6.0095e4)  # Pa: section 4, normal stress
PRINTED_SHEAR = 2.7085e3  # Pa: section 4, platform
_UNITS = (("x", "mm", 1e3), ("y", "mm", 1e3), ("turning", "deg", 180.0 / np.pi))
_FROM_REST = 1.0  # s, in which both recursions are run
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


def _stresses(model: FiniteElementModel, response: Response) -> Stresses:
    links, plate = link_stress(model, response), platform_stress(model, response)
    peaks = (links[2].largest.max(), links[3].largest.max(), plate.second.min(), plate.first.max())
    return Stresses(*map(float, (*peaks, plate.largest_shear.max())))


@cache
def _loaded_as_printed() -> Response:
    """Quasi-static response, roots held, to the loads of section 2.2 as printed."""
    model, state = results().model, results().motion
    k, _ = model.matrices(state)
    u = solve(k, as_printed.load(model, state)[:, model.kept])
    return Response(state, u, 0.0 * u, 0.0 * u, model.platform_displacement(state, u))


def _kinematics() -> list[Claim]:
    g, motion = robot().geometry, results().motion
    times = np.linspace(0.0, robot().duration, 4001)
    number = count(g, robot().cranks(times)[0])
    share = 100.0 * float(np.mean(number == 4))
    start = assemblies(g, robot().phi0)
    angles = ", ".join(f"{np.rad2deg(a):.2f}" for a in start.x[:, 0])
    branches = [follow(g, robot().cranks, x, robot().duration) for x in start.x]
    paths = ", ".join(f"{travel(b, 'path'):.4f}" for b in branches)
    best = shortest(g, robot().cranks, robot().duration, "path")
    degree = polynomial(g, robot().phi0[None]).shape[1] - 1
    rate = np.max(np.abs(motion.dx[:, 0]))
    speed, acceleration = (1e3 * np.max(np.linalg.norm(x[:, 1:], axis=1)) for x in (motion.dx, motion.ddx))
    instants = sum(s.type == 1 for s in results().branch.singularities)
    apart = np.min(np.abs(determinants(g, motion.phi, motion.x)[1]), axis=1) > 0.1
    away = motion.part(np.flatnonzero(apart))
    theirs = as_printed.accelerations(g, away)
    worst = float(np.max(np.abs(theirs - away.ddx)) / np.max(np.abs(away.ddx)))
    where = np.argmax(np.abs(away.ddx[:, 1]))
    return [
        Claim(
            "position equation, eq. (2)", "degree 8 in t, 8 solutions", f"degree {degree} times 1 + t²",
            [Printed(8.0, degree, "solutions")],
            "the factor has no real roots: at most six assemblies",
        ),
        Claim(
            "assemblies at every instant, section 4", "4",
            f"{number.min()} to {number.max()} (4 during {share:.1f} % of the revolution); at t = 0: {len(start)}"
            f" (θ = {angles} deg)",
            [Share(100.0, share, "% of the revolution")],
            "real roots counted exactly at t = 0, all assemblies closed to round-off at 4,001 times", "other lengths or drive angles",
        ),
        Claim(
            '"shortest travel" assembly', "not named",
            f"paths of the platform's centre {paths} m; shorter from θ = {np.rad2deg(best.x[0, 0]):.2f} deg", [],
            "two assemblies last for the revolution; both paths are close", "a named assembly, or the metric of its travel",
        ),
        Claim(
            "velocities and accelerations, figs. 7 and 8", "curves only",
            f"largest dθ/dt {rate:.4f} rad/s, speed {speed:.2f} mm/s, acceleration {acceleration:.2f} mm/s²", [],
            f"smooth, as the paper says; eq. (3) is singular at {instants} instants, the rows used here are not", "numbers on the axes",
        ),
        Claim(
            "accelerations by the H matrices, eqs. (5) and (6)", "no numbers",
            f"{1e3 * theirs[where, 1]:.3f} mm/s² where ours is {1e3 * away.ddx[where, 1]:.3f}, the largest along x;"
            f" everywhere within {'round-off' if worst < 1e-9 else f'{worst:.1g}'}",
            [Printed(1e3 * theirs[where, 1], 1e3 * away.ddx[where, 1], "mm/s²")],
            "with the first row of G on the right of (6) too, where the index is lost; away from the singular instants",
        ),
    ]  # fmt: skip


def _modes() -> list[Claim]:
    here = results()
    model = FiniteElementModel(changed(here.robot, model={"elements": 16}))
    fine = frequencies(model, here.motion.part(slice(0, 1)), 6)[0]
    lowest, other = (r.frequencies[:, 0] for r in (here, second()))
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
            "nothing holds the mechanism; the paper does not mention zero modes", "the number of curves in fig. 9",
        ),
        Claim(
            "one element per link", "sufficient (implied)",
            f"first mode {error[0]:+.2f} %, fourth to sixth {error[3:].min():+.1f} to"
            f" {error[3:].max():+.1f} % against 16 elements",
            [Printed(*map(float, pair), "Hz") for pair in zip(coarse, fine, strict=True)],
            "good for the first mode only: one element overestimates bending of a pinned rod by"
            f" {100.0 * (np.sqrt(120.0) / np.pi**2 - 1.0):.2f} %",
        ),
    ]  # fmt: skip


def _displacement() -> list[Claim]:
    static, other = (np.abs(r.static.platform).max(axis=0) for r in (results(), second()))
    moving = np.abs(shaken().platform).max(axis=(0, 1))
    bound = stress_bound(results())
    softer = robot().material.youngs_modulus * bound.platform / PRINTED_ERROR[1]
    return [
        *(
            Claim(
                f"elastic displacement of the platform, {name}, fig. 11", f"{scale * printed:.4g} {unit}",
                f"{scale * moving[k]:.3g} {unit} over the revolution from rest; {scale * static[k]:.3g} {unit} quasi-static"
                f" ({scale * other[k]:.3g} on the other assembly)",
                [Number(scale * printed, scale * moving[k], unit)],
                f"{printed / moving[k]:.2g} times ours; contradicts the printed stress, see the next rows",
                "a material that much softer, or roots that nothing holds",
            )
            for k, (printed, (name, unit, scale)) in enumerate(zip(PRINTED_ERROR, _UNITS, strict=True))
        ),
        Claim(
            "0.35 MPa against millimetres", f"{1e-6 * PRINTED_CRANK:.3g} MPa with {1e3 * PRINTED_ERROR[1]:.3g} mm",
            f"at that stress a crank bends by {1e6 * bound.crank:.3g} µm and a coupler changes its length by"
            f" {1e6 * bound.axial:.3g} µm; the load that gives it ({bound.scale:.3g} times ours) moves the"
            f" platform by {1e6 * bound.platform:.3g} µm",
            [Printed(1e6 * PRINTED_ERROR[1], 1e6 * bound.platform, "µm")],
            "as elastic displacements and stresses of one robot they cannot go together", f"E = {1e-6 * softer:.2g} MPa",
        ),
    ]  # fmt: skip


def _drift() -> list[Claim]:
    model, run = drifting()
    moved, stress = np.abs(run.platform).max(axis=0), _stresses(model, run)
    found = [scale * value for value, (_, _, scale) in zip(moved, _UNITS, strict=True)]
    passed = [
        float(run.motion.time[np.argmax(np.abs(run.platform[:, k]) > value)]) for k, value in enumerate(PRINTED_ERROR)
    ]
    asked = [scale * value for value, (_, _, scale) in zip(PRINTED_ERROR, _UNITS, strict=True)]
    return [
        Claim(
            "24 equations with free roots by eq. (13): displacement", "6.456 mm, 9.158 mm, 1.263 deg",
            f"{found[0]:.0f} mm, {found[1]:.0f} mm, {found[2]:.0f} deg over the revolution",
            [Number(a, b, unit) for a, b, (_, unit, _) in zip(asked, found, _UNITS, strict=True)],
            "three zero modes, for which F/p² has no value; with its limit p → 0 nothing drives the mechanism, and it lags behind"
            f" its prescribed motion: by the printed values after {passed[0]:.2g} s, {passed[1]:.2g} s and {passed[2]:.2g} s."
            " A possible origin of the millimetres: rigid drift, not elasticity (our reading)",
            "how the paper treats the zero modes, and from when to when fig. 11 goes",
        ),
        Claim(
            "24 equations with free roots by eq. (13): stress of A₂B₂", f"{1e-3 * PRINTED_CRANK:.4g} kPa",
            f"{1e-3 * stress.crank:.3g} kPa (B₂C₂ {1e-3 * stress.coupler:.3g} kPa)",
            [Number(1e-3 * PRINTED_CRANK, 1e-3 * stress.crank, "kPa")],
            "drift is no strain: with free roots the cranks carry no drive torque, and less stress than held",
        ),
        Claim(
            "the same with one basis in each step", "not printed",
            "; ".join(_one_basis(model, steps) for steps in (2000, 8000)), [],
            "what is drift in one pose strains the robot in the next: printed millimetres and kilopascals can come out"
            " together, but the stress is that of the step, not of the robot (our reading)",
            "the paper's step, which is not given",
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


def _recursion() -> list[Claim]:
    times = np.linspace(0.0, _FROM_REST, 4001)
    right = recursion(results().model, results().branch, times).platform
    theirs = recursion(results().model, results().branch, times, printed=True).platform
    apart = np.max(np.abs(theirs - right) / np.abs(right).max(axis=0))
    peaks = zip(*(np.abs(x).max(axis=0) for x in (theirs, right)), _UNITS, strict=True)
    return [
        Claim(
            "time recursion, eq. (13)", "back with the next step's basis",
            f"with modes that keep their order and signs it stays within {100.0 * apart:.1g} % of the peak displacement of"
            f" the recursion with one basis in each step, for {_FROM_REST:g} s",
            [Printed(scale * a, scale * b, unit) for a, b, (_, unit, scale) in peaks],
            "both are of first order in the step; the paper does not say that modes must be followed",
        )
    ]  # fmt: skip


def _reason(name: str, printed: float, ours: float) -> str:
    """Say what of a printed stress the candidates explain: ours times as large, and each candidate's value [kPa]."""
    swapped = changed(robot(), sections={"crank_diameter": 0.04, "coupler_diameter": 0.03})
    model, theirs = results().model, _loaded_as_printed()
    axial, bending = as_printed.rod_stress(model, theirs)
    first, low, shear = as_printed.platform_stress(model, theirs)
    rods = [float(np.max(axial[:, k] + bending[:, k])) for k in (2, 3)]
    other = FiniteElementModel(swapped)
    found = {
        "the printed loads and formulas": Stresses(*rods, float(low.min()), float(first.max()), float(shear.max())),
        "d₁ and d₂ exchanged": _stresses(other, quasi_static_response(other, results().motion)),
        "the other assembly": _stresses(second().model, second().static),
        "free roots": _stresses(*drifting()),
    }
    values = {key: getattr(stress, name) for key, stress in found.items()}
    told = ", ".join(f"with {key} {1e-3 * value:.3g}" for key, value in values.items())
    right = [key for key, value in values.items() if Number(printed, value).grade == 0]
    return f"{printed / ours:.3g} times ours, {f'explained by {right[0]}' if right else 'unexplained'}: {told} kPa"


def _stress() -> list[Claim]:
    here, moving = results(), shaken()
    static = _stresses(here.model, here.static)
    assert moving.plate is not None  # the robot's platform is a triangle
    plate = moving.plate
    dynamic = Stresses(
        moving.largest["crank2"],
        moving.largest["coupler2"],
        *map(float, (plate[0, :, 1].min(), plate[1, :, 0].max(), plate[1, :, 2].max())),
    )
    rows = (
        ("crank", "A₂B₂, fig. 12a", PRINTED_CRANK), ("coupler", "B₂C₂, fig. 12b", PRINTED_COUPLER),
        ("low", "the platform, least normal, fig. 12c", PRINTED_PLATFORM[0]),
        ("high", "the platform, largest normal, fig. 12c", PRINTED_PLATFORM[1]), ("shear", "the platform, shear, fig. 12c", PRINTED_SHEAR),
    )  # fmt: skip
    factors = ", ".join(f"{printed / getattr(dynamic, name):.2g}" for name, _, printed in rows)
    links = here.stress[2:4]
    places = [1e3 * float(link.s[np.argmax(link.largest) % len(link.s)]) for link in links]
    lengths = [1e3 * float(link.s[-1]) for link in links]
    return [
        *(
            Claim(
                f"stress of {where}", f"{1e-3 * printed:.4g} kPa",
                f"{1e-3 * getattr(dynamic, name):.3g} kPa over the revolution from rest, {1e-3 * getattr(static, name):.3g} kPa quasi-static",
                [Number(1e-3 * printed, 1e-3 * getattr(dynamic, name), "kPa")],
                _reason(name, printed, getattr(dynamic, name)),
                f"density and speeds, but no common scale: the five printed values are {factors} times ours",
            )
            for name, where, printed in rows
        ),
        Claim(
            "where the stress is largest, section 3.3", "at a rod's end",
            f"A₂B₂ at {places[0]:.0f} mm (its root), B₂C₂ at {places[1]:.0f} mm of {lengths[1]:.0f} mm",
            [parts(min(s, length - s) < 0.05 * length for s, length in zip(places, lengths, strict=True))],
            "right for the crank; a pinned coupler bends most near mid-span",
        ),
    ]  # fmt: skip


def _formulas() -> list[Claim]:
    here, theirs = results(), _loaded_as_printed()
    place = np.argmax(np.abs(here.static.platform[:, 0]))
    ours, loaded = (1e6 * float(r.platform[place, 0]) for r in (here.static, theirs))
    axial, bending = (1e-3 * x[:, 3] for x in as_printed.rod_stress(here.model, here.static))
    coupler = here.stress[3]
    shear = 1e-3 * float(as_printed.platform_stress(here.model, here.static)[2].max())
    right = 1e-3 * float(platform_stress(here.model, here.static).largest_shear.max())
    stretched, bent = (1e-3 * float(np.max(np.abs(x))) for x in (coupler.axial, coupler.bending))
    return [
        Claim(
            "generalised forces of inertia, section 2.2", "+∫ρ a N, the platform's without translation",
            f"they move the platform by {loaded:.3g} µm along x where the right ones do by {ours:.3g} µm",
            [Printed(loaded, ours, "µm")], "d'Alembert: -ρ a; the translation of the platform's centre has inertia too",
        ),
        Claim(
            "axial stress of a rod, section 3.3", "Σ η′ u",
            f"{1e3 * float(axial.max()):.2g} Pa in B₂C₂, with E {stretched:.3g} kPa",
            [Printed(float(axial.max()), stretched, "kPa")], "a strain: E is lacking",
        ),
        Claim(
            "bending stress of a rod, section 3.3", "E d/2 Σ φ″ v at its ends",
            f"{float(bending.max()):.3g} kPa in B₂C₂, from equilibrium {bent:.3g} kPa",
            [Printed(float(bending.max()), bent, "kPa")],
            "the end of a pinned rod has no moment; a cubic does not see the inertia along it",
        ),
        Claim(
            "shear stress, eq. (14)", "E/(1 + μ²) γ", f"{shear:.3g} kPa, with E/(2(1 + μ)) {right:.3g} kPa",
            [Printed(shear, right, "kPa")], "as printed stress depends on the axes",
        ),
    ]  # fmt: skip


#: What `python docs/replicate.py robot.NAME` repeats.
SECTIONS = {
    "kinematics": _kinematics,
    "modes": _modes,
    "displacement": _displacement,
    "drift": _drift,
    "recursion": _recursion,
    "stress": _stress,
    "formulas": _formulas,
}
