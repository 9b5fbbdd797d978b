"""The page of the paper's results and ours."""

from __future__ import annotations

import re
from pathlib import Path

import make_replication_3rrr
import numpy as np
import pytest
import replicate
from replication.claims import differences
from replication.computed import read
from replication.robot_elastic import first_mode
from replication.robot_runs import PRINTED_CRANK, PRINTED_ERROR, PRINTED_SHEAR, stress_bound
from replication.robot_soft import energies, free, held

from linkages.three_rrr.analysis import RobotResults
from linkages.three_rrr.modes import frequencies

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


@pytest.mark.slow
def test_page_is_fresh() -> None:
    """Regenerate with ``python docs/make_replication_3rrr.py``. One unit of the last digit for each rounding."""
    written = make_replication_3rrr.PAGE.read_text(encoding="utf-8")
    assert differences(written, make_replication_3rrr.page()) == []


def test_a_row_is_repeated_by_its_section(capsys: pytest.CaptureFixture[str]) -> None:
    """Cells of the page come out again; a name that is none gets one line."""
    assert replicate.main(["robot.formulas"]) == 0
    printed = capsys.readouterr().out
    page = (DOCS / "replication_3rrr.md").read_text(encoding="utf-8")
    cells = dict(re.findall(r"^(claim|verdict) {2,}(.+)$", printed, re.MULTILINE))
    assert printed.count("verdict  ") == 4
    assert re.search(rf"^\| {re.escape(cells['claim'])} \| .* \| {cells['verdict']} \|$", page, re.MULTILINE)
    assert replicate.main(["robot.formula"]) == 2
    error = capsys.readouterr().err
    assert error == 'docs/replicate.py: "robot.formula" is no section; did you mean "robot.formulas"?\n'


def test_strain_energies_of_the_bodies_add_up(results: RobotResults) -> None:
    """Cranks, couplers and platform together hold the potential energy u K u/2; none holds less than nothing."""
    model, state = results.model, results.motion.part(slice(0, 3))
    stiffness, _ = model.matrices(state)
    u = np.random.default_rng(1).normal(size=(len(state), model.size)) * 1e-6
    found = energies(model, state, model.expand(state, u))
    np.testing.assert_allclose(found.sum(axis=1), 0.5 * np.einsum("ni,nij,nj->n", u, stiffness, u), rtol=1e-10)
    assert (found > 0.0).all()


def test_first_frequency_between_the_default_poses(results: RobotResults) -> None:
    """Finer poses do not change its largest value; at the default poses it is 0.1 Hz lower."""
    found = first_mode(results)
    peak = results.branch.motion(np.linspace(3.9, 4.5, 5001))
    assert found.max() == pytest.approx(frequencies(results.model, peak, 1).max(), abs=5e-3)
    assert found.max() == pytest.approx(344.93, abs=5e-3)
    assert results.frequencies[:, 0].max() < found.max() - 0.05


def test_modes_of_held_roots_bend_the_cranks_first() -> None:
    """A held crank is soft in bending; free roots carry no moment, and the long couplers bend: shares by mode."""
    roots_held, roots_free = held(), free()
    assert min(roots_held.crank[:2]) > 0.7
    assert min(roots_free.coupler) > 0.7
    for shares in (roots_held, roots_free):
        np.testing.assert_allclose(np.sum(shares[:3], axis=0), 1.0, rtol=1e-12)


def test_the_agreement_of_two_factors_is_accidental() -> None:
    """Crank stress and platform shear miss the print by one factor at one time step, start and assembly only."""
    factors = {
        name: (PRINTED_CRANK / row["crank"], PRINTED_SHEAR / row["shear"])
        for name, row in read("robot_factors").items()
    }
    apart = {name: abs(a / b - 1.0) for name, (a, b) in factors.items()}
    assert apart["20 steps in a period"] < 1e-3
    assert min(value for name, value in apart.items() if name != "20 steps in a period") > 5e-3
