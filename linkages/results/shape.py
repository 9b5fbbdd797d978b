"""A summary as data, which is the schema of ``summary.json`` too; docs/summary_json.md explains the keys."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Self

from pydantic import Field, model_validator

from linkages.base.errors import Status
from linkages.input.files.entry import Entry, Number
from linkages.input.files.toml import Finite, NonNegative, leaves
from linkages.input.model.experiment import Experiment

StatusName = Annotated[str, Field(pattern=f"^({'|'.join(status.value for status in Status)})$")]


class Peak(Entry):
    """Largest magnitude of a quantity, and its time [s]."""

    peak: Number
    time: Number = None


class _Bounds(Entry):
    min: Number
    max: Number


class Range(Peak, _Bounds):
    """Extremes of an output."""


class Ratio(Entry):
    """Largest eccentricity ratio."""

    peak: Finite


class Least(Entry):
    """Thinnest film [m], its time [s], and its share of the clearance."""

    min: Finite
    time: Finite
    share: Finite


class Difference(Entry):
    """Largest difference from the ideal motion, its time [s], and its share of the ideal range or peak."""

    peak: Finite
    time: Finite
    share: Number


class Heat(Entry):
    """Heat balance of a joint over a part of the run; units as in docs/summary_json.md."""

    model: str = "lumped"
    temperature: Finite
    viscosity: Finite
    power: Finite
    flow: Finite
    by_flow: Finite
    by_conduction: Finite
    change: Number = None
    start: Number = Field(None, alias="from")
    to: Number = None


class JointNumbers(Entry):
    """Numbers of a joint: with clearance also of its journal, film, contacts and oil."""

    model: str
    force: Peak
    eccentricity_ratio: Ratio | None = None
    film_thickness: Least | None = None
    contact_fraction: Finite | None = None
    impacts: int | None = Field(None, ge=0)
    tilting_moment: Peak | None = None
    heat: Heat | None = None

    @model_validator(mode="after")
    def _goes_together(self) -> Self:
        if (self.force.peak is None) != (self.force.time is None):
            raise ValueError("force: peak and time must both be given")
        for key in ("eccentricity_ratio", "contact_fraction", "impacts"):
            if (self.model == "ideal") != (getattr(self, key) is None):
                raise ValueError(f"{key}: allowed only with a model that is not ideal")
        return self


class Drive(Entry):
    """Torque [N m] or force [N] of a drive, its work [J], and the fluctuation of a free speed."""

    torque: Peak
    work: Number
    unit: str
    acts: bool = True
    fluctuation: Number = None


class Load(Entry):
    """Force or torque of a load, an element, a gear, a stop or a contact, and its work [J]."""

    force: Peak | None = None
    torque: Peak | None = None
    work: Number
    contact_fraction: Finite | None = None
    impacts: int | None = Field(None, ge=0)


class Placed(Peak):
    """Peak along a flexible link, and its place [m]."""

    place: Number


class Link(Entry):
    """Peaks of a flexible link."""

    deflection: Placed
    bending: Peak
    stress: Placed


class Numbers(Entry):
    """Characteristic numbers of a motion or a part of it."""

    outputs: dict[str, Range]
    joints: dict[str, JointNumbers]
    drives: dict[str, Drive]
    loads: dict[str, Load] = Field({})
    links: dict[str, Link] = Field({})
    difference: dict[str, Difference] = Field({})

    @property
    def peaks(self) -> dict[str, float | None]:
        """Return all peaks by key, see `peaks_by_key`."""
        return peaks_by_key(self)

    def lacks(self, other: Numbers) -> str:
        """Name an entry of the other numbers that is missing here; "" if none is."""
        for kind in ("outputs", "joints", "drives", "loads"):
            for name in getattr(other, kind):
                if name not in getattr(self, kind):
                    return f"{kind}.{name}"
        return ""


def peaks_by_key(numbers: Numbers | Mapping[str, Any]) -> dict[str, float | None]:
    """Return all peaks of a summary by key: ``slider7.ax.peak``, ``A.force.peak``."""
    result = {f"{name}.peak": value["peak"] for name, value in numbers["outputs"].items()}
    for kind in ("joints", "drives", "loads", "links"):
        for name, entry in numbers.get(kind, {}).items():
            for quantity, value in entry.items():
                if isinstance(value, Mapping) and "peak" in value:
                    result[f"{name}.{quantity}.peak"] = value["peak"]
    return result


class _Outcome(Entry):
    status: StatusName


class Ideal(Numbers, _Outcome):
    """Numbers of the ideal motion."""


class _Span(Entry):
    start: Finite = Field(alias="from")
    to: Finite


class Window(Numbers, _Span):
    """Numbers of a part of the run."""

    ideal: Numbers | None
    error: dict[str, Number] = Field({})

    @model_validator(mode="after")
    def _is_whole(self) -> Self:
        if self.ideal is not None and (missing := self.ideal.lacks(self)):
            raise ValueError(f"ideal.{missing} is missing")
        return self


class Cut(Entry):
    """Joints that are cut to get a tree."""

    play: list[str]
    ideal: list[str]


class Machine(Entry):
    """The linkage of a run."""

    name: str
    mobility: int
    driven: list[str]
    joints: dict[str, list[str]] = Field({})
    colors: dict[str, str] = Field({})
    cut: Cut
    quality: Number
    loop_error: Finite


class FinalMotion(Entry):
    """Classification of the motion at the end of the run."""

    kind: str | None
    why: str
    period: Number
    periods: int | None
    since: Number


class RunWarning(Entry):
    """A doubt about numbers: its kind, its time [s], what to do, and values to try by dotted path."""

    kind: str
    time: Number
    what: str
    remedy: str
    changes: dict[str, str | int | Finite] = Field(default={})  # earlier files have none


class _Ran(Experiment):
    file: str


class Provenance(Entry):
    """What ran, and where it came from."""

    versions: dict[str, str | None]
    experiment: Any  # the tables of the experiment, with overrides; `RecordedProvenance` checks them
    folder: str | None = None
    sources: dict[str, str]
    run: dict[str, str | int | Finite]
    wall_time: NonNegative


class Fit(Entry):
    """A smooth curve through a part of a signal."""

    text: str
    rows: int
    residual: Finite
    deviation: Finite


class Recorded(Entry):
    """A signal from a data file."""

    file: str
    fits: list[Fit]


class Comparison(Entry):
    """A measured curve against the run, in the output's unit; times [s]."""

    column: str
    rows: int
    rms: Finite
    largest: Finite
    time: Finite
    peak: Finite


