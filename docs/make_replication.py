"""Write docs/replication.md and its figures: ``python docs/make_replication.py``."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from replication import figures, patent_claims, press_claims, press_designs, press_paper
from replication.claims import WITHIN, Claim, table

PAGE = Path(__file__).with_name("replication.md")
FIGURES = Path(__file__).with_name("figures")


def page() -> str:
    """Return the whole page."""
    return f"""# Replication of the published results

What two sources print, beside what this package computes from the same data. `python docs/make_replication.py` writes this page;
its numbers are computed when it is written, and its verdicts follow from them. Designs of ours were searched for once, and are
kept with their provenance in `docs/replication/designs/`:

- *reproduced*: within {100 * WITHIN:.0f} % of the printed value; what an optimisation lowers, also by more than is printed;
- *trend only*: a value within a factor of two; a change with the printed sign and at least a tenth of it;
- *not reproducible*: neither; the reason says whether data are missing, or what the number is instead;
- *wrong as printed*: contradicts itself, or mechanics.

The robot of the third source has [a page of its own](replication_3rrr.md).

## The press

Chen, Wang and Wang, *Dynamics optimization design of multi-link mechanisms with lubrication clearances of revolute joints*, China
Mechanical Engineering 36(1), 2025, 87-95. Clearance 0.3 mm (rig: 0.2 mm); both cranks turn at 2π rad/s from t = 0 with the journals
centred, 1 s. The paper gives neither the speeds nor the start; these are assumed.

{table(Claim._fields, press_claims.claims())}
### Designs

All by our runs. *Ours* is the recorded answer of `sevenbar_force` (eq. (24)).

{table(*press_designs.designs_table())}
### Figures

![Displacement, velocity and acceleration of the slider for the four designs, and their differences](figures/replication_motion.png)

*The paper's figures 6 to 8: the designs cannot be told apart; on the right what they differ by, from 10 ms after the start.*

![Paths of the journals in joints A and B](figures/replication_orbits.png)

*Figure 9: every journal starts in the centre. Design 1 makes the orbits larger, not smaller.*

![Forces in joints A and B over a period](figures/replication_forces.png)

*Figure 10.*

## The four-bar

CN106055749A, Bai, Zhao and Sun, *A method for improving the motion stability of linkages with clearance*, 2016. A double crank at
600 r/min, dry clearance of 0.5 mm between coupler and follower. *Ours* is the best design that was found for the study
`fourbar_jitter` ([the methods compared](fourbar_methods.md)).

{table(Claim._fields, patent_claims.claims())}
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
    figures.write_jitter(*map(patent_claims.motions, (False, True)), FIGURES / "replication_jitter.png")


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    draw()
