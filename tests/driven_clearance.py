"""Machines with clearance in driven joints, and independent models of some.

A slider-crank and a four-bar have clearance in the main bearing O of the driven crank. All bodies have absolute coordinates x, y, angle of their mass centres;
pins, guide and drive are constraints with Lagrange multipliers. The journal's centre (x, y), and for a drive by torque
the crank's angle, are integrated; the other positions follow in closed form, so that no constraint drifts.
"""

from __future__ import annotations

from dataclasses import dataclass

import contact_events
import guide_model
import numpy as np
from machines import bar, circle_intersection, four_bar, joint, model, slider_crank, solid
from paper_formulation import LENGTH, RADIUS, Data
from scipy.integrate import solve_ivp

BEARING = (
    f"<linkages:bearing><linkages:radius>{RADIUS}</linkages:radius><linkages:length>{LENGTH}</linkages:length>"
    "</linkages:bearing>"
)
GRAVITY = -9.81
#: Lengths of crank and coupler; of the follower and the ground, or masses of the links [m, kg].
SLIDER_CRANK, FOUR_BAR = (0.05, 0.12), (0.1, 0.25, 0.2, 0.3)


def with_bearing(sdf: str) -> str:
    """Give the driven pin O of a machine of `machines` the bearing of the laws in `joint_laws`."""
    plain = joint("O", "world", "crank")
    assert plain in sdf
    return sdf.replace(plain, joint("O", "world", "crank", inner=BEARING))


SDF = {"slider_crank": with_bearing(slider_crank()), "four_bar": with_bearing(four_bar())}


def unit(angle):
    """Unit vector at an angle."""
    return np.array([np.cos(angle), np.sin(angle)])


def normal(angle):
    """The same, turned by a right angle."""
    return np.array([-np.sin(angle), np.cos(angle)])


