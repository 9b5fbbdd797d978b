"""Linkages whose motion is known independently of any engine: SDFormat texts, and closed forms or few equations.

| machine                 | known from                                                           |
|-------------------------|----------------------------------------------------------------------|
| squeezing mechanism     | `andrews`: published values                                          |
| double pendulum         | Lagrange's equations in two angles, energy                           |
| slider-crank            | closed form: motion, reactions, drive torque                         |
| parallelogram           | closed form, through the flat (change-point) positions               |
| equal slider-crank      | energy in one coordinate, through both dead centres and the point where the slider passes the pivot |
| folding four-bar        | energy along its path in two angles, closely past the parallelogram's flat position |
| windows                 | one equation, and a published position (IFToMM's N-four-bar)          |
| chain of bars           | `vector_sums`                                                        |

Bars are `machines.bar`: uniform, 0.2 kg unless said otherwise. The plane is the file's x-y plane, gravity along -y.
"""

from __future__ import annotations

import numpy as np
from machines import bar, joint, model, solid
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from vector_sums import Body, Sums

MASS = 0.2  # kg, of each bar
GRAVITY = 9.81  # m/s2


# --- double pendulum and chains ---------------------------------------------------------------------------------------


def chain_sdf(lengths, angles, plane="xy") -> str:
    """Bars bar1, bar2, ... hung one from the other by joints pin1, pin2, ...; `angles` are from the x axis."""
    body, at, parent, before = "", "__model__", "world", 0.0
    for i, (length, angle) in enumerate(zip(lengths, angles, strict=True), start=1):
        body += bar(f"bar{i}", length, at, float(angle) - before, MASS)
        body += joint(f"pin{i}", parent, f"bar{i}")
        at = parent = f"bar{i}_tip"
        before = float(angle)
    return model("chain", body, plane)


def chain_model(lengths) -> Sums:
    """The same chain; coordinates are the bars' angles from the x axis."""
    n = len(lengths)
    bodies = [
        Body(MASS, MASS * lengths[i] ** 2 / 12, i, {j: lengths[j] for j in range(i)} | {i: lengths[i] / 2})
        for i in range(n)
    ]
    return Sums(np.eye(n), bodies, [], lambda q, v: np.zeros(n), -1j * GRAVITY)


def double_pendulum(lengths, angles, times):
    """Angles and rates (nt, 2) of two bars released from rest, by Lagrange's equations and DOP853 at 1e-12."""
    (l1, l2), g = lengths, GRAVITY
    j1, j2 = MASS * l1**2 / 3 + MASS * l1**2, MASS * l2**2 / 3
    coupling = MASS * l1 * l2 / 2

    def rate(t, s):
        a, b, w, u = s
        sin, cos = np.sin(a - b), np.cos(a - b)
        load = np.array(
            [
                -coupling * sin * u**2 - 1.5 * MASS * g * l1 * np.cos(a),
                coupling * sin * w**2 - 0.5 * MASS * g * l2 * np.cos(b),
            ]
        )
        return [w, u, *np.linalg.solve([[j1, coupling * cos], [coupling * cos, j2]], load)]

    run = solve_ivp(rate, (0.0, times[-1]), [*angles, 0.0, 0.0], "DOP853", t_eval=times, rtol=1e-12, atol=1e-12)
    assert run.success
    return run.y[:2].T, run.y[2:].T


# --- slider-crank -----------------------------------------------------------------------------------------------------


