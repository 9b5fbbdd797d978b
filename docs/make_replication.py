"""Write docs/replication.md and its figures: ``python docs/make_replication.py``."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from replication import figures, patent_designs, press_conditions, press_designs, press_ideal, press_paper, press_spike
from replication.claims import table
from replication.measured import read
from replication.summary import summary
from replication.verdicts import HEAD, LEGEND, rows

PAGE = Path(__file__).with_name("replication.md")
FIGURES = Path(__file__).with_name("figures")
#: Speeds of the drawn maps [rad/s].
SPEEDS = np.arange(-13.0, 13.25, 0.5)


def page() -> str:
    """Return the whole page."""
    return f"""# Replication of the published results

For readers who want evidence: the printed results of three sources compared with results of this package from the same data, claim by
claim. The [robot](replication_3rrr.md) of the third source and the [misprints](misprints.md) have separate pages.
`python docs/make_replication.py` writes this page.

{summary()}
## How rows are judged

{LEGEND}
`docs/replication/designs/` contains the designs found by this package, with their provenance.

## The press

Chen, Wang and Wang, *Dynamics optimization design of multi-link mechanisms with lubrication clearances of revolute joints*, China
Mechanical Engineering 36(1), 2025, 87-95. Clearance 0.3 mm (rig: 0.2 mm); 1 s from the start, forces in the printed windows. All runs
use `seven_bar_paper.toml`; its gravity, speeds, ε₀ and m are fitted to ten printed numbers (see [conditions](#conditions)).

{table(HEAD, rows("press"))}
### Conditions

The paper prints no gravity, no drive speeds, no start, no ε₀ and no m. Ten printed numbers depend on them: six largest forces in their
windows, three accelerations at the start and the largest acceleration computed for the rig. `python docs/make_conditions.py` computes the
tables of this section (about twenty minutes) and stores them in `docs/replication/measured/press_conditions.json`.

Deviation of the six forces alone, for the ideal press at 105 × 105 pairs of speeds within ±13 rad/s (root mean square of the logarithms; at rest:
eq. (22) with α = β = 50 accelerates the cranks within 0.1 s):

{table(*press_conditions.maps_table())}
![Deviation of the ideal press from the six printed forces, over both speeds](figures/replication_conditions.png)

*Outlined: below 5 % (orange) and below 10 % (white); darkest: 60 % and more.*

With gravity along -y many pairs of speeds meet the forces; with gravity along +y only pairs at which the slider has ten times the printed
acceleration; with gravity along x no pair. The rows "all ten numbers at once" above give the best conditions of each scenario. The next table holds
one unknown and fits the others again, by a local search from the neighbouring value (an upper bound):

{table(*press_conditions.profiles_table())}
![Smallest deviation of all ten numbers with one unknown held](figures/replication_profiles.png)

*Vertical lines: the values of `seven_bar_paper.toml`.*

Round speeds, gravity along -y, without eqs. (12)-(13):

{table(*press_conditions.natural_table())}
{press_conditions.conclusion()}

### Designs

All numbers come from runs of this package. *Ours* is the recorded result of `sevenbar_paper_force` (eq. (24)).

{table(*press_designs.designs_table())}
### Figures

![Displacement, velocity and acceleration of the slider for the four designs, and their differences](figures/replication_motion.png)

*The paper's figures 6 to 8: the curves of the designs coincide; the right column shows their differences, from 10 ms after the start.*

![Acceleration of the slider at the start with the small-eccentricity correction](figures/replication_spike.png)

*Figure 8: left the first 50 ms, right the first 0.1 ms, in which the film stops the falling journals.*

![Acceleration of the slider on the rig, ideal and with clearance](figures/replication_rig.png)

*Figure 5: clearance of the rig, 2 s; dashed: largest values of the printed experiment and computation.*

![Paths of the journals in joints A and B](figures/replication_orbits.png)

*Figure 9: every journal starts in the centre and stays within the clearance circle. The orbits of design 1 are larger.*

![Forces in joints A and B over a period](figures/replication_forces.png)

*Figure 10.*

![Best and mean objective of each generation](figures/replication_generations.png)

*Best and mean objective of the survivors of each generation, with the population and rates of the paper: acceleration (left), forces (right).*

## The four-bar

CN106055749A, Bai, Zhao and Sun, *A method for improving the motion stability of linkages with clearance*, 2016. A double crank at
600 r/min, dry clearance of 0.5 mm between coupler and follower. Its formulas, tables and figures are lost in the available
text: lengths, bounds, material, friction and eq. (8) are assumed. *Ours* are recorded results of the named studies, by default
`fourbar_jitter` ([comparison of methods](fourbar_methods.md)). Dry runs are chaotic: intervals are the 5 % and 95 % quantiles over start angles
(`docs/replication/dry.py`). *At the start* refers to the first revolutions, as in the patent's example, *running* to later ones.

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
    figures.write_maps(SPEEDS, _maps(), _marked(), FIGURES / "replication_conditions.png")
    figures.write_profiles(
        read("press_conditions")["profiles"], press_conditions.best()._asdict(), press_conditions.LABELS,
        FIGURES / "replication_profiles.png",
    )  # fmt: skip
    rig, twice = press_paper.rig_run().columns, np.linspace(0.0, 2.0 * press_paper.DURATION, 2001)
    figures.write_rig(rig, press_paper.rig_ideal(twice), press_paper.RIG, FIGURES / "replication_rig.png")


def _maps() -> dict[str, press_paper.Array]:
    """Deviations of the forces over `SPEEDS` by title."""
    found = {}
    for gravity, start in (("none", "moving"), ("-y", "moving"), ("-y", "at rest"), ("+y", "moving")):
        values = press_ideal.grid(SPEEDS, press_ideal.GRAVITY[gravity], start == "at rest")
        found[f"gravity {gravity}, start {start}"] = press_ideal.deviation(
            values.reshape(-1, values.shape[-1])
        ).reshape(len(SPEEDS), -1)
    return found


def _marked() -> dict[str, tuple[float, float]]:
    """Speeds of the map's marks by name."""
    found = {"seven_bar_paper.toml": press_conditions.best(), "seven_bar.toml": press_conditions.ASSUMED}
    return {name: (guess.omega_1, guess.omega_4) for name, guess in found.items()}


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    draw()
