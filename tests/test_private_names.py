"""Numba's private names: where they stand, how many, and that kernels give the same digits without them."""

import ast
import os
import subprocess
import sys
from pathlib import Path

import numba
import pytest

import linkages
import optim
from linkages.base.kernel import private

PUBLIC = {"numba", "numba.extending", "numba.types", "numba.typed", "numba.experimental"}
PACKAGES = [Path(package.__file__).parent for package in (linkages, optim)]
MOST = 16


def names_of(file):
    """Private names of numba that a module imports, and what it takes from them by names of numba's own."""
    found = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "numba":
            if node.module not in PUBLIC:
                found |= {alias.name for alias in node.names}
            elif node.module == "numba":
                found |= {alias.name for alias in node.names if not hasattr(numba, alias.name)}
        elif isinstance(node, ast.Import):
            found |= {a.name for a in node.names if a.name.split(".")[0] == "numba" and a.name not in PUBLIC}
    return found


def test_only_one_module_imports_private_names_and_its_table_lists_them():
    by_module = {file: names_of(file) for package in PACKAGES for file in package.rglob("*.py")}
    home = Path(private.__file__)
    assert {file for file, names in by_module.items() if names} == {home}
    text = home.read_text(encoding="utf-8").split('"""', 2)[2]
    assert by_module[home] <= set(private.NAMES)
    assert len(private.NAMES) <= MOST
    used = {
        node.attr for node in ast.walk(ast.parse(home.read_text(encoding="utf-8"))) if isinstance(node, ast.Attribute)
    }
    for name in private.NAMES:
        assert name in used or name in text or name == "_numba_type_", name


def test_private_attributes_of_numba_are_used_nowhere_else():
    """Attributes with an underscore that the package does not define itself."""
    defined, used = set(), {}
    for file in (file for package in PACKAGES for file in (package / "kernel").rglob("*.py")):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Attribute) and node.attr.startswith("_") and not node.attr.startswith("__"):
                used.setdefault(node.attr, set()).add(file.name)
                if isinstance(node.ctx, ast.Store) and isinstance(node.value, ast.Name) and node.value.id == "self":
                    defined.add(node.attr)
            elif isinstance(node, ast.FunctionDef):
                defined.add(node.name)
    foreign = set(used) - defined - {"_fields", "_exit", "_make", "_replace"}
    assert foreign <= set(private.NAMES), foreign - set(private.NAMES)


@pytest.mark.skipif(private.OFF, reason="nothing is compiled")
def test_another_layout_of_arrays_is_refused(monkeypatch):
    private._compare_words()
    monkeypatch.setattr(private, "array_words", lambda array, data, *rest: (0, 0, array.size, data, *sum(rest, ())))
    with pytest.raises(ImportError, match=r"^numba \S+ has another layout of arrays; install an earlier version$"):
        private._compare_words()


#: Kernels of every kind: named tuples by reference, laws at their addresses, lazy kernels of films; lanes, methods by
#: closures. A contact at B, and steps of van der Pol's oscillator. All kernels of a run take minutes to compile plainly.
COMPUTED = """
import numpy as np
from ivp_problems import VAN_DER_POL, take_steps
import linkages
from linkages.engines.drake.joint_forces import Rooms, joint_forces, placed
from linkages.mechanics.integrate.stepper import make_stepper
from linkages.mechanics.planar.contacts import PENETRATION, WIDTH

system = linkages.load(linkages.find_file("slider_crank_dry.toml"))
n = system.tree.size
places = np.arange(n)
state, forces = np.linspace(1e-3, 2e-3, 2 * n), np.zeros(n + WIDTH)
joint_forces(placed(system, places, places + n, places, n), Rooms(system).work, np.zeros((1, 2)), state, forces)
touches = forces[n + PENETRATION] > 0.0
problem, start = (np.array([1e3]), VAN_DER_POL, np.zeros(2)), np.array([2.0, 0.0])
end, error = take_steps(True, problem, make_stepper(2), 0.0, start, np.array([1e-4, 1e-3]), np.full(2, 1e-3), False)
found = [str(touches), forces.tobytes().hex(), end.tobytes().hex(), float(error).hex()]
"""
HIDDEN = """
import numba.core.runtime.nrt
del numba.core.runtime.nrt.rtsys  # as in a version of numba that has another name for it
"""
PLAIN = """
from linkages.base.kernel import private
assert private.problem
print(*found)
"""


@pytest.mark.slow
@pytest.mark.long
@pytest.mark.skipif(private.OFF, reason="nothing is compiled")
def test_a_numba_without_a_private_name_gives_the_same_digits(tmp_path):
    assert not private.problem
    own = {}
    exec(COMPUTED, own)
    assert own["touches"]
    assert own["error"] > 0.0
    path = os.pathsep.join(filter(None, [str(Path(__file__).parent), os.environ.get("PYTHONPATH")]))
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path), "PYTHONPATH": path}
    words = [sys.executable, "-c", HIDDEN + COMPUTED + PLAIN]
    done = subprocess.run(words, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == own["found"]