def slider_crank_motion(theta, omega, crank=0.05, rod=0.12, gravity=0.0):
    """The in-line slider-crank of `machines.slider_crank` at constant crank speed, every joint ideal.

    Parameters
    ----------
    theta : (nt,) array
        Crank angle from the slider's axis [rad].
    omega : float
        [rad/s]
    gravity : float
        Along -y [m/s2].

    Returns
    -------
    dict of (nt,) arrays
        Named as the engines' columns. Forces act on the joint's child: O on the crank, A on the rod, B on the slider;
        guide.fy on the slider; O.torque drives the crank.
    """
    m_crank, m_rod, m_slider = 0.3, 0.21, 0.14  # kg, as machines.slider_crank
    sin, cos = np.sin(theta), np.cos(theta)
    s = -crank / rod * sin  # sine of the rod's angle, eq. of the loop's y
    c = np.sqrt(1.0 - s**2)
    phi, dphi = np.arcsin(s), -crank / rod * cos * omega / c
    ddphi = (crank / rod * sin * omega**2 + s * dphi**2) / c
    x = crank * cos + rod * c
    vx = -crank * sin * omega - rod * s * dphi
    ax = -crank * cos * omega**2 - rod * (c * dphi**2 + s * ddphi)
    # mass centres
    gx = -crank * cos * omega**2 - 0.5 * rod * (c * dphi**2 + s * ddphi)
    gy = -crank * sin * omega**2 + 0.5 * rod * (c * ddphi - s * dphi**2)
    hx, hy = -0.5 * crank * cos * omega**2, -0.5 * crank * sin * omega**2
    # slider along x; moments on the rod about A; the rest by Newton
    bx = m_slider * ax
    inertia = m_rod * rod**2 / 12
    moment = inertia * ddphi + m_rod * 0.5 * rod * (c * (gy + gravity) - s * gx)
    by = (s * bx * rod - moment) / (rod * c)
    fax, fay = m_rod * gx + bx, m_rod * (gy + gravity) + by
    fox, foy = m_crank * hx + fax, m_crank * (hy + gravity) + fay
    torque = crank * (cos * fay - sin * fax) + m_crank * 0.5 * crank * cos * gravity
    return {
        "slider.x": x, "slider.vx": vx, "slider.ax": ax, "rod.angle": phi, "rod.omega": dphi, "rod.alpha": ddphi,
        "B.fx": bx, "B.fy": by, "A.fx": fax, "A.fy": fay, "O.fx": fox, "O.fy": foy,
        "guide.fy": m_slider * gravity - by, "O.torque": torque,
    }  # fmt: skip


# --- torque-driven, through singular positions ------------------------------------------------------------------------


def parallelogram_sdf(length=0.3, crank=0.1, angle=1.0) -> str:
    """Crank and follower of equal length, coupler as long as the ground; drawn at this crank angle.

    Joints O (crank), Q (follower), A (crank-coupler), B (coupler-follower). It is flat at 0 and pi, where it could
    fold into the contra-parallelogram.
    """
    return _four_bar("parallelogram", length, crank, length, angle, angle)


def _four_bar(name, ground, crank, coupler, angle, follower_angle) -> str:
    """Crank and follower of equal length, drawn at these angles."""
    tip = crank * np.exp(1j * angle)
    coupler_angle = np.angle(ground + crank * np.exp(1j * follower_angle) - tip)
    body = f"""
<frame name="pivot" attached_to="world"><pose relative_to="__model__">{ground} 0 0 0 0 0</pose></frame>
{bar("crank", crank, "__model__", angle)}{bar("coupler", coupler, "crank_tip", coupler_angle - angle)}
{bar("follower", crank, "pivot", follower_angle)}
{joint("O", "world", "crank")}{joint("A", "crank_tip", "coupler")}{joint("Q", "world", "follower")}
{joint("B", "coupler_tip", "follower_tip")}"""
    return model(name, body)


def parallelogram_model(torque, length=0.3, crank=0.1) -> Sums:
    """The parallelogram in its one coordinate, by vector sums."""
    bodies = [
        Body(MASS, MASS * crank**2 / 12, 0, {0: crank / 2}),
        Body(MASS, MASS * length**2 / 12, 1, {0: crank, 1: length / 2}),
        Body(MASS, MASS * crank**2 / 12, 0, {None: length, 0: crank / 2}),
    ]
    return Sums(np.array([[1.0], [0.0]]), bodies, [], lambda q, v: np.array([torque]))


def parallelogram_angle(times, torque, speed, crank=0.1, angle=1.0):
    """Crank angle and its rate (nt,): the coupler only translates, so that the inertia is constant."""
    inertia = 2 * MASS * crank**2 / 3 + MASS * crank**2
    rate = torque / inertia
    return angle + speed * times + 0.5 * rate * times**2, speed + rate * times


