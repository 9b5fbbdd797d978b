"""Write docs/replication.md, its appendix docs/replication_details.md, and their figures: ``python docs/make_replication.py``."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from replication import (
    figures,
    patent_designs,
    patent_searches,
    press_conditions,
    press_designs,
    press_ideal,
    press_paper,
    press_spike,
)
from replication.claims import table
from replication.computed import read
from replication.summary import causes, counts
from replication.verdicts import BRIEF, LEGEND, brief

PAGE = Path(__file__).with_name("replication.md")
DETAILS = Path(__file__).with_name("replication_details.md")
FIGURES = Path(__file__).with_name("figures")
#: Speeds of the drawn map [rad/s].
SPEEDS = np.arange(-13.0, 13.25, 0.5)
#: Names of the ten numbers in the figure.
NAMES = (
    *(f"{joint}\n{design}" for joint in ("F_A", "F_B", "start") for design in ("nominal", "design 1", "design 2")),
    "rig",
)


def page() -> str:
    """Return the page of the press and the four-bar."""
    found = press_conditions.outcome(press_conditions.best())
    deviation = 100.0 * press_conditions.mismatch(found)
    return f"""# Replication of the published results

For readers who want evidence: printed results of two sources compared with results of this package from the same data. The
[robot](replication_3rrr.md) of the third source and the [misprints](misprints.md) have separate pages; the
[appendix](replication_details.md) has rule, causes and commands. `python docs/make_replication.py` writes both.

Rows that hold, by kind. A *fitted* number takes part in the choice of conditions that the source does not print. *Open* rows fail without a confirmed cause.

{counts().replace("(replication.md#", "(#")}

## The press

Chen, Wang and Wang (China Mechanical Engineering 36(1), 2025, 87-95) optimise a two-crank press with lubricated clearance in two joints. The
paper prints no gravity, no drive speeds, no start and neither of the two parameters ε₀ and m of its film. All runs here use
`seven_bar_paper.toml`: gravity along -y and cranks at π and -2π rad/s, chosen among all commensurate speeds because the printed forces and
the rig's acceleration agree there; ε₀ and m are fitted ([derivation](replication_details.md#conditions)). Ten printed numbers, the targets of the choice, are then met with a root
mean square deviation of {deviation:.1f} %, {press_conditions.met(found)} of them within 5 %.

**Holds.** The geometry closes; the lubricated joints keep the journals apart from the bearings; after the start the slider moves like the ideal
one; design 1 raises and design 2 lowers the joint forces; lubrication lowers forces and acceleration.

**Does not hold.** Three film equations are wrong as printed, the film is used outside its range (L/D = 1.33), two of six design variables cannot
change anything that the paper minimises, and two printed percentages contradict the paper's own numbers.

**Open.** The measured -13.72 m/s² is three times the paper's own computation with the opposite sign. The change of F_B by design 2, and the
differences of displacement and speed between the designs, are not met under these conditions.

![Ours over printed for ten numbers](figures/replication_ten.png)

*Six forces, three accelerations at the start, one of the rig; grey: within 5 %.*

{table(BRIEF, brief("press"))}
## The four-bar

Bai, Zhao and Sun (CN106055749A, 2016) choose the lengths of a double crank with one dry clearance joint so that its acceleration departs least
from the ideal linkage's. Formulas, tables and figures are lost in the available text: lengths, bounds, material and friction are
assumed, and eq. (8) is read as the follower's angular acceleration minus its ideal value. Intervals of the chaotic runs are the 5 % and 95 %
quantiles over start angles, *at the start* in the first revolutions, *running* later.

**Holds.** The method (claims 1 to 7) works: the departure falls as much as the patent says, its peaks become lower and fewer, and the claims
about clearance, speed and lubrication are true. The printed -77.5 % is no evidence: the assumed bounds were chosen so wide that it is possible.

**Holds in part.** Two other linkages improve in the steady state, but not from every start. A spring helps only if it is not too stiff.

**Does not hold.** Other masses do not lower the departure reliably.

![Angular acceleration of the follower before and after the optimisation, with clearance and ideal](figures/replication_jitter.png)

{table(BRIEF, brief("patent"))}"""


def details() -> str:
    """Return the appendix."""
    survivors = press_conditions.survivors()
    pairs = read("press_conditions")["scan"]["-y, moving"]["pairs"]
    return f"""# Replication: details

Appendix of [the press and the four-bar](replication.md) and [the robot](replication_3rrr.md), for readers who check a row: rule, causes and commands.
`python docs/make_replication.py` writes this page.

## How rows are judged

{LEGEND}
## The press

Clearance 0.3 mm (rig: 0.2 mm); 1 s from the start, forces in the printed windows; the rig runs for two periods of 2 s. The paper's text on
figure 10 ends at 1.0 s, and in a second half of the period every design would exceed the 4.290 m/s² of figure 8.

{causes("press")}### Conditions

Ten printed numbers depend on gravity, drive speeds, start, ε₀ and m, which the paper does not print: six largest forces in their
windows, three accelerations at the start and the largest acceleration computed for the rig. The rig is measured in steady running over two
complete periods: the speeds have a common period. `python docs/make_conditions.py` computes the tables of this section; its scan takes two minutes.

The scan contains all {pairs} pairs p : q of turns up to 6, in both senses, with ω₁ in steps of 0.05 rad/s and both speeds up to 13 rad/s, for the ideal press. Deviation
of the six forces: root mean square of the logarithms. Acceleration: the largest size over a period, against {press_paper.RIG["computed"]:g} m/s². At rest: eq. (22) with
α = β = 50 accelerates the cranks within 0.1 s.

