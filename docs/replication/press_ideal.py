"""The press without clearance: closed-form kinematics and joint forces, for maps over the speeds of both cranks.

Points of the plane are complex numbers [m]; the functions accept arrays of any shape. Every force that the tables of the paper
allow follows from four accelerations and four masses, so a map of 10,000 pairs of speeds takes seconds.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import gcd
from typing import NamedTuple

import numpy as np

from linkages import find_file, load
from replication.press_paper import DESIGNS, PAPER, PRINTED, WINDOWS, Array

#: Directions of gravity: the plane is the world's x-y plane, the slider moves along x [m/s2].
GRAVITY = {"none": 0j, "-y": -9.81j, "+y": 9.81j, "-x": -9.81 + 0j, "+x": 9.81 + 0j}
#: Decay of Baumgarte's stabilisation with the paper's alpha = beta = 50 [1/s].
BAUMGARTE = 50.0
#: Printed largest forces of the three designs, F_A and then F_B [N].
FORCES = np.array([PRINTED[name][design] for name in WINDOWS for design in DESIGNS])

Complex = np.ndarray[tuple[int, ...], np.dtype[np.complex128]]


class Angle(NamedTuple):
    """A crank's angle from the x axis, its rate and its acceleration [rad, s]."""

    value: Array
    rate: Array
    acceleration: Array


class Motion(NamedTuple):
    """Positions and accelerations of joints, and the links' angular accelerations [m, s, rad]; the slider is at `d`."""

    a: Complex
    b: Complex
    c: Complex
    d: Complex
    a_a: Complex
    a_b: Complex
    a_c: Complex
    a_d: Complex
    alpha: dict[int, Array]


class Machine:
    """Lengths [m], masses [kg] and moments of inertia [kg m2] of the press by link."""

    def __init__(self) -> None:
        value = load(find_file(PAPER)).value
        frames = {1: "crank1_A", 2: "link2_C", 3: "link3_C", 4: "crank4_B", 6: "link6_D"}
        self.length = {link: value(f"sdf.frames.{frame}.pose.x") for link, frame in frames.items()}
        self.height = value("sdf.frames.ground_O4.pose.y")
        self.start = np.radians(310.79)  # eq. (17)
        self.values = {
            f"{link}.{key}": value(f"sdf.links.{link}.{key}") for link in BODIES for key in ("mass", "inertia")
        }

    def inertias(self, design: Mapping[str, float]) -> dict[str, float]:
        """Masses and moments of inertia of a design of `DESIGNS`, by ``link.key``."""
        return {key: design.get(f"sdf.links.{key}", value) for key, value in self.values.items()}


BODIES = ("link2", "link3", "link6", "slider7")


def crank(start: float, speed: Array, t: Array, at_rest: bool) -> Angle:
    """Angle of a crank at constant speed, or from rest as eq. (22) with `BAUMGARTE` moves it.

    From rest the constraint theta - theta_0 - omega t of eq. (17) decays as y'' + 100 y' + 2500 y = 0 with y(0) = 0 and
    y'(0) = -omega, which gives theta = theta_0 + omega t (1 - exp(-50 t)).
    """
    decay = np.exp(-BAUMGARTE * t) if at_rest else np.zeros_like(t)
    rate = 1.0 - decay * (1.0 - BAUMGARTE * t)
    acceleration = decay * BAUMGARTE * (2.0 - BAUMGARTE * t)
    return Angle(start + speed * t * (1.0 - decay), speed * rate, speed * acceleration)


def dot(p: Complex, q: Complex) -> Array:
    """Scalar product of plane vectors."""
    return np.real(np.conj(p) * q)


def cross(p: Complex, q: Complex) -> Array:
    """Component of the vector product normal to the plane."""
    return np.imag(np.conj(p) * q)


def move(machine: Machine, one: Angle, four: Angle) -> Motion:
    """Compute the ideal motion; NaN where the loop does not close."""
    length = machine.length
    a, v_a, a_a = _pin(length[1], one)
    b, v_b, a_b = _pin(length[4], four)
    b = b + 1j * machine.height
    distance = np.abs(b - a)
    along = (length[2] ** 2 - length[3] ** 2 + distance**2) / (2.0 * distance)
    c = a + (b - a) / distance * (along - 1j * np.sqrt(length[2] ** 2 - along**2))  # as drawn, on the right
    p, q = c - a, c - b
    v_c = _solve(p, q, dot(p, v_a), dot(q, v_b))
    a_c = _solve(p, q, dot(p, a_a) - np.abs(v_c - v_a) ** 2, dot(q, a_b) - np.abs(v_c - v_b) ** 2)
    reach = np.sqrt(length[6] ** 2 - c.imag**2)
    d = c.real + reach + 0j
    rate = -c.imag * v_c.imag / reach
    a_d = a_c.real - (v_c.imag**2 + c.imag * a_c.imag + rate**2) / reach + 0j
    rods = {2: (p, a_c - a_a), 3: (q, a_c - a_b), 6: (d - c, a_d - a_c)}
    return Motion(a, b, c, d, a_a, a_b, a_c, a_d, {k: cross(r, x) / length[k] ** 2 for k, (r, x) in rods.items()})


