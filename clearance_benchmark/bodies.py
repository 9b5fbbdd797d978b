"""Machines in the coordinates of all bodies, with numpy and scipy alone: a second solution of each problem.

Every body has the place of its mass centre and its angle (x, y, a); joints are constraints, whose forces are Lagrange
multipliers; clearances are forces. DOP853 integrates from one event (a contact begins or ends) to the next. The program
whose references stand beside it has relative coordinates and its own integrators; the two share no line.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import minimize_scalar

NODES, WEIGHTS = np.polynomial.legendre.leggauss(120)
STEEL = 207e9 / (2.0 * (1.0 - 0.3**2))  # modulus E' of two steel bodies [Pa]
GROUND = -1
EXACT = {"method": "DOP853", "rtol": 2.3e-14, "atol": 1e-16}
#: Columns of a reference of contacts.
CONTACT = {"contact": "1", "start": "s", "approach_speed": "m/s", "end": "s", "peak_load": "N", "peak_penetration": "m",
           "separation_speed": "m/s"}  # fmt: skip


@dataclass
class Clearance:
    """A journal in a bearing, at points of two bodies: a short film if it has a viscosity, else dry contact."""

    bearing: int
    at: tuple[float, float]
    journal: int
    point: tuple[float, float]
    clearance: float
    radius: float
    length: float = 0.0
    viscosity: float = 0.0
    restitution: float = 0.9
    friction: float = 0.0


@dataclass
class Flanks:
    """Backlash of two wheels: penetration of either flank +-r (a_j - ratio a_i) - width/2."""

    wheels: tuple[int, int]
    ratio: float
    radius: float
    width: float
    stiffness: float
    restitution: float


@dataclass
class Machine:
    """Bodies, and what acts between them."""

    mass: list[float]
    inertia: list[float]
    guess: list[tuple[float, float, float]]  # near the places at t = 0
    pins: list[tuple] = field(default_factory=list)  # body, its point, other body, its point
    guides: list[int] = field(default_factory=list)  # bodies that move along x without turning
    driven: dict[int, Callable] = field(default_factory=dict)  # angle, rate and acceleration of bodies over time
    spin: dict[int, float] = field(default_factory=dict)  # rates at t = 0 of bodies that are not driven
    torque: dict[int, Callable] = field(default_factory=dict)  # of the rate of a body
    clearances: list[Clearance] = field(default_factory=list)
    flanks: list[Flanks] = field(default_factory=list)
    gravity: float = 0.0  # along -y

    def point(self, q, v, body, at):
        """Arm from the mass centre, place, velocity and rate of turning of a body's point."""
        if body == GROUND:
            return np.array(at), np.array(at), np.zeros(2), 0.0
        c, s = np.cos(q[body, 2]), np.sin(q[body, 2])
        arm, rate = np.array([c * at[0] - s * at[1], s * at[0] + c * at[1]]), v[body, 2]
        return arm, q[body, :2] + arm, v[body, :2] + rate * np.array([-arm[1], arm[0]]), rate

    def rows(self, q, v, t, pins, spin=()):
        """Constraints (n,), their derivatives (n, 3 nb), wanted rates (n,) and wanted products with accelerations."""
        gap, lines, rates, wanted, unit = [], [], [], [], np.eye(q.size)
        for pin in pins:
            line, apart, turn = np.zeros((2, *q.shape)), np.zeros(2), np.zeros(2)
            for sign, body, at in ((1.0, *pin[2:]), (-1.0, *pin[:2])):
                arm, place, _, rate = self.point(q, v, body, at)
                apart, turn = apart + sign * place, turn + sign * rate**2 * arm
                if body != GROUND:
                    line[:, body] = sign * np.array([[1.0, 0.0, -arm[1]], [0.0, 1.0, arm[0]]])
            gap, lines, rates, wanted = (
                [*gap, *apart],
                [*lines, *line.reshape(2, -1)],
                [*rates, 0.0, 0.0],
                [*wanted, *turn],
            )
        single = [(3 * body + k, 0.0, 0.0, 0.0) for body in self.guides for k in (1, 2)]
        single += [(3 * body + 2, *motion(t)) for body, motion in self.driven.items()]
        single += [(3 * body + 2, self.guess[body][2], spin[body], 0.0) for body in spin]
        for k, place, rate, more in single:
            gap, lines, rates, wanted = [*gap, q.flat[k] - place], [*lines, unit[k]], [*rates, rate], [*wanted, more]
        return np.array(gap), np.array(lines).reshape(len(gap), q.size), np.array(rates), np.array(wanted)

    def start(self):
        """Places and rates at t = 0: journals in the middle of their bearings, flanks in the middle of their play."""
        q, pins = np.array(self.guess), self.pins + [(c.bearing, c.at, c.journal, c.point) for c in self.clearances]
        for _ in range(20):
            gap, lines, rates, _ = self.rows(q, 0.0 * q, 0.0, pins, self.spin)
            q -= (np.linalg.pinv(lines) @ gap).reshape(q.shape)
        return np.concatenate([q.ravel(), np.linalg.pinv(lines) @ rates])

    def depths(self, y):
        """Penetrations of all contacts and their rates, (2, nc)."""
        (q, v), found = y.reshape(2, -1, 3), []
        for joint in self.clearances:
            if joint.viscosity == 0.0:
                e, w = self.eccentricity(joint, y)[:2]
                found.append((np.hypot(*e) - joint.clearance, e @ w / max(np.hypot(*e), 1e-300)))
        for gear in self.flanks:
            for side in (gear.radius, -gear.radius):
                apart = [side * (x[gear.wheels[1], 2] - gear.ratio * x[gear.wheels[0], 2]) for x in (q, v)]
                found.append((apart[0] - gear.width / 2, apart[1]))
        return np.array(found).reshape(-1, 2).T

    def eccentricity(self, joint, y):
        """Place and velocity of the journal's centre in the bearing; rates of both; arms of the journal's centre."""
        q, v = y.reshape(2, -1, 3)
        bearing, journal = self.point(q, v, joint.bearing, joint.at), self.point(q, v, joint.journal, joint.point)
        e = journal[1] - bearing[1]
        return e, journal[2] - bearing[2], bearing[3], journal[3], bearing[0] + e, journal[0]

    def forces(self, y, approach):
        """Generalised forces (nb, 3), and a list with the force on each journal and the load of each flank."""
        total, each, contacts = np.zeros((len(self.mass), 3)), [], iter(zip(*self.depths(y), approach, strict=True))
        for joint in self.clearances:
            e, w, spin_b, spin_j, arm_b, arm_j = self.eccentricity(joint, y)
            if joint.viscosity > 0.0:
                force, couple = short_film(joint, e, w - 0.5 * (spin_b + spin_j) * np.array([-e[1], e[0]])), 0.0
            else:
                force, couple = dry(joint, e, w, spin_b, spin_j, *next(contacts))
            each.append(force)
            for body, sign, arm in ((joint.journal, 1.0, arm_j), (joint.bearing, -1.0, arm_b)):
                if body != GROUND:
                    total[body] += sign * np.array([*force, arm[0] * force[1] - arm[1] * force[0] + couple])
        for gear in self.flanks:
            for side in (gear.radius, -gear.radius):
                each.append(flank(gear, *next(contacts)))
                total[gear.wheels, 2] += side * each[-1] * np.array([gear.ratio, -1.0])
        return total, each

    def rates(self, t, y, approach):
        """Rates of places and velocities, by the multipliers of the joints."""
        (q, v), load = y.reshape(2, -1, 3), self.forces(y, approach)[0]
        load[:, 1] -= self.gravity * np.array(self.mass)
        for body, torque in self.torque.items():
            load[body, 2] += torque(v[body, 2])
        _, lines, _, wanted = self.rows(q, v, t, self.pins)
        inertia = np.diag(np.stack([self.mass, self.mass, self.inertia], axis=1).ravel())
        matrix = np.block([[inertia, lines.T], [lines, np.zeros((len(lines), len(lines)))]])
        return np.concatenate([v.ravel(), np.linalg.solve(matrix, np.concatenate([load.ravel(), wanted]))[: q.size]])

    def contacts(self, most, free_step, contact_step):
        """Run to the end of a number of contacts; return their rows.

        A row: number of the contact, start, approach speed, end, largest load and penetration, separation speed.
        """
        t, y, rows, open_ = 0.0, self.start(), [], {}
        approach = [None] * len(self.depths(y)[0])
        films = sum(joint.viscosity > 0.0 for joint in self.clearances)
        while len(rows) < most:
            found = solve_ivp(
                self.rates, (t, 1.0), y, **EXACT, args=(approach,), dense_output=True,
                max_step=contact_step if open_ else free_step,
                events=[self.event(k, 1.0 if one is None else -1.0) for k, one in enumerate(approach)],
            )  # fmt: skip
            for k, row in open_.items():
                load = lambda t, k=k: np.linalg.norm(self.forces(found.sol(t), approach)[1][films + k])  # noqa: E731
                depth = lambda t, k=k: self.depths(found.sol(t))[0][k]  # noqa: E731
                row[4:6] = max(row[4], largest(load, found.t)), max(row[5], largest(depth, found.t))
            t, y = found.t[-1], found.y[:, -1]
            for k in (k for k in range(len(approach)) if len(found.t_events[k])):
                speed = self.depths(y)[1][k]
                if approach[k] is None:
                    approach[k], open_[k] = speed, [k, t, speed, 0.0, 0.0, 0.0]
                else:
                    row, approach[k] = open_.pop(k), None
                    rows.append([*row[:3], t, *row[4:], -speed])
        return np.array(sorted(rows, key=lambda row: row[1]))

    def event(self, k, direction):
        """The penetration of a contact, whose zero ends an integration."""

        def depth(t, y, approach):
            return self.depths(y)[0][k]

        depth.terminal, depth.direction = True, direction
        return depth


