"""The part of a table that takes a signal from a data file."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated, Any, ClassVar, Self

from pydantic import Field, PrivateAttr, ValidationInfo, model_validator

from linkages.base.errors import nearest
from linkages.input.files.recorded import Recording, read_recording
from linkages.input.files.table_keys import bracketed
from linkages.input.files.toml import Finite, Positive, Table
from linkages.input.files.unit_conversion import SLIDING, is_quantity, si
from linkages.input.functions.smoothing import Smoothing, SmoothSignal, fitted

Size = Annotated[float, Field(ge=0, allow_inf_nan=False)] | str

_PER_TURN = re.compile(r"\s*(\d+)\s*/\s*(?:rev|r|turn)\s*")
_TURN = 6.283185307179586
_OWN = (
    "units",
    "resolution",
    "deviation",
    "periodic",
    "period",
    "unwrap",
    "smoothing",
    "shift",
    "gain",
    "offset",
    "columns",
)


class FromFile(Table):
    """A signal from a data file: its columns, and how it is smoothed."""

    #: Keys that take names of columns, and whether the signal is a motion.
    column_keys: ClassVar[tuple[str, ...]] = ()

    file: str | None = Field(
        None, description="data file (.csv, .txt, .mat, .parquet, .npz), relative to this file; the keys of values then"
        " take names of its columns"
    )  # fmt: skip
    time: str = Field("time", description="file: column of the times")
    columns: dict[str, list[str]] = Field({}, description="file: columns by key; written at the keys themselves")
    units: dict[str, str] = Field({}, description='file: units by key, as { time = "ms", angle = "deg" }; default: SI')
    resolution: Size | None = Field(
        None, description='file: step of the sensor, as "4096/rev" or "0.1 deg"; deviation times the root of 12'
    )
    deviation: Size | None = Field(
        None, description='file: standard deviation of a sample, as "0.05 deg"; 0: samples are exact'
    )
    periodic: bool | None = Field(
        None, description="file: whether the motion repeats with every turn; default: if the file covers whole turns"
    )
    period: Positive | None = Field(None, description="file: time after which the signal repeats [s]; default: a turn")
    unwrap: bool = Field(False, description="file: whether the angle jumps by a turn, as from 359 to 0 degrees")
    smoothing: Positive | None = Field(
        None,
        description="file: the order of the series or the number of spline segments is divided by it; default: 1 [1]",
    )
    shift: Finite | None = Field(None, description="file: time that is added to the file's times; default: 0 [s]")

    gain: Finite | None = Field(None, description="file: factor of the value's column; not 0; default: 1 [1]")
    offset: Finite | None = Field(
        None, description="file: number that is added to gain times the column, in the value's SI unit; default: 0"
    )

    _recording: Recording | None = PrivateAttr(None)
    _fits: tuple[SmoothSignal, ...] = PrivateAttr(())
    _folder: Path | None = PrivateAttr(None)

    @property
    def fitted(self) -> tuple[SmoothSignal, ...]:
        """Return the smooth functions of the signal in the file, one for each component; empty without a file."""
        return self._fits

    @model_validator(mode="before")
    @classmethod
    def _take_columns(cls, data: Any) -> Any:
        """Move names of columns from the keys of values to `columns`."""
        if not isinstance(data, dict) or "file" not in data:
            return data
        made, columns = dict(data), dict(data.get("columns", {}))
        for key in cls.column_keys:
            names = [made[key]] if isinstance(made.get(key), str) else made.get(key)
            if isinstance(names, list) and names and all(isinstance(n, str) and not is_quantity(n) for n in names):
                columns[key] = names
                del made[key]
        return made | {"columns": columns} if columns else made

    @model_validator(mode="after")
    def _checked(self, info: ValidationInfo) -> Self:
        self._folder = info.context
        self._complete()
        return self

    def _complete(self) -> None:
        if self.file is None:
            if given := [key for key in (*_OWN, "time") if key in self.model_fields_set]:
                raise ValueError(f"{given[0]} belongs to file; give the data file, or remove it")
            return
        if unknown := sorted(set(self.units) - {"time", *self.columns}):
            raise ValueError(f'units has "{unknown[0]}"; {nearest(unknown[0], ("time", *self.columns))}')
        if unknown := sorted(set(self.columns) - set(self.column_keys)):
            raise ValueError(f'columns has "{unknown[0]}"; {nearest(unknown[0], self.column_keys)}')
        if self.gain == 0.0:
            raise ValueError("gain is 0; the signal would not depend on the file")
        if self._folder is not None:
            self._recording = read_recording(self._folder / self.file)

    def _check_columns(self) -> str | None:
        """Return the key of the signal in the file; None without a file."""
        if self.file is None:
            return None
        keys = [key for key in self.columns if key != "at"]
        if len(keys) != 1:
            known = ", ".join(key for key in self.column_keys if key != "at")
            raise ValueError(f"file needs the name of a column for one of {known}")
        return keys[0]

    def unit(self, key: str) -> str:
        """Return the SI unit of a key's column: of a prismatic joint if the stated unit is one of lengths or forces."""
        unit, stated = bracketed(type(self).model_fields[key].description), self.units.get(key)
        sliding = SLIDING.get(unit)
        if stated is None or not self.of_any_joint or sliding is None:
            return unit
        try:
            si(f"1 {stated}", sliding)
        except ValueError:
            return unit
        return sliding

    def _fit(self, key: str, over: tuple[str, str] = ("time", "s"), kind: str = "value") -> None:
        """Fit the columns of a key over the times, or over another key's column, with its unit."""
        recording, self._recording = self._recording, None  # it is not part of what other processes get
        if recording is None:
            return
        line = 1.0 if self.gain is None else self.gain, self.offset or 0.0
        deviation = abs(line[0]) * self._deviation(key)
        smoothing = Smoothing(deviation, self.periodic, self.period, self.unwrap, self.smoothing or 1.0)
        place, place_unit = over
        name = self.time if place == "time" else self.columns[place][0]
        shift = (self.shift or 0.0) if place == "time" else 0.0
        places, start = (name, place_unit, self.units.get(place)), float(getattr(self, "angle", 0.0) or 0.0)
        self._fits = tuple(
            fitted(
                recording, places, (column, self.unit(key), self.units.get(key)), kind, smoothing, shift, start, line
            )
            for column in self.columns[key]
        )

    def _deviation(self, key: str) -> float:
        """Return the standard deviation of a sample, in the unit of a key's column."""
        if (self.resolution is None) == (self.deviation is None):
            asked = 'give resolution, as "4096/rev", or deviation, as "0.05 deg" (0: the samples are exact)'
            raise ValueError(
                f"{asked}: it decides the accelerations" if self.resolution is None else f"{asked}, not both"
            )
        if self.deviation is not None:
            return self._size("deviation", key)
        assert self.resolution is not None
        per_turn = _PER_TURN.fullmatch(self.resolution) if isinstance(self.resolution, str) else None
        if per_turn and int(per_turn[1]) > 0:
            if self.unit(key) != "rad":
                raise ValueError(f'resolution "{self.resolution}" is one of angles; give it in {self.unit(key)}')
            return _TURN / int(per_turn[1]) / 12.0**0.5
        return self._size("resolution", key) / 12.0**0.5

    def _size(self, which: str, key: str) -> float:
        """Return the resolution or deviation in the unit of a key's column."""
        given = getattr(self, which)
        try:
            size = si(given, self.unit(key)) if isinstance(given, str) else float(given)
        except ValueError as problem:
            raise ValueError(f"{which} {problem}") from None
        if size < 0.0:
            raise ValueError(f'{which} is "{given}"; it must be zero or positive')
        return size


