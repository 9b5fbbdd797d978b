"""Feed grooves and holes of a bearing: regions of its surface that are held at a supply pressure."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.base.kernel import Array

_TURN = 2.0 * math.pi
_LEAST = 1e-9  # least extent [rad] and length: meshes round their edges to 1e-13


class Groove(NamedTuple):
    """A rectangular groove in the bearing's surface, or a round hole; its oil has the supply pressure.

    Attributes
    ----------
    angle : float
        Angle of its middle [rad], positive in the sense of rotation; from the load, or from x of the bearing.
    extent : float
        Angle that it extends over, above 0, at most a turn (a circumferential groove) [rad].
    length : float
        Axial length as a share of the bearing's, above 0, at most 1.
    pressure : float
        Supply pressure, gauge [Pa] (solver: in its unit of pressure).
    position : float
        Axial place of its middle from the bearing's middle, as a share of the bearing's length.
    hole : bool
        Whether it is an ellipse of these diameters instead of a rectangle: a round hole.

    Examples
    --------
    >>> from linkages.laws.film.surface.grooves import Groove
    >>> Groove(angle=3.0, extent=0.5, length=0.8).span
    (2.75, 3.25)
    """

    angle: float
    extent: float
    length: float = 1.0
    pressure: float = 0.0
    position: float = 0.0
    hole: bool = False

    @property
    def span(self) -> tuple[float, float]:
        """Angles where it begins and ends [rad]."""
        return self.angle - 0.5 * self.extent, self.angle + 0.5 * self.extent

    @property
    def reach(self) -> tuple[float, float]:
        """Axial places where it begins and ends, as shares of the bearing's length from its middle."""
        return self.position - 0.5 * self.length, self.position + 0.5 * self.length

    def covers(self, theta: Array, share: Array) -> NDArray[np.bool_]:
        """Tell which points (angle, axial share) it covers."""
        around = np.abs(np.remainder(theta - self.angle + math.pi, _TURN) - math.pi) / (0.5 * self.extent)
        along = np.abs(share - self.position) / (0.5 * self.length)
        return around**2 + along**2 <= 1.0 if self.hole else (around <= 1.0) & (along <= 1.0)


def no_load(remedy: str = "") -> str:
    """Say that nothing feeds a film that conserves mass, has no groove, and a cavity at ambient pressure."""
    return (
        "with mass conservation, without a groove and with the cavity at ambient pressure nothing feeds the film "
        f"and it carries no load; add a groove, {remedy}or choose cavitation guembel or reynolds"
    )


def check_grooves(grooves: Sequence[Groove], cavity_pressure: float) -> None:
    """Check grooves: ValueError with one sentence that names the groove, the fault, and the allowed values."""
    if cavity_pressure > 0.0:
        raise ValueError(f"cavity pressure {cavity_pressure:g} Pa: must not be above ambient (0)")
    _refuse(_faults(groove, cavity_pressure) for groove in grooves)
    for number, groove in enumerate(grooves, 1):
        for other in grooves[: number - 1]:
            if other.pressure != groove.pressure and _meet(groove, other):
                raise ValueError(f"groove {number}: overlaps another one, whose pressure differs")


def check_areas(grooves: Sequence[Groove]) -> None:
    """Check that grooves have an area; ValueError as `check_grooves`."""
    _refuse(_sizes(groove) for groove in grooves)


def _refuse(faults: Iterable[Iterable[str]]) -> None:
    """Raise the first fault of the grooves."""
    for number, own in enumerate(faults, 1):
        for fault in own:
            raise ValueError(f"groove {number}: {fault}")


def _faults(groove: Groove, cavity_pressure: float) -> Iterable[str]:
    if not all(map(math.isfinite, groove[:5])):
        yield "a number is not finite"
    if abs(groove.angle) > _TURN * (1.0 + 1e-12):
        yield f'angle {groove.angle:g} rad: must be within a turn; give degrees with their unit: "{groove.angle:g} deg"'
    yield from _sizes(groove)
    if max(map(abs, groove.reach)) > 0.5 + 1e-12:
        yield "reaches beyond the bearing: position and half its length must stay within half the bearing's length"
    if groove.extent >= _TURN and groove.length >= 1.0:
        yield "covers the whole bearing: no film is left"
    if groove.pressure < cavity_pressure:
        yield f"supply pressure {groove.pressure:g} Pa: must not be below the cavity pressure {cavity_pressure:g} Pa"


def _sizes(groove: Groove) -> Iterable[str]:
    if not _LEAST <= groove.extent <= _TURN * (1.0 + 1e-12):
        yield f"extent {groove.extent:g} rad: must be above 0 ({_LEAST:g} rad or more), at most a turn"
    if not _LEAST <= groove.length <= 1.0:
        yield f"length {groove.length:g}: must be above 0 ({_LEAST:g} or more), at most 1, the length of the bearing"


def _meet(groove: Groove, other: Groove) -> bool:
    apart = abs(math.remainder(groove.angle - other.angle, _TURN))
    around = apart < 0.5 * (groove.extent + other.extent)
    return around and abs(groove.position - other.position) < 0.5 * (groove.length + other.length)
