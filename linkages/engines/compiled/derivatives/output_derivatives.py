"""Derivatives of outputs: their formulas, evaluated with duals."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import cast

import numpy as np

from linkages.base.kernel import Array
from linkages.base.kernel.compile import bound
from linkages.base.kernel.dual import DIRECTIONS
from linkages.engines.compiled.derivatives.neighbours import Neighbours
from linkages.mechanics.planar.arrays import size_of
from linkages.results.outputs.columns import Columns, columns
from linkages.results.outputs.evaluation import make_dual_table, make_snapshot, slopes
from linkages.results.outputs.registry import JITTER, names, packer
from linkages.system import System
from linkages.system.ideal_motion import IdealMotion
from linkages.system.rigid_segments import Segmented


class OutputTable:
    """Outputs of a system, whose numbers follow values.

    Parameters
    ----------
    system : System
    wanted : sequence of str, optional
        Names of outputs; default: all. With rigid segments: outputs of the linkage of segments.
    nearby : sequence of Neighbours
        Of np values.
    ideals : IdealMotions
        Of the system and of neighbouring ones.
    """

    def __init__(
        self, system: System, wanted: Sequence[str] | None, nearby: Sequence[Neighbours], ideals: IdealMotions
    ) -> None:
        self._system, self._ideals, self._nearby = system, ideals, nearby
        self.names = _all_names(system) if wanted is None else list(wanted)
        read, n = packer(system, self.names), size_of(system.arrays)
        records = read(system)
        self._table, self._memory = make_dual_table(system.arrays, records, n)
        after = records.nbytes // 8  # place of the arrays
        changes = [(near.rates(read), near.arrays) for near in nearby]
        self._changes = [
            (np.concatenate([own.places, after + arrays.places]), np.concatenate([own.rates, arrays.rates]))
            for own, arrays in changes
        ]
        self._given = bool(records["forces"].any()), make_snapshot(system.arrays, n)
        self._jitter = [k for k, one in enumerate(records) if one["jitter"]]

    def evaluate(
        self, times: Array, state: Sequence[Array], change: Sequence[Array]
    ) -> tuple[Columns, dict[str, Columns]]:
        """Compute the outputs, and their derivatives by the path of the value.

        Parameters
        ----------
        times : (nt,) array
        state, change : arrays
            Coordinates, rates, accelerations (nt, n) and contacts (nt, nc, WIDTH), and their derivatives, see
            `linkages.engines.compiled.derivatives.run_derivatives.Changes`.
        """
        values = np.zeros((len(self.names), len(times)))
        result = np.zeros((len(self._nearby), *values.shape))
        fill: Callable[..., None] | None = None
        for first in range(0, len(result), DIRECTIONS):
            part = slice(first, first + DIRECTIONS)
            self._memory[:, 1:] = 0.0
            for k, (places, rates) in enumerate(self._changes[part], 1):
                self._memory[places, k] = rates
            given = self._table, *self._given, np.asarray(times, np.float64), *state, *change, first, values
            fill = fill or cast(Callable[..., None], bound(slopes, *given, result[part]))
            fill(*given, result[part])
        if self._jitter:
            plain = [self.names[k].removesuffix(JITTER) for k in self._jitter]
            values[self._jitter] -= self._ideals(self._system, times, plain)
            for near, rows in zip(self._nearby, result, strict=True):
                rows[self._jitter] -= near.derivative(lambda one: self._ideals(one, times, plain))
        return self._named(values), {
            near.path: self._named(rows) for near, rows in zip(self._nearby, result, strict=True)
        }

    def _named(self, rows: Array) -> Columns:
        return dict(zip(self.names, rows, strict=True))


def _all_names(system: System) -> list[str]:
    """Return the names of all outputs that a system has itself, of the whole linkage of rigid segments among them."""
    whole, own = system.whole if isinstance(system, Segmented) else system, set(names(system, False))
    return [name for name in names(whole, False) if name in own]


class IdealMotions:
    """Ideal motions of systems, each followed once."""

    def __init__(self) -> None:
        self._known: dict[System, IdealMotion] = {}

    def __call__(self, system: System, times: Array, wanted: Sequence[str]) -> Array:
        """Compute outputs (no, nt) of the ideal linkage of a system."""
        if system not in self._known:
            self._known[system] = IdealMotion(system)
        states = self._known[system].states(np.asarray(times, dtype=np.float64))
        found = columns(system, times, *states, names=wanted)
        return np.stack([found[name] for name in wanted])
