"""Parameters that a law declares, and the record of numbers that describes one contact to every law.

A law declares its parameters next to its function, as `Parameter` objects. Keys of files, checks, documentation and
records follow from the declaration. The function reads a parameter as an attribute of the record: ``joint.v_0``.

All records have the same layout, `PARAMETERS`, with `SLOTS` unnamed numbers for each kind of law. `named_record` gives
the slots of one law the names of its parameters. So the compiled functions of all laws have the same arguments, and a
parameter costs one load.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numba import from_dtype

from linkages.base.kernel import record_type
from linkages.laws.states import SCALES

#: The kinds of laws that declare parameters.
KINDS = ("contact", "friction", "film")
#: Most parameters of one law.
SLOTS = 8

#: One contact. Fields that choose a law hold the address of its compiled function (`linkages.base.kernel.address`),
#: valid only in this process: records are always computed from the experiment, never stored.
PARAMETERS = record_type(
    clearance="f8",  # radial clearance c [m]
    radius="f8",  # bearing radius R [m]
    length="f8",  # bearing length L [m]
    model="i8",  # code of the joint model: MODELS[name]
    film="i8",  # FILMS[name].address, bare_address
    film_reads_record="i8",  # 1: the film's function takes the record
    groove_angle="f8",  # of the first groove's middle in the bearing's frame [rad]
    supply_pressure="f8",  # largest of the grooves', gauge [Pa]
    tilt="f8",  # displacement of the journal at an end by its tilt, over the clearance; 0: no tilt
    tilt_angle="f8",  # its direction at the end towards the viewer, in the bearing's frame [rad]
    viscosity="f8",  # dynamic viscosity mu [Pa s]
    shear="i8",  # shear torque of the film: SHEAR[name]
    small_eps="f8",  # eps_0 of Chen 2025 eqs. (12)-(13); 0: no correction
    small_power="f8",  # m of Chen 2025 eqs. (12)-(13)
    contact="i8",  # CONTACTS[name].address
    stiffness="f8",  # K: N/m^n, or N/m for conformal cylinders and Kelvin-Voigt
    restitution="f8",  # nominal coefficient of restitution e
    hysteresis="f8",  # chi = CONTACTS[name].factor(e)
    damping_limit="f8",  # largest |ddelta/ddelta0| that the damping sees; inf: any
    shape_ratio="f8",  # L^2/(R_b R_j) of Dubowsky and Freudenstein
    friction="i8",  # FRICTIONS[name].address; 0: none
    contact_states="i8",  # number of continuous states of the contact law, and of the friction law
    friction_states="i8",
    **dict.fromkeys(SCALES, "f8"),  # of the states of both, see `linkages.laws.states`
    mu_s="f8",  # static and dynamic coefficient of friction
    mu_d="f8",
    transition="f8",  # mixed, blend: E_0 of Chen 2025 eq. (15) [m]; 0 for asperities
    film_limit="f8",  # mixed: largest eps at which the film is evaluated
    roughness="f8",  # mixed, asperities: combined standard deviation [m]
    asperity_pressure="f8",  # mixed, asperities: factor of F_5/2 [Pa]
    worn="i8",  # `linkages.laws.wear.force.worn_address`; 0: round
    bearing_nodes="i8",  # worn: of each part's profile, 0 if it is round
    journal_nodes="i8",
    **{f"{kind}_{slot}": "f8" for kind in KINDS for slot in range(SLOTS)},  # parameters of the three laws, see above
)

#: Type of a record in compiled code.
RECORD: Any = from_dtype(PARAMETERS)

#: Codes of the models of a clearance joint.
MODELS = {"lubricated": 0, "dry": 1, "mixed": 2}

#: Extent of the film that carries the shear torque.
SHEAR = {"none": 0, "full": 1, "half": 2}

#: Keys, common to the laws of a kind, that a law can need, and the fields of the record that follow from each.
NEEDS: dict[str, dict[str, tuple[str, ...]]] = {
    "contact": {"restitution": ("restitution", "hysteresis"), "stiffness": ("stiffness",)},
    "friction": {"coefficient": ("mu_s", "mu_d")},
    "film": {},
}


class Parameter(NamedTuple):
    """A number that a law declares: its key in files, and the attribute of the record that the law reads.

    Attributes
    ----------
    name : str
        Key in files, next to the key that names the law.
    unit : str
        SI unit; "1" for a pure number.
    default : float or None
        None: files must give it.
    meaning : str
        One phrase for lists and messages.
    gt, ge, lt, le : float, optional
        Range: greater than, at least, less than, at most.
    above : str
        Name of another parameter of the law; this one must be greater.
    source : str
        Where default or range come from.

    Examples
    --------
    >>> from linkages.laws import Parameter
    >>> Parameter("relaxation", "s", 2e-7, "relaxation time", ge=0.0).range
    '>= 0'
    """

    name: str
    unit: str
    default: float | None
    meaning: str
    gt: float | None = None
    ge: float | None = None
    lt: float | None = None
    le: float | None = None
    above: str = ""
    source: str = ""

    @property
    def bounds(self) -> dict[str, float]:
        """The bounds that there are, by name."""
        bounds = {"gt": self.gt, "ge": self.ge, "lt": self.lt, "le": self.le}
        return {name: bound for name, bound in bounds.items() if bound is not None}

    @property
    def range(self) -> str:
        """The bounds as text; empty if there are none."""
        signs = {"gt": ">", "ge": ">=", "lt": "<", "le": "<="}
        return " and ".join(f"{signs[name]} {bound:g}" for name, bound in self.bounds.items())

    def admits(self, value: float) -> bool:
        """Whether a value is finite and within the bounds."""
        low = self.gt is None or value > self.gt, self.ge is None or value >= self.ge
        high = self.lt is None or value < self.lt, self.le is None or value <= self.le
        return bool(np.isfinite(value)) and all((*low, *high))


@cache
def named_record(kind: str, parameters: tuple[Parameter, ...], needs: tuple[str, ...]) -> Any:
    """Make the type of a record as one law sees it, for compiled code.

    Parameters
    ----------
    kind : str
        One of `KINDS`.
    parameters : tuple of Parameter
        The law's own, in the order of their slots.
    needs : tuple of str
        Keys of `NEEDS` that the law needs; the fields of others of its kind are not there.
    """
    hidden = {field for need, fields in NEEDS[kind].items() if need not in needs for field in fields}
    hidden |= {f"{kind}_{slot}" for kind in KINDS for slot in range(SLOTS)}
    places: dict[str, Any] = dict(PARAMETERS.fields or {})
    seen = {name: place for name, place in places.items() if name not in hidden}
    seen |= {parameter.name: places[f"{kind}_{slot}"] for slot, parameter in enumerate(parameters)}
    formats, offsets = zip(*((place[0], place[1]) for place in seen.values()), strict=True)
    layout = {"names": list(seen), "formats": formats, "offsets": offsets, "itemsize": PARAMETERS.itemsize}
    return from_dtype(np.dtype((np.record, layout)))


def slots(kind: str, parameters: Sequence[Parameter]) -> dict[str, str]:
    """Return the names of a law's parameters by the fields of a record that hold them."""
    return {f"{kind}_{slot}": parameter.name for slot, parameter in enumerate(parameters)}


def set_numbers(record: Any, own: Mapping[str, str], values: Mapping[str, float]) -> None:
    """Write values, by name, into the fields of a record that they fill as they are."""
    for field, name in own.items():
        record[field] = values[name]
