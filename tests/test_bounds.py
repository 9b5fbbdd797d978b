"""Kernels use no index out of bounds: compiled with checks (NUMBA_BOUNDSCHECK=1) they report none."""

import os
import subprocess
import sys

import pytest

RUNS = """
import linkages
for file, values in (("slider_crank_flexible.toml", {"duration": 0.01}), ("six_bar_dry.toml", {"duration": 0.01})):
    system = linkages.load(linkages.find_file(file), values)
    run, batch = linkages.simulate(system, "compiled"), linkages.simulate_batch(system, outputs=["A.force"])
    print(run.status.value, run.time[-1], batch.status[0].value)
"""
BEYOND = """
import numpy as np
from linkages.base.kernel import kernel
@kernel
def entry(values, k):
    return values[k]
for k in (-4, 3):
    try:
        entry(np.ones(3), k)
    except IndexError:
        print('refused')
"""


@pytest.mark.slow
@pytest.mark.long
def test_runs_ask_for_no_index_out_of_bounds(tmp_path):
    """A kernel that does ask shows that the checks are there."""
    (tmp_path / "beyond.py").write_text(BEYOND)
    (tmp_path / "runs.py").write_text(RUNS)
    environment = os.environ | {"NUMBA_BOUNDSCHECK": "1", "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    found = [
        subprocess.run([sys.executable, name], cwd=tmp_path, env=environment, capture_output=True, text=True)
        for name in ("beyond.py", "runs.py")
    ]
    assert [(done.stdout, done.stderr) for done in found] == [
        ("refused\nrefused\n", ""),
        ("ok 0.01 ok\nok 0.01 ok\n", ""),
    ]