@dataclass
class DrivenCrank:
    """A machine, the law of its main bearing, and its drive: (angle, speed, acceleration) of the time, or a torque."""

    name: str
    law: object
    clearance: float
    viscosity: float = 0.0
    motion: object = None
    torque: float = 0.0
    speed: float = 0.0

    def __post_init__(self):
        self.slides = self.name == "slider_crank"
        self.lengths = SLIDER_CRANK if self.slides else FOUR_BAR[:3]
        masses = (0.3, 0.21) if self.slides else (0.2, 0.2, 0.2)
        self.masses = [*masses, *([0.14] if self.slides else [])]
        self.inertias = [m * length**2 / 12 for m, length in zip(masses, self.lengths, strict=False)]
        self.inertias += [1e-4] if self.slides else []
        self.data = Data(clearance=(self.clearance,) * 2, viscosity=(self.viscosity,) * 2)
        angles = self.angles(np.zeros(2), 0.0)
        self.upright = angles[-1] if self.slides else 0.0
        self.start = np.array([0.0, 0.0, 0.0, 0.0] if self.motion else [0.0, 0.0, 0.0, 0.0, 0.0, self.speed])

    def angles(self, centre, theta):
        """Angles of the bodies: the loop closed on its branch."""
        tip = centre + self.lengths[0] * unit(theta)
        if self.slides:
            return theta, np.arcsin(-tip[1] / self.lengths[1]), 0.0
        pivot = np.array([FOUR_BAR[3], 0.0])
        pin = circle_intersection(tip, self.lengths[1], pivot, self.lengths[2])
        return theta, np.arctan2(*(pin - tip)[::-1]), np.arctan2(*(pin - pivot)[::-1])

    def solve(self, t, state, approach=None):
        """Accelerations of the integrated coordinates, force on the journal, torque of the drive, e and its rate."""
        n = 2 if self.motion else 3
        theta, speed, acceleration = self.motion(t) if self.motion else (state[2], state[5], 0.0)
        centre, rate = state[:2], state[n : n + 2]
        a = self.angles(centre, theta)
        half = [0.5 * length for length in self.lengths]
        # places of pins along the bodies, from their mass centres: crank-coupler, coupler-(slider or follower), ground
        pins = [(0, half[0], 1, -half[1]), (1, half[1], 2, 0.0 if self.slides else half[2])]
        rows, arms = np.zeros((7, 9)), []
        for k, (i, s, j, r) in enumerate(pins):
            rows[2 * k : 2 * k + 2, 3 * i : 3 * i + 2], rows[2 * k : 2 * k + 2, 3 * j : 3 * j + 2] = (
                np.eye(2),
                -np.eye(2),
            )
            rows[2 * k : 2 * k + 2, 3 * i + 2], rows[2 * k : 2 * k + 2, 3 * j + 2] = s * normal(a[i]), -r * normal(a[j])
            arms.append((i, s, j, r))
        if self.slides:
            rows[4, 7] = rows[5, 8] = 1.0
        else:
            rows[4:6, 6:8], rows[4:6, 8] = np.eye(2), -half[2] * normal(a[2])
        rows[6, 2] = 1.0
        journal = np.zeros((2, 9))
        journal[:, :2], journal[:, 2] = np.eye(2), -half[0] * normal(theta)
        v = np.linalg.solve(np.vstack([rows, journal]), np.concatenate([np.zeros(6), [speed], rate]))
        w = v[2::3]
        right = np.zeros(7)
        for k, (i, s, j, r) in enumerate(arms):
            right[2 * k : 2 * k + 2] = s * w[i] ** 2 * unit(a[i]) - r * w[j] ** 2 * unit(a[j])
        if not self.slides:
            right[4:6] = -half[2] * w[2] ** 2 * unit(a[2])
        right[6] = acceleration
        force, couple = self.law(self.data, 0, centre, rate, 0.0, speed, approach)
        loads = journal.T @ force
        loads[1::3] += np.array(self.masses) * GRAVITY
        loads[2] += couple
        if not self.motion:
            rows, right = rows[:6], right[:6]
            loads[2] += self.torque
        m = len(rows)
        mass = np.diag(np.ravel([(m, m, inertia) for m, inertia in zip(self.masses, self.inertias, strict=True)]))
        whole = np.block([[mass, rows.T], [rows, np.zeros((m, m))]])
        found = np.linalg.solve(whole, np.concatenate([loads, right]))
        acc = found[:9]
        moved = journal @ acc + half[0] * w[0] ** 2 * unit(theta)
        effort = -found[-1] if self.motion else self.torque
        return np.append(moved, acc[2])[:n], force, effort

    def rates(self, t, state, approach=None):
        """Rates of the state."""
        n = len(state) // 2
        return np.concatenate([state[n:], self.solve(t, state, approach)[0]])

    def run(self, times):
        """Eccentricity, force on the journal and torque of the drive at some times, for a film, (nt, 5)."""
        found = solve_ivp(
            self.rates, (0.0, times[-1]), self.start, "Radau", t_eval=times, rtol=1e-11, atol=1e-15, max_step=1e-3
        )
        assert found.success
        solved = [self.solve(t, state) for t, state in zip(times, found.y.T, strict=True)]
        return np.array([[*state[:2], *one[1], one[2]] for state, one in zip(found.y.T, solved, strict=True)])

    def contacts(self, duration):
        """Contacts of the dry journal, see `contact_events.contacts`."""

        def depths(t, state):
            n = len(state) // 2
            size = np.hypot(*state[:2])
            closing = state[:2] @ state[n : n + 2] / size if size > 0.0 else 0.0
            return [size - self.clearance], [closing]

        def loads(t, state, approach):
            return [np.hypot(*self.solve(t, state, approach[0])[1])]

        def rates(t, state, approach):
            return self.rates(t, state, approach[0])

        return contact_events.contacts(
            rates, depths, loads, self.start, duration, rtol=1e-12, max_step=1e-4, samples=1000
        )


SLOT = "<linkages:slot><linkages:length>0.04</linkages:length><linkages:height>0.028</linkages:height></linkages:slot>"
#: A block, driven along its slot, with its mass centre beside the slot's middle.
BLOCK_MASS, BLOCK_INERTIA, CENTRE = 0.14, 1e-4, (0.006, 0.003)
BLOCK = model(
    "block",
    solid("block", BLOCK_MASS, BLOCK_INERTIA, centre=f"{CENTRE[0]} {CENTRE[1]} 0 0 0 0")
    + joint("P", "world", "block", "prismatic", "1 0 0", inner=SLOT),
)


