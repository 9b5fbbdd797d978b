"""The tables of an identification file."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, field_validator

from linkages.input.files.toml import Finite, Positive, Table

Adjusted = Finite | Literal["fit"]
Open = Literal["fit"] | None
Size = Positive | str
Windows = Literal["all", "grow", "impacts", "statistics"]
Deviations = Literal["white", "autocorrelated"]


class Filter(Table):
    """A filter without phase shift, which runs forwards and backwards over measured and computed samples."""

    kind: Literal["butterworth"] = Field("butterworth", description="filter")
    order: Annotated[int, Field(ge=1, le=12)] = Field(4, description="order of one passage [1]")
    cutoff: Positive = Field(description="corner of one passage [Hz]")


class Clock(Table):
    """The times of a data file: one clock for all of its columns."""

    column: str = Field("time", description="column of the times")
    unit: str | None = Field(None, description="unit of the times; default: the file's, or s")
    shift: Adjusted = Field(0.0, description='time that is added to the file\'s times, or "fit" [s]')


class MeasuredColumn(Table):
    """A measured column: gain times the column plus offset, in the output's unit, is the output."""

    column: str | None = Field(None, description="name of the column; default: the table's name")
    output: str = Field(description="output that it measures")
    unit: str | None = Field(None, description="unit of the column; default: the file's, or the output's in SI")
    gain: Adjusted = Field(1.0, description='factor of the column, or "fit" [1]')
    offset: Adjusted = Field(0.0, description='added value in the output\'s SI unit, or "fit"')
    deviation: Size | None = Field(
        None,
        description='standard deviation of a sample, in the column\'s unit, or with a unit as "0.5 mm"; default: that'
        " of the residuals",
    )
    filter: Filter | None = Field(None, description="filter of the column, of the run and of its derivatives alike")


class DataFile(Table):
    """A measurement: its file, and the machine it was taken on."""

    file: str = Field(description="data file (.csv, .txt, .mat, .parquet, .npz), relative to this file")
    time: Clock = Field(Clock.model_validate({}), description="its clock; or the name of the column of the times")
    columns: Annotated[dict[str, MeasuredColumn], Field(min_length=1)] = Field(description="measured columns")
    experiment: str | None = Field(None, description="its experiment; default: the one of all files")
    set: dict[str, Any] = Field({}, description="values of this measurement, as its speed or load, by dotted path")

    @field_validator("time", mode="before")
    @classmethod
    def _named(cls, value: Any) -> Any:
        return {"column": value} if isinstance(value, str) else value


class Unknown(Table):
    """A value that the measurements shall determine."""

    path: str = Field(description="dotted path: joints.A.clearance, sdf.links.rod.mass")
    lower: Any = Field(description="least value: a number in SI, or with a unit")
    upper: Any = Field(description="largest value")
    start: Any = Field(None, description="where the search begins; default: the experiment's value")
    prior: Annotated[list[Any], Field(min_length=2, max_length=2)] | None = Field(
        None, description="mean and standard deviation that are known before"
    )
    of: str | None = Field(None, description="the one measurement that has this value; default: all have it")


class FitTable(Table):
    """How the unknowns are found."""

    windows: Windows | None = Field(
        None,
        description="all: all samples at once; grow: first the beginning of the run, then up to the horizon of"
        " predictability; impacts: integrals over the first impacts, then grow; statistics: means, deviations"
        " and peaks of many turns; default: impacts with contacts, else all",
    )
    deviations: Deviations = Field(
        "autocorrelated",
        description="whether residuals are independent (white) or are counted by their autocorrelation",
    )
    starts: Annotated[int, Field(ge=1, le=1000)] = Field(
        1, description="number of starts; others than the first are spread"
    )
    seed: Annotated[int, Field(ge=0, lt=2**32)] = Field(1, description="seed of the starts")
    predict: Annotated[float, Field(ge=0, lt=1)] = Field(
        0.0, description="last part of the samples that is predicted, not fitted; with alternatives 0.5 by default [1]"
    )
    max_steps: Annotated[int, Field(ge=100, le=5_000_000)] = Field(
        200_000, description="steps of a run; a design that needs more counts as one that does not fit [1]"
    )
    time: Positive | None = Field(
        None,
        description="most time of the fit, and of each alternative, by the clock on the wall; it ends then, or after"
        " the present run, with the best values so far; default: 50 [s]",
    )
    posterior_runs: Annotated[int, Field(ge=1000, le=100_000_000)] = Field(
        40_000, description="most runs of --posterior, which makes a hundred steps at least [1]"
    )