class DataColumn(Table):
    """A measured column: gain times the column plus offset, in the output's unit, is compared with the output."""

    output: str = Field(description="output that it is compared with")
    unit: str | None = Field(None, description="unit of the column; default: the file's, or the output's in SI")
    gain: Finite = Field(1.0, description="factor of the column [1]")
    offset: Finite = Field(0.0, description="added value, in the output's SI unit")


class DataTable(Table):
    """Measured curves for comparison with computed ones."""

    file: str = Field(description="data file (.csv, .txt, .mat, .parquet, .npz), relative to this file")
    time: str = Field("time", description="column of the times")
    time_unit: str | None = Field(None, description="unit of the times; default: the file's, or s")
    shift: Finite = Field(0.0, description="time that is added to the file's times [s]")
    columns: dict[str, DataColumn] = Field(
        {}, description="columns by name; default: all with names of outputs of the run"
    )

    _recording: Recording | None = PrivateAttr(None)

    @property
    def recording(self) -> Recording | None:
        """Return the data file; None if it was not read."""
        return self._recording

    @model_validator(mode="after")
    def _checked(self, info: ValidationInfo) -> Self:
        if info.context is not None:
            self._recording = read_recording(info.context / self.file)
            self._recording.column(self.time, "s", self.time_unit)
            for name in self.columns:
                self._recording.named(name)
        return self