@dataclass
class DrivenBlock:
    """The block in its slot: corners and laws of `guide_model`; its drive: (place, speed, acceleration), or a force."""

    motion: object = None
    force: float = 0.0
    speed: float = 0.0

    def corners(self, t, state):
        """Arm from the block's middle, side, penetration, its rate, speed along the wall of each corner."""
        n = len(state) // 2
        along = self.motion(t)[1] if self.motion else state[3]
        (y, turn), (y_rate, rate) = state[n - 2 : n], state[2 * n - 2 :]
        for x, side in guide_model.CORNERS:
            arm = x * guide_model.HALF_LENGTH * unit(turn) + side * guide_model.HALF_HEIGHT * normal(turn)
            depth = side * (y + arm[1]) - guide_model.HALF_HEIGHT - guide_model.CLEARANCE
            yield arm, side, depth, side * (y_rate + rate * arm[0]), along - rate * arm[1]

    def forces(self, t, state, approach):
        """Arm and force of each corner."""
        r, mu = guide_model.RESTITUTION, guide_model.FRICTION
        for k, (arm, side, depth, closing, speed) in enumerate(self.corners(t, state)):
            load = 0.0
            if approach[k] is not None and depth > 0.0:
                damping = 1 + 8 * (1 - r) / (5 * r) * np.clip(closing / max(approach[k], 1e-6), -1, 1)
                load = max(guide_model.STIFFNESS * depth**1.5 * damping, 0.0)
            yield arm, np.array([-mu * np.tanh(speed / guide_model.V_1) * load, -side * load])

    def rates(self, t, state, approach):
        """Newton and Euler about the mass centre; the drive's force acts along the slot through the block's middle."""
        n, m = len(state) // 2, BLOCK_MASS
        turn, rate = state[n - 1], state[-1]
        r = CENTRE[0] * unit(turn) + CENTRE[1] * normal(turn)
        total, moment = m * rate**2 * r + np.array([0.0, m * GRAVITY]), 0.0
        for arm, force in self.forces(t, state, approach):
            total = total + force
            moment += (arm[0] - r[0]) * force[1] - (arm[1] - r[1]) * force[0]
        # unknown: acceleration along the slot, or the drive's force; acceleration across; angular acceleration
        matrix = np.array([[m, 0.0, -m * r[1]], [0.0, m, m * r[0]], [0.0, 0.0, BLOCK_INERTIA]])
        right = np.array([total[0] + self.force, total[1], moment + r[1] * self.force])
        if self.motion:
            matrix[:, 0] = [-1.0, 0.0, -r[1]]
            right[0] -= m * self.motion(t)[2]
        found = np.linalg.solve(matrix, right)
        return np.concatenate([state[n:], found[3 - n :]])

    def contacts(self, duration):
        """Contacts of the corners, see `contact_events.contacts`."""
        start = np.zeros(4) if self.motion else np.array([0.0, 0.0, 0.0, self.speed, 0.0, 0.0])

        def depths(t, state):
            return np.array([(depth, closing) for _, _, depth, closing, _ in self.corners(t, state)]).T

        def loads(t, state, approach):
            return [np.hypot(*force) for _, force in self.forces(t, state, approach)]

        return contact_events.contacts(self.rates, depths, loads, start, duration, rtol=1e-11, max_step=2e-5)


def cylinder(parent: str, child: str) -> str:
    """A lever moved by a cylinder and its rod: a driven slider P between two links that move; either has the slot."""
    hook = 0.2 * unit(1.0) - np.array([0.3, 0.0])
    body = f"""{bar("lever", 0.3, "__model__", 1.0, mass=0.5)}
<frame name="foot" attached_to="world"><pose relative_to="__model__">0.3 0 0 0 0 0</pose></frame>
<frame name="hook" attached_to="lever"><pose>0.2 0 0 0 0 0</pose></frame>
{bar("cylinder", 0.12, "foot", np.arctan2(hook[1], hook[0]), mass=0.3)}
<frame name="mouth" attached_to="cylinder"><pose>{np.hypot(*hook) - 0.09} 0 0 0 0 0</pose></frame>
{bar("rod", 0.09, "mouth")}{joint("F", "world", "cylinder")}{joint("L", "world", "lever")}
{joint("H", "rod_tip", "hook")}"""
    slide = joint("P", parent, child, "prismatic", "1 0 0", SLOT).replace("<xyz>", '<xyz expressed_in="cylinder">')
    return model("cylinder", body + slide)


def carried_crank(parent: str, child: str, axis: str, plane: str) -> str:
    """A crank and a pendulum on a free carriage: a driven pin O with clearance between two links that move."""
    body = solid("carriage", 0.5, 1e-3) + bar("crank", 0.1, "__model__", 0.3) + bar("tail", 0.08, "crank_tip", 0.8)
    body += joint("s", "world", "carriage", "prismatic", "1 0 0") + joint("T", "crank_tip", "tail")
    return model("carried_crank", body + joint("O", parent, child, axis=axis, inner=BEARING), plane)
