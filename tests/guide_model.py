"""Independent model of the slider-crank with clearance in its guide, ``slider_crank_guide.toml``.

Two coordinates: the angles of rod and slider. Four corners of the block touch the two walls of the slot.
"""

from __future__ import annotations

import contact_events
import numpy as np

CRANK, ROD, SPEED = 0.05, 0.12, 209.43951023931953
M_ROD, J_ROD, M_SLIDER, J_SLIDER = 0.21, 2.5e-4, 0.14, 1e-4
GRAVITY = np.array([0.0, -9.81])
HALF_LENGTH, HALF_HEIGHT, CLEARANCE = 0.02, 0.014, 0.05e-3
#: Place of each corner on the block, and its wall's normal, counted as the package does.
CORNERS = [(1, 1), (-1, 1), (-1, -1), (1, -1)]
STIFFNESS, RESTITUTION, FRICTION, V_1 = 1e11, 0.6, 0.05, 1e-2


def corners(t, state):
    """Arm from the slider's pin, penetration, its rate and the speed along the wall of each corner."""
    phi, psi, phi_rate, psi_rate = state
    theta = SPEED * t
    pin = CRANK * np.sin(theta) + ROD * np.sin(phi)
    across = CRANK * SPEED * np.cos(theta) + ROD * phi_rate * np.cos(phi)
    along = -CRANK * SPEED * np.sin(theta) - ROD * phi_rate * np.sin(phi)
    for x, side in CORNERS:
        u, v = x * HALF_LENGTH, side * HALF_HEIGHT
        arm = np.array([np.cos(psi) * u - np.sin(psi) * v, np.sin(psi) * u + np.cos(psi) * v])
        depth = side * (pin + arm[1]) - HALF_HEIGHT - CLEARANCE
        yield arm, side, depth, side * (across + psi_rate * arm[0]), along - psi_rate * arm[1]


def forces(t, state, approach):
    """Arm and force of each corner: Flores' contact, Coulomb's friction smoothed by tanh."""
    for k, (arm, side, depth, closing, speed) in enumerate(corners(t, state)):
        load = 0.0
        if approach[k] is not None and depth > 0.0:
            ratio = np.clip(closing / max(approach[k], 1e-6), -1, 1)
            damping = 1 + 8 * (1 - RESTITUTION) / (5 * RESTITUTION) * ratio
            load = max(STIFFNESS * depth**1.5 * damping, 0.0)
        yield arm, np.array([-FRICTION * np.tanh(speed / V_1) * load, -side * load])


def rates(t, state, approach):
    """Newton and Euler: the slider's mass is at its pin."""
    phi = state[0]
    theta = SPEED * t
    pull = GRAVITY + CRANK * SPEED**2 * np.array([np.cos(theta), np.sin(theta)])  # less the crank pin's acceleration
    normal = ROD * np.array([-np.sin(phi), np.cos(phi)])
    total, moment = np.zeros(2), 0.0
    for arm, force in forces(t, state, approach):
        total += force
        moment += arm[0] * force[1] - arm[1] * force[0]
    inertia = J_ROD + (M_ROD / 4 + M_SLIDER) * ROD**2
    turn = normal @ (total + (M_SLIDER + M_ROD / 2) * pull) / inertia
    return np.array([state[2], state[3], turn, moment / J_SLIDER])


def contacts(duration):
    """Contacts of the corners, see `contact_events.contacts`."""
    start = np.array([0.0, 0.0, -CRANK * SPEED / ROD, 0.0])

    def depths(t, state):
        return np.array([(depth, closing) for _, _, depth, closing, _ in corners(t, state)]).T

    def loads(t, state, approach):
        return [np.hypot(*force) for _, force in forces(t, state, approach)]

    return contact_events.contacts(rates, depths, loads, start, duration)
