"""Compare a run with kernels that numba's documented interface compiles alone: ``python benchmarks/plain_numba.py``.

As with a version of numba that has lost one of the private names of `kernel.private`: same digits, a longer
first compilation. A test compares kernels of every kind (tests/test_private_names.py); this is a whole run, whose
plain compilation takes minutes.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time

RUN = """
import linkages
from linkages.base.kernel import private
system = linkages.load(linkages.find_file("slider_crank_dry.toml"), {"duration": 0.02})
run = linkages.simulate(system, "compiled")
print(private.problem or "none", run.status.value, *(run[name].tobytes().hex() for name in run.columns), sep="\\n")
"""
HIDDEN = "import numba.core.runtime.nrt\ndel numba.core.runtime.nrt.rtsys\n"


def main() -> int:
    """Print times of the first runs, and whether all columns are equal; the exit status is 1 if they are not."""
    argparse.ArgumentParser(description=__doc__.split(":")[0]).parse_args()
    found = []
    for before in ("", HIDDEN):
        with tempfile.TemporaryDirectory() as cache:
            begun = time.perf_counter()
            environment = os.environ | {"NUMBA_CACHE_DIR": cache}
            words = [sys.executable, "-c", before + RUN]
            done = subprocess.run(words, env=environment, capture_output=True, text=True, check=True)
        lines = done.stdout.splitlines()
        print(f"missing name: {lines[0]}; first run {time.perf_counter() - begun:.0f} s, status {lines[1]}")
        found.append(lines[1:])
    same = found[0] == found[1]
    print(f"{len(found[0]) - 1} columns: {'the same digits' if same else 'DIFFERENT'}")
    return int(not same)


if __name__ == "__main__":
    sys.exit(main())
