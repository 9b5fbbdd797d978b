"""The press paper's claims beside our numbers: see `replication.press_paper` for the runs."""

from __future__ import annotations

import numpy as np
from scipy.signal import find_peaks

from linkages import Trajectory, extremes
from linkages.results.extremes import Extremes
from replication import press_conditions, press_context, press_designs, press_equations, press_spike
from replication import press_paper as paper
from replication.claims import change
from replication.press_paper import DESIGNS, PRINTED, Array, peak, peaks
from replication.verdicts import Claim, Fitted, FittedChange, Number, Printed, Share, parts

SPEEDS = "the drives' speeds"
FRICTION = 5.0  # N in the guide, assumed: more than all normal force there
WIDEST = 0.2e-3 + 0.5 * 0.011e-3  # m, section 3.2: shafts of 11.6 mm with the tolerance 0/-0.011 mm


def model() -> list[Claim]:
    """Equations and data that the rest hangs on."""
    x = float(paper.ideal_run()["slider7.x"][0])
    length, radius = 0.04, 0.015  # m, Table 5
    film = paper.run({f"joints.{j}.film": "finite" for j in "AB"})
    force, ratio = extremes(film, ["A.force"])["A.force"].peak, float(film["A.eccentricity_ratio"].max())
    ours = peak("nominal", "A.eccentricity_ratio")
    inwards = press_equations.never()
    jump = press_equations.jump()
    speed, relative = press_equations.farthest(speed=True), press_equations.farthest(relative=True)
    return [
        Claim(
            "lower dead position S₀, Table 2", "560 mm", f"{1e3 * x:.2f} mm", [Number(1e3 * paper.POSITION, 1e3 * x, "mm")],
            "the loop of Table 2 and eq. (17) closes there, except for the rounding of 310.79°",
        ),
        Claim(
            "eq. (4): dε/dt is the size of de/dt over r", "never negative: eq. (11) never applies",
            f"the journal of A moves inwards during {inwards:.0f} % of a steady period, where (11) should apply",
            [Printed(0.0, inwards, "% of the time")], "the rate of the length of e has either sign",
        ),
        Claim(
            "the same, in the film's force", f"{speed[0]:+.2f} of the largest force", f"{speed[1]:+.2f} there",
            [Printed(*speed)], "largest difference along joint A's path over the same period; eq. (9) with the size of de/dt, also while separating",
        ),
        Claim(
            "eq. (11) as printed: film force where dε/dt < 0", f"{jump:+.3f} of the force just above dε/dt = 0",
            "+1.000, continuous", [Printed(jump, 1.0)], "as printed the force has a jump and the film supplies energy; the sign is corrected here",
        ),
        Claim(
            "eqs. (9)-(11): ω is the relative speed", f"{relative[0]:+.2f} of the largest force", f"{relative[1]:+.2f} there",
            [Printed(*relative)], "largest difference along joint A's path over the same period; with eq. (6) in the fixed frame the sum of both speeds counts: a force must not depend on the observer",
        ),
        Claim(
            "film of an infinitely long bearing, for L/D > 2", f"largest eccentricity ratio of A {ours:.3f}",
            f"L/D = {length / (2 * radius):.2f} (Table 5); with the finite film {ratio:.3f}, F_A {force:.3f} instead of"
            f" {peak('nominal', 'A.force'):.3f} N", [Printed(ours, ratio)],
            "the paper's own condition is not met; inertia determines the forces, so they change little; orbits change much",
        ),
    ]  # fmt: skip


