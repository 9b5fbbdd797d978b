"""A design problem from its file: variables, bounds, operating points, objectives, constraints, all checked.

Values keep their units (SI). The comment beside a value of the file is its source, as in experiments.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.errors import InputError, nearest
from linkages.files.toml import leaves, read_toml, validate
from linkages.model.experiment import Experiment, check, load_experiment
from linkages.model.mechanism import Mechanism, load_mechanism
from optim.problem import formula
from optim.problem.formula import Formula
from optim.problem.nominal import value_at
from optim.problem.outputs import check_output, known_outputs
from optim.problem.schema import Constraint, Objective, Point, StudyFile, Window
from optim.problem.shipped import find_experiment

Array = NDArray[np.float64]


@dataclass(frozen=True)
class OperatingPoint:
    """An experiment to be run for every design.

    Attributes
    ----------
    paths : tuple of str
        What a design sets: the variables, then what is linked to them; of equal ones the last counts.
    links : tuple of Formula
        Of the linked paths.
    windows : dict of (nw, 2) arrays
        Times by name [s]; "run" is all of it.
    """

    name: str
    mechanism: Mechanism
    experiment: Experiment
    paths: tuple[str, ...]
    links: tuple[Formula, ...]
    windows: dict[str, Array]


@dataclass(frozen=True)
class Study:
    """A checked design problem.

    Attributes
    ----------
    source : Path
        The file.
    file : StudyFile
        What it says.
    sources : dict
        The comment beside each value, by dotted path.
    names, paths : tuples of str
        Of the n design variables.
    lower, upper, nominal : (n,) arrays
        Bounds and start.
    points : tuple of OperatingPoint
    formulas : dict
        By name of an objective or constraint.
    designs : dict of (n,) arrays
        Reference designs by name.
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

    @property
    def title(self) -> str:
        """One line for tables and figures."""
        return self.file.title or self.source.stem

    def named(self, design: Array) -> dict[str, float]:
        """Values of everything that formulas may name: constants and, for this design (n,), variables."""
        return dict(self.file.constants) | dict(zip(self.names, map(float, design), strict=True))

    def description(self) -> dict[str, Any]:
        """Everything that determines the numbers, as JSON types; the seed and the algorithm aside."""
        return {
            "problem": self.file.model_dump(exclude={"title", "seed", "algorithm", "experiment", "designs"}),
            "lower": self.lower.tolist(),
            "upper": self.upper.tolist(),
            "nominal": self.nominal.tolist(),
            "machine": hashlib.sha256(self.points[0].mechanism.source.read_bytes()).hexdigest(),
            "experiments": {p.name: p.experiment.model_dump(exclude={"title"}) for p in self.points},
        }


def load_study(path: str | Path) -> Study:
    """Read a study, its experiment and its mechanism, and check that they fit each other.

    Raises
    ------
    InputError
        One line with file, key and reason.
    """
    path = Path(path)
    data, sources = read_toml(path)
    file = validate(StudyFile, data, path)
    experiment = load_experiment(find_experiment(file.experiment, path))
    with _within(path, "set"):
        experiment = experiment.replaced(dict(leaves(file.set)))
        mechanism = load_mechanism(experiment.mechanism_path, experiment.sdf_overrides)
        check(mechanism, experiment)
    nominal = np.array([_nominal(path, file, name, mechanism, experiment) for name in file.variables])
    bounds = [_bounds(path, file, name, x) for name, x in zip(file.variables, nominal, strict=True)]
    points = tuple(
        _point(path, file, name, point, experiment, nominal)
        for name, point in (file.points or {"nominal": Point.model_validate({})}).items()
    )
    _check_quantities(path, file, points)
    return Study(
        path,
        file,
        sources,
        tuple(file.variables),
        tuple(variable.path for variable in file.variables.values()),
        np.array([lower for lower, _ in bounds]),
        np.array([upper for _, upper in bounds]),
        nominal,
        points,
        {
            name: _formula(path, f"{kind}.{name}.formula", quantity.formula, file)
            for kind, name, quantity in quantities(file)
            if quantity.formula is not None
        },
        {name: _design(path, file, name, nominal) for name in file.designs},
    )


def quantities(file: StudyFile) -> list[tuple[str, str, Objective | Constraint]]:
    """Every objective, then every constraint: table, name, quantity."""
    return [("objectives", name, objective) for name, objective in file.objectives.items()] + [
        ("constraints", name, constraint) for name, constraint in file.constraints.items()
    ]


def label(study: Study, name: str) -> str:
    """Name of an objective or constraint, with its unit."""
    quantity = next(quantity for _, key, quantity in quantities(study.file) if key == name)
    unit = "of nominal" if quantity.relative else quantity.unit
    return f"{name} [{unit}]" if unit else name


@contextmanager
def _within(path: Path, where: str) -> Iterator[None]:
    """Name the study, and the place in it, before what is wrong with its experiment."""
    try:
        yield
    except InputError as problem:
        raise InputError(path, where, str(problem).removeprefix("argument: ")) from None


def _nominal(path: Path, file: StudyFile, name: str, mechanism: Mechanism, experiment: Experiment) -> float:
    variable = file.variables[name]
    if variable.nominal is not None:
        return variable.nominal
    with _within(path, f"variables.{name}.path"):
        return value_at(mechanism, experiment, variable.path)


