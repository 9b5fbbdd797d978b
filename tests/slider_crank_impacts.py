"""Independent model of the dry slider-crank ``slider_crank_dry.toml``, impact by impact."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp

CRANK, ROD, SPEED = 0.05, 0.12, 523.5987755982989
M_ROD, J_ROD, M_SLIDER = 0.21, 2.5e-4, 0.14
RADIUS, CLEARANCE = 0.01, 0.5e-3


def slider_crank_impacts(friction, end, count, limit=1.0):
    """First impacts of the dry slider-crank in two coordinates (rod angle, slider), an independent model.

    Lankarani and Nikravesh with restitution 0.9, Hertz's stiffness (journal in a bearing), Ambrosio's ramp; DOP853 with
    event location; the damping's ratio of speeds is clipped to +-limit. Returns rows start, approach, tangential speed,
    duration, peak force, peak penetration, separation, peak of the normal force.
    """
    journal = RADIUS - CLEARANCE
    s = (1 - 0.3**2) / 207e9
    stiffness = 4 / (3 * (s + s)) * np.sqrt(RADIUS * journal / (RADIUS - journal))

    def geometry(t, y):
        phi, x, phi_rate, x_rate = y
        theta = SPEED * t
        a = CRANK * np.array([np.cos(theta), np.sin(theta)])
        a_rate = CRANK * SPEED * np.array([-np.sin(theta), np.cos(theta)])
        arm, normal = np.array([np.cos(phi), np.sin(phi)]), np.array([-np.sin(phi), np.cos(phi)])
        e = a + ROD * arm - np.array([x, 0.0])
        v = a_rate + ROD * phi_rate * normal - np.array([x_rate, 0.0])
        size = np.hypot(*e)
        n = e / max(size, 1e-300)
        tangent = np.array([-n[1], n[0]])
        return size - CLEARANCE, v @ n, v @ tangent + phi_rate * journal, n, tangent, arm, normal

    def rates(t, y, approach):
        delta, closing, sliding, n, tangent, _, normal = geometry(t, y)
        load = 0.0
        if approach is not None and delta > 0.0:
            ratio = min(max(closing / approach, -limit), limit)
            load = max(stiffness * delta**1.5 * (1 + 0.75 * (1 - 0.81) * ratio), 0.0)
        mu = np.sign(sliding) * friction * min(max((abs(sliding) - 1e-4) / 9e-4, 0.0), 1.0)
        force = -load * n - mu * load * tangent
        couple = -journal * mu * load
        crank = -CRANK * SPEED**2 * np.array([np.cos(SPEED * t), np.sin(SPEED * t)])
        moment = ROD * normal @ force + couple - M_ROD * ROD / 2 * normal @ crank
        phi_acc = moment / (J_ROD + M_ROD * (ROD / 2) ** 2)
        return np.array([y[2], y[3], phi_acc, -force[0] / M_SLIDER]), (np.hypot(*force), load)

    # ideal start: crank along +x, e = 0
    y, t = np.array([0.0, CRANK + ROD, -CRANK * SPEED / ROD, 0.0]), 0.0
    rows = []
    settings = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-14}
    while len(rows) < count and t < end:
        touch = lambda t, y: geometry(t, y)[0]  # noqa: E731
        touch.terminal, touch.direction = True, 1
        free = solve_ivp(lambda t, y: rates(t, y, None)[0], (t, end), y, events=touch, max_step=1e-5, **settings)
        if free.status != 1:
            break
        t, y = free.t[-1], free.y[:, -1]
        _, approach, tangential = geometry(t, y)[:3]
        part = lambda t, y: geometry(t, y)[0]  # noqa: E731
        part.terminal, part.direction = True, -1
        hit = solve_ivp(
            lambda t, y, v=approach: rates(t, y, v)[0], (t, end), y, events=part, dense_output=True,
            max_step=1e-6, **settings,
        )  # fmt: skip
        assert hit.status == 1
        fine = np.linspace(t, hit.t[-1], 4001)
        states = hit.sol(fine)
        loads = np.array([rates(u, states[:, i], approach)[1] for i, u in enumerate(fine)])
        depth = np.array([geometry(u, states[:, i])[0] for i, u in enumerate(fine)])
        separation = -geometry(hit.t[-1], hit.y[:, -1])[1]
        force, normal = loads.max(axis=0)
        rows.append([t, approach, tangential, hit.t[-1] - t, force, depth.max(), separation, normal])
        t, y = hit.t[-1], hit.y[:, -1]
    return np.array(rows)


def table(rows):
    """The same columns of the package's impacts."""
    return np.array(
        [
            [
                r.start,
                r.approach_speed,
                r.tangential_speed,
                r.duration,
                r.peak_force,
                r.peak_penetration,
                r.separation_speed,
                r.peak_normal_force,
            ]
            for r in rows
        ]
    )