def motion() -> list[Claim]:
    """Figures 6 and 7."""
    t = np.linspace(0.0, paper.DURATION, 4001)
    runs = {name: paper.columns(name, t) for name in ("ideal", *DESIGNS)}

    def apart(name: str, other: str, output: str) -> float:
        return 1e3 * float(np.abs(runs[name][output] - runs[other][output]).max())

    shift, faster = (apart("nominal", "ideal", output) for output in ("slider7.x", "slider7.vx"))
    differ = max(apart(name, "nominal", "slider7.x") for name in DESIGNS)
    positions = {name: paper.design_extremes(name)["slider7.x"] for name in DESIGNS}
    speed = peaks("slider7.vx")
    dv = 1e3 * (max(speed.values()) - min(speed.values()))
    lower = [speed[name] < speed["nominal"] for name in ("paper 1", "paper 2")]
    bends = [_turning_points(runs[name]["slider7.ax"][t > paper.START]) for name in ("nominal", "ideal")]
    return [
        Claim(
            "slider with and without clearance, figs. 5-7", "smooth, same trend",
            f"{bends[0]} turning points of the acceleration, of the ideal slider {bends[1]}; {shift:.4f} mm and {faster:.3f} mm/s apart",
            [parts([bends[0] == bends[1]])], "after the start the film keeps the journals near the centre",
        ),
        Claim(
            "displacement, fig. 6: differences of the designs", "about 0.1 mm", f"at most {differ:.4f} mm",
            [Number(0.1, differ, "mm")], "0.1 mm is a third of the clearance; the film is stiffer", "a softer film", [],
        ),
        Claim(
            "displacement peak of design 2 is slightly larger, fig. 6", "larger than nominal and design 1",
            f"{', '.join(f'{1e3 * one.max:.4f}' for one in positions.values())} mm (nominal, 1, 2), at t = {max(one.time_max for one in positions.values()):g} s",
            [parts(positions["paper 2"].max > positions[name].max for name in ("nominal", "paper 1"))],
            "the slider starts in its extended position: all three peaks are the start position, which no design changes", SPEEDS,
            [parts(one.time_max == 0.0 for one in positions.values())],
        ),
        Claim(
            "largest speed, fig. 7: differences of the designs", "about 0.1 mm/s, both below the nominal",
            f"{dv:.3f} mm/s; {sum(lower)} of 2 below the nominal", [Number(0.1, dv, "mm/s"), parts(lower)],
            "lengths and drives determine the speed", SPEEDS, [],
        ),
    ]  # fmt: skip


def rig() -> list[Claim]:
    """Section 3.2, figure 5: extremes with their signs over two periods, after the start."""

    def settled(run: Trajectory) -> Extremes:
        return extremes(run.within(paper.START, float(run.time[-1])), ["slider7.ax"])["slider7.ax"]

    found, rubbed, wide = map(settled, (paper.rig_run(), paper.rig_run(FRICTION), paper.rig_run(clearance=WIDEST)))
    perfect = paper.rig_ideal(np.linspace(0.0, paper.PERIOD, 4001))["slider7.ax"]
    both = f"{found.min:+.3f} to {found.max:+.3f} m/s² (ideal {perfect.min():+.3f} to {perfect.max():+.3f})"
    computed, measured = paper.RIG["computed"], paper.RIG["measured"]
    return [
        Claim(
            "largest acceleration on the rig, computed", f"{computed:+} m/s²", both, [Fitted(computed, found.max, "m/s²")],
            "largest value of the printed sign, over two periods of 2 s; the paper compares it with a measured value of the opposite sign", SPEEDS,
        ),
        Claim(
            "largest acceleration on the rig, measured", f"{measured:+} m/s²", both, [Number(measured, found.min, "m/s²")],
            f"{measured / computed:.1f} times the paper's own computation, with the opposite sign; the next row tests the cause that the paper names",
            "records of the drives and of the frame's vibration", [],
        ),
        Claim(
            "friction between slider and guide as the cause", f"{measured:+} m/s²",
            f"{rubbed.min:+.3f} to {rubbed.max:+.3f} m/s² with {FRICTION:g} N of Coulomb friction, {found.min:+.3f} to {found.max:+.3f} without",
            [Number(measured, rubbed.min, "m/s²")],
            "cranks at constant speed and the film determine the slider's motion: a force on the slider changes the joint forces, not its acceleration",
            "compliant drives", trial=True,
        ),
        Claim(
            "tolerance of the rig's shafts, 11.6 (0/-0.011) mm", "not compared", f"{wide.min:+.3f} to {wide.max:+.3f} m/s² with the widest clearance, {1e3 * WIDEST:.4f} mm", [],
            f"additional question: it changes the extremes by at most {1e3 * max(abs(wide.min - found.min), abs(wide.max - found.max)):.1f} mm/s²",
        ),
        Claim(
            "diameter of the bearings: Tables 4 and 5, and section 3.2", "30 mm and 12 mm", "rig 12 mm, all else 30 mm", [Printed(30.0, 12.0, "mm")],
            "Tables 4 and 5 give a radius of 15 mm, section 3.2 shafts of 12 mm diameter for the same machine; the film's force differs by a factor of 15.6",
        ),
    ]  # fmt: skip


