"""The record of numbers that describes one clearance joint to every law."""

from __future__ import annotations

from typing import Any

from numba import from_dtype

from linkages.kernel import record_type

#: One joint. Fields that choose a law hold the address of its compiled function (`linkages.kernel.address`), which is
#: good in this process alone: records are made anew from the experiment, never stored.
PARAMETERS = record_type(
    clearance="f8",  # radial clearance c [m]
    radius="f8",  # bearing radius R [m]
    length="f8",  # bearing length L [m]
    model="i8",  # what acts: MODELS[name]
    film="i8",  # FILMS[name].address, bare_address
    viscosity="f8",  # dynamic viscosity mu [Pa s]
    shear="i8",  # shear torque of the film: SHEAR[name]
    small_eps="f8",  # eps_0 of Chen 2025 eqs. (12)-(13); 0: no correction
    small_power="f8",  # m of Chen 2025 eqs. (12)-(13)
    contact="i8",  # CONTACTS[name].address
    stiffness="f8",  # K: N/m^n, or N/m for conformal cylinders and Kelvin-Voigt
    exponent="f8",  # n of power laws
    restitution="f8",  # nominal coefficient of restitution e
    hysteresis="f8",  # chi = CONTACTS[name].factor(e)
    damping="f8",  # D of Kelvin-Voigt [N s/m]
    damping_limit="f8",  # largest |ddelta/ddelta0| that the damping sees; inf: any
    shape_ratio="f8",  # L^2/(R_b R_j) of Dubowsky and Freudenstein
    friction="i8",  # FRICTIONS[name].address; 0: none
    bristles="i8",  # 1: FRICTIONS[name].bristles
    mu_s="f8",  # static and dynamic coefficient of friction
    mu_d="f8",
    v_0="f8",  # speeds of the friction law [m/s]
    v_1="f8",
    bristle_stiffness="f8",  # LuGre, per unit of load [1/m]
    bristle_damping="f8",  # LuGre, per unit of load [s/m]
    transition="f8",  # mixed, blend: E_0 of Chen 2025 eq. (15) [m]; 0 for asperities
    film_limit="f8",  # mixed: largest eps at which the film is evaluated
    roughness="f8",  # mixed, asperities: combined standard deviation [m]
    asperity_pressure="f8",  # mixed, asperities: factor of F_5/2 [Pa]
    worn="i8",  # `linkages.laws.wear.force.worn_address`; 0: round
    bearing_nodes="i8",  # worn: of each part's profile, 0 if it is round
    journal_nodes="i8",
)

#: Type of a record in compiled code.
RECORD: Any = from_dtype(PARAMETERS)

#: What acts in a joint with clearance.
MODELS = {"lubricated": 0, "dry": 1, "mixed": 2}

#: Extent of the film that carries the shear torque.
SHEAR = {"none": 0, "full": 1, "half": 2}