def forces(motion: Motion, inertia: Mapping[str, float], gravity: complex) -> tuple[Complex, Complex]:
    """Compute the forces of the cranks on link 2 at A and on link 3 at B [N], without friction.

    Parameters
    ----------
    motion : Motion
    inertia : mapping of float
        See `Machine.inertias`.
    gravity : complex
        Gravitational acceleration [m/s2].
    """
    m = motion
    p, q, r = m.a - m.c, m.b - m.c, m.d - m.c
    two, three, six = (
        inertia[f"link{k}.mass"] * (0.5 * (u + v) - gravity)
        for k, u, v in ((2, m.a_a, m.a_c), (3, m.a_b, m.a_c), (6, m.a_c, m.a_d))
    )
    seven = inertia["slider7.mass"] * (m.a_d - gravity)
    # moments about C: of link 6 and the slider for the guide's force, of links 2 and 3 for the cranks' forces
    guide = (inertia["link6.inertia"] * m.alpha[6] + cross(r, 0.5 * six + seven)) / r.real
    total = two + three + six + seven - 1j * guide
    moment_2 = inertia["link2.inertia"] * m.alpha[2] + cross(p, 0.5 * two)
    moment_3 = inertia["link3.inertia"] * m.alpha[3] + cross(q, 0.5 * three)
    # p x F_A = moment_2, q x (total - F_A) = moment_3
    rotated = _solve(1j * p, 1j * q, moment_2, cross(q, total) - moment_3)
    return rotated, total - rotated


def largest(
    machine: Machine, omega_1: Array, omega_4: Array, gravity: complex, at_rest: bool, steps: int = 400
) -> Array:
    """Compute the largest forces in their printed windows, (n, 6) in the order of `FORCES` [N].

    Parameters
    ----------
    machine : Machine
    omega_1, omega_4 : (n,) arrays
        Speeds of the cranks [rad/s].
    gravity : complex
    at_rest : bool
        Start at rest instead of at the ideal velocities.
    steps : int
        Intervals within the longest window.

    Returns
    -------
    (n, 6) array
        NaN where the linkage does not close.
    """
    t = np.linspace(0.0, max(WINDOWS.values()), steps + 1)
    with np.errstate(invalid="ignore"):
        motion = move(
            machine, crank(0.0, omega_1[:, None], t, at_rest), crank(machine.start, omega_4[:, None], t, at_rest)
        )
        found = [forces(motion, machine.inertias(design), gravity) for design in DESIGNS.values()]
    sizes = [
        np.abs(pair[k][:, t <= end + 1e-12]).max(axis=1) for k, end in enumerate(WINDOWS.values()) for pair in found
    ]
    return np.stack(sizes, axis=1)


def ratios(limit: int = 6) -> list[tuple[int, int]]:
    """List the turns of crank 1 and crank 4 in a common period, up to `limit` of each, in both senses."""
    whole = range(1, limit + 1)
    return [(i * p, j * q) for p in whole for q in whole if gcd(p, q) == 1 for i in (1, -1) for j in (1, -1)]


def steady(machine: Machine, turns_1: int, turns_4: int, steps: int = 4000) -> tuple[float, float]:
    """Compute largest and least acceleration of the slider over a period of 2 pi s [m/s2]; NaN where the linkage does not close.

    Accelerations grow with the square of the speeds, so this is the slider's motion at all speeds of this ratio.
    """
    t = np.linspace(0.0, 2.0 * np.pi, steps + 1)
    with np.errstate(invalid="ignore"):
        motion = move(
            machine, crank(0.0, np.float64(turns_1), t, False), crank(machine.start, np.float64(turns_4), t, False)
        )
    return float(motion.a_d.real.max()), float(motion.a_d.real.min())


def deviation(found: Array) -> Array:
    """Root mean square of the logarithms of forces over the printed ones, (n,); infinite where the linkage does not close."""
    with np.errstate(divide="ignore", invalid="ignore"):
        apart = np.sqrt(np.mean(np.log(found / FORCES) ** 2, axis=1))
    return np.where(np.isfinite(apart), apart, np.inf)


def scan(gravity: complex, at_rest: bool, limit: float, step: float) -> Array:
    """Compute all commensurate pairs of speeds whose linkage turns over.

    Parameters
    ----------
    gravity : complex
    at_rest : bool
    limit, step : float
        Largest speed of either crank, and the step of crank 1's [rad/s].

    Returns
    -------
    (n, 5) array
        Both speeds [rad/s], deviation of the six forces, largest and least acceleration of the slider over a period [m/s2].
    """
    machine, rows = Machine(), []
    for one, four in ratios():
        extremes = np.array(steady(machine, one, four))
        if not np.isfinite(extremes).all():
            continue
        first = np.copysign(np.arange(step, limit + 0.5 * step, step), one)
        second = first * four / one
        first, second = (speeds[np.abs(second) <= limit + 1e-9] for speeds in (first, second))
        apart = deviation(largest(machine, first, second, gravity, at_rest))
        rows.append(np.column_stack([first, second, apart, (first / one)[:, None] ** 2 * extremes]))
    return np.vstack(rows)


def grid(speeds: Array, gravity: complex) -> Array:
    """Compute the deviation of the six forces over both speeds, (n, n); rows are omega_4, columns omega_1."""
    machine = Machine()
    return np.array(
        [deviation(largest(machine, speeds, np.full_like(speeds, four), gravity, False)) for four in speeds]
    )


def _pin(length: float, angle: Angle) -> tuple[Complex, Complex, Complex]:
    """Position from the pivot, velocity and acceleration of a crank's pin."""
    at = length * np.exp(1j * angle.value)
    return at, 1j * angle.rate * at, (1j * angle.acceleration - angle.rate**2) * at


def _solve(p: Complex, q: Complex, of_p: Array, of_q: Array) -> Complex:
    """Find the vector with the scalar products `of_p` with p and `of_q` with q."""
    return 1j * (of_q * p - of_p * q) / cross(p, q)
