"""Reads a study file: variables, bounds, operating points, objectives and constraints, each checked.

Values keep their units (SI). The comment after a value in the file is its source, as in experiments.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from linkages import InputError, System, find_file, load
from linkages.base.errors import AssemblyError, RunError, nearest
from linkages.engines.compiled.effects import differ, explained, varied
from linkages.input.files.formula import Formula, parse
from linkages.input.files.toml import leaves, read_toml, validate
from linkages.input.files.unit_conversion import decimal_comma, is_quantity, read
from linkages.results.outputs.registry import check_output
from optim.problem.scatter import read_scatter
from optim.problem.schema import LIFE, PointTable, ScatterTable, StudyFile, StudyWindow, Term, Variable
from optim.problem.study import Array, OperatingPoint, Study


def find_study(name: str | Path) -> Path:
    """Return the file as given if it exists, else the shipped study of this name; its suffix may be left out.

    Raises
    ------
    InputError
        If neither exists; the message names the most similar existing file.

    Examples
    --------
    >>> import optim
    >>> optim.find_study("sevenbar_force").name
    'sevenbar_force.toml'
    """
    return find_file(name, ".toml")


def load_study(path: str | Path) -> Study:
    """Read a study, its experiment and its mechanism, and check that they fit each other.

    Parameters
    ----------
    path : str or Path
        The TOML file; see `optim.find_study` for the shipped ones.

    Raises
    ------
    InputError
        One line with file, key and reason.

    Examples
    --------
    >>> import optim
    >>> study = optim.load_study(optim.find_study("sevenbar_force"))
    >>> study.names[0], float(study.lower[0]), float(study.upper[0])
    ('mass_2', 0.1095, 0.438)
    """
    path = Path(path)
    data, sources = read_toml(path)
    file = validate(StudyFile, data, path)
    system = shipped_or_beside(path, "experiment", file.experiment)
    with within(path, "set"):
        system = system.replaced(dict(leaves(file.set)))
    rows = [_variable(path, file, name, system) for name in file.variables]
    scatter = read_scatter(path, file, system)
    start = dict(zip(file.variables, (nominal for _, _, nominal in rows), strict=True))
    usual = {name: start[name] for name in _moving(file) if name in start}
    if scatter is not None:
        usual |= dict(zip(scatter.names, map(float, scatter.means), strict=True))
    if file.sampled:
        assert scatter is not None  # by the file's validation
        rows = [(*ends, usual[name]) for name, ends in zip(scatter.names, scatter.bounds().T, strict=True)]
    lower, upper, nominal = np.array(rows).T.copy()
    named = dict(file.constants) | start | usual
    points = tuple(
        _point(path, file, name, point, system, named)
        for name, point in (file.points or {"nominal": PointTable.model_validate({})}).items()
    )
    changing: Mapping[str, Variable | ScatterTable] = file.scatter if file.sampled else file.variables
    study = Study(
        path,
        file,
        sources,
        tuple(changing),
        tuple(table.path for table in changing.values()),
        lower,
        upper,
        nominal,
        points,
        {
            name: _formula(path, f"{kind}.{name}.formula", quantity.formula, named)
            for kind, table in (("objectives", file.objectives), ("constraints", file.constraints))
            for name, quantity in table.items()
            if quantity.formula is not None
        },
        {
            name: _design(path, file, name, [table.path for table in changing.values()], nominal)
            for name in file.designs
        },
        usual,
        scatter,
    )
    _check_quantities(study)
    _check_effects(study)
    return study


def shipped_or_beside(path: Path, where: str, experiment: str) -> System:
    """Load the experiment that a file names at a key: in the file's folder, or a shipped one."""
    with within(path, where):
        beside = path.parent / experiment
        return load(beside if os.path.exists(beside) else find_file(experiment))


@contextmanager
def within(path: Path, where: str) -> Iterator[None]:
    """Put the file and the key before an error of its experiment or of a value."""
    try:
        yield
    except ValueError as problem:  # of which InputError is one
        raise InputError(path, where, str(problem).removeprefix("argument: ")) from None


