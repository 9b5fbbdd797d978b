"""A rod with component modes between a driven crank and a slider, its inertia summed over points of the rod.

Every point moves by the exact kinematics of its section, so that nothing of higher order in the modal coordinates is left
out. It shares with the package only the shapes, H and K of `linkages.mechanics.flexible.component_modes`, not its integrals.
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp

from linkages.mechanics.flexible.component_modes import ComponentModes


def slider_crank(
    modes: ComponentModes,
    tip: float,
    points: tuple[np.ndarray, np.ndarray],
    crank: float,
    speed: float,
    slider: float,
    damping: float,
    times: np.ndarray,
) -> np.ndarray:
    """Modal coordinates (n, nf) from a straight rod along the crank, which turns from angle 0; the way is the x axis.

    Parameters
    ----------
    modes : ComponentModes
        Of the rod, the crank's pin at its origin, the slider's at the end of its chord.
    tip : float
        Abscissa of the slider's pin [m].
    points : (p,), (p,) arrays
        Abscissas and masses of the rod's points [m, kg].
    crank, speed, slider, damping : float
        [m, rad/s, kg, s], the last one over all of the rod's stiffness.
    times : (n,) array
    """
    nf, place, mass = len(modes.names), np.append(points[0], tip), points[1]
    a, b = modes.shapes(place)
    h = np.array([modes.at(s)[3] for s in place])

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        theta, eta, w, etad = y[0], y[1 : nf + 1], y[nf + 1], y[nf + 2 :]
        c, s = np.cos(theta), np.sin(theta)
        x, z = -(speed**2) * crank * np.cos(speed * t), -(speed**2) * crank * np.sin(speed * t)
        psi, rho, across = a - h @ eta, place + a @ eta - 0.5 * h @ eta @ eta, b @ eta
        # by the rates of theta and eta, in the rod's axes; part of the accelerations without their rates
        one, two = np.column_stack([-across, psi]), np.column_stack([rho, b])
        bias1 = c * x + s * z - w**2 * rho - 2.0 * w * b @ etad - h @ etad @ etad
        bias2 = c * z - s * x - w**2 * across + 2.0 * w * psi @ etad
        m = (one[:-1].T * mass) @ one[:-1] + (two[:-1].T * mass) @ two[:-1]
        force = -one[:-1].T @ (mass * bias1[:-1]) - two[:-1].T @ (mass * bias2[:-1])
        force[1:] -= modes.k * (eta + damping * etad)
        along, aside = c * one[-1] - s * two[-1], s * one[-1] + c * two[-1]
        m += slider * np.outer(along, along)
        force -= slider * along * (c * bias1[-1] - s * bias2[-1])
        whole = np.block([[m, aside[:, None]], [aside, np.zeros(1)]])
        found = np.linalg.solve(whole, np.array([*force, -(s * bias1[-1] + c * bias2[-1])]))
        return np.array([w, *etad, *found[:-1]])

    y0 = np.zeros(2 * nf + 2)
    y0[nf + 1] = -crank * speed / tip
    found = solve_ivp(rates, (0.0, times[-1]), y0, "Radau", times, rtol=1e-6, atol=1e-9)
    return found.y[1 : nf + 1].T
