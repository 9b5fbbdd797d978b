"""The page of what the paper prints beside ours."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from replication.claims import differences
from replication.three_rrr import PRINTED_CRANK, PRINTED_ERROR, Row, page, rows, stress_bound

from linkages.three_rrr.results import RobotResults
from linkages.three_rrr.robot import Robot

DOCS = Path(__file__).resolve().parents[2] / "docs"


def test_printed_displacements_contradict_the_printed_stress(results: RobotResults) -> None:
    """At 0.35 MPa the platform moves by less than 3 um; the paper prints more than 6 mm."""
    bound = stress_bound(results)
    e, d, length = 2.06e11, 0.03, 0.112
    moment = PRINTED_CRANK * np.pi * d**3 / 32
    assert bound.crank == pytest.approx(moment * length**2 / (3 * e * np.pi * d**4 / 64), rel=1e-12)
    assert max(bound.crank, bound.axial, bound.platform) < 3e-6
    assert min(PRINTED_ERROR[:2]) > 2000 * max(bound.crank, bound.axial, bound.platform)
    assert np.max(np.abs(results.static.platform[:, :2])) < 1e-6


@pytest.fixture(scope="module")
def table(robot: Robot) -> list[Row]:
    return rows(robot)


@pytest.mark.slow
def test_page_is_fresh(robot: Robot, table: list[Row]) -> None:
    """Regenerate with ``python docs/make_replication_3rrr.py``. One unit of the last digit for each rounding."""
    written = (DOCS / "replication_3rrr.md").read_text(encoding="utf-8")
    assert differences(written, page(robot, table)) == []


@pytest.mark.slow
def test_rows_are_complete(table: list[Row]) -> None:
    assert len(table) >= 15
    for row in table:
        for cell in (row.quantity, row.printed, row.ours, row.verdict):
            assert cell
            assert "|" not in cell
            assert "nan" not in cell
    printed = " ".join(row.printed for row in table)
    for number in ("6.456 mm", "9.158 mm", "1.263 deg", "346.7 kPa", "138 kPa", "2.708 kPa"):
        assert number in printed
