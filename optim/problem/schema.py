"""The tables of a study file."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal, NamedTuple

from pydantic import AfterValidator, Field

from linkages.input.files.formula import CONSTANTS, FUNCTIONS
from linkages.input.files.toml import Finite, NonNegative, Positive, Table

FunctionalName = Literal["peak", "max", "min", "range", "fluctuation", "mean", "rms", "integral"]
Aggregate = Literal["max", "mean", "min"]

#: Prefix of the name of a service life in the outputs of terms.
LIFE = "life."

#: Name of the algorithm that samples the scatter.
SAMPLING = "scatter"


def _check_bound(value: Any) -> Any:
    number = isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
    if not number and not isinstance(value, str):
        raise ValueError(f"is {value!r}; give a number, or a formula between quotes")
    return value


Bound = Annotated[Any, AfterValidator(_check_bound)]


class Variable(Table):
    """A design variable: a value of the experiment or of its SDF file, between bounds."""

    path: str = Field(
        description="dotted path: joints.A.viscosity, sdf.links.link2.mass; scatter.NAME.factor multiplies a tolerance"
    )
    lower: Bound = Field(description="bound: a number, or a formula of constants")
    upper: Bound = Field(description="bound: a number, or a formula of constants")
    relative: bool = Field(False, description="whether the bounds are multiples of the nominal value")
    nominal: Finite | None = Field(None, description="start value; default: the experiment's")


#: Kinds of distributions by their numbers of parameters.
SHAPES = {"uniform": 2, "normal": 2, "truncated": 4, "triangular": 3, "lognormal": 2, "beta": 4}


class ScatterTable(Table):
    """A value that scatters from machine to machine: a path and its distribution."""

    path: str = Field(description="dotted path: joints.A.clearance, sdf.links.link2.mass")
    fit: str | None = Field(None, description='ISO fit of a joint, "30 H7/f7": its radial clearance')
    parts: Literal["normal", "uniform", "triangular"] = Field(
        "normal", description="distribution of hole and shaft; normal: limits are 3 deviations"
    )
    interference: Literal["refuse", "failed"] = Field(
        "refuse", description="whether a fit that allows interference is refused, or such machines count as failed"
    )
    uniform: list[Bound] | None = Field(None, description="lower, upper")
    normal: list[Bound] | None = Field(None, description="mean, deviation")
    truncated: list[Bound] | None = Field(None, description="normal between limits: mean, deviation, lower, upper")
    triangular: list[Bound] | None = Field(None, description="lower, mode, upper")
    lognormal: list[Bound] | None = Field(None, description="mean, deviation")
    beta: list[Bound] | None = Field(None, description="exponents a and b, lower, upper")
    empirical: str | None = Field(None, description="file of measured values, one a line, SI unit")
    relative_to: Literal["nominal"] | None = Field(None, description='"nominal": added to the value of the experiment')

    def _complete(self) -> None:
        kinds = ("fit", "empirical", *SHAPES)
        given = [kind for kind in kinds if getattr(self, kind) is not None]
        if len(given) != 1:
            raise ValueError(f"has {' and '.join(given) or 'no distribution'}; give one of {', '.join(kinds)}")
        kind, numbers = given[0], getattr(self, given[0])
        if kind in SHAPES and len(numbers) != SHAPES[kind]:
            raise ValueError(f"{kind} has {len(numbers)} numbers; give {SHAPES[kind]}")
        if given == ["fit"] and self.relative_to is not None:
            raise ValueError("relative_to has no meaning for a fit")


class Correlation(Table):
    """A correlation between scattering values."""

    names: Annotated[list[str], Field(min_length=2)] = Field(description="scattering values, each pair of them")
    correlation: Annotated[float, Field(gt=-1, lt=1)] = Field(description="of the normal numbers of a Gaussian copula")


class StudyWindow(Table):
    """Times over which functionals are taken: `count` equal windows between start and end."""

    start: NonNegative = Field(description="[s], or revolutions")
    end: Positive = Field(description="[s], or revolutions")
    count: Annotated[int, Field(ge=1, le=10000)] = Field(1, description="number of equal windows")
    revolutions_of: str | None = Field(
        None, description="drive whose revolutions start and end count, at its speed in each operating point"
    )

    def _complete(self) -> None:
        if self.end <= self.start:
            raise ValueError(f"end, {self.end:g}, must be after start, {self.start:g}")


class ServiceLife(Table):
    """Service life: cycles until a quantity of the wear exceeds a limit; the output ``life.NAME``."""

    until: str = Field(description="JOINT.depth, JOINT.play [m], or the mean peak in a cycle of JOINT.force, .jitter")
    limit: Positive = Field(description="in the quantity's unit")
    cycles: Annotated[float, Field(ge=1, lt=1e15)] = Field(
        description="limit of simulated revolutions; longer lives count as this number"
    )
    drive: str | None = Field(
        None,
        description="drive that counts the cycles; default: the first with constant speed, else the first periodic one",
    )
    tolerance: Positive | None = Field(None, description="tolerance of the depth in a jump, as in `linkages wear` [m]")
    scatter: Positive | None = Field(None, description="scatter of the work of all cycles, as in `linkages wear` [1]")


class PointTable(Table):
    """An operating point: the experiment with some values replaced."""

    set: dict[str, Any] = Field({}, description="values by dotted path")
    linked: dict[str, Any] = Field(
        {}, description="formulas of the variables by dotted path; they may replace the path of a variable"
    )


class Term(Table):
    """A functional of one output."""

    functional: FunctionalName = Field(
        description="peak: largest magnitude; range: max - min; fluctuation: range/|mean|; integral over time"
    )
    output: str = Field(
        description="an output (slider7.ax, A.force, O1.torque; see Outputs), + .jitter: less the ideal linkage's;"
        " of the ideal linkage, without a run: ideal.NAME, ideal.JOINT.turning_rate; cycles of a life: life.NAME"
    )
    weight: Finite = Field(1.0, description="factor of this term")
    window: str = Field("run", description='a name in [windows], or "run": all of it')
    over_windows: Aggregate = Field("max", description="combination of several windows")
    over_points: Aggregate = Field("max", description="combination of several operating points")


class Share(NamedTuple):
    """The share of machines whose quantity has these limits."""

    at_least: float = -math.inf
    at_most: float = math.inf


_COMBINATIONS = ("mean", "deviation", "max", "min")


def _check_combination(value: Any) -> Any:
    """Accept a name, a quantile, or a table of limits."""
    if value in _COMBINATIONS or (isinstance(value, float) and 0.0 < value < 1.0):
        return value
    known = isinstance(value, dict) and bool(value) and set(value) <= set(Share._fields)
    if known and all(isinstance(end, int | float) and math.isfinite(end) for end in value.values()):
        return Share(**value)
    names = ", ".join(_COMBINATIONS)
    raise ValueError(f"is {value!r}; give {names}, a number between 0 and 1, or {{ at_most = 3.0, at_least = 1.0 }}")


#: Combination of the machines of a design; a number is a quantile.
OverScatter = str | float | Share


class StudyQuantity(Table):
    """A number of a design: functionals, weighted and summed, or a formula of the variables."""

    terms: Annotated[list[Term], Field(min_length=1)] | None = Field(None, description="weighted functionals")
    over_terms: Literal["sum", "max", "min"] = Field("sum", description="combination of several weighted terms")
    formula: str | None = Field(None, description="formula of the variables and constants")
    relative: bool = Field(False, description="whether it is divided by the nominal design's value")
    over_scatter: Annotated[Any, AfterValidator(_check_combination)] = Field(
        None,
        description="combination of the machines of a design, with [scatter]: mean, deviation, max, min, a quantile"
        " such as 0.99, or the share of machines within limits, { at_most = 3.0 }",
    )
    unit: str = Field("", description="for tables and figures")

    def _complete(self) -> None:
        if (self.terms is None) == (self.formula is None):
            raise ValueError("give either terms or formula")


class Objective(StudyQuantity):
    """A quantity that is minimised, or maximised."""

    maximise: bool = Field(False, description="whether it is maximised instead")


class Constraint(StudyQuantity):
    """A quantity with limits, in its unit, or in multiples of the nominal value if relative."""

    at_most: Finite | None = Field(None, description="upper limit")
    at_least: Finite | None = Field(None, description="lower limit")
    equals: Finite | None = Field(None, description="prescribed value")
    hard: bool = Field(
        False,
        description="with a formula: designs beyond the limit are never run, not even for derivatives; they may jam",
    )

    def _complete(self) -> None:
        super()._complete()
        sided = self.at_most is not None or self.at_least is not None
        if sided == (self.equals is not None):
            raise ValueError("give at_most, at_least or both, or equals alone")
        if self.at_most is not None and self.at_least is not None and self.at_least >= self.at_most:
            raise ValueError("at_least must be below at_most")


class StudyFile(Table):
    """A design study and how it is solved. SI units."""

    experiment: str = Field(description="experiment file, in the same folder or a shipped one")
    title: str = Field("", description="one line for tables and figures")
    seed: Annotated[int, Field(ge=0, lt=2**32)] = Field(1, description="seed of the random numbers")
    set: dict[str, Any] = Field({}, description="replaced values of the experiment, by dotted path")
    constants: dict[str, Finite] = Field({}, description="names for formulas")
    variables: dict[str, Variable] = Field({}, description="design variables by name")
    scatter: dict[str, ScatterTable] = Field({}, description="scattering values by name")
    correlated: list[Correlation] = Field([], description="correlations of scattering values")
    machines: Annotated[int, Field(ge=2, le=10**6)] = Field(
        64, description="machines of a design in a search with [scatter]: Sobol points, the same ones for all designs"
    )
    linked: dict[str, Any] = Field({}, description="formulas of the variables by dotted path")
    windows: dict[str, StudyWindow] = Field({}, description="times by name")
    lives: dict[str, ServiceLife] = Field({}, description="service lives by name")
    points: dict[str, PointTable] = Field({}, description="operating points by name; default: the experiment")
    objectives: dict[str, Objective] = Field({}, description="objectives by name")
    constraints: dict[str, Constraint] = Field({}, description="constraints by name")
    designs: dict[str, dict[str, Any]] = Field(
        {}, description="reference designs by name, for tables and figures: values of variables by dotted path"
    )
    algorithm: dict[str, Any] = Field(description="name and settings of the algorithm")

    @property
    def sampled(self) -> bool:
        """Tell whether the study samples the scatter instead of searching a design."""
        return self.algorithm.get("name") == SAMPLING

    def _complete(self) -> None:
        needed = ("scatter",) if self.sampled else ("variables", "objectives")
        for key in needed:
            if not getattr(self, key):
                raise ValueError(f"[{key}] is missing, or empty")
        if self.sampled and not (self.objectives or self.constraints):
            raise ValueError("[constraints] is missing, or empty")
        for name, quantity in (self.objectives | self.constraints).items():
            needs = bool(self.scatter) and not self.sampled and quantity.terms is not None
            if needs and quantity.over_scatter is None:
                raise ValueError(f'{name} needs over_scatter, such as "mean" or 0.99, as there is [scatter]')
            if quantity.over_scatter is not None and not (self.scatter and not self.sampled):
                raise ValueError(f"over_scatter of {name} needs [scatter] and an algorithm that searches")
        taken: set[str] = set(CONSTANTS) | set(FUNCTIONS)
        for name in (*self.constants, *self.variables, *self.scatter):
            if not name.isidentifier():
                raise ValueError(f'"{name}" cannot be used in formulas; use letters, digits and _')
            if name in taken:
                raise ValueError(f'"{name}" is taken; choose another name')
            taken.add(name)
        if "run" in self.windows:
            raise ValueError('the window "run" is all of the run; choose another name')
        both = set(self.objectives) & set(self.constraints)
        if both:
            raise ValueError(f'"{min(both)}" names an objective and a constraint')
