"""Reads an identification file: measurements, unknowns and their bounds, each checked."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from linkages import InputError, System
from linkages.base.arrays import Array
from linkages.engines.compiled.effects import varied
from linkages.input.files.recorded import Recording, read_recording
from linkages.input.files.toml import leaves, read_toml, validate
from linkages.input.files.unit_conversion import decimal_comma, read, si
from linkages.results.outputs.registry import check_output, unit
from optim.identify.filters import filtered, sections_of
from optim.identify.numerics import LOAD_BEFORE, LOAD_FEWEST, LOAD_LARGEST, LOAD_LONGEST
from optim.identify.schema import DataFile, IdentificationFile, MeasuredColumn, Unknown
from optim.problem.load import shipped_or_beside, within

SHIFT = 0.1  # largest shift of a clock that is fitted, relative to the time of its samples


@dataclass(frozen=True, eq=False)
class Channel:
    """A measured column, in SI.

    Attributes
    ----------
    name, output : str
    unit : str
    times : (n,) array
        Increasing times of the file's clock, without its shift [s].
    raw, values : (n,) arrays
        Measured values, without and with the filter.
    deviation : float
        Of a sample, after the filter; NaN if it is not known.
    gain, offset : float
        NaN if they are fitted.
    sections : array or None
        Second-order sections of the filter.
    """

    name: str
    output: str
    unit: str
    times: Array
    raw: Array
    values: Array
    deviation: float
    gain: float
    offset: float
    sections: Array | None

    def filtered(self, rows: Array) -> Array:
        """Filter samples (n, ...) as the measured ones."""
        return filtered(rows, self.sections)


@dataclass(frozen=True, eq=False)
class Measurement:
    """A data file and its machine.

    Attributes
    ----------
    name : str
    system : System
    channels : tuple of Channel
    shift : float
        Time that is added to the file's clock [s]; NaN if it is fitted.
    """

    name: str
    system: System
    channels: tuple[Channel, ...]
    shift: float


@dataclass(frozen=True, eq=False)
class Identification:
    """A checked identification of n unknowns; made by `optim.load_identification`.

    Attributes
    ----------
    source : Path
    file : IdentificationFile
    system : System
        The experiment without measurements, for a plan.
    measurements : tuple of Measurement
    names, paths : tuples of str
        Of the unknowns.
    owners : tuple of (str or None)
        The one measurement that has an unknown.
    lower, upper, start : (n,) arrays
        SI units.
    priors : (n, 2) array
        Mean and standard deviation known before, NaN without.
    """

    source: Path
    file: IdentificationFile
    system: System
    measurements: tuple[Measurement, ...]
    names: tuple[str, ...]
    paths: tuple[str, ...]
    owners: tuple[str | None, ...]
    lower: Array
    upper: Array
    start: Array
    priors: Array

    @property
    def title(self) -> str:
        """Title of tables and figures."""
        return self.file.title or self.source.stem

    def units(self) -> tuple[str, ...]:
        """Return the SI units of the unknowns."""
        return tuple(self.system.value_unit(path) for path in self.paths)


def load_identification(path: str | Path) -> Identification:
    """Read an identification file, its experiment and its data, and check that they fit each other.

    Parameters
    ----------
    path : str or Path
        The TOML file, or the name of a shipped one.

    Raises
    ------
    InputError
        One line with file, key and reason.

    Examples
    --------
    >>> import optim
    >>> task = optim.load_identification("slider_crank_fit")
    >>> task.names, len(task.measurements[0].channels)
    (('clearance', 'viscosity', 'mass'), 2)
    """
    path = Path(path)
    shipped = Path(__file__).resolve().parent / "examples" / f"{path.stem}.toml"
    if path.parent == Path() and not path.exists() and shipped.exists():
        path = shipped
    data, _ = read_toml(path)
    file = validate(IdentificationFile, data, path)
    system = shipped_or_beside(path, "experiment", file.experiment)
    with within(path, "set"):
        system = system.replaced(dict(leaves(file.set)))
    measurements = tuple(_measurement(path, file, name, one, system) for name, one in file.data.items())
    rows = np.array([_unknown(path, name, one, system) for name, one in file.unknowns.items()])
    unknowns = list(file.unknowns.values())
    lower, upper, start = rows.T[:3].copy()
    owners = tuple(one.of for one in unknowns)
    paths = tuple(one.path for one in unknowns)
    names = tuple(file.unknowns)
    for name, one, values in zip(names, unknowns, rows[:, :3].tolist(), strict=True):
        _check_effect(path, name, one, values, measurements)
    return Identification(
        path, file, system, measurements, names, paths, owners, lower, upper, start, rows[:, 3:].copy()
    )


def _unknown(path: Path, name: str, unknown: Unknown, system: System) -> tuple[float, ...]:
    """Return lower and upper limit, start, and the prior's mean and deviation."""
    where = f"unknowns.{name}"
    unit = system.value_unit(unknown.path)
    read = lambda key, value: _number(path, f"{where}.{key}", value, unit)  # noqa: E731
    lower, upper = read("lower", unknown.lower), read("upper", unknown.upper)
    given = None if unknown.start is None else read("start", unknown.start)
    with within(path, f"{where}.path"):
        start = system.value(unknown.path) if given is None else given
        system.replaced({unknown.path: start})
    if not lower < upper:
        raise InputError(path, where, f"lower, {lower:g}, must be below upper, {upper:g}")
    if not lower <= start <= upper:
        raise InputError(path, where, f"its start {start:g} is not between {lower:g} and {upper:g}; give start")
    mean, deviation = (math.nan, math.nan) if unknown.prior is None else (read("prior", x) for x in unknown.prior)
    if deviation <= 0.0:
        raise InputError(path, f"{where}.prior", f"has the deviation {deviation:g}; it must be positive")
    return lower, upper, start, mean, deviation


