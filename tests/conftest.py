from pathlib import Path

import pytest

from linkages.data import data_folder
from linkages.experiment import load


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
