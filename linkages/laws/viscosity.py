"""Viscosity of a lubricating oil at a temperature: Walther (ASTM D341), and ISO grades.

Temperatures are in degrees Celsius, kinematic viscosities nu in mm2/s (cSt) as oils are sold by, dynamic
viscosities mu in Pa s as the films take them: mu = nu*1e-6*rho.
"""

from __future__ import annotations

import math

_ZERO = 273.15

#: Kinematic viscosity at 100 deg C [mm2/s] of an oil of viscosity index 95 whose viscosity at 40 deg C is
#: the middle of the grade: ASTM D2270 (ISO 2909) solved for it, grades of ISO 3448.
ISO_VG = {
    10: 2.637, 15: 3.381, 22: 4.254, 32: 5.289, 46: 6.645, 68: 8.530, 100: 11.066,
    150: 14.546, 220: 18.750, 320: 23.957, 460: 30.350, 680: 39.063, 1000: 49.859, 1500: 64.215,
}  # fmt: skip

#: Density of a mineral oil at 15 deg C [kg/m3] and its slope [kg/m3/K]. Assumed, typical.
DENSITY_15, DENSITY_SLOPE = 870.0, -0.65


def walther_constants(nu_1: float, celsius_1: float, nu_2: float, celsius_2: float) -> tuple[float, float]:
    """Constants A, B of log10(log10(nu + 0.7)) = A - B*log10(T) through two viscosities of 2 mm2/s or more."""
    x_1, x_2 = math.log10(celsius_1 + _ZERO), math.log10(celsius_2 + _ZERO)
    w_1, w_2 = (math.log10(math.log10(nu + 0.7)) for nu in (nu_1, nu_2))
    slope = (w_1 - w_2) / (x_2 - x_1)
    return w_1 + slope * x_1, slope


def walther(celsius: float, a: float, b: float) -> float:
    """Kinematic viscosity [mm2/s] by Walther's equation; valid where it exceeds 2 mm2/s.

    Source: ASTM D341, the form for nu > 2 mm2/s; Walther 1931.
    """
    return 10.0**10.0 ** (a - b * math.log10(celsius + _ZERO)) - 0.7


def density(celsius: float, density_15: float = DENSITY_15) -> float:
    """Density of a mineral oil [kg/m3], linear in temperature."""
    return density_15 + DENSITY_SLOPE * (celsius - 15.0)


def iso_vg_viscosity(grade: int, celsius: float, density_15: float = DENSITY_15) -> float:
    """Dynamic viscosity [Pa s] of an oil of this ISO grade and viscosity index 95, by Walther's equation.

    Raises
    ------
    ValueError
        If the grade is not one of `ISO_VG`.
    """
    if grade not in ISO_VG:
        raise ValueError(f"ISO VG {grade!r}: must be one of {', '.join(map(str, ISO_VG))}")
    a, b = walther_constants(float(grade), 40.0, ISO_VG[grade], 100.0)
    return walther(celsius, a, b) * 1e-6 * density(celsius, density_15)