def _check_effect(
    path: Path, name: str, unknown: Unknown, values: list[float], measurements: tuple[Measurement, ...]
) -> None:
    """Refuse an unknown that changes no number of the measured machines."""
    asked = [one for one in measurements if unknown.of in (None, one.name)]
    said = [varied(one.system, unknown.path, values, [c.output for c in one.channels]) for one in asked]
    if said and all(said):
        raise InputError(path, f"unknowns.{name}.path", f"{unknown.path} {said[0]}")


def _number(path: Path, where: str, value: Any, unit: str) -> float:
    try:
        found = float(read(value, unit))
    except (TypeError, ValueError) as problem:
        comma = decimal_comma(value) if isinstance(value, str) else ""
        raise InputError(path, where, f'is "{value}"{comma}' if comma else str(problem)) from None
    if isinstance(value, bool) or not math.isfinite(found):
        raise InputError(path, where, f"is {value!r}; give a number, or one with a unit between quotes")
    return float(found)


def _measurement(path: Path, file: IdentificationFile, name: str, one: DataFile, system: System) -> Measurement:
    """Read the data of a measurement, and build its machine."""
    where = f"data.{name}"
    if one.experiment is not None:
        system = shipped_or_beside(path, f"{where}.experiment", one.experiment)
        with within(path, "set"):
            system = system.replaced(dict(leaves(file.set)))
    with within(path, f"{where}.set"):
        system = system.replaced(dict(leaves(one.set)) | {"solver.max_steps": file.fit.max_steps})
    recording = read_recording(path.parent / one.file)
    channels = tuple(
        _channel(path, f"{where}.columns.{key}", key, column, recording, one, system)
        for key, column in one.columns.items()
    )
    return Measurement(name, system, channels, math.nan if one.time.shift == "fit" else float(one.time.shift))