def windows_sdf(n, propped=False) -> str:
    """N four-bar windows side by side: bars of 1 m and 1 kg, drawn upright; all of them are flat at the same time.

    If they are propped, a third crank carries the middle of each coupler, and one closure row of each window is redundant.

    Joints A0 ... An (ground-crank), B0 ... (crank-coupler), C0 ... (coupler-next crank). The N-four-bar of the library of
    benchmarks of IFToMM's Technical Committee for Multibody Dynamics (Gonzalez and others, Engineering with
    Computers 26, 2010).
    """
    body = ""
    for i in range(n + 1):
        pivot = f"ground{i}"
        body += f'<frame name="{pivot}" attached_to="world"><pose relative_to="__model__">{i} 0 0 0 0 0</pose></frame>'
        body += bar(f"crank{i}", 1.0, pivot, np.pi / 2, 1.0) + joint(f"A{i}", "world", f"crank{i}")
    for i in range(n):
        body += bar(f"coupler{i}", 1.0, f"crank{i}_tip", -np.pi / 2, 1.0)
        body += joint(f"B{i}", f"crank{i}_tip", f"coupler{i}") + joint(f"C{i}", f"coupler{i}_tip", f"crank{i + 1}_tip")
    for i in range(n if propped else 0):
        body += f'<frame name="foot{i}" attached_to="world"><pose relative_to="__model__">{i + 0.5} 0 0 0 0 0</pose></frame>'
        body += f'<frame name="middle{i}" attached_to="coupler{i}"><pose>0.5 0 0 0 0 0</pose></frame>'
        body += bar(f"prop{i}", 1.0, f"foot{i}", np.pi / 2, 1.0) + joint(f"P{i}", "world", f"prop{i}")
        body += joint(f"D{i}", f"prop{i}_tip", f"middle{i}")
    return model("windows", body)


def tower_sdf(n) -> str:
    """N parallelograms on top of each other, of bars of 1 m and 1 kg: rods rodA0, rodB0, ... and beams beam1, ...

    Joints A0, B0, ... (beam-rod), C0, D0, ... (rod-next beam). Each level moves freely.
    """
    body = '<frame name="beam0" attached_to="world"/>'
    body += '<frame name="beam0_tip" attached_to="world"><pose>1 0 0 0 0 0</pose></frame>'
    for i in range(n):
        below, above = f"beam{i}", f"beam{i + 1}"
        body += bar(f"rodA{i}", 1.0, below, np.pi / 2, 1.0) + joint(f"A{i}", below, f"rodA{i}")
        body += bar(f"rodB{i}", 1.0, f"{below}_tip", np.pi / 2, 1.0) + joint(f"B{i}", f"{below}_tip", f"rodB{i}")
        body += bar(above, 1.0, f"rodA{i}_tip", -np.pi / 2, 1.0) + joint(f"C{i}", f"rodA{i}_tip", above)
        body += joint(f"D{i}", f"rodB{i}_tip", f"{above}_tip")
    return model("tower", body)


#: The windows are pushed to the right at 1 m/s, where B0 is, and fall.
WINDOWS = "gravity = [0.0, -9.81, 0.0]\n[drives.A0]\ntorque = 0.0\nspeed = -1.0\n"


def windows_angle(n, times):
    """Crank angle and its rate (2, nt): n + 1 cranks turn, n couplers translate with their tips; DOP853 at 1e-13."""
    inertia, weight = (n + 1) / 3 + n, GRAVITY * ((n + 1) / 2 + n)

    def rate(t, s):
        return [s[1], -weight * np.cos(s[0]) / inertia]

    run = solve_ivp(rate, (0.0, times[-1]), [np.pi / 2, -1.0], "DOP853", t_eval=times, rtol=1e-13, atol=1e-13)
    assert run.success
    return run.y


#: Crank angle of the four-bar that folds, as drawn.
FOLDING = 1.0


def _folding_follower(longer, length=0.3, crank=0.1):
    """Follower angle of the reference configuration, different from the parallelogram's."""

    def gap(angle):
        return abs(length + crank * (np.exp(1j * angle) - np.exp(1j * FOLDING))) - length * (1.0 + longer)

    return brentq(gap, FOLDING - 0.1, FOLDING + 0.1, xtol=1e-16)


