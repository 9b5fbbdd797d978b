"""The six machines of the benchmark for `independent.py`; their problem statements are in `statements.md`."""

from __future__ import annotations

import math

import numpy as np

from independent import Clearance, Flanks, Machine

TURN = 2.0 * math.pi


def steady(rate, angle=0.0):
    """An angle that grows at a constant rate."""
    return lambda t: (angle + rate * t, rate, 0.0)


def bouncing_journal():
    """A spinning journal falls in its bearing."""
    joint = Clearance(-1, (0.0, 0.0), 0, (0.0, 0.0), 0.5e-3, 0.01, restitution=0.9, friction=0.05)
    return Machine([0.5], [2e-5], [(0.0, 0.0, 0.0)], spin={0: 50.0}, clearances=[joint], gravity=9.81)


def slider_crank(crank, **given):
    """Crank 50 mm, rod 120 mm, slider: bodies 0, 1, 2."""
    guess = [(0.0, 0.0, 0.0), (0.11, 0.0, 0.0), (0.17, 0.0, 0.0)]
    return Machine([0.30, 0.21, 0.14], [1e-5, 2.5e-4, 1e-4], guess, guides=[2], **crank, **given)


O, A, B = (-1, (0.0, 0.0), 0, (0.0, 0.0)), (0, (0.05, 0.0), 1, (-0.06, 0.0)), (2, (0.0, 0.0), 1, (0.06, 0.0))


def dry_slider_crank():
    """The rod's journal B in the slider, dry; 5000 r/min."""
    joint = Clearance(*B, 0.5e-3, 0.01, restitution=0.9, friction=0.03)
    return slider_crank({"driven": {0: steady(5000.0 * TURN / 60.0)}}, pins=[O, A], clearances=[joint])


def main_bearing():
    """The crank's journal O in the frame, with a film; a motor's torque on the crank."""
    joint = Clearance(*O, 0.1e-3, 0.015, 0.02, viscosity=0.05)
    torque = {0: lambda rate: 2.0}
    crank = {"spin": {0: 150.0}, "torque": torque}
    return slider_crank(crank, pins=[A, B], clearances=[joint], gravity=9.81)


def four_bar():
    """Drag-link double crank with films in A and B; 600 r/min."""
    up, coupler, follower = math.radians(90.0), math.radians(1.5808464), math.radians(68.6954659)
    centre = lambda x, y, r, a: (x + r * math.cos(a), y + r * math.sin(a), a)  # noqa: E731
    guess = [centre(0.0, 0.0, 0.1, up), centre(0.0, 0.2, 0.09, coupler), centre(0.1, 0.0, 0.11, follower)]
    pins = [(-1, (0.0, 0.0), 0, (-0.1, 0.0)), (-1, (0.1, 0.0), 2, (-0.11, 0.0))]
    films = [(0, (0.1, 0.0), 1, (-0.09, 0.0)), (1, (0.09, 0.0), 2, (0.11, 0.0))]
    joints = [Clearance(*film, 0.2e-3, 0.015, 0.03, viscosity=0.1) for film in films]
    mass, inertia = [0.314, 0.2826, 0.3454], [0.0010571, 0.00077244, 0.0014046]
    return Machine(mass, inertia, guess, pins, driven={0: steady(20.0 * math.pi, up)}, clearances=joints, gravity=9.81)


def gear_pair():
    """The pinion's speed fluctuates, the idle wheel rattles within the backlash."""
    rate = 251.3
    fluctuating = lambda t: (80.0 * t + 0.01 * math.sin(rate * t), 80.0 + 0.01 * rate * math.cos(rate * t),
                             -0.01 * rate**2 * math.sin(rate * t))  # noqa: E731  # fmt: skip
    flanks = Flanks((0, 1), -0.5, 0.0564, 50e-6, 5e8, 0.6)
    pins = [(-1, (0.0, 0.0), 0, (0.0, 0.0)), (-1, (0.09, 0.0), 1, (0.0, 0.0))]
    drag = {1: lambda rate: -0.01 * rate}
    wheels = [0.44, 1.78], [2.0e-4, 3.2e-3], [(0.0, 0.0, 0.0), (0.09, 0.0, 0.0)]
    spin = {1: -0.5 * (80.0 + 0.01 * rate)}
    return Machine(*wheels, pins, driven={0: fluctuating}, spin=spin, torque=drag, flanks=[flanks])