def _bounds(path: Path, file: StudyFile, name: str, nominal: float) -> tuple[float, float]:
    """Bounds of a variable, in its unit."""
    variable = file.variables[name]
    found = []
    for side in ("lower", "upper"):
        bound, where = getattr(variable, side), f"variables.{name}.{side}"
        if isinstance(bound, str):
            names = dict(file.constants)
            bound = _formula(path, where, bound, file, names)(names)
            if math.isnan(bound):
                raise InputError(path, where, "has no finite value")
        found.append(bound * nominal if variable.relative else bound)
    lower, upper = sorted(found) if variable.relative and nominal < 0.0 else found
    if not lower < upper:
        raise InputError(path, f"variables.{name}", f"lower, {lower:g}, must be below upper, {upper:g}")
    if not lower <= nominal <= upper:
        raise InputError(
            path, f"variables.{name}", f"its nominal value {nominal:g} is not between {lower:g} and {upper:g}"
        )
    return lower, upper


def _design(path: Path, file: StudyFile, name: str, nominal: Array) -> Array:
    """Make a reference design; what its table does not name is nominal."""
    paths = [variable.path for variable in file.variables.values()]
    design = nominal.copy()
    for key, value in leaves(file.designs[name]):
        where = f"designs.{name}.{key}"
        if key not in paths:
            raise InputError(path, where, f"is set by no variable; {nearest(key, paths)}")
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            raise InputError(path, where, f"is {value!r}; give a number")
        design[paths.index(key)] = value
    return design


def _formula(
    path: Path, where: str, text: Any, file: StudyFile, known: Mapping[str, Any] | None = None
) -> Formula:
    """Parse a formula and check its names, by default against variables and constants."""
    if not isinstance(text, str):
        raise InputError(path, where, f"is {text!r}; write a formula between quotes")
    try:
        found = formula.parse(text)
    except ValueError as problem:
        raise InputError(path, where, str(problem)) from None
    known = {**file.variables, **file.constants} if known is None else known
    for name in sorted(found.names - set(known)):
        raise InputError(path, where, f'"{name}" is unknown; {nearest(name, known)}')
    return found


def _point(
    path: Path, file: StudyFile, name: str, point: Point, base: Experiment, nominal: Array
) -> OperatingPoint:
    where = f"points.{name}"
    replaced = dict(leaves(point.set))
    links = dict(leaves(file.linked)) | dict(leaves(point.linked))
    formulas = {
        key: _formula(
            path,
            f"{where}.linked.{key}" if key in dict(leaves(point.linked)) else f"linked.{key}",
            text,
            file,
        )
        for key, text in links.items()
    }
    paths = tuple(v.path for v in file.variables.values())
    owners: dict[str, str] = {}
    for owner, key in (
        # here a formula may take a variable's place: the viscosity at this point's temperature
        *(
            (f"variables.{n}", v.path)
            for n, v in file.variables.items()
            if v.path not in dict(leaves(point.linked))
        ),
        *((f"linked.{key}", key) for key in links),
        *((f"{where}.set.{key}", key) for key in replaced),
    ):
        if key in owners:
            raise InputError(path, owner, f"{key} is set by {owners[key]} already")
        owners[key] = owner
    values = dict(file.constants) | dict(zip(file.variables, map(float, nominal), strict=True))
    design = {v.path: values[n] for n, v in file.variables.items()}
    for key, found in formulas.items():
        design[key] = found(values)
        if math.isnan(design[key]):
            raise InputError(path, f"linked.{key}", "has no finite value at the nominal design")
    with _within(path, where if file.points else "nominal design"):
        experiment = base.replaced(replaced)
        trial = experiment.replaced(design)
        check(load_mechanism(trial.mechanism_path, trial.sdf_overrides), trial)
        mechanism = load_mechanism(experiment.mechanism_path, experiment.sdf_overrides)
    windows = {
        key: _times(path, f"windows.{key}", window, experiment, design)
        for key, window in file.windows.items()
    }
    windows["run"] = np.array([[0.0, experiment.duration]])
    return OperatingPoint(name, mechanism, experiment, (*paths, *formulas), tuple(formulas.values()), windows)


def _times(
    path: Path, where: str, window: Window, experiment: Experiment, design: Mapping[str, float]
) -> Array:
    """Make the times of a window, (count, 2) [s]."""
    unit, count = 1.0, window.count
    drive = window.revolutions_of
    if drive is not None:
        if drive not in experiment.drives:
            raise InputError(
                path, f"{where}.revolutions_of", f'no drive "{drive}"; {nearest(drive, experiment.drives)}'
            )
        speed = experiment.drives[drive].speed
        if not speed or f"drives.{drive}.speed" in design:
            raise InputError(
                path, f"{where}.revolutions_of", f"{drive} has no constant speed; give times [s]"
            )
        unit = 2.0 * math.pi / abs(speed)
    edges = unit * np.linspace(window.start, window.end, count + 1)
    if edges[-1] > experiment.duration * (1.0 + 1e-12):
        raise InputError(
            path, where, f"ends at {edges[-1]:.6g} s, after the run's {experiment.duration:g} s; set duration"
        )
    edges[-1] = min(edges[-1], experiment.duration)
    return np.column_stack([edges[:-1], edges[1:]])


def _check_quantities(path: Path, file: StudyFile, points: tuple[OperatingPoint, ...]) -> None:
    """Check the windows and outputs that quantities name."""
    outputs = [known_outputs(point.mechanism, point.experiment) for point in points]
    for kind, name, quantity in quantities(file):
        for k, term in enumerate(quantity.terms or ()):
            where = f"{kind}.{name}.terms[{k}]"
            if term.window not in points[0].windows:
                near = nearest(term.window, points[0].windows)
                raise InputError(path, f"{where}.window", f'"{term.window}" is unknown; {near}')
            for known in outputs:
                try:
                    check_output(term.output, known)
                except ValueError as problem:
                    raise InputError(path, f"{where}.output", str(problem)) from None
