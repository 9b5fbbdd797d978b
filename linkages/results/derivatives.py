"""Derivatives of a run's outputs with respect to values: by path and output, with a status."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any, NamedTuple

import numpy as np

from linkages.base.arguments import number, several
from linkages.base.arrays import Array
from linkages.base.errors import InputError, nearest
from linkages.results.outputs.columns import Columns

#: Status of derivatives; the last two are of a row of a batch.
OK, GRAZING, HORIZON, STUCK, REFUSED, NO_RUN = "ok", "grazing", "horizon", "singular", "refused", "no run"
#: What each status means.
MEANING = {
    OK: "known up to the end of the run",
    GRAZING: "a contact begins without speed: whether it begins depends on the values",
    HORIZON: "beyond, errors of the run change the state visibly: a derivative has no meaning",
    STUCK: "the equations of a step are singular",
    REFUSED: "no neighbouring value is valid, or it changes the structure of the system",
    NO_RUN: "the run did not reach its end",
}


class Direction(NamedTuple):
    """A value that the values at several paths follow.

    Attributes
    ----------
    name : str
    value : float
        Its own value; differences use its magnitude.
    rates : mapping of str to float
        Derivative of the value at each dotted path with respect to it.

    Examples
    --------
    >>> import linkages
    >>> system = linkages.load(linkages.find_file("seven_bar.toml"), {"duration": 0.01})
    >>> oil = linkages.Direction("viscosity", 0.3, {"joints.A.viscosity": 1.0, "joints.B.viscosity": 1.0})
    >>> run = linkages.simulate(system, outputs=["A.force"], wrt=[oil, "joints.A.viscosity", "joints.B.viscosity"])
    >>> parts = run.sensitivity["joints.A.viscosity"]["A.force"] + run.sensitivity["joints.B.viscosity"]["A.force"]
    >>> bool(abs(run.sensitivity["viscosity"]["A.force"] - parts).max() < 1e-5 * abs(parts).max())
    True
    """

    name: str
    value: float
    rates: Mapping[str, float]


def values_to_move(values: Any) -> tuple[str | Direction, ...]:
    """Convert a list of dotted paths and `Direction` to a tuple; ValueError for others."""
    found = several(values)
    for one in found:
        if not isinstance(one, str | Direction):
            raise ValueError(f"has {one!r}; give dotted paths, or Direction of linkages")
        if isinstance(one, Direction):
            number(one.value)
    return found


#: Type of arguments ``wrt``.
Wrt = Annotated[Sequence[str | Direction], values_to_move]


@dataclass(frozen=True, repr=False, eq=False)
class Derivatives(Mapping[str, Columns]):
    """Derivatives of outputs at fixed times: ``run.sensitivity["joints.A.clearance"]["A.force"]``.

    They are computed at first use.

    Attributes
    ----------
    paths : tuple of str
        Paths of the values.
    status : str
        Why derivatives end; see `MEANING`.
    until : float
        Last time with derivatives [s].
    times : (nt,) array
        Times of the run [s].
    with_values : callable
        Function that gives the outputs at times (n,) of the run, in any order, and their derivatives by path;
        InputError for times outside.
    """

    paths: tuple[str, ...]
    status: str
    until: float
    times: Array
    with_values: Callable[[Array], tuple[Columns, dict[str, Columns]]]

    @cached_property
    def columns(self) -> dict[str, Columns]:
        """Derivatives by path and output, at the run's times, in units of the output per unit of the value.

        NaN where there is none.
        """
        return self.evaluate(self.times)

    def evaluate(self, times: Array) -> dict[str, Columns]:
        """Return the derivatives at times (n,) of the run [s], in any order; InputError for times outside."""
        return self.with_values(times)[1]

    def __getitem__(self, path: str) -> Columns:
        if path not in self.paths:
            raise InputError("argument", path, f"has no derivatives; {nearest(path, self.paths)}")
        return self.columns[path]

    def __iter__(self) -> Iterator[str]:
        return iter(self.paths)

    def __len__(self) -> int:
        return len(self.paths)


#: Of a run without any.
NONE = Derivatives((), OK, 0.0, np.zeros(0), lambda times: ({}, {}))
