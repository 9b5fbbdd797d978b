"""The record of numbers that describes one clearance joint to every law."""

from __future__ import annotations

import numpy as np

#: One joint. Codes are those of the registries (`linkages.laws.FILMS`, `SHEAR`).
PARAMETERS = np.dtype(
    (
        np.record,
        [
            ("clearance", "f8"),  # radial clearance c [m]
            ("radius", "f8"),  # bearing radius R [m]
            ("length", "f8"),  # bearing length L [m]
            ("film", "i8"),  # which film: FILMS[name].code
            ("viscosity", "f8"),  # dynamic viscosity mu [Pa s]
            ("shear", "i8"),  # film shear torque: SHEAR[name]
            ("small_eps", "f8"),  # eps_0 of seed eqs. (12)-(13); 0 switches the correction off
            ("small_power", "f8"),  # m of seed eqs. (12)-(13)
            ("model", "i8"),  # what acts: MODELS[name]
            ("contact", "i8"),  # normal contact: CONTACTS[name].code
            ("stiffness", "f8"),  # of the contact law: N/m^n, or N/m for cylinder laws and Kelvin-Voigt
            ("exponent", "f8"),  # n of power-law contacts
            ("restitution", "f8"),  # nominal coefficient of restitution
            ("damping", "f8"),  # of Kelvin-Voigt [N s/m]
            ("shape_ratio", "f8"),  # L^2/(R_b R_j) of Dubowsky and Freudenstein
            (
                "damping_limit",
                "f8",
            ),  # largest |ddelta/ddelta0| in the damping factor; inf switches the clip off
            ("friction", "i8"),  # FRICTIONS[name].code
            ("mu_s", "f8"),  # static and dynamic coefficient of friction
            ("mu_d", "f8"),
            ("v_0", "f8"),  # speeds of the friction law [m/s]
            ("v_1", "f8"),
            ("bristle_stiffness", "f8"),  # LuGre, per unit of load [1/m]
            ("bristle_damping", "f8"),  # LuGre [s/m]
            ("transition", "f8"),  # mixed, blend: E_0 of seed eq. (15) [m]; 0 for asperities
            ("film_limit", "f8"),  # mixed: largest eps at which the film is evaluated
            ("roughness", "f8"),  # mixed, asperities: combined standard deviation [m]
            ("asperity_pressure", "f8"),  # mixed, asperities: factor of F_5/2 [Pa]
        ],
    )
)

#: What acts in a joint with clearance.
MODELS = {"lubricated": 0, "dry": 1, "mixed": 2}

#: Extent of the film that carries the shear torque.
SHEAR = {"none": 0, "full": 1, "half": 2}