def largest(value, times):
    """The largest value within steps, at least three points of which are evaluated in each."""
    dense = np.unique(np.linspace(times[:-1], times[1:], 5))
    k = int(np.clip(np.argmax([value(t) for t in dense]), 1, len(dense) - 2))
    return -minimize_scalar(lambda t: -value(t), bounds=(dense[k - 1], dense[k + 1]), options={"xatol": 1e-14}).fun


def short_film(joint, e, w):
    """Ocvirk's film where its pressure is positive: F = -mu R L^3 (integral of (w.u) u / h^3), h = c - e.u."""
    angle = np.arctan2(w[1], w[0]) + np.pi / 2 * NODES
    u = np.stack([np.cos(angle), np.sin(angle)])
    weights = np.pi / 2 * WEIGHTS * (w @ u) / (joint.clearance - e @ u) ** 3
    return -joint.viscosity * joint.radius * joint.length**3 * (u @ weights)


def dry(joint, e, w, spin_b, spin_j, depth, rate, approach):
    """Lankarani and Nikravesh's normal force, Ambrosio's friction: force and couple on the journal."""
    if approach is None or depth <= 0.0:
        return np.zeros(2), 0.0
    journal, size = joint.radius - joint.clearance, np.hypot(*e)
    stiffness = 4.0 / 3.0 * STEEL * np.sqrt(joint.radius * journal / joint.clearance)
    loss = 0.75 * (1.0 - joint.restitution**2)
    load = stiffness * depth**1.5 * (1.0 + loss * np.clip(rate / approach, -1.0, 1.0))
    n, t = e / size, np.array([-e[1], e[0]]) / size
    sliding = w @ t + spin_j * journal - spin_b * (size + journal)
    drag = np.sign(sliding) * joint.friction * np.clip((abs(sliding) - 1e-4) / 9e-4, 0.0, 1.0) * load
    return -load * n - drag * t, -journal * drag


