from pathlib import Path

import pytest
from hypothesis import settings

from linkages.files.shipped import data_folder
from linkages.model.experiment import load

# Compiled functions are compiled at their first call: no deadline. The same examples in every run: a failure is one
# that can be repeated; searching for new ones is `pytest --hypothesis-profile=default`.
settings.register_profile("repeatable", deadline=None, derandomize=True)
settings.load_profile("repeatable")


@pytest.fixture(scope="session")
def seven_bar():
    """The shipped seven-bar: (mechanism, experiment)."""
    return load(data_folder() / "seven_bar.toml")


@pytest.fixture
def experiment_file(tmp_path):
    """Write an SDF text and a TOML text into a folder; returns the path of the TOML file."""

    def write(sdf: str, toml: str) -> Path:
        (tmp_path / "machine.sdf").write_text(sdf)
        path = tmp_path / "experiment.toml"
        path.write_text('mechanism = "machine.sdf"\n' + toml)
        return path

    return write