class Alternative(Table):
    """Another model of the same machine, for comparison by its prediction."""

    set: dict[str, Any] = Field(description="its values by dotted path")
    unknowns: list[str] | None = Field(None, description="unknowns that it has; default: all")


class Candidate(Table):
    """A sensor that could be used."""

    output: str = Field(description="output that it measures")
    deviation: Size = Field(description='standard deviation of a sample, in SI or with a unit, as "0.5 mm"')
    gain: Open = Field(None, description='"fit": its factor will be fitted, too')
    offset: Open = Field(None, description='"fit": its offset will be fitted, too')


class Plan(Table):
    """A measurement that is planned."""

    rate: Positive = Field(description="samples in a second [Hz]")
    duration: Positive | None = Field(None, description="its time; default: the experiment's duration [s]")
    shift: Open = Field(None, description='"fit": the shift of its clock will be fitted, too')
    vary: str | None = Field(None, description="dotted path of a value that can be chosen, as drives.O.speed")
    values: list[Finite] = Field([], description="values of it to compare, in SI")
    candidates: Annotated[dict[str, Candidate], Field(min_length=1)] = Field(description="sensors by name")


class IdentificationFile(Table):
    """Measurements, unknowns, and how they are found. SI units."""

    experiment: str = Field(description="experiment file, in the same folder or a shipped one")
    title: str = Field("", description="one line for tables and figures")
    set: dict[str, Any] = Field({}, description="replaced values of the experiment, by dotted path")
    data: dict[str, DataFile] = Field({}, description="measurements by name")
    unknowns: Annotated[dict[str, Unknown], Field(min_length=1)] = Field(description="unknowns by name")
    fit: FitTable = Field(FitTable.model_validate({}), description="how the unknowns are found")
    alternatives: dict[str, Alternative] = Field({}, description="other models by name")
    plan: Plan | None = Field(None, description="a measurement that is planned, for --plan")

    def _complete(self) -> None:
        if self.fit.windows == "statistics" and (self.alternatives or self.fit.predict):
            raise ValueError(
                'fit.windows is "statistics", which predicts no samples; leave out alternatives and predict'
            )
        for name, data in self.data.items():
            if self.fit.windows == "statistics" and data.time.shift == "fit":
                raise ValueError(f"data.{name}.time.shift: is not in statistics; give a number")
        for name, unknown in self.unknowns.items():
            if unknown.of is not None and unknown.of not in self.data:
                raise ValueError(f'unknowns.{name}.of is "{unknown.of}"; there is no such table in data')
        seen: dict[tuple[str, str | None], str] = {}
        for name, unknown in self.unknowns.items():
            first = seen.setdefault((unknown.path, unknown.of), name)
            if first != name:
                raise ValueError(f'unknowns.{first} and unknowns.{name} have the same path, "{unknown.path}"')
        for name, data in self.data.items():
            for key, column in data.columns.items():
                if column.gain == 0.0:
                    raise ValueError(f"data.{name}.columns.{key}.gain is 0; the column says nothing then")
        if self.plan is not None and (self.plan.vary is None) != (not self.plan.values):
            raise ValueError("plan.vary and plan.values belong together; give both or neither")
        for name, other in self.alternatives.items():
            for one in other.unknowns or ():
                if one not in self.unknowns:
                    raise ValueError(f'alternatives.{name}.unknowns has "{one}"; there is no such table in unknowns')
