"""Derivatives of a run's outputs with respect to values: by path and output, with a status."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any, NamedTuple

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


@dataclass(frozen=True, repr=False)
class Derivatives(Mapping[str, Columns]):
    """Derivatives of outputs at fixed times: ``run.sensitivity["joints.A.clearance"]["A.force"]``.

    Attributes
    ----------
    columns : dict of dict of (nt,) arrays
        By path and output, at the run's times, in units of the output per unit of the value; NaN where there is none.
    status : str
        Why derivatives end; see `MEANING`.
    until : float
        Last time with derivatives [s].
    evaluate : callable
        Function that gives the same at times (n,) of the run, in any order; InputError for times outside.
    """

    columns: dict[str, Columns]
    status: str
    until: float
    evaluate: Callable[[Array], dict[str, Columns]] = field(compare=False)

    def __getitem__(self, path: str) -> Columns:
        if path not in self.columns:
            raise InputError("argument", path, f"has no derivatives; {nearest(path, self.columns)}")
        return self.columns[path]

    def __iter__(self) -> Iterator[str]:
        return iter(self.columns)

    def __len__(self) -> int:
        return len(self.columns)


#: Of a run without any.
NONE = Derivatives({}, OK, 0.0, lambda times: {})