class _Run(Entry):
    engine: str
    duration: NonNegative
    status: StatusName
    mechanism: Machine


class Summary(Numbers, _Run):
    """The summary of an assessment; made by `linkages.summarize`.

    Its numbers are attributes, ``summary.joints["A"].force.peak``, and entries, ``summary["joints"]["A"]``; its
    `content` is that of ``summary.json``.
    """

    ideal: Ideal | None
    no_ideal: str | None = None
    recorded: dict[str, Recorded] = Field({})
    measured: dict[str, Comparison] = Field({})
    motion: FinalMotion
    start_up: Number = None
    report: str
    error: dict[str, Number]
    error_until: Number = None
    warnings: list[RunWarning]
    windows: dict[str, Window]
    provenance: Provenance
    smoothing: dict[str, dict[str, Finite]] = Field({})

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


class _RecordedProvenance(Provenance):
    experiment: _Ran

    @model_validator(mode="after")
    def _is_whole(self) -> Self:
        known = {path for path, _ in leaves(self.experiment.model_dump(exclude_unset=True))}
        tables = {".".join(parts[:k]) for parts in (path.split(".") for path in known) for k in range(1, len(parts))}
        if missing := self.sources.keys() - known - tables:
            raise ValueError(f"experiment.{min(missing)} has a source and no value")
        return self


class SummaryFile(Summary):
    """The schema of ``summary.json``: a summary whose experiment is checked."""

    provenance: _RecordedProvenance
