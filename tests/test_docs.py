"""Generated pages are fresh."""

import importlib.util
from pathlib import Path

DOCS = Path(__file__).resolve().parents[1] / "docs"


def test_the_list_of_experiment_keys_is_fresh():
    spec = importlib.util.spec_from_file_location("make_experiment", DOCS / "make_experiment.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    assert (DOCS / "experiment.md").read_text(encoding="utf-8") == module.markdown()
