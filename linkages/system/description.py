"""Names and files of a system, for tables, figures, errors and folders of results."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from linkages.input.model.experiment import Experiment
from linkages.input.model.mechanism import Mechanism


@dataclass(frozen=True)
class Description:
    """Names and files of a system.

    Attributes
    ----------
    title : str
        Title of the experiment; empty without one.
    source, machine_source : Path
        Files of the experiment and of the mechanism, which errors name.
    machine : str
        Name of the mechanism.
    units : str
        Units of tables and figures; empty: SI units.
    """

    title: str
    source: Path
    machine: str
    machine_source: Path
    units: str

    @property
    def stem(self) -> str:
        """Return the name of the experiment's file without its ending, from which folders of results are named."""
        return self.source.stem

    @property
    def heading(self) -> str:
        """Return the title, else the name of the experiment's file."""
        return self.title or self.stem


def description_of(mechanism: Mechanism, experiment: Experiment) -> Description:
    """Take the names and files from a mechanism and an experiment."""
    return Description(experiment.title, experiment.source, mechanism.name, mechanism.source, experiment.units)
