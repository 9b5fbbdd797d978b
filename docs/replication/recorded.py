"""Designs that a search found, kept with where they come from.

A search among random numbers, or over a rough objective, ends elsewhere when a last digit differs. What is said about
a design must not depend on that: the design is searched for once, written to a file of ``docs/replication/designs/``,
and all numbers about it are computed from there.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import tomlkit
from numpy.typing import NDArray
from pydantic import Field

from linkages import InputError
from linkages.input.files.toml import Finite, Table, read_toml, validate
from linkages.input.files.versions import versions
from linkages.input.files.writing import whole
from optim import Study, read_store

Array = NDArray[np.float64]


class Generations(Table):
    """Objective of the best design of each generation, and its mean over the generation's survivors."""

    best: list[Finite] = Field(description="in the order of the generations")
    mean: list[Finite] = Field(description="the same")


class Record(Table):
    """A design and its provenance."""

    study: str = Field(description="shipped study that it answers")
    command: str = Field(description="what searched for it, and does so again")
    algorithm: dict[str, Any] = Field(description="name and settings")
    seed: int = Field(ge=0, description="of the random numbers")
    evaluations: int = Field(ge=1, description="designs that the search evaluated")
    versions: dict[str, str] = Field(description="of the packages that determine the numbers")
    objectives: dict[str, Finite] = Field(description="when it was found, as the study means them")
    variables: dict[str, Finite] = Field(description="by dotted path, SI units")
    generations: Generations | None = Field(None, description="of a genetic algorithm, from its store")
    spread: list[Finite] | None = Field(
        None,
        description="least and largest objective at other tolerances and rounding, where a run has no three digits",
    )
    drake: dict[str, Finite] = Field(
        {}, description="objectives by Drake, which takes minutes, where they were computed"
    )

    def design(self, study: Study) -> Array:
        """Values of a study's variables, (n,).

        Raises
        ------
        InputError
            If the study varies other values than these.
        """
        if set(study.paths) != set(self.variables):
            raise InputError(study.source, "variables", f"are not those of the recorded {self.study}")
        return np.array([self.variables[path] for path in study.paths])


def path_of(name: str) -> Path:
    """File of a study's recorded design."""
    return Path(__file__).resolve().parent / "designs" / f"{name}.toml"


def load_record(name: str) -> Record:
    """Read the recorded design of a shipped study.

    Raises
    ------
    InputError
        If there is none, or its file is not right.
    """
    path = path_of(name)
    return validate(Record, read_toml(path)[0], path)


def generations(study: Study, path: Path) -> Generations | None:
    """Read the generations of a genetic algorithm of one objective from its store; None of another algorithm."""
    with read_store(path) as store:
        designs, found = store.evaluations()
        states = [json.loads(row.state) for row in store.iterations()]
    if not all("pool" in state for state in states):
        return None
    value = dict(zip(map(bytes, designs), found.objectives[:, 0], strict=True))
    width = study.upper - study.lower
    values = []
    for state in states:
        survivors = np.clip(study.lower + np.array(state["pool"]) * width, study.lower, study.upper)
        values.append([float(value[bytes(design)]) for design in survivors])
    return Generations(best=[row[0] for row in values], mean=[float(np.mean(row)) for row in values])


def write_record(study: Study, result: Mapping[str, Any], command: str, passed: Generations | None = None) -> Path:
    """Keep the best design of a shipped study.

    Parameters
    ----------
    study : Study
    result : mapping
        ``best``, ``algorithm``, ``seed`` and ``evaluations`` as in ``result.json``.
    command : str
        What searched for it.
    passed : Generations, optional
        Of the search.
    """
    given = {key: result[key] for key in ("algorithm", "seed", "evaluations")}
    best = {key: result["best"][key] for key in ("objectives", "variables")}
    record = Record(
        study=study.source.stem, command=command, versions=versions("pygad"), generations=passed, **given, **best
    )
    return save(record)


def save(record: Record) -> Path:
    """Write a record to its file."""
    document = tomlkit.document()
    document.add(tomlkit.comment(f"Written by `{record.command}`."))
    document.update({key: value for key, value in record.model_dump(exclude_none=True).items() if value != {}})
    path = path_of(record.study)
    with whole(path) as partial:
        partial.write_text(tomlkit.dumps(document), encoding="utf-8")
    return path