def _variable(path: Path, file: StudyFile, name: str, system: System) -> tuple[float, float, float]:
    """Bounds and nominal value of a variable, in its unit."""
    variable, where = file.variables[name], f"variables.{name}"
    if variable.path.startswith("scatter."):
        known = [f"scatter.{name}.factor" for name in file.scatter]
        if variable.path not in known:
            raise InputError(path, f"{where}.path", f'"{variable.path}" is unknown; {nearest(variable.path, known)}')
        nominal = 1.0 if variable.nominal is None else variable.nominal
    else:
        with within(path, f"{where}.path"):
            nominal = system.value(variable.path) if variable.nominal is None else variable.nominal
    found = []
    for side, bound in (("lower", variable.lower), ("upper", variable.upper)):
        if isinstance(bound, str) and is_quantity(bound):
            with within(path, f"{where}.{side}"):
                bound = read(bound, system.value_unit(variable.path))
        elif isinstance(bound, str):
            bound = _formula(path, f"{where}.{side}", bound, file.constants)(file.constants)
            if math.isnan(bound):
                raise InputError(path, f"{where}.{side}", "has no finite value")
        found.append(bound * nominal if variable.relative else bound)
    lower, upper = sorted(found) if variable.relative and nominal < 0.0 else found
    if not lower < upper:
        raise InputError(path, where, f"lower, {lower:g}, must be below upper, {upper:g}")
    if not lower <= nominal <= upper:
        problem = f"its nominal value {nominal:g} is not between {lower:g} and {upper:g}"
        raise InputError(path, where, problem)
    return lower, upper, nominal


def _design(path: Path, file: StudyFile, name: str, paths: list[str], nominal: Array) -> Array:
    """Make a reference design; what its table does not name is nominal."""
    design = nominal.copy()
    for key, value in leaves(file.designs[name]):
        where = f"designs.{name}.{key}"
        if key not in paths:
            raise InputError(path, where, f"is set by no variable; {nearest(key, paths)}")
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            raise InputError(path, where, f"is {value!r}; give a number")
        design[paths.index(key)] = value
    return design


def _moving(file: StudyFile) -> Mapping[str, Variable | ScatterTable]:
    """Return the variables with a path of the experiment, then the scattering values, by name."""
    own = {name: table for name, table in file.variables.items() if not table.path.startswith("scatter.")}
    return {**own, **file.scatter}


def _formula(path: Path, where: str, text: Any, known: Mapping[str, Any]) -> Formula:
    if not isinstance(text, str):
        raise InputError(path, where, f"is {text!r}; write a formula between quotes")
    if comma := decimal_comma(text):
        raise InputError(path, where, f'is "{text}"{comma}')
    with within(path, where):
        found = parse(text)
    for name in sorted(found.names - set(known)):
        raise InputError(path, where, f'"{name}" is unknown; {nearest(name, known)}')
    return found


def _point(
    path: Path, file: StudyFile, name: str, point: PointTable, base: System, named: Mapping[str, float]
) -> OperatingPoint:
    where = f"points.{name}"
    replaced, own = dict(leaves(point.set)), dict(leaves(point.linked))
    links = dict(leaves(file.linked)) | own
    formulas = {
        key: _formula(path, f"{where}.linked.{key}" if key in own else f"linked.{key}", text, named)
        for key, text in links.items()
    }
    variables = {variable: table.path for variable, table in _moving(file).items()}
    # here a formula may take a variable's place: the viscosity at this point's temperature
    setters = [
        (f"{'scatter' if variable in file.scatter else 'variables'}.{variable}", key)
        for variable, key in variables.items()
        if key not in own
    ]
    setters += [(f"linked.{key}", key) for key in links]
    setters += [(f"{where}.set.{key}", key) for key in replaced]
    owners: dict[str, str] = {}
    for owner, key in setters:
        if key in owners:
            raise InputError(path, owner, f"{key} is set by {owners[key]} already")
        owners[key] = owner
    design = {key: named[variable] for variable, key in variables.items()}
    for key, found in formulas.items():
        design[key] = found(named)
        if math.isnan(design[key]):
            raise InputError(path, f"linked.{key}", "has no finite value at the nominal design")
    with within(path, where if file.points else "nominal design"):
        system = base.replaced(replaced)
        system.replaced(design)
    windows = {key: _times(path, f"windows.{key}", window, system, design) for key, window in file.windows.items()}
    windows["run"] = np.array([[0.0, system.settings.duration]])
    return OperatingPoint(name, system, (*variables.values(), *formulas), tuple(formulas.values()), windows)


