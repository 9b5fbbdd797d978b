"""Write docs/replication_3rrr.md and its figure: ``python docs/make_replication_3rrr.py``."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from replication.claims import table
from replication.figures import write_robot
from replication.robot_runs import results, robot
from replication.verdicts import BRIEF, Number, brief, claims

from linkages.three_rrr.modes import frequencies

PAGE = Path(__file__).with_name("replication_3rrr.md")
FIGURE = Path(__file__).with_name("figures") / "replication_robot.png"
SHOWN = 4  # modes of the figure


def page() -> str:
    """Return the whole page."""
    m = robot().material
    return f"""# Replication: the flexible 3-RRR robot

For readers who want evidence: printed results of Lu, Shi, Gao and Dan, *Elastic-dynamics of planar flexile parallel mechanism*, Transactions of the
Chinese Society for Agricultural Machinery 41(6), 2010, 208-215, compared with results of [`linkages modes`](flexible_3rrr.md). The
[appendix](replication_details.md#the-robot) has rule, causes and commands, [replication](replication.md) the counts.
`python docs/make_replication_3rrr.py` writes this page.

The paper gives no material; used here: {m.name}, E = {m.youngs_modulus:.3g} Pa, {m.density:g} kg/m³, ν = {m.poisson:g}. The crank has the diameter
d₁, the coupler d₂; crank roots are held unless stated otherwise; {robot().model.elements} element in each link.

**Holds.** The position equation and the acceleration formula are right, the time recursion is sound if modes keep their order and sign, the
operating speeds are far below the natural frequencies, and the largest stress is in the driven crank.

**Holds in part.** One element per link is accurate for the lowest modes only; the long couplers are soft in the higher modes, the cranks in the
lowest three.

**Does not hold.** Four assemblies exist during a part of the revolution only. Inertia forces, axial, bending and shear stress are wrong as printed. The
printed millimetres and the printed 0.35 MPa exclude each other: at this stress the platform of a steel robot moves by less than a micrometre.

**Open.** All printed displacements are 10⁴ to 10⁵ times ours, all stresses 5 to 130 times. No single assumption about material,
diameters, assembly, roots or printed formulas explains them. With free crank roots the recursion drifts past the printed millimetres within a second, a possible origin.

![Natural frequencies over the revolution, and printed over our numbers](figures/replication_robot.png)

*Left: the lowest {SHOWN} natural frequencies, roots held (figure 9). Right: printed values over ours.*

{table(BRIEF, brief("robot"))}"""


def draw() -> None:
    """Write the figure."""
    found = results()
    times = np.linspace(0.0, found.branch.times[-1], 1001)
    ratios = {
        claim.claim.rpartition(", fig")[0].removeprefix("elastic "): abs(number.printed / number.ours)
        for _, claim in claims("robot", ["displacement", "stress"])
        for number in claim.numbers
        if isinstance(number, Number) and claim.kind == "number" and "fig." in claim.claim
    }
    write_robot(times, frequencies(found.model, found.branch.motion(times), SHOWN), ratios, FIGURE)


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    draw()
