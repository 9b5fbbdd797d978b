"""Write docs/replication.md and its figures: ``python docs/make_replication.py``."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from replication import figures, patent_designs, press_designs, press_missing, press_paper, press_spike
from replication.claims import table
from replication.measured import read
from replication.verdicts import HEAD, LEGEND, rows

PAGE = Path(__file__).with_name("replication.md")
FIGURES = Path(__file__).with_name("figures")


def page() -> str:
    """Return the whole page."""
    return f"""# Replication of the published results

What two sources print, beside what this package computes from the same data. `python docs/make_replication.py` writes this page;
its numbers are computed when it is written. Designs of ours were searched for once, and are kept with their provenance in
`docs/replication/designs/`. {LEGEND}
What the sources print wrongly, and the tests that show it, are [listed](misprints.md).
The robot of the third source has [a page of its own](replication_3rrr.md).

## The press

Chen, Wang and Wang, *Dynamics optimization design of multi-link mechanisms with lubrication clearances of revolute joints*, China
Mechanical Engineering 36(1), 2025, 87-95. Clearance 0.3 mm (rig: 0.2 mm); both cranks turn at 2π rad/s from t = 0 with the journals
centred, 1 s. The paper gives neither the speeds nor the start; these are assumed.

{table(HEAD, rows("press"))}
### Designs

All by our runs. *Ours* is the recorded answer of `sevenbar_force` (eq. (24)).

{table(*press_designs.designs_table())}
### Figures

![Displacement, velocity and acceleration of the slider for the four designs, and their differences](figures/replication_motion.png)

*The paper's figures 6 to 8: the designs cannot be told apart; on the right what they differ by, from 10 ms after the start.*

![Acceleration of the slider at the start with the small-eccentricity correction](figures/replication_spike.png)

*Figure 8 with the artefact of eqs. (12)-(13): left a period, right the first 10 ms. The spikes are negative, of 5.43, 5.41 and 5.49 m/s².*

![Acceleration of the slider on the rig, ideal and with clearance](figures/replication_rig.png)

*Figure 5: the rig's clearance, two periods; the printed experiment's and computation's largest values.*

![Paths of the journals in joints A and B](figures/replication_orbits.png)

*Figure 9: every journal starts in the centre, and stays far within the circle where it would touch. Design 1 makes the orbits larger.*

![Forces in joints A and B over a period](figures/replication_forces.png)

*Figure 10.*

![Best and mean objective of each generation](figures/replication_generations.png)

*Best and mean of the survivors of each generation of our searches, by the paper's sizes and rates: left with the correction, right the forces.*

![How far ours is from all printed numbers at once, over the speeds of both cranks](figures/replication_missing.png)

*The scan of the speeds, all else as assumed: factor by which ours misses the printed numbers; darkest: ten or more, or a run that fails. None of these meets them all.*

## The four-bar

CN106055749A, Bai, Zhao and Sun, *A method for improving the motion stability of linkages with clearance*, 2016. A double crank at
600 r/min, dry clearance of 0.5 mm between coupler and follower. Its formulas, tables and figures are lost in the text that is
known: lengths, their bounds, material, friction and eq. (8) are assumed. *Ours* are recorded answers of the studies that the rows
name, the first three of `fourbar_jitter` ([the methods compared](fourbar_methods.md)).

{table(HEAD, rows("patent"))}
![Angular acceleration of the follower before and after the optimisation, with clearance and ideal](figures/replication_jitter.png)

*The patent's figure 4: before and after.*
"""


def draw() -> None:
    """Write the figures of the page."""
    times = np.linspace(0.0, press_paper.DURATION, 2001)
    designs = {name: press_paper.columns(name, times) for name in (*press_paper.DESIGNS, "ours")}
    figures.write_motion(designs, FIGURES / "replication_motion.png")
    figures.write_orbits(designs, press_paper.CLEARANCE, FIGURES / "replication_orbits.png")
    figures.write_forces(designs, FIGURES / "replication_forces.png")
    figures.write_jitter(*patent_designs.motions("fourbar_jitter"), FIGURES / "replication_jitter.png")
    plain = press_paper.design_run("nominal").columns
    patched = {name: press_spike.patched_run(name).columns for name in press_paper.DESIGNS}
    figures.write_spike(plain, patched, press_paper.PRINTED["slider7.ax"], FIGURES / "replication_spike.png")
    figures.write_generations(
        {title: (label, found.model_dump()) for title, (label, found) in press_designs.searches().items()},
        FIGURES / "replication_generations.png",
    )
    figures.write_map(read("press_missing")["map"], press_missing.marked(), FIGURES / "replication_missing.png")
    rig, twice = press_paper.rig_run().columns, np.linspace(0.0, 2.0 * press_paper.DURATION, 2001)
    figures.write_rig(rig, press_paper.rig_ideal(twice), press_paper.RIG, FIGURES / "replication_rig.png")


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    draw()
