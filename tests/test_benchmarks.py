"""Every benchmark and page generator still finds what it imports; what they measure is never asserted."""

import importlib.util
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
#: What scripts share.
ALSO = {"seven_bar_reference"}
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
