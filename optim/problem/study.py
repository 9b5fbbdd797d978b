"""`Study`: variables, bounds, operating points, objectives and constraints, read from a file and checked."""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from linkages import System
from linkages.base.arrays import Array
from linkages.base.brief import Brief, counted
from linkages.input.files.formula import Formula
from linkages.system.identity import input_tables
from optim.problem.scatter import Scatter, content
from optim.problem.schema import Constraint, Objective, StudyFile


@dataclass(frozen=True)
class OperatingPoint:
    """A system that every design is run in, one of the `points` of a `Study`.

    Attributes
    ----------
    name : str
    system : System
        The system before a design is put in.
    paths : tuple of str
        Dotted paths that a design sets: variables, scattering values, linked values; of equal paths the last counts.
    links : tuple of Formula
        Formulas of the linked values.
    windows : dict of (nw, 2) arrays
        Starts and ends by name [s]; "run" is all of it.
    """

    name: str
    system: System
    paths: tuple[str, ...]
    links: tuple[Formula, ...]
    windows: dict[str, Array]


@dataclass(frozen=True, repr=False)
class Study(Brief):
    """A checked design study of n design variables; made by `optim.load_study`.

    Attributes
    ----------
    source : Path
        The study file.
    file : StudyFile
        Content of the file.
    sources : dict of str to str
        The comment after each value, by dotted path.
    names, paths : tuples of str
        Names and dotted paths of the variables.
    lower, upper, nominal : (n,) arrays
        Bounds and start, SI units.
    points : tuple of OperatingPoint
    formulas : dict of str to Formula
        By name of an objective or constraint.
    designs : dict of (n,) arrays
        Reference designs by name.
    usual : dict of str to float
        Values of the variables that a point's `paths` have, then of the scattering values, in their order: nominal
        ones, means of scattering ones. Those that are not among `names` keep them.
    scatter : Scatter or None
    """

    source: Path
    file: StudyFile
    sources: dict[str, str]
    names: tuple[str, ...]
    paths: tuple[str, ...]
    lower: Array
    upper: Array
    nominal: Array
    points: tuple[OperatingPoint, ...]
    formulas: dict[str, Formula]
    designs: dict[str, Array]
    usual: dict[str, float]
    scatter: Scatter | None = None

    def _facts(self) -> tuple[str, dict[str, str]]:
        objectives, constraints = self.file.objectives, self.file.constraints
        parts = counted(len(self.names), "variable"), counted(len(objectives), "objective")
        rows = {"file": self.source.name, "experiment": self.file.experiment}
        for name, path, low, high in zip(self.names, self.paths, self.lower, self.upper, strict=True):
            rows[f"variable {name}"] = f"{path}, {low:g} to {high:g}"
        rows |= {"objectives": ", ".join(map(self.label, objectives))}
        rows |= {"constraints": ", ".join(map(self.label, constraints)) or "none"}
        return f"{self.title}; {', '.join(parts)}, {counted(len(constraints), 'constraint')}", rows

    @property
    def title(self) -> str:
        """Return one line for tables and figures."""
        return self.file.title or self.source.stem

    @property
    def quantities(self) -> list[tuple[str, str, Objective | Constraint]]:
        """Return every objective, then every constraint: table, name, quantity."""
        return [("objectives", name, objective) for name, objective in self.file.objectives.items()] + [
            ("constraints", name, constraint) for name, constraint in self.file.constraints.items()
        ]

    @property
    def signs(self) -> list[float]:
        """Return for each objective -1 if it is maximised, else 1."""
        return [-1.0 if objective.maximise else 1.0 for objective in self.file.objectives.values()]

    def label(self, name: str) -> str:
        """Return the name of an objective or constraint, with its unit."""
        unit = self.unit(name)
        return f"{name} [{unit}]" if unit else name

    def unit(self, name: str) -> str:
        """Return the unit of an objective or constraint, empty for a pure number."""
        quantity = next(quantity for _, key, quantity in self.quantities if key == name)
        return "of nominal" if quantity.relative else quantity.unit

    def variable_label(self, path: str) -> str:
        """Return the path of a variable, with its unit."""
        unit = self.points[0].system.value_unit(path)
        return f"{path} [{unit}]" if unit not in ("", "1") else path

    def named(self, design: Array) -> dict[str, float]:
        """Return the values of all names in formulas: constants and, for this design (n,), all others."""
        return dict(self.file.constants) | self.usual | dict(zip(self.names, map(float, design), strict=True))

    def row(self, design: Array, point: OperatingPoint) -> list[float]:
        """Return the values of a point's `paths` for a design (n,)."""
        named = self.named(design)
        return [*(named[name] for name in self.usual), *(link(named) for link in point.links)]

    def system(self, design: Array, point: OperatingPoint | None = None) -> System:
        """Put a design into the system of an operating point.

        Parameters
        ----------
        design : (n,) array
        point : OperatingPoint, optional
            Default the first one.

        Raises
        ------
        InputError
            If a value is not valid.
        """
        point = point or self.points[0]
        return point.system.replaced(dict(zip(point.paths, self.row(design, point), strict=True)))

    def with_machines(self) -> Study:
        """Return the study whose designs have the scattering values after the variables; it needs `scatter`."""
        assert self.scatter is not None
        bounds, paths = self.scatter.bounds(), [self.file.scatter[name].path for name in self.scatter.names]
        return dataclasses.replace(
            self,
            names=(*self.names, *self.scatter.names),
            paths=(*self.paths, *paths),
            lower=np.concatenate([self.lower, bounds[0]]),
            upper=np.concatenate([self.upper, bounds[1]]),
            nominal=np.concatenate([self.nominal, self.scatter.means]),
        )

    def replaced(self, values: Callable[[System], Mapping[str, Any]]) -> Study:
        """Return the study with values replaced at every operating point.

        Parameters
        ----------
        values : callable
            From a point's system to values by dotted path.

        Raises
        ------
        InputError
            If a path or a value is not valid.
        """
        points = (
            dataclasses.replace(point, system=point.system.replaced(values(point.system))) for point in self.points
        )
        return dataclasses.replace(self, points=tuple(points))

    def description(self) -> dict[str, Any]:
        """Return everything that determines the numbers, as JSON types; the seed and the algorithm aside.

        A store can be resumed by a study of the same description, so its content must not change.
        """
        machine = self.points[0].system.description.machine_source
        return {
            "problem": self.file.model_dump(exclude={"title", "seed", "algorithm", "experiment", "designs"}),
            "scatter": {} if self.scatter is None else content(self.scatter),
            "lower": self.lower.tolist(),
            "upper": self.upper.tolist(),
            "nominal": self.nominal.tolist(),
            "machine": hashlib.sha256(machine.read_bytes()).hexdigest(),
            "experiments": {p.name: input_tables(p.system, without=("title",)) for p in self.points},
        }
