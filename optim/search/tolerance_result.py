"""The result of a study of tolerances as data, which is the content of ``tolerances.json`` too; docs/tolerances.md."""

from __future__ import annotations

from typing import Any, NamedTuple

from pydantic import Field

from linkages.input.files.entry import Entry, Number


class Interval(NamedTuple):
    """The two ends of an interval."""

    lower: float
    upper: float


class Quantile(NamedTuple):
    """A quantile of a sample, and the ends of its interval, None where the sample is short."""

    value: float
    lower: float | None
    upper: float | None


class Yield(Entry):
    """Share of the machines that meet all limits."""

    value: float
    interval: Interval


class Scattering(Entry):
    """Distribution of a value, and its tolerance limits."""

    path: str
    mean: float
    deviation: float
    lower: float
    upper: float


class Histogram(Entry):
    """Machines in each bin, and the edges of the bins."""

    counts: list[int]
    edges: list[float]


class Share(Entry):
    """Share of the variance that a value causes alone, and with others."""

    first: Number
    first_error: Number
    total: Number
    total_error: Number


class Variance(Entry):
    """Shares of the variance by value, and the share that no term explains."""

    of_values: dict[str, Share] = Field(alias="values")
    unexplained: Number


class FirstOrder(Entry):
    """Deviation of a quantity and shares of its variance from derivatives at the means; `why` if there is none."""

    deviation: Number
    error: Number
    shares: dict[str, float] | None
    why: str = Field(alias="unknown")


class Corners(Entry):
    """Extremes of a quantity at the corners of the limits, and the share of machines beyond them."""

    count: int
    range: Interval | None
    failed: int
    outside: float = 0.0


class QuantityStatistics(Entry):
    """Statistics of an objective or constraint; `why` has a sentence for each that has no value."""

    limits: dict[str, float]
    why: list[str] = Field(alias="unknown")
    mean: Number = None
    mean_error: Number = None
    deviation: Number = None
    deviation_error: Number = None
    quantiles: dict[str, Quantile] = Field(default={})
    capability: Number = None
    histogram: Histogram | None = None
    unpredictable_deviation: Number = None
    variance: Variance | None = None
    first_order: FirstOrder | None = None
    corners: Corners | None = None

    @property
    def alone(self) -> dict[str, float | None]:
        """Return the share of the variance that each value alone causes; empty if the shares are unknown."""
        return {} if self.variance is None else {name: one.first for name, one in self.variance.of_values.items()}


class Halved(Entry):
    """Yield with half a tolerance, and its standard error; None if no machine tells."""

    halved: Number
    error: Number


class MostProbable(Entry):
    """The most probable machine beyond a limit, and the share beyond it if it were a plane: FORM."""

    index: float
    share: float
    converged: bool
    iterations: int
    machine: dict[str, float]


class Climbed(Entry):
    """Estimate of a rare share by subset simulation."""

    share: float
    interval: Interval


class Weighted(Entry):
    """Estimate of a rare share by importance sampling, its standard error, and the part that failed."""

    share: float
    error: float
    failed: float


class Rare(Entry):
    """Share of machines beyond a limit that few exceed, None if there is none; `why`, or what is doubtful."""

    share: float | None
    interval: Interval | None
    why: str = Field(alias="unknown")
    subset: Climbed | None = None
    sampled: Weighted | None = None
    failed: float = 0.0
    form: MostProbable | None = None


class ToleranceResult(Entry):
    """The result of a study of tolerances; made by `optim.tolerances`.

    Its numbers are attributes, ``result.outputs["force"].mean``, and entries, ``result["outputs"]``; its `content` is
    that of ``tolerances.json``, where `share` is ``yield``, and `why` is ``unknown``. SI units.

    Attributes
    ----------
    samples, failed : int
        Number of machines, and of those that failed, by reason in `failures`.
    share : Yield
        Share of the machines that meet all limits: the key ``yield``.
    violated : dict of str to int
        Machines beyond each limit.
    scatter : dict of str to Scattering
    outputs : dict of str to QuantityStatistics
    shares : dict
        `QuantityStatistics.alone` of each quantity.
    contributions : dict of str to Halved
        Yields with half of each tolerance, the best first.
    rare : dict of str to Rare
    """

    study: str
    title: str
    seed: int
    algorithm: dict[str, Any]
    labels: dict[str, str]
    samples: int
    failed: int
    failures: dict[str, int]
    share: Yield = Field(alias="yield")
    violated: dict[str, int]
    scatter: dict[str, Scattering]
    outputs: dict[str, QuantityStatistics]
    shares: dict[str, dict[str, Number]]
    contributions: dict[str, Halved]
    rare: dict[str, Rare]
    versions: dict[str, str]
