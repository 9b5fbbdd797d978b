"""A linkage that cannot turn fully: the run ends with a status, and what came before is kept."""

import json

import numpy as np
import pytest
from machines import four_bar

from linkages.cli.main import main
from linkages.engines.study import ideal
from linkages.errors import Status
from linkages.model.experiment import load

SPEED = 15.0  # rad/s
DRIVE = f"duration=0.2\n[drives.O]\nspeed={SPEED}\n"


@pytest.mark.slow
def test_a_crank_that_locks_ends_the_run_where_geometry_says(experiment_file, tmp_path, capsys):
    """Coupler and follower are stretched where the crank's tip is 0.3 m from the follower's pivot: cos(phi) = 1/3."""
    path = experiment_file(four_bar(ground=0.3, crank=0.2, coupler=0.15, follower=0.15), DRIVE)
    locked = pytest.approx(
        np.arccos(1.0 / 3.0) / SPEED, abs=0.02 / SPEED
    )  # the ideal motion's table has 0.02 rad
    motion = ideal(*load(path))
    assert motion.status in (Status.NO_ASSEMBLY, Status.SINGULAR)
    assert motion.time[-1] == locked
    out = tmp_path / "out"
    words = ["simulate", str(path), "--set", "solver.accuracy=1e-5", "--out", str(out), "--no-plots"]
    assert main(words) == 1
    told = capsys.readouterr().err
    assert "the run ended" in told
    assert f"the ideal linkage ended at t = {motion.time[-1]:.6g} s: {motion.status.value}" in told
    summary = json.loads((out / "summary.json").read_text())
    assert summary["status"] == "step-size-collapse"
    assert summary["duration"] == locked
    assert (
        out / "animation.html"
    ).exists()  # though the ideal linkage cannot be drawn where the run still is
