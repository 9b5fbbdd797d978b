"""Write docs/replication_3rrr.md: ``python docs/make_replication_3rrr.py``."""

from __future__ import annotations

from pathlib import Path

from replication.claims import table
from replication.robot_runs import robot
from replication.verdicts import HEAD, LEGEND, rows

PAGE = Path(__file__).with_name("replication_3rrr.md")


def page() -> str:
    """Return the whole page."""
    m = robot().material
    return f"""# Replication: the flexible 3-RRR robot

For readers who want evidence: printed results of Lu, Shi, Gao and Dan, *Elastic-dynamics of planar flexile parallel mechanism*, Transactions of the Chinese Society
for Agricultural Machinery 41(6), 2010, pp. 208-215, compared with results of [`linkages modes`](flexible_3rrr.md). `python docs/make_replication_3rrr.py` writes this page;
[the summary](replication.md#summary) counts its rows; [misprints](misprints.md) lists the errors of the paper.

Assumptions: the paper gives no material; used here: {m.name}, E = {m.youngs_modulus:.3g} Pa,
{m.density:g} kg/m³, ν = {m.poisson:g}. The crank has the diameter d₁, the coupler d₂; crank roots are held unless stated otherwise; \
{robot().model.elements} element in each link.

## How rows are judged

{LEGEND}
## Comparison

{table(HEAD, rows("robot"))}
The calculation of the row *0.35 MPa against millimetres*: a crank is clamped at A₂ and hinged at B₂, so its root
stress is σ = 3 E (d₁/2) δ / l₁² for a deflection δ of B₂; the first length is this deflection at the printed σ. A coupler is
hinged at both ends and carries the platform by its axial force alone: the second length is σ l₂ / E. The third length uses the
model's ratio of platform displacement to crank stress over the revolution.

`linkages modes three_rrr.toml --dynamic rest` computes the motion with vibration.
"""


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
