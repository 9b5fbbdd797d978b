"""The result of an identification as data, which is the content of ``result.json`` too."""

from __future__ import annotations

from typing import Any, NamedTuple

from pydantic import Field

from linkages.input.files.entry import Entry, Number


class Interval(NamedTuple):
    """The two ends of an interval."""

    lower: float
    upper: float


class Rise(NamedTuple):
    """A point of a profile likelihood: the unknown's value, and the rise of chi-square there."""

    value: float
    rise: float


class Stage(NamedTuple):
    """A window of a fit.

    Attributes
    ----------
    runs : float
        Number of runs so far.
    end : float
        End of the window [s].
    chi_square : float
        Of a sample.
    """

    runs: float
    end: float
    chi_square: float


class Parameter(Entry):
    """A value that was found, with its deviation and 95 % interval, None if it is not identifiable; its profile."""

    path: str
    value: float
    unit: str
    deviation: Number
    interval: Interval | None
    identifiable: bool
    profile: list[Rise] = Field(default=[])
    profile_interval: Interval | None = None
    profile_runs: int = 0


class Nuisance(Entry):
    """A fitted gain, offset or shift, and its deviation."""

    value: float
    deviation: Number


class Residual(Entry):
    """Residuals and their tests, a row for each of the `columns`."""

    columns: list[str]
    rms: list[Number]
    deviation: list[float]
    samples: list[int]
    autocorrelation_time: list[float]
    chi_square: list[Number]
    chi_square_probability: list[Number]
    whiteness: list[Number]
    normality: list[Number]
    model_error: list[Number]


class Accuracy(Entry):
    """Accuracy of the runs, and the largest shift of a value by their error, in deviations."""

    given: float
    used: float
    largest_shift: Number


class Pair(Entry):
    """Two unknowns that the data determine together only."""

    unknowns: list[str]
    correlation: float
    together: str
    apart: float


class Correlations(Entry):
    """Correlations of all values; None where a value is not told."""

    names: list[str]
    matrix: list[list[Number]]


class Prediction(Entry):
    """Root mean squares of the residuals after the fitted part, by column."""

    start: float = Field(alias="from")
    rms: dict[str, Number]


class Curve(Entry):
    """Measured and computed samples of a column, at times of the file [s]."""

    unit: str
    time: list[float]
    measured: list[float]
    computed: list[float]


class ColumnNumbers(Entry):
    """Statistics of a column; the last two are means over parts of the run."""

    mean: float
    deviation: float
    highest: float
    lowest: float


class Compared(Entry):
    """Measured and computed statistics of a column."""

    measured: ColumnNumbers
    computed: ColumnNumbers


class Starts(Entry):
    """How many starts have ended at the best chi-square."""

    count: int
    same: int
    chi_square: list[Number]


class Alternative(Entry):
    """A model with other laws, fitted to the same data."""

    prediction: Prediction | None
    chi_square: float
    parameters: dict[str, Parameter]


class Sampled(Entry):
    """Posterior of an unknown."""

    median: float
    deviation: float
    interval: Interval


class Posterior(Entry):
    """Samples of the posterior; made by `optim.identify.posterior.posterior`."""

    parameters: dict[str, Sampled]
    samples: list[list[float]]
    walkers: int
    runs: int
    acceptance: float
    autocorrelation_times: float
    enough: bool


class IdentificationResult(Entry):
    """The result of an identification; made by `optim.identify`.

    Its numbers are attributes, ``found.parameters["mass"].interval.lower``, and entries, ``found["parameters"]``; its
    `content` is that of ``result.json``. SI units.

    Attributes
    ----------
    parameters : dict of str to Parameter
    nuisance : dict of str to Nuisance
        Gains, offsets and shifts of sensors.
    mixtures : list of str
        Mixtures of unknowns that the data leave open.
    sensors : list of str
        Sensors that would determine them.
    fitted_until : float
        End of the fitted part [s].
    curves, statistics : dict
        Compared samples, or numbers by column and name.
    value_of : dict of str to float
        Values by name: the key ``values``.
    starts : Starts
    alternatives : dict of str to Alternative
        This model is "this".
    other_laws : dict of str to float
        How far each unknown lies from this model's value in those that predict nearly as well.
    file : dict
        The file and its data.
    time_over : bool
        Whether the limit of time ended the fit, or that of an alternative.
    wall_time : float
        [s]
    """

    parameters: dict[str, Parameter]
    nuisance: dict[str, Nuisance]
    residual: Residual
    assumed: str
    accuracy: Accuracy
    correlated: list[Pair]
    correlation: Correlations
    prediction: Prediction | None
    singular_values: list[float]
    mixtures: list[str]
    sensors: list[str]
    fitted_until: float
    warnings: list[str]
    history: list[Stage]
    curves: dict[str, Curve]
    statistics: dict[str, Compared]
    value_of: dict[str, float] = Field(alias="values")
    starts: Starts
    alternatives: dict[str, Alternative] = Field(default={})
    best_alternative: str = ""
    other_laws: dict[str, float] = Field(default={})
    posterior: Posterior | None = None
    title: str
    file: Any
    runs: int
    time_over: bool = False
    versions: dict[str, str]
    wall_time: float
