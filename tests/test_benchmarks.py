"""All imports of benchmarks and page generators exist; their measurements are never asserted."""

import importlib.util
import re
from pathlib import Path

import numpy as np
import pytest
from seven_bar_reference import free_motion

from linkages.engines.compiled.run.equations import derivatives
from linkages.engines.compiled.run.runner import Runner

ROOT = Path(__file__).resolve().parents[1]
#: What scripts share.
ALSO = {"laws_page", "seven_bar_reference"}
SCRIPTS = sorted(path for folder in ("benchmarks", "docs") for path in (ROOT / folder).glob("*.py"))


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.name)
def test_script_can_be_loaded(path):
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    if "__main__" not in path.read_text(encoding="utf-8"):
        assert path.stem in ALSO
        return
    name = path.relative_to(ROOT).as_posix()
    assert f"python {name}" in module.__doc__
    for page in re.findall(r"docs/\w+\.md", module.__doc__):
        assert name in (ROOT / page).read_text(encoding="utf-8"), page


@pytest.mark.slow
def test_the_equations_that_benchmarks_hand_to_other_integrators_are_the_engine_s(seven_bar):
    motion, runner = free_motion(seven_bar), Runner(seven_bar)
    state = motion.start + 1e-6 * np.cos(np.arange(len(motion.start)))
    expected = np.empty_like(state)
    derivatives(runner.aside(), 0.1, state, expected)
    np.testing.assert_allclose(motion.rates(0.1, state), expected, rtol=1e-9)
