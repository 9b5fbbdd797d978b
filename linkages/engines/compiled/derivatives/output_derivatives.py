"""Derivatives of outputs from derivatives of the state: differences of the fourth order of the outputs' formulas."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import cast

import numpy as np

from linkages.base.kernel import Array, kernel
from linkages.base.kernel.block import Duplicate, contents
from linkages.base.kernel.compile import bound
from linkages.engines.compiled.derivatives.neighbours import PAIRS, Neighbours
from linkages.mechanics.planar.arrays import Arrays
from linkages.mechanics.planar.contacts import EX, EY
from linkages.results.outputs.columns import Columns, columns
from linkages.results.outputs.evaluation import add_moved, make_snapshot
from linkages.results.outputs.registry import JITTER, names, packer
from linkages.system import System
from linkages.system.ideal_motion import IdealMotion
from linkages.system.rigid_segments import Segmented

# Step of differences of the fourth order, in parts of a value and of 1 rad; in parts of a clearance, beyond which an
# eccentricity near zero is far from linear.
_STEP, _SHORT = 1e-3, 1e-4


class OutputTable:
    """Outputs of a system, whose numbers follow values.

    Parameters
    ----------
    system : System
    wanted : sequence of str, optional
        Names of outputs; default: all. With rigid segments: outputs of the linkage of segments.
    ideals : IdealMotions
        Of the system and of neighbouring ones.
    """

    def __init__(self, system: System, wanted: Sequence[str] | None, ideals: IdealMotions) -> None:
        self._ideals, self.names = ideals, _all_names(system) if wanted is None else list(wanted)
        self._read = packer(system, self.names)
        self._numbers = Duplicate((system.arrays, self._read(system)))
        model, self._records = self._numbers.value
        self._seen = make_snapshot(model, system.tree.size)
        self._first = len(self._numbers.initial) - len(contents((self._records,)).words)  # place of the records
        self._with_forces = bool(self._records["forces"].any())
        self._add: Callable[..., None] | None = None
        self._jitter = [k for k, one in enumerate(self._records) if one["jitter"]]

    def derivatives(
        self, near: Neighbours, times: Array, state: Sequence[Array], change: Sequence[Array], model: Arrays
    ) -> Columns:
        """Differentiate the outputs.

        Parameters
        ----------
        near : Neighbours
            Of the value.
        times : (nt,) array
        state, change : arrays
            Coordinates, rates, accelerations (nt, n) and contacts (nt, nc, WIDTH), and their derivatives.
        model : Arrays
        """
        arrays, records = near.arrays, near.rates(self._read)
        places = np.concatenate([arrays.places, self._first + records.places])
        rates = np.concatenate([arrays.rates, records.rates])
        h = 1.0 / _largest(change[0] / min(1.0, model.size), change[3], model.laws["clearance"], 1.0 / near.magnitude)
        result, initial = np.zeros((len(self.names), len(times))), self._numbers.initial[places]
        given = (self._records, self._with_forces, self._seen, np.asarray(times, np.float64), *state, *change)
        if self._add is None:
            self._add = cast(Callable[..., None], bound(add_moved, *given, h, 1.0, result))
        for place, weight in zip(*PAIRS, strict=True):
            self._numbers.numbers[places] = initial + place * h * rates
            self._add(*given, place * h, weight / h, result)
        self._numbers.numbers[places] = initial
        if self._jitter:
            plain = [self.names[k].removesuffix(JITTER) for k in self._jitter]
            result[self._jitter] -= near.derivative(lambda one: self._ideals(one, times, plain))
        return dict(zip(self.names, result, strict=True))


@kernel
def _largest(turns: Array, contacts: Array, clearances: Array, least: float) -> float:
    """Return the inverse of the step: the largest change in parts of its scale; not NaN.

    Changes: of angles (nt, n), of displacements of journals in contacts (nt, nc, WIDTH) over clearances, of the value.
    """
    found, shorter = least / _STEP, 1.0 / _SHORT
    for i in range(len(turns)):
        for k in range(turns.shape[1]):
            if abs(turns[i, k]) > found * _STEP:
                found = abs(turns[i, k]) / _STEP
        for k in range(contacts.shape[1]):
            for j in (EX, EY):
                if shorter * abs(contacts[i, k, j]) > found * clearances[k]:
                    found = shorter * abs(contacts[i, k, j]) / clearances[k]
    return found


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
