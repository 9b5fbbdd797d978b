"""Derivatives of a run's outputs with respect to values: by path and output, with a status."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field

from linkages.arrays import Array
from linkages.errors import InputError, nearest
from linkages.outputs.columns import Columns

#: Status of derivatives: known up to the end of the run; up to a contact that begins without speed; up to the horizon
#: of predictability; up to a step whose equations are singular.
OK, GRAZING, HORIZON, STUCK = "ok", "grazing", "horizon", "singular"
#: What each status means.
MEANING = {
    OK: "known up to the end of the run",
    GRAZING: "a contact begins without speed: whether it begins depends on the values",
    HORIZON: "beyond, errors of the run change the state visibly: a derivative has no meaning",
    STUCK: "the equations of a step are singular",
}


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
        Function that gives the same at any times of the run.
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
