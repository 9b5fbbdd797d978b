"""Systems from files."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from linkages.base.errors import ARGUMENT
from linkages.input.files.toml import read_toml
from linkages.input.model.check import names_first, without_lost_outputs
from linkages.input.model.experiment import load_experiment
from linkages.input.model.mechanism import Mechanism, faults_of_values, load_mechanism
from linkages.system.system import System


def load(path: str | Path, overrides: Mapping[str, Any] | None = None, origin: str = ARGUMENT) -> System:
    """Read an experiment and its mechanism, and check their consistency.

    Parameters
    ----------
    path : str or Path
        The TOML file.
    overrides : mapping, optional
        Values by dotted path that override the files; see `System.replaced`.
    origin : str
        Origin of the overrides, named in errors and as the source of their values.

    Raises
    ------
    InputError
        If the input is invalid: one line with file, element or key, and reason.

    Examples
    --------
    >>> import linkages
    >>> system = linkages.load(linkages.find_file("seven_bar.toml"), {"duration": 0.5})
    >>> system.experiment.duration
    0.5
    """
    with names_first(lambda: _mechanism_of(Path(path), overrides or {})):
        experiment = load_experiment(path, overrides, origin)
    with faults_of_values(experiment):
        mechanism = load_mechanism(experiment.mechanism_path, experiment.sdf_overrides)
    return System(mechanism, without_lost_outputs(mechanism, experiment, overrides or ()))


def _mechanism_of(path: Path, overrides: Mapping[str, Any]) -> Mechanism:
    """Return the mechanism of an experiment's file that may be faulty."""
    data = read_toml(path)[0] | dict(overrides)
    return load_mechanism(path.parent / str(data.get("mechanism", "")))
