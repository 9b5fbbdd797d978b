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

Lu, Shi, Gao and Dan, *Elastic-dynamics of planar flexile parallel mechanism*, Transactions of the Chinese Society
for Agricultural Machinery 41(6), 2010, pp. 208-215. The paper gives no material; assumed here: \
{m.name}, E = {m.youngs_modulus:.3g} Pa,
{m.density:g} kg/m³, ν = {m.poisson:g}; the crank has the diameter d₁, the coupler d₂; crank roots held, where nothing else is said; \
{robot().model.elements} element in each link. What the paper prints wrongly, and the tests that show it, are [listed](misprints.md).

This page is written by `python docs/make_replication_3rrr.py`; [the summary](replication.md#summary) counts its rows. {LEGEND}
{table(HEAD, rows("robot"))}
The calculation of the row *0.35 MPa against millimetres*: a crank is clamped at A₂ and hinged at B₂, so its root
stress is σ = 3 E (d₁/2) δ / l₁² for a deflection δ of B₂; at the printed σ this is the first length. A coupler is
hinged at both ends and carries the platform by its axial force alone: σ l₂ / E is the second. The third takes the
model's own ratio of platform displacement to crank stress over the revolution.

The motion with vibration is that of `linkages modes three_rrr.toml --dynamic rest`.
"""


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
