"""Numba's private names: where they stand, how many, and that a numba without them is refused."""

import ast
import subprocess
import sys
import tomllib
from pathlib import Path

import numba
import pytest

import linkages
import optim
from linkages.base.kernel import private

PUBLIC = {"numba", "numba.extending", "numba.types", "numba.typed", "numba.experimental"}
PACKAGES = [Path(package.__file__).parent for package in (linkages, optim)]
MOST = 17


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
        assert name in used or name in text or name in ("_numba_type_", "_dmm"), name


def test_private_attributes_of_numba_are_used_nowhere_else():
    """Attributes with an underscore that the package does not define itself."""
    defined, used = set(), {}
    for file in (file for package in PACKAGES for file in package.rglob("*.py")):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Attribute) and node.attr.startswith("_") and not node.attr.startswith("__"):
                used.setdefault(node.attr, set()).add(file.name)
                if isinstance(node.ctx, ast.Store) and ast.unparse(node.value) == "self":
                    defined.add(node.attr)
            elif isinstance(node, ast.FunctionDef):
                defined.add(node.name)
            elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):  # a field of a class
                defined.add(node.target.id)
    argparse_and_python = {
        "_asdict",
        "_fields",
        "_exit",
        "_make",
        "_replace",
        "_AppendAction",
        "_actions",
        "_option_string_actions",
    }
    foreign = set(used) - defined - argparse_and_python
    assert foreign, "the search finds nothing"
    assert foreign <= set(private.NAMES), foreign - set(private.NAMES)


@pytest.mark.skipif(private.OFF, reason="nothing is compiled")
def test_another_layout_of_arrays_is_refused(monkeypatch):
    private._compare_words()
    monkeypatch.setattr(private, "array_words", lambda array, data, *rest: (0, 0, array.size, data, *sum(rest, ())))
    with pytest.raises(ImportError, match=r"^numba \S+ is not supported; run "):
        private._compare_words()


def test_a_numba_without_a_private_name_or_of_an_untested_version_is_refused_in_one_line(tmp_path):
    for change in ("del numba.core.runtime.nrt.rtsys", "numba.__version__ = '0.99.1'", "numba.__version__ = '0.61.2'"):
        text = f"import sys, numba.core.runtime.nrt\n{change}\nfrom linkages.cli.main import main\nsys.exit(main(sys.argv[1:]))"
        words = [sys.executable, "-c", text, "simulate", "slider_crank.toml", "--out", str(tmp_path / "out")]
        done = subprocess.run(words, capture_output=True, text=True)
        version = change.partition("'")[2].rstrip("'") or numba.__version__
        assert done.stderr == f'failed: numba {version} is not supported; run `pip install "numba>=0.62,<0.69"`\n'
        assert done.returncode == 1


def test_the_versions_of_numba_that_are_not_refused_are_those_of_the_package(request):
    with open(request.config.rootpath / "pyproject.toml", "rb") as file:
        needed = tomllib.load(file)["project"]["dependencies"]
    assert "numba>={},<{}".format(*private.TESTED) in needed
