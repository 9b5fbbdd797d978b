"""Schemas of ``summary.json`` and ``wear.json``; docs/outputs.md explains the keys."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import ConfigDict, Field, model_validator

from linkages.base.errors import Status
from linkages.input.files.toml import Finite, NonNegative, Table, leaves
from linkages.input.model.experiment import Experiment
from linkages.input.model.worn import WornJoint

_Number = Finite | None  # null if meaningless
_Status = Annotated[str, Field(pattern=f"^({'|'.join(status.value for status in Status)})$")]


class _Entry(Table):
    """An object of the file; additional keys are ignored."""

    model_config = ConfigDict(extra="ignore")


class _Peak(_Entry):
    peak: _Number
    time: _Number = None


class _Extremes(_Peak):
    min: _Number
    max: _Number


class _Ratio(_Entry):
    peak: Finite


class _Least(_Entry):
    min: Finite
    time: Finite
    share: Finite


class _Difference(_Entry):
    peak: Finite
    time: Finite
    share: _Number


class _Heat(_Entry):
    temperature: Finite
    viscosity: Finite
    power: Finite
    flow: Finite
    by_flow: Finite
    by_conduction: Finite


class _JointNumbers(_Entry):
    model: str
    force: _Peak
    eccentricity_ratio: _Ratio | None = None
    film_thickness: _Least | None = None
    contact_fraction: Finite | None = None
    impacts: int | None = Field(None, ge=0)
    heat: _Heat | None = None
    tilting_moment: _Peak | None = None

    @model_validator(mode="after")
    def _goes_together(self) -> Self:
        if (self.force.peak is None) != (self.force.time is None):
            raise ValueError("force: peak and time must both be given")
        for key in ("eccentricity_ratio", "contact_fraction", "impacts"):
            if (self.model == "ideal") != (getattr(self, key) is None):
                raise ValueError(f"{key}: allowed only with a model that is not ideal")
        return self


class _Drive(_Entry):
    torque: _Peak
    unit: str
    work: _Number
    fluctuation: Finite | None = None
    acts: bool = True


class _Load(_Entry):
    force: _Peak | None = None
    torque: _Peak | None = None
    work: _Number
    contact_fraction: Finite | None = None
    impacts: int | None = Field(None, ge=0)


class _Placed(_Peak):
    place: _Number


class _Link(_Entry):
    deflection: _Placed
    bending: _Peak
    stress: _Placed


class _Numbers(_Entry):
    outputs: dict[str, _Extremes]
    joints: dict[str, _JointNumbers]
    drives: dict[str, _Drive]
    loads: dict[str, _Load] = Field({})
    links: dict[str, _Link] = Field({})
    difference: dict[str, _Difference] = Field({})

    def lacks(self, other: _Numbers) -> str:
        """Name an entry of the other numbers that is missing here; "" if none is."""
        for kind in ("outputs", "joints", "drives", "loads"):
            for name in getattr(other, kind):
                if name not in getattr(self, kind):
                    return f"{kind}.{name}"
        return ""


class _Ideal(_Numbers):
    status: _Status


class _Window(_Numbers):
    start: Finite = Field(alias="from")
    to: Finite
    ideal: _Numbers | None
    error: dict[str, _Number]

    @model_validator(mode="after")
    def _is_whole(self) -> Self:
        if self.ideal is not None and (missing := self.ideal.lacks(self)):
            raise ValueError(f"ideal.{missing} is missing")
        return self


class _Cut(_Entry):
    play: list[str]
    ideal: list[str]


class _Mechanism(_Entry):
    name: str
    mobility: int
    driven: list[str]
    joints: dict[str, list[str]] = Field({})
    colors: dict[str, str] = Field({})
    cut: _Cut
    quality: _Number
    loop_error: Finite


class _Motion(_Entry):
    kind: str | None
    why: str
    period: _Number
    periods: int | None
    since: _Number


class _Warning(_Entry):
    kind: str
    time: _Number
    what: str
    remedy: str
    changes: dict[str, str | float] = Field(default={})  # earlier files have none


class _Ran(Experiment):
    file: str


class _Provenance(_Entry):
    versions: dict[str, str | None]
    experiment: _Ran
    folder: str | None = None
    sources: dict[str, str]
    run: dict[str, str | Finite]
    wall_time: NonNegative

    @model_validator(mode="after")
    def _is_whole(self) -> Self:
        known = {path for path, _ in leaves(self.experiment.model_dump(exclude_unset=True))}
        tables = {".".join(parts[:k]) for parts in (path.split(".") for path in known) for k in range(1, len(parts))}
        if missing := self.sources.keys() - known - tables:
            raise ValueError(f"experiment.{min(missing)} has a source and no value")
        return self


class _Fit(_Entry):
    text: str
    rows: int
    residual: Finite
    deviation: Finite


class _Recorded(_Entry):
    file: str
    fits: list[_Fit]


class _Measured(_Entry):
    column: str
    rows: int
    rms: Finite
    largest: Finite
    time: Finite
    peak: Finite


class Summary(_Numbers):
    """The schema of ``summary.json``."""

    engine: str
    duration: NonNegative
    status: _Status
    mechanism: _Mechanism
    ideal: _Ideal | None
    no_ideal: str | None = None
    motion: _Motion
    start_up: _Number = None
    report: str
    error: dict[str, _Number]
    error_until: _Number = None
    warnings: list[_Warning]
    windows: dict[str, _Window]
    measured: dict[str, _Measured] = Field({})
    recorded: dict[str, _Recorded] = Field({})
    smoothing: dict[str, dict[str, Finite]] = Field({})
    provenance: _Provenance

    @model_validator(mode="after")
    def _is_whole(self) -> Self:
        for where, numbers in (("ideal", self.ideal), *((f"windows.{k}", w) for k, w in self.windows.items())):
            if numbers is not None and (missing := numbers.lacks(self)):
                raise ValueError(f"{where}.{missing} is missing")
        if self.ideal is None and not self.no_ideal:
            raise ValueError("no_ideal: is missing, and ideal is null")
        if self.report != "whole" and self.report not in self.windows:
            raise ValueError(f'report: the window "{self.report}" is missing')
        return self


class _WornJoint(WornJoint):
    volume: Finite
    depth: Finite
    play: Finite
    clearance: Finite
    load_distance: Finite


class _WearBlock(_Entry):
    cycles: int = Field(ge=0)
    error: _Number
    peaks: dict[str, Finite]
    joints: dict[str, _WornJoint]


class Record(_Entry):
    """The schema of ``record.json``: what a command was asked and what it found."""

    title: str
    question: str
    answer: list[str]
    table: str
    words: list[str]
    versions: dict[str, str]


class WearContent(_Entry):
    """The schema of ``wear.json``."""

    cycles: int = Field(ge=0)
    status: _Status
    title: str | None
    experiment: str
    joints: dict[str, _WornJoint]
    blocks: list[_WearBlock] = Field(min_length=1)
    simulated_cycles: int = Field(ge=0)
    tolerance: Finite

    @model_validator(mode="after")
    def _is_whole(self) -> Self:
        if missing := self.blocks[0].peaks.keys() - self.blocks[-1].peaks.keys():
            raise ValueError(f"blocks: the last one has no peak of {min(missing)}")
        return self