def orbits() -> list[Claim]:
    """Figure 9."""
    largest = {joint: peaks(f"{joint}.eccentricity_ratio") for joint in "AB"}
    both = ", ".join(f"{j}: {', '.join(f'{x:.3f}' for x in found.values())}" for j, found in largest.items())
    touched = {name: paper.contacts(name) for name in DESIGNS}
    second = [found["paper 2"] == min(found.values()) for found in largest.values()]
    first = [found["paper 1"] < found["nominal"] for found in largest.values()]
    return [
        Claim(
            "no contact in the joints, fig. 9", "none",
            f"{', '.join(map(str, touched.values()))} contacts (nominal, 1, 2)", [parts(n == 0 for n in touched.values())],
            "run with eq. (15), finite film and contact, where contacts are possible; the film carries the load",
        ),
        Claim(
            "orbits, fig. 9", "design 1 smaller than nominal, design 2 smallest",
            f"largest eccentricity ratios (nominal, 1, 2) {both}", [parts([*first, *second])],
            "design 2 is smallest; design 1 has thinner oil and a heavier link 2: its orbits grow", "the oils of Table 6", [],
        ),
    ]  # fmt: skip


def forces() -> list[Claim]:
    """Figure 10, in the printed windows."""
    late = paper.share_below("A.force", "paper 2", "nominal", 0.8, 1.0)
    middle = [paper.share_below("B.force", "paper 2", other, 0.2, 1.0) for other in ("nominal", "paper 1")]
    return [
        *_force("A"), *_force("B"),
        Claim(
            "F_A after 0.8 s, design 2", "clearly below", f"below the nominal during {late:.0f} % of 0.8-1 s",
            [Share(100.0, late, "%")], "lighter links",
        ),
        Claim(
            "F_B from 0.2 to 1 s, design 2", "below nominal and design 1",
            f"below during {middle[0]:.0f} % and {middle[1]:.0f} %", [Share(100.0, share, "%") for share in middle], "lighter links",
        ),
    ]  # fmt: skip


def _force(joint: str) -> list[Claim]:
    """Claims of a joint's largest force in its window."""
    output = f"{joint}.force"
    printed, end = PRINTED[output], paper.WINDOWS[output]
    found = {name: paper.design_extremes(name)[output] for name in DESIGNS}
    rows = [
        Claim(
            f"largest F_{joint} within {end:g} s, {name}, fig. 10", f"{printed[name]} N", f"{one.max:.3f} N at {one.time:.3f} s",
            [Fitted(printed[name], one.max, "N")], "chosen speeds; mainly the weight of the links", SPEEDS, [],
        )
        for name, one in found.items()
    ]  # fmt: skip
    for n in (1, 2):
        asked, ours = (
            change(printed["nominal"], printed[f"paper {n}"]),
            change(found["nominal"].max, found[f"paper {n}"].max),
        )
        rows.append(
            Claim(
                f"change of F_{joint}, design {n}", f"{asked:+.1f} %", f"{ours:+.1f} %", [FittedChange(asked, ours, "%")],
                "from the same forces", SPEEDS, [],
            )
        )  # fmt: skip
    return rows


def _turning_points(values: Array) -> int:
    """Count maxima and minima that stand out by a hundredth of the range."""
    least = 0.01 * np.ptp(values)
    return sum(len(find_peaks(sign * values, prominence=least)[0]) for sign in (1.0, -1.0))


SECTIONS = {
    "model": model, "motion": motion, "rig": rig, "spike": press_spike.claims, "orbits": orbits, "forces": forces,
    "conditions": press_conditions.claims, "optima": press_designs.optima, "arithmetic": press_designs.arithmetic,
    "context": press_context.context,
}  # fmt: skip
