"""Comparison of measured with computed curves: residuals of a run against the columns of a data file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from linkages.base.arrays import Array
from linkages.base.errors import InputError, Status
from linkages.input.files.reading import read_arrays
from linkages.input.functions.recorded_tables import DataColumn
from linkages.results.akima import interpolated
from linkages.results.outputs.registry import check_output, unit
from linkages.results.shape import Comparison
from linkages.results.trajectory import Trajectory
from linkages.system import System


@dataclass(frozen=True, eq=False)
class Measured:
    """A measured curve and the run at its times.

    Attributes
    ----------
    column : str
        Column of the data file.
    time : array
        Times within the run (n,) [s].
    values, computed : array
        Measured and computed values (n,), in the output's SI unit.
    """

    column: str
    time: Array
    values: Array
    computed: Array

    @property
    def residual(self) -> Array:
        """Return measured less computed values (n,)."""
        return self.values - self.computed

    @property
    def comparison(self) -> Comparison:
        """Return an entry of ``measured`` in a summary."""
        residual = self.residual
        k = int(np.abs(residual).argmax())
        return Comparison(
            column=self.column,
            rows=len(self.time),
            rms=float(np.sqrt(np.mean(residual**2))),
            largest=float(residual[k]),
            time=float(self.time[k]),
            peak=float(np.abs(self.values).max()),
        )


def check_data(system: System) -> None:
    """Check the outputs that columns of the experiment's data are mapped to; InputError for an unknown one."""
    for data in [system.settings.data] if system.settings.data is not None else []:
        for name, column in data.columns.items():
            try:
                check_output(system, column.output)
            except InputError as problem:
                raise InputError(
                    system.description.source, f"data.columns.{name}.output", str(problem.problem)
                ) from None


def measured(system: System, run: Trajectory) -> dict[str, Measured]:
    """Evaluate a run at the times of the measured curves of its experiment, by output.

    Without ``[data.columns]`` each column of the file that is named like an output is compared.
    """
    data, source = system.settings.data, system.description.source
    if data is None or data.recording is None:
        return {}
    recording = data.recording
    columns = data.columns or {
        name: DataColumn.model_validate({"output": recording.bare(name)})
        for name in recording.columns
        if recording.bare(name) in run.columns and recording.bare(name) != "time" and name != recording.named(data.time)
    }
    if not columns:
        named = f"no column of {recording.path.name} is named like a recorded output"
        raise InputError(source, "data", f'{named}; add [data.columns.NAME] with output = "OUTPUT"')
    found = {}
    for name, column in columns.items():
        where = f"data.columns.{name}"
        if column.output not in run.columns:
            raise InputError(source, where, f'"{column.output}" is not recorded; add it to outputs')
        try:
            times = recording.column(data.time, "s", data.time_unit) + data.shift
            values = recording.column(name, unit(system, column.output), column.unit)
        except ValueError as problem:
            raise InputError(source, where, str(problem)) from None
        values = column.gain * values + column.offset
        inside = np.isfinite(times) & np.isfinite(values) & (times >= run.time[0]) & (times <= run.time[-1])
        if not inside.any() and run.status is not Status.OK:
            continue  # the run ended before
        if not inside.any():
            span = f"{run.time[0]:g} to {run.time[-1]:g} s"
            raise InputError(source, where, f"has no number at a time within the run, {span}; change data.shift")
        at = times[inside]
        computed = run.evaluate(at)[column.output] if run.evaluate else _between(run, column.output, at)
        found[column.output] = Measured(name, at, values[inside], computed)
    return found


def save_measured(found: Mapping[str, Measured], path: Path) -> None:
    """Write measured curves as ``OUTPUT/time``, ``OUTPUT/values``, ``OUTPUT/computed`` of an archive."""
    parts = ("time", "values", "computed")
    np.savez(
        path,
        allow_pickle=False,
        **{f"{name}/{part}": getattr(one, part) for name, one in found.items() for part in parts},
    )


def load_measured(path: Path) -> dict[str, tuple[Array, Array]]:
    """Read times and values of the curves of `save_measured`, by output; ValueError for a defect."""
    arrays = read_arrays(path)
    names = dict.fromkeys(name.rpartition("/")[0] for name in arrays)
    return {name: (_floats(arrays[f"{name}/time"]), _floats(arrays[f"{name}/values"])) for name in names}


def _floats(values: NDArray[np.generic]) -> Array:
    return values.astype(np.float64)


def _between(run: Trajectory, output: str, times: Array) -> Array:
    """Interpolate a column of a loaded run."""
    return interpolated(run.time, run[output][:, None], times)[:, 0]