def folding_sdf(longer, length=0.3, crank=0.1) -> str:
    """The parallelogram with a coupler that is longer by a part of its length: it never gets flat, but folds."""
    return _four_bar("folding", length, crank, length * (1.0 + longer), FOLDING, _folding_follower(longer))


def folding_angles(longer, speed, time, length=0.3, crank=0.1):
    """Angles of its crank and follower (2,) when it has coasted for a time, with DOP853 at 1e-13.

    Its path in the plane of both angles is a smooth curve, which the kinetic energy tells how fast to follow.
    """

    def along(angles):
        a, b = crank * np.exp(1j * angles)
        coupler = length + b - a
        slope_a, slope_b = -2.0 * (np.conj(coupler) * 1j * a).real, 2.0 * (np.conj(coupler) * 1j * b).real
        tangent = np.array([-slope_b, slope_a]) / np.hypot(slope_a, slope_b)
        u, w = 1j * a * tangent[0], 1j * b * tangent[1]  # of the coupler's ends
        pins = abs(u) ** 2 + abs(w) ** 2
        return tangent, MASS / 3 * (pins + pins + (np.conj(u) * w).real)

    start = np.array([FOLDING, _folding_follower(longer)])
    tangent, inertia = along(start)
    momentum = np.sqrt(inertia) * speed / tangent[0]

    def rate(t, angles):
        tangent, inertia = along(angles)
        return tangent * momentum / np.sqrt(inertia)

    run = solve_ivp(rate, (0.0, time), start, "DOP853", rtol=1e-13, atol=1e-13)
    assert run.success
    return run.y[:, -1]


def equal_slider_crank_sdf(length=0.1, angle=0.5) -> str:
    """Crank and rod of equal length, slider 0.1 kg; drawn at this crank angle, the rod at minus it.

    At a quarter turn the slider is at the crank's pivot, where the rod could turn with the crank instead.
    """
    x = 2.0 * length * np.cos(angle)
    body = f"""
{bar("crank", length, "__model__", angle)}{bar("rod", length, "crank_tip", -2.0 * angle)}
{solid("slider", 0.1, 1e-5, f"{x} 0 0 0 0 0")}
{joint("O", "world", "crank")}{joint("A", "crank_tip", "rod")}{joint("B", "rod_tip", "slider")}
{joint("guide", "world", "slider", "prismatic", "1 0 0")}"""
    return model("equal_slider_crank", body)


def equal_slider_crank_model(torque, length=0.1) -> Sums:
    """The equal slider-crank in its one coordinate, by vector sums: crank and rod turn against each other."""
    bodies = [
        Body(MASS, MASS * length**2 / 12, 0, {0: length / 2}),
        Body(MASS, MASS * length**2 / 12, 1, {0: length, 1: length / 2}),
        Body(0.1, 0.0, 2, {0: length, 1: length}),
    ]
    return Sums(np.array([[1.0], [-1.0], [0.0]]), bodies, [], lambda q, v: np.array([torque]))


def equal_slider_crank_inertia(theta, length=0.1):
    """Inertia J that the crank feels, kinetic energy = J theta'^2 / 2, and dJ/dtheta.

    The slider is at 2 l cos(theta), the rod's centre at l (1.5 cos, 0.5 sin)(theta).
    """
    square = length**2
    constant = MASS * square / 3 + MASS * square / 12 + 0.25 * MASS * square
    varying = 2.0 * MASS * square + 4.0 * 0.1 * square
    return constant + varying * np.sin(theta) ** 2, varying * np.sin(2.0 * theta)


def equal_slider_crank_angle(times, torque, speed, length=0.1, angle=0.5):
    """Crank angle and its rate (nt,) by J theta'' + J' theta'^2 / 2 = T and DOP853 at 1e-12."""

    def rate(t, s):
        inertia, slope = equal_slider_crank_inertia(s[0], length)
        return [s[1], (torque - 0.5 * slope * s[1] ** 2) / inertia]

    run = solve_ivp(rate, (0.0, times[-1]), [angle, speed], "DOP853", t_eval=times, rtol=1e-12, atol=1e-12)
    assert run.success
    return run.y
