"""An additional state: a formula of its rate, or of its next value at sampling instants."""

from __future__ import annotations

from pydantic import Field

from linkages.elements.analysis import SAMPLED
from linkages.elements.element import Checks, Element
from linkages.input.files.toml import Finite, Positive, Table
from linkages.input.functions.definitions import Definition, Quantity, formula


class State(Table):
    """An additional state z: dz/dt = rate, or at each sampling instant z = next.

    Formulas have the time t, positions and speeds, and the names of states. Sampled states keep their values between
    the instants 0, T, 2 T, ...; all that are due change at once, from the values before.
    """

    rate: str | None = Field(None, description="its rate: a formula of t, positions, speeds and states, in SI units")
    next: str | None = Field(None, description="instead: its next value at each sampling instant, the same")
    sample_time: Positive | None = Field(None, description="time between two sampling instants of `next` [s]")
    start: Finite = Field(0.0, description="value at t = 0, before the first sampling instant, in SI units")
    scale: Positive = Field(1.0, description="magnitude in parts of which its error is controlled, in SI units")
    unit: str = Field("", description="its unit, for tables and figures")

    def _complete(self) -> None:
        if (self.rate is None) == (self.next is None):
            raise ValueError("give either rate, or next with sample_time")
        if (self.next is None) != (self.sample_time is None):
            raise ValueError("next and sample_time belong together")
        formula(self.rate or self.next or "")


def check(_: State, checks: Checks) -> None:
    """Refuse a name that formulas cannot have."""
    checks.name_for_formulas()


def quantities(state: State, name: str) -> dict[str, Quantity]:
    """Return the state by its name."""
    given = Definition(formula(state.rate or state.next or ""))
    return {name: Quantity(given, True, state.start, state.scale, state.sample_time or 0.0)}


STATE = Element(
    table="states",
    keys=State,
    check=check,
    quantities=quantities,
    own={"value": "its value []"},
    unit=lambda state: state.unit,
    unsupported=(SAMPLED,),
)