{table(*press_conditions.scan_table())}
Gravity along ±x has no pair within 10 %. With a start in motion only ω₄ = -2 ω₁ with gravity along -y meets both criteria. Starts at rest add ω₄ = 2 ω₁ at 2.15 to 2.45 rad/s, where the
largest forces occur at t = 0, when the cranks are accelerated; with both speeds reversed, gravity along +y gives the same. With a start in motion
these pairs have ω₁ from {survivors[0, 0]:g} to {survivors[-1, 0]:g} rad/s and deviate by {100.0 * survivors[0, 2]:.1f} to {100.0 * survivors[-1, 2]:.1f} % from the six forces.

![Deviation of the ideal press from the six printed forces over both speeds, and both criteria](figures/replication_conditions.png)

*Left: white dots are commensurate pairs within 10 %, orange dots meet both criteria. Right: all pairs within 10 %, by gravity; band: 15 % of the printed acceleration.*

Fits of ε₀ and m, each from several starting points:

{table(*press_conditions.fits_table())}
Profiles hold one unknown and fit the others again, each from three starting points:

{table(*press_conditions.profiles_table())}
![Smallest deviation of all ten numbers with one unknown held](figures/replication_profiles.png)

*Vertical lines: the values of `seven_bar_paper.toml`.*

{press_conditions.conclusion()}

### Designs

All numbers come from runs of this package. *Ours* is the recorded result of `sevenbar_paper_force` (eq. (24)).

{table(*press_designs.designs_table())}
### Figures

![Displacement, velocity and acceleration of the slider for the four designs, and their differences](figures/replication_motion.png)

*Figures 6 to 8: the right column shows differences of the designs, from 10 ms after the start.*

![Acceleration of the slider at the start with the small-eccentricity correction](figures/replication_spike.png)

*Figure 8: left the first 50 ms, right the first 0.1 ms.*

![Acceleration of the slider on the rig, ideal and with clearance](figures/replication_rig.png)

*Figure 5: two periods; dashed: largest values of the printed experiment and computation.*

![Paths of the journals in joints A and B](figures/replication_orbits.png)

*Figure 9.*

![Forces in joints A and B during the first second](figures/replication_forces.png)

*Figure 10.*

![Best and mean objective of each generation](figures/replication_generations.png)

*Population and rates of the paper: acceleration (left), forces (right).*

## The four-bar

A double crank at 600 r/min, dry clearance of 0.5 mm between coupler and follower. *Ours* are recorded results of the named studies, by default
`fourbar_jitter`; medians with intervals: `docs/replication/dry.py`. Tables, figures and formulas of the patent are lost: every row lacks them.

{causes("patent")}### Methods

{patent_searches.methods()}
### Landscape

{patent_searches.landscape()}
## The robot

{causes("robot")}The row *0.35 MPa against millimetres*: a crank is clamped at A₂ and hinged at B₂, so its root
stress is σ = 3 E (d₁/2) δ / l₁²; the first length is the deflection δ of B₂ at the printed σ. A coupler is
hinged at both ends: the second length is σ l₂ / E. The third length uses the model's ratio of platform displacement to crank stress over the revolution.
"""


def draw() -> None:
    """Write the figures of both pages."""
    times = np.linspace(0.0, press_paper.DURATION, 2001)
    designs = {name: press_paper.columns(name, times) for name in (*press_paper.DESIGNS, "ours")}
    figures.write_motion(designs, FIGURES / "replication_motion.png")
    figures.write_orbits(designs, press_paper.CLEARANCE, FIGURES / "replication_orbits.png")
    figures.write_forces(designs, FIGURES / "replication_forces.png")
    figures.write_jitter(*patent_designs.motions("fourbar_jitter"), FIGURES / "replication_jitter.png")
    start = {
        name: press_paper.run({**design, **press_spike.FINE}, press_paper.START)
        for name, design in press_paper.DESIGNS.items()
    }
    figures.write_spike(
        press_spike.plain_run("nominal").columns, {name: run.columns for name, run in start.items()},
        press_paper.PRINTED["slider7.ax"], FIGURES / "replication_spike.png",
    )  # fmt: skip
    figures.write_generations(
        {title: (label, found.model_dump()) for title, (label, found) in press_designs.searches().items()},
        FIGURES / "replication_generations.png",
    )
    near = {
        name: np.array(read("press_conditions")["scan"][f"{name}, moving"]["near"]) for name in ("-y", "+y", "none")
    }
    figures.write_scan(
        SPEEDS, press_ideal.grid(SPEEDS, press_ideal.GRAVITY["-y"]), near, press_conditions.survivors(),
        (press_conditions.NEAR_FORCES, press_paper.RIG["computed"], press_conditions.NEAR_RIG),
        FIGURES / "replication_conditions.png",
    )  # fmt: skip
    figures.write_profiles(
        read("press_conditions")["profiles"], press_conditions.best()._asdict(), press_conditions.LABELS,
        FIGURES / "replication_profiles.png",
    )  # fmt: skip
    guesses = {"π and -2π rad/s, ε₀ and m fitted": press_conditions.best(), "four fitted values": press_conditions.FREE}
    figures.write_ten(
        NAMES, press_conditions.ASKED, {name: press_conditions.outcome(guess) for name, guess in guesses.items()},
        FIGURES / "replication_ten.png",
    )  # fmt: skip
    rig, twice = press_paper.rig_run().columns, np.linspace(0.0, 2.0 * press_paper.PERIOD, 4001)
    figures.write_rig(rig, press_paper.rig_ideal(twice), press_paper.RIG, FIGURES / "replication_rig.png")


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    DETAILS.write_text(details(), encoding="utf-8")
    draw()
