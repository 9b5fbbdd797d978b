"""The press paper's claims beside our numbers: see `replication.press_paper` for the runs."""

from __future__ import annotations

import numpy as np

from linkages import extremes
from replication import press_designs, press_equations, press_missing, press_spike
from replication import press_paper as paper
from replication.claims import change
from replication.press_paper import DESIGNS, PRINTED, Array, peak, peaks
from replication.verdicts import Claim, Number, Printed, parts

SPEEDS = "the drives' speeds, which are not given"


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
            "the loop of Table 2 and eq. (17) closes there, but for the rounding of 310.79°",
        ),
        Claim(
            "eq. (4): dε/dt is the size of de/dt over r", "never negative: eq. (11) never applies",
            f"the journal of A moves inwards during {inwards:.0f} % of our run, where (11) should apply",
            [Printed(0.0, inwards, "% of the time")], "the rate of the length of e has either sign",
        ),
        Claim(
            "the same, in the film's force", f"{speed[0]:+.2f} of the largest force", f"{speed[1]:+.2f} there",
            [Printed(*speed)], "along our run of joint A, where they differ most; eq. (9) with the size of de/dt, also while separating",
        ),
        Claim(
            "eq. (11) as printed: film force where dε/dt < 0", f"{jump:+.3f} of the force just above dε/dt = 0",
            "+1.000, continuous", [Printed(jump, 1.0)], "as printed the force jumps and the film feeds energy in; the sign is corrected here",
        ),
        Claim(
            "eqs. (9)-(11): ω is the relative speed", f"{relative[0]:+.2f} of the largest force", f"{relative[1]:+.2f} there",
            [Printed(*relative)], "along our run of joint A, where they differ most; with eq. (6) in the fixed frame the sum of both"
            " counts: a force must not depend on the observer",
        ),
        Claim(
            "film of an infinitely long bearing, for L/D > 2", f"largest eccentricity ratio of A {ours:.3f}",
            f"L/D = {length / (2 * radius):.2f} (Table 5); with the finite film {ratio:.3f}, F_A {force:.3f} instead of"
            f" {peak('nominal', 'A.force'):.3f} N", [Printed(ours, ratio)],
            "the paper's own condition is not met; forces hardly notice, as inertia sets them, orbits do",
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
    speed = peaks("slider7.vx")
    dv = 1e3 * (max(speed.values()) - min(speed.values()))
    lower = [speed[name] < speed["nominal"] for name in ("paper 1", "paper 2")]
    bends = [_turning_points(runs[name]["slider7.ax"][t > press_spike.START]) for name in ("nominal", "ideal")]
    return [
        Claim(
            "slider with and without clearance, figs. 5-7", "smooth, same trend",
            f"{bends[0]} turning points of the acceleration, of the ideal slider {bends[1]}; {shift:.4f} mm and {faster:.3f} mm/s apart",
            [parts([bends[0] == bends[1]])], "after the start the film keeps the journals near the centre",
        ),
        Claim(
            "displacement, fig. 6: differences of the designs", "about 0.1 mm", f"at most {differ:.4f} mm",
            [Number(0.1, differ, "mm")], "0.1 mm is a third of the clearance, the film yields less", "a softer film",
        ),
        Claim(
            "largest speed, fig. 7: differences of the designs", "about 0.1 mm/s, both below the nominal",
            f"{dv:.3f} mm/s; {sum(lower)} of 2 below the nominal", [Number(0.1, dv, "mm/s"), parts(lower)],
            "lengths and drives determine the speed", SPEEDS,
        ),
    ]  # fmt: skip


def rig() -> list[Claim]:
    """Section 3.2, figure 5: extremes with their signs."""
    found = extremes(paper.rig_run(), ["slider7.ax"])["slider7.ax"]
    perfect = extremes(paper.ideal_run(), ["slider7.ax"])["slider7.ax"]
    both = f"{found.min:+.3f} to {found.max:+.3f} m/s² (ideal {perfect.min:+.3f} to {perfect.max:+.3f})"
    computed, measured = paper.RIG["computed"], paper.RIG["measured"]
    return [
        Claim(
            "largest acceleration on the rig, computed", f"{computed:+} m/s²", both, [Number(computed, found.max, "m/s²")],
            "the largest in the printed sense; the paper compares it with a measured one of the other sign", SPEEDS,
        ),
        Claim(
            "largest acceleration on the rig, measured", f"{measured:+} m/s²", both, [Number(measured, found.min, "m/s²")],
            f"{measured / computed:.1f} times the paper's own computation, of the other sign;"
            " data of drives and guide are missing", "a model of the guide's friction and of the drives",
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
            "run with eq. (15), finite film and contact, where there could be some; the film carries",
        ),
        Claim(
            "orbits, fig. 9", "design 1 smaller than nominal, design 2 smallest",
            f"largest eccentricity ratios (nominal, 1, 2) {both}", [parts([*first, *second])],
            "design 2 is smallest; design 1 has thinner oil and a heavier link 2: its orbits grow",
        ),
    ]  # fmt: skip


def forces() -> list[Claim]:
    """Figure 10."""
    printed = PRINTED["B.force"]["nominal"] / PRINTED["A.force"]["nominal"]
    ours = peak("nominal", "B.force") / peak("nominal", "A.force")
    late = paper.share_below("A.force", "paper 2", "nominal", 0.8, 1.0)
    middle = [paper.share_below("B.force", "paper 2", other, 0.2, 1.0) for other in ("nominal", "paper 1")]
    return [
        *_force("A", "drive speeds missing; forces grow with their square"),
        *_force(
            "B",
            f"the printed peak lies in the first 0.2 s, at the start; printed F_B/F_A is {printed:.2f},"
            f" ours {ours:.2f} at any common speed",
        ),
        Claim(
            "F_A after 0.8 s, design 2", "clearly below", f"below the nominal during {late:.0f} % of 0.8-1 s",
            [Number(100.0, late, "%")], "lighter links",
        ),
        Claim(
            "F_B from 0.2 to 1 s, design 2", "below nominal and design 1",
            f"below during {middle[0]:.0f} % and {middle[1]:.0f} %", [Number(100.0, share, "%") for share in middle], "lighter links",
        ),
    ]  # fmt: skip


def _force(joint: str, why: str) -> list[Claim]:
    """Claims of a joint's largest force; `why` the nominal one differs."""
    printed, ours = PRINTED[f"{joint}.force"], peaks(f"{joint}.force")
    changes = ([n, *(change(x["nominal"], x[f"paper {n}"]) for x in (printed, ours))] for n in (1, 2))
    return [
        Claim(
            f"largest F_{joint}, nominal, fig. 10", f"{printed['nominal']} N", f"{ours['nominal']:.3f} N",
            [Number(printed["nominal"], ours["nominal"], "N")], why, SPEEDS,
        ),
        *(
            Claim(
                f"change of F_{joint}, design {n}", f"{asked:+.1f} %", f"{found:+.1f} %", [Number(asked, found, "%")],
                "the size depends on the speeds and on the start", SPEEDS,
            )
            for n, asked, found in changes
        ),
    ]  # fmt: skip


def _turning_points(values: Array) -> int:
    return int(np.sum(np.diff(np.sign(np.diff(values))) != 0))


SECTIONS = {
    "model": model, "motion": motion, "rig": rig, "spike": press_spike.claims, "orbits": orbits, "forces": forces,
    "missing": press_missing.claims, "optima": press_designs.optima, "arithmetic": press_designs.arithmetic,
}  # fmt: skip