def flank(gear, depth, rate, approach):
    """Flores' load of a flank, never below zero."""
    if approach is None or depth <= 0.0:
        return 0.0
    loss = 1.6 * (1.0 - gear.restitution) / gear.restitution
    return max(gear.stiffness * depth**1.5 * (1.0 + loss * np.clip(rate / approach, -1.0, 1.0)), 0.0)


def steady(rate, angle=0.0):
    """An angle that grows at a constant rate: angle, rate and acceleration over time."""
    return lambda t: (angle + rate * t, rate, 0.0)


def over_time(machine, times, state, rates):
    """Columns at times: numbers of the state and of its rates, then place and force of each journal.

    Each time ends a step: forces need velocities that are more accurate than between the ends of steps.
    """
    rows, y, before = [], machine.start(), times[0]
    for t in times:
        y = solve_ivp(machine.rates, (before, t), y, **EXACT, args=([],)).y[:, -1] if t > before else y
        change, forces, before = machine.rates(t, y, []), machine.forces(y, [])[1], t
        journals = [
            [*machine.eccentricity(joint, y)[0], *f] for joint, f in zip(machine.clearances, forces, strict=True)
        ]
        rows.append([t, *y[list(state)], *change[list(rates)], *np.ravel(journals)])
    return np.array(rows)


def journal(name):
    """Columns of a journal: its place in the bearing, and the force on it."""
    return {f"{name}.{what}": unit for what, unit in (("ex", "m"), ("ey", "m"), ("fx", "N"), ("fy", "N"))}


def table(rows, columns):
    """Print rows as CSV, with the names and units of the columns."""
    print(",".join(f"{name} [{unit}]" for name, unit in columns.items()))
    for row in rows:
        print(",".join(f"{x:.15g}" for x in row))
