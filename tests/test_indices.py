"""Indices in kernels: taken as they are, so that none may be negative but constants."""

import os
import subprocess
import sys

import numba
import numpy as np
import pytest

from linkages.kernel import indices, kernel

RUNS = """
import linkages
for file, values in (("slider_crank_flexible.toml", {"duration": 0.01}), ("six_bar_dry.toml", {"duration": 0.01})):
    system = linkages.load(linkages.find_file(file), values)
    run, batch = linkages.simulate(system, "compiled"), linkages.simulate_batch(system, outputs=["A.force"])
    print(run.status.value, run.time[-1], batch.status[0].value)
"""


def _entry(values, k):
    return values[k]


def _last(values):
    return values[-1]


@kernel
def of_users(values, k):
    return values[k]


_entry.__module__ = _last.__module__ = indices.__name__
entry, last = kernel(_entry), kernel(_last)


@numba.njit
def of_others(values, k):
    return values[k]


def test_only_constants_count_from_the_end():
    values = np.arange(6.0)
    assert entry(values[3:], -1) == 2.0  # what stands before
    assert last(values) == 5.0
    assert of_users(values, -1) == 5.0
    assert of_others(values, -1) == 5.0


@pytest.mark.slow
def test_runs_ask_for_no_index_out_of_bounds(tmp_path):
    """Compiled with checks. That these are there is seen in a kernel that does ask."""
    (tmp_path / "beyond.py").write_text(
        "import numpy as np\nfrom linkages.kernel import kernel\n@kernel\ndef entry(values, k):\n    return values[k]\n"
        "for k in (-4, 3):\n    try:\n        entry(np.ones(3), k)\n    except IndexError:\n        print('refused')\n"
    )
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
