"""Andrews' squeezing mechanism: seven bodies, three loops, a spring, a torque.

F. Mazzia and C. Magherini, Test Set for Initial Value Problem Solvers, release 2.4, Department of Mathematics,
University of Bari and INdAM, 2008, problem ANDREWS (after W. Schiehlen (ed.), Multibody Systems Handbook, 1990, and
E. Hairer and G. Wanner, Solving Ordinary Differential Equations II, section VI.9): parameters, initial values, and
the reference solution at t = 0.03 s (PSIDE on a Cray C90, tolerance 1e-14), also in the R package deTestSet.

Coordinates are the test set's, q = (beta, Theta, gamma, Phi, delta, Omega, epsilon). Angles of the bodies K1 to K7 are
beta, beta + Theta, gamma, Phi + delta, delta, Omega + epsilon, epsilon.
"""

from __future__ import annotations

import numpy as np
from machines import joint, model
from vector_sums import Body, Sums

MASS = (0.04325, 0.00365, 0.02373, 0.00706, 0.07050, 0.00706, 0.05498)  # kg
INERTIA = (2.194e-6, 4.410e-7, 5.255e-6, 5.667e-7, 1.169e-5, 5.667e-7, 1.912e-5)  # kg m2
XA, YA, XB, YB, XC, YC = -0.06934, -0.00227, -0.03635, 0.03273, 0.014, 0.072  # m
D, DA, E, EA = 28e-3, 115e-4, 2e-2, 1421e-5
RR, RA = 7e-3, 92e-5
SS, SA, SB, SC, SD = 35e-3, 1874e-5, 1043e-5, 18e-3, 2e-2
TA, TB, U, UA, UB = 2308e-5, 916e-5, 4e-2, 1228e-5, 449e-5
ZF, ZT, FA = 2e-2, 4e-2, 1421e-5
TORQUE = 0.033  # N m, on K1
STIFFNESS, REST_LENGTH = 4530.0, 0.07785  # N/m, m: spring from K3 to the ground

#: Angle of body b is TURNS[b] @ q.
TURNS = np.array(
    [
        [1, 0, 0, 0, 0, 0, 0], [1, 1, 0, 0, 0, 0, 0], [0, 0, 1, 0, 0, 0, 0], [0, 0, 0, 1, 1, 0, 0],
        [0, 0, 0, 0, 1, 0, 0], [0, 0, 0, 0, 0, 1, 1], [0, 0, 0, 0, 0, 0, 1],
    ],
    dtype=float,
)  # fmt: skip

START = np.array(
    [
        -0.0617138900142764496358948458001, 0.0, 0.455279819163070380255912382449, 0.222668390165885884674473185609,
        0.487364979543842550225598953530, -0.222668390165885884674473185609, 1.23054744454982119249735015568,
    ]
)  # fmt: skip
START_ACCELERATION = np.array([14222.4439199541138705911625887, -10666.8329399655854029433719415, 0, 0, 0, 0, 0])
START_MULTIPLIERS = np.array([98.5668703962410896057654982170, -6.12268834425566265503114393122, 0, 0, 0, 0])

END_TIME = 0.03  # s
END = np.array(
    [
        0.1581077119629904e2, -0.1575637105984298e2, 0.4082224013073101e-1, -0.5347301163226948,
        0.5244099658805304, 0.5347301163226948, 0.1048080741042263e1,
    ]
)  # fmt: skip
END_RATE = np.array(
    [
        0.1139920302151208e4, -0.1424379294994111e4, 0.1103291221937134e2, 0.1929337464421385e2,
        0.5735699284790808, -0.1929337464421385e2, 0.3231791658026955,
    ]
)  # fmt: skip
END_ACCELERATION = np.array(
    [
        -0.2463176316945196e5, 0.5185037701610329e5, 0.3241025686413781e6, 0.5667493645176213e6,
        0.1674362929479361e5, -0.5667493645176222e6, 0.9826520791458422e4,
    ]
)  # fmt: skip
END_MULTIPLIERS = np.array(
    [
        0.1991753333731910e3, -0.2975531228015052e2, 0.2306654119098399e2,
        0.3145271365475927e2, 0.2264249232082739e2, 0.1161740700019673e2,
    ]
)  # fmt: skip