def press():
    """The seven-bar press with films in A and B; 30 and 60 r/min."""
    crank4 = math.radians(310.79)
    mass, inertia = [0.107, 0.219, 0.374, 0.107, 0.354, 0.139], [1.179e-4, 7.736e-4, 3.595e-3, 1.179e-4, 3.056e-3, 6.083e-5]
    c4, s4 = math.cos(crank4), math.sin(crank4)
    b = np.array([0.08 * c4, 0.301 + 0.08 * s4])
    link3 = math.atan2(-b[1], 0.26 - b[0])
    guess = [
        (0.04, 0.0, 0.0), (0.17, 0.0, 0.0), (b[0] + 0.159 * math.cos(link3), b[1] + 0.159 * math.sin(link3), link3),
        (0.04 * c4, 0.301 + 0.04 * s4, crank4), (0.41, 0.0, 0.0), (0.56, 0.0, 0.0),
    ]  # fmt: skip
    ground = [(-1, (0.0, 0.0), 0, (-0.04, 0.0)), (-1, (0.0, 0.301), 3, (-0.04, 0.0))]
    pins = [(1, (0.09, 0.0), 4, (-0.15, 0.0)), (2, (0.159, 0.0), 4, (-0.15, 0.0)), (4, (0.15, 0.0), 5, (0.0, 0.0))]
    films = [(0, (0.04, 0.0), 1, (-0.09, 0.0)), (3, (0.04, 0.0), 2, (-0.159, 0.0))]
    joints = [Clearance(*film, 0.3e-3, 0.015, 0.04, viscosity=0.4) for film in films]
    driven = {0: steady(math.pi), 3: steady(-TURN, crank4)}
    return Machine(mass, inertia, guess, ground + pins, [5], driven, clearances=joints, gravity=9.81)


def contacts(machine, most, free_step, contact_step):
    """Rows of the first contacts."""
    return machine.run(1.0, most=most, free_step=free_step, contact_step=contact_step)[1]


def over_time(machine, times, sizes):
    """Columns at times: numbers of the state and of its rates, then place and force of each journal."""
    rows = []
    for t, y in zip(times, machine.run(times[-1], times)[0], strict=True):
        rates, forces = machine.rates(t, y, []), machine.forces(y, [])[1]
        journals = [[*machine.eccentricity(joint, y)[0], *f] for joint, f in zip(machine.clearances, forces, strict=True)]
        rows.append([t, *(y[k] for k in sizes["state"]), *(rates[k] for k in sizes["rates"]), *np.ravel(journals)])
    return np.array(rows)


#: The reference of each problem, computed by these lines; for the columns see `make.py`.
PROBLEMS = {
    "bouncing_journal": lambda: contacts(bouncing_journal(), 8, 1e-3, 2e-6),
    "dry_slider_crank": lambda: contacts(dry_slider_crank(), 8, 1e-5, 1e-6),
    "main_bearing": lambda: over_time(main_bearing(), np.linspace(0.0, 0.08, 161), {"state": (2, 11, 6), "rates": (15,)}),
    "four_bar": lambda: over_time(four_bar(), np.linspace(0.0, 0.1, 201), {"state": (8, 17), "rates": (17,)}),
    "gear_pair": lambda: contacts(gear_pair(), 10, 1e-4, 1e-4),
    "press": lambda: over_time(press(), np.linspace(0.0, 0.1, 201), {"state": (15, 33), "rates": (33,)}),
}