def _channel(
    path: Path, where: str, name: str, column: MeasuredColumn, recording: Recording, data: DataFile, system: System
) -> Channel:
    with within(path, where):
        check_output(system, column.output)
        si_unit = unit(system, column.output)
        times = recording.column(data.time.column, "s", data.time.unit)
        values = recording.column(column.column or name, si_unit, column.unit)
        _check_samples(times, values)
        _check_times(times, data.time.shift, system.settings.duration)
        sections = None if column.filter is None else sections_of(column.filter, times)
        deviation = _deviation(column, recording, column.column or name, si_unit)
    raw, values = values, filtered(values, sections)
    if sections is not None:
        impulse = np.zeros(len(values))
        impulse[len(values) // 2] = 1.0
        deviation *= float(np.linalg.norm(filtered(impulse, sections)))
    gain, offset = (math.nan if x == "fit" else float(x) for x in (column.gain, column.offset))
    return Channel(name, column.output, si_unit, times, raw, values, deviation, gain, offset, sections)


def _check_samples(times: Array, values: Array) -> None:
    """Raise a ValueError, in one sentence, for samples that cannot be used."""
    if len(times) < LOAD_FEWEST:
        raise ValueError(f"has {len(times)} samples; at least {LOAD_FEWEST} are needed")
    for what, array in (("the times have", times), ("the column has", values)):
        if not np.isfinite(array).all():
            line = int(np.flatnonzero(~np.isfinite(array))[0])
            raise ValueError(f"{what} no number in row {line + 1}; remove the row, or repair it")
        if np.abs(array).max() > LOAD_LARGEST:
            line = int(np.abs(array).argmax())
            raise ValueError(
                f"{what} {array[line]:g} in row {line + 1}; at most {LOAD_LARGEST:g} is possible; remove or repair it"
            )
    if not np.all(np.diff(times) > 0.0):
        line = int(np.flatnonzero(np.diff(times) <= 0.0)[0])
        raise ValueError(f"the times do not increase from row {line + 1} to row {line + 2}; sort the rows")
    if np.ptp(values) == 0.0:
        raise ValueError(f"all samples are {values[0]:g}; they say nothing")


def _check_times(times: Array, shift: float | str, duration: float) -> None:
    """Raise a ValueError, in one sentence, for times that do not belong to the run."""
    early = SHIFT * float(np.ptp(times)) if isinstance(shift, str) else 0.0
    first, last = (float(t) + (0.0 if isinstance(shift, str) else shift) for t in times[[0, -1]])
    if first < -early - LOAD_BEFORE * float(np.ptp(times)):
        raise ValueError(f"its first time, {first:g} s, is before the start of the run; give time.shift")
    if last > LOAD_LONGEST * duration:
        raise ValueError(
            f"its last time, {last:g} s, is beyond {LOAD_LONGEST:g} times the duration of the experiment, "
            f"{duration:g} s; give time.unit, or a longer duration"
        )


def _deviation(column: MeasuredColumn, recording: Recording, name: str, si_unit: str) -> float:
    """Return the standard deviation of a sample in SI; NaN if none is given."""
    if column.deviation is None:
        return math.nan
    stated = recording.stated(name, si_unit, column.unit)
    factor = 1.0 if stated == si_unit else si(f"1 {stated}", si_unit) - si(f"0 {stated}", si_unit)
    size = si(column.deviation, si_unit) if isinstance(column.deviation, str) else column.deviation * factor
    if not size > 0.0:
        raise ValueError(f"deviation is {column.deviation!r}; it must be positive")
    return float(size)


def described(identification: Identification) -> Mapping[str, Any]:
    """Return what determines the numbers of an identification, JSON types."""
    content = hashlib.sha256()
    for one in identification.measurements:
        content.update(one.system.description.machine_source.read_bytes())
        content.update(one.system.experiment.model_dump_json(exclude={"title"}).encode())
        for channel in one.channels:
            content.update(channel.times.tobytes() + channel.values.tobytes())
    other: Any = {"title": True, "plan": True, "fit": {"posterior_runs", "time"}}  # --resume continues
    return {**identification.file.model_dump(mode="json", exclude=other), "content": content.hexdigest()}