def _times(path: Path, where: str, window: StudyWindow, system: System, design: Mapping[str, float]) -> Array:
    """Make the times of a window, (count, 2) [s]."""
    unit, drive, key = 1.0, window.revolutions_of, f"{where}.revolutions_of"
    if drive is not None:
        if drive not in system.drives:
            raise InputError(path, key, f'no drive "{drive}"; {nearest(drive, system.drives)}')
        speed = system.drives[drive].speed
        if not speed or f"drives.{drive}.speed" in design:
            raise InputError(path, key, f"{drive} has no constant speed; give times [s]")
        unit = 2.0 * math.pi / abs(speed)
    edges = unit * np.linspace(window.start, window.end, window.count + 1)
    if edges[-1] > system.settings.duration * (1.0 + 1e-12):
        raise InputError(
            path, where, f"ends at {edges[-1]:.6g} s, after the run's {system.settings.duration:g} s; set duration"
        )
    edges[-1] = min(edges[-1], system.settings.duration)
    return np.column_stack([edges[:-1], edges[1:]])


def _check_quantities(study: Study) -> None:
    """Check that there are the windows and outputs that objectives and constraints name."""
    windows = study.points[0].windows
    for kind, name, quantity in study.quantities:
        scattering = study.formulas[name].names & set(study.file.scatter) if name in study.formulas else set()
        if scattering and quantity.over_scatter is None and not study.file.sampled:
            problem = f'has the scattering value "{min(scattering)}"; give over_scatter, such as "mean"'
            raise InputError(study.source, f"{kind}.{name}.formula", problem)
        for k, term in enumerate(quantity.terms or ()):
            where = f"{kind}.{name}.terms[{k}]"
            if term.window not in windows:
                near = nearest(term.window, windows)
                raise InputError(study.source, f"{where}.window", f'"{term.window}" is unknown; {near}')
            if term.output.startswith(LIFE):
                _check_life(study, where, term)
                continue
            for point in study.points:
                with within(study.source, where):
                    check_output(point.system, term.output)


def _check_life(study: Study, where: str, term: Term) -> None:
    """Check the service life that a term names, and its limiting quantity."""
    from linkages.explore.wear.stages import check_life

    name, lives = term.output.removeprefix(LIFE), study.file.lives
    if name not in lives:
        raise InputError(study.source, f"{where}.output", f'"{term.output}" is unknown; {nearest(name, lives)}')
    if term.functional not in ("mean", "min", "max"):
        raise InputError(study.source, f"{where}.functional", f'is "{term.functional}" of one number; write "mean"')
    for point in study.points:
        with within(study.source, f"lives.{name}"):
            check_life(point.system, lives[name].until, lives[name].drive)


def _check_effects(study: Study) -> None:
    """Refuse variables and scattering values that change no number of any operating point."""
    terms = [term.output for _, _, quantity in study.quantities for term in quantity.terms or ()]
    outputs = [name for name in terms if not name.startswith((LIFE, "ideal."))]
    for k, (name, path) in enumerate(zip(study.names, study.paths, strict=True)):
        if path.startswith("scatter.") or (study.file.lives and ".wear." in path):
            continue
        low, high = study.nominal.copy(), study.nominal.copy()
        low[k], high[k] = study.lower[k], study.upper[k]
        try:
            acts = any(differ(study.system(low, one), study.system(high, one), outputs) for one in study.points)
        except (InputError, AssemblyError, RunError):  # the designs report it
            continue
        if not acts:
            kind = "scatter" if study.file.sampled else "variables"
            problem = f"{path} {explained(study.points[0].system, path)}"
            raise InputError(study.source, f"{kind}.{name}.path", problem)
    if study.scatter is not None and not study.file.sampled:
        for name, ends in zip(study.scatter.names, study.scatter.bounds().T.tolist(), strict=True):
            path = study.file.scatter[name].path
            if all(varied(one.system, path, ends, outputs) for one in study.points):
                problem = f"{path} {explained(study.points[0].system, path)}"
                raise InputError(study.source, f"scatter.{name}.path", problem)
