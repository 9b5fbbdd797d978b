"""Tables of contact and friction: of joints with clearance, stops, teeth and points at lines."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from linkages.elements.law_tables import LawTable
from linkages.input.files.table_keys import OneOf
from linkages.input.files.toml import NonNegative, Positive
from linkages.laws import CONTACTS, FRICTIONS
from linkages.laws.states import STATES

ContactName = Annotated[str, OneOf(CONTACTS)]


class ContactTable(LawTable):
    """Contact of journal and bearing, for dry and mixed joints."""

    law_kind = "contact"

    law: ContactName = Field(description="normal contact law")
    restitution: Annotated[float, Field(gt=0, le=1)] | None = Field(
        None, description="nominal coefficient of restitution; every built-in law but maxwell needs it [1]"
    )
    youngs_modulus: Positive | None = Field(None, description="Young's modulus of both bodies [Pa]")
    poissons_ratio: Annotated[float, Field(ge=0, lt=0.5)] = Field(0.3, description="Poisson's ratio of both [1]")
    stiffness: Positive | None = Field(
        None, description="stiffness instead of the law's from material and radii [N/m^n; N/m for cylinders]"
    )
    yield_strength: Positive | None = Field(
        None, description="yield strength of the softer body; contacts that yield give a warning [Pa]"
    )
    clip: bool = Field(True, description="whether the damping's speed ratio is clipped to [-1, 1]")

    def _complete(self) -> None:
        super()._complete()
        needs = CONTACTS[self.law].needs
        if "restitution" in needs and self.restitution is None:
            raise ValueError("restitution is missing (nominal coefficient of restitution [1])")
        if "stiffness" in needs and self.youngs_modulus is None and self.stiffness is None:
            raise ValueError("give youngs_modulus or stiffness")
        if self.yield_strength is not None and self.youngs_modulus is None:
            raise ValueError("yield_strength needs youngs_modulus, for the pressure [Pa]")


class FrictionTable(LawTable):
    """Friction between journal and bearing, for dry and mixed joints."""

    law_kind = "friction"

    law: Annotated[str, OneOf(FRICTIONS)] = Field(description="friction law")
    coefficient: NonNegative | None = Field(
        None, description="dynamic coefficient; every built-in law but none needs it; 0: no friction [1]"
    )
    static: NonNegative | None = Field(None, description="static coefficient; default: the dynamic one [1]")

    def _complete(self) -> None:
        super()._complete()
        if self.coefficient is None and "coefficient" in FRICTIONS[self.law].needs:
            raise ValueError(f"{self.law} needs its coefficient [1]")
        if self.static is not None and self.static < (self.coefficient or 0.0):
            raise ValueError("static must not be below coefficient")
        if self.law == "lugre" and self.coefficient == 0.0 and self.static:
            raise ValueError("lugre with a static coefficient needs a coefficient above 0")

    @property
    def acts(self) -> bool:
        """Check whether the friction is nonzero."""
        law = FRICTIONS[self.law]
        return law.coefficient is not None and bool(self.coefficient or self.static or "coefficient" not in law.needs)


def check_states(contact: ContactTable | None, friction: FrictionTable | None) -> None:
    """Check that a contact has room for the states of its laws."""
    if contact is not None and friction is not None:
        counts = len(CONTACTS[contact.law].states), len(FRICTIONS[friction.law].states)
        if sum(counts) > STATES:
            found = f"{contact.law} has {counts[0]} states and {friction.law} {counts[1]}"
            raise ValueError(f"{found}; the laws of a contact can have {STATES}")