#: Vectors in the bodies' frames, as complex numbers: pins and mass centres seen from the pin nearest to the ground.
PIN_F = RR  # on K1
PIN_E = {1: -D, 2: -1j * SS, 3: -1j * E, 5: ZF}  # on K2, K3, K4, K6, where the three loops meet
PIN_G, PIN_H = ZT, -1j * U  # on K5, K7: K4 and K6 hang there
SPRING_END = SD - 1j * SC  # on K3
CENTRE = (RA, -DA, SB - 1j * SA, -1j * (E - EA), TA + 1j * TB, ZF - FA, -UB - 1j * UA)
A, B, C = complex(XA, YA), complex(XB, YB), complex(XC, YC)


def andrews_model(spring: bool = True) -> Sums:
    """The independent model; without its spring, the torque alone drives it."""
    bases = ({}, {0: PIN_F}, {None: B}, {None: A, 4: PIN_G}, {None: A}, {None: A, 6: PIN_H}, {None: A})
    bodies = [Body(MASS[b], INERTIA[b], b, base | {b: CENTRE[b]}) for b, base in enumerate(bases)]
    crank = {0: PIN_F, 1: PIN_E[1]}
    loops = [
        crank | {None: -B, 2: -PIN_E[2]},
        crank | {None: -A, 4: -PIN_G, 3: -PIN_E[3]},
        crank | {None: -A, 6: -PIN_H, 5: -PIN_E[5]},
    ]

    def force(q, v):
        turned = SPRING_END * np.exp(1j * q[2])
        drawn = B + turned - C
        pull = -STIFFNESS * (1.0 - REST_LENGTH / abs(drawn)) * drawn if spring else 0.0
        return np.array([TORQUE, 0, np.real(np.conj(1j * turned) * pull), 0, 0, 0, 0])

    return Sums(TURNS, bodies, loops, force)


def columns(q, v) -> dict:
    """Angles [rad] and angular velocities [rad/s] of the bodies at q, v (..., 7), named as the engines' columns."""
    angle, omega = q @ TURNS.T, v @ TURNS.T
    result = {f"K{b + 1}.angle": angle[..., b] for b in range(7)}
    return result | {f"K{b + 1}.omega": omega[..., b] for b in range(7)}


def andrews_sdf(plane: str = "xy") -> str:
    """Links K1 to K7 drawn at the initial values, each frame turned by its body's angle, and frames for the spring.

    Joints: O (K1, the torque's), F_pin (K1-K2), B_pin (K3), A5, A7 (K5, K7), G_pin (K5-K4), H_pin (K7-K6), and E3, E4,
    E6, where K2 meets K3, K4 and K6. The spring acts between the frames ``spring_K3`` and ``spring_ground``.
    """
    angle = TURNS @ START
    hung = (("__model__", None), ("F", 0), ("B", None), ("G", 4), ("A", None), ("H", 6), ("A", None))
    parts = [_frame("A", "world", A), _frame("B", "world", B), _frame("spring_ground", "world", C)]
    parts += [_frame("F", "K1", PIN_F), _frame("G", "K5", PIN_G), _frame("H", "K7", PIN_H)]
    parts += [_frame(f"E_on_K{b + 1}", f"K{b + 1}", pin) for b, pin in PIN_E.items()]
    parts.append(_frame("spring_K3", "K3", SPRING_END))
    for b, (at, parent) in enumerate(hung):
        parts.append(_link(b, at, angle[b] - (0.0 if parent is None else angle[parent])))
    for name, parent, child in (
        ("O", "world", "K1"), ("F_pin", "F", "K2"), ("B_pin", "B", "K3"), ("A5", "A", "K5"), ("A7", "A", "K7"),
        ("G_pin", "G", "K4"), ("H_pin", "H", "K6"),
        ("E3", "E_on_K2", "E_on_K3"), ("E4", "E_on_K2", "E_on_K4"), ("E6", "E_on_K2", "E_on_K6"),
    ):  # fmt: skip
        parts.append(joint(name, parent, child))
    return model("andrews", "\n".join(parts), plane)


def _frame(name, link, point):
    point = complex(point)
    relative = ' relative_to="__model__"' if link == "world" else ""
    pose = f"<pose{relative}>{point.real!r} {point.imag!r} 0 0 0 0</pose>"
    return f'<frame name="{name}" attached_to="{link}">{pose}</frame>'


def _link(b, at, angle):
    centre, inertia = complex(CENTRE[b]), INERTIA[b]
    return f"""<link name="K{b + 1}"><pose relative_to="{at}">0 0 0 0 0 {float(angle)!r}</pose>
<inertial><pose>{centre.real!r} {centre.imag!r} 0 0 0 0</pose><mass>{MASS[b]}</mass>
<inertia><ixx>{inertia / 2}</ixx><iyy>{inertia / 2}</iyy><izz>{inertia}</izz></inertia></inertial></link>"""
