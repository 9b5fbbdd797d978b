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
        ],
    )
)

#: Extent of the film that carries the shear torque.
SHEAR = {"none": 0, "full": 1, "half": 2}
