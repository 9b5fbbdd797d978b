"""Correct digits of derivatives through an impact in three programs: ``python benchmarks/impact_derivatives.py``.

A mass falls by a clearance onto a spring and a damper (Kelvin and Voigt), whose force jumps at the touch. The closed
form gives the derivatives of its speed during the contact with respect to gravity, clearance, stiffness, damping, mass.
CasADi (CVODES with forward sensitivities; the touch by ``if_else``) and diffrax (an event with a root finder, then the
contact; reverse mode) are compared if they are installed. All have tolerances of 1e-12.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from linkages.engines.compiled.derivatives.sensitivity import differentiate
from linkages.engines.compiled.run.runner import Runner, join
from linkages.engines.drop import CLEARANCE, GRAVITY, MASS, drop

NAMES = ("gravity", "clearance", "stiffness", "damping", "mass")
VALUES = np.array([GRAVITY, CLEARANCE, 1e7, 2e3, MASS])
END = 0.01465  # s, during the contact


def exact() -> np.ndarray:
    """Differentiate the downward speed of the closed form, by complex steps."""
    found = []
    for k, value in enumerate(VALUES):
        moved = VALUES.astype(complex)
        moved[k] += 1e-20j * value
        gravity, clearance, stiffness, damping, mass = moved
        speed, since = np.sqrt(2.0 * clearance * gravity), END - np.sqrt(2.0 * clearance / gravity)
        decay, rest = damping / (2.0 * mass), gravity * mass / stiffness
        rate = np.sqrt(stiffness / mass - decay**2)
        sine = (speed - decay * rest) / rate
        cos, sin, fall = np.cos(rate * since), np.sin(rate * since), np.exp(-decay * since)
        found.append((fall * (rate * (sine * cos + rest * sin) - decay * (sine * sin - rest * cos))).imag)
    return np.array(found) / (1e-20 * VALUES)


def linkages_() -> np.ndarray:
    """Differentiate a run of the compiled engine."""
    contact = {"law": "kelvin-voigt", "restitution": 1.0, "stiffness": VALUES[2], "damping": VALUES[3]}
    runner = Runner(drop().replaced({"joints.J.contact": contact, "duration": END, "solver.accuracy": 1e-12}))
    steps = join([runner.run(0.0, runner.start, 0.0, 10**6)])
    parts = ["gravity.y", "joints.J.clearance", "joints.J.contact.stiffness", "joints.J.contact.damping"]
    found = differentiate(runner, steps, [*parts, "sdf.links.journal.mass"])
    n = len(runner.model.free)
    place = n + int(np.argmax(np.abs(steps.states[-1][:n])))
    return found.states[-1][place, -len(VALUES) :] * [1.0, -1.0, -1.0, -1.0, -1.0]  # downwards; gravity.y too


def casadi_() -> np.ndarray:
    """Differentiate by CasADi."""
    import casadi

    x, p = casadi.SX.sym("x", 2), casadi.SX.sym("p", 5)
    gravity, clearance, stiffness, damping, mass = casadi.vertsplit(p)
    depth = x[0] - clearance
    force = casadi.if_else(depth > 0.0, stiffness * depth + damping * x[1], 0.0)
    problem = {"x": x, "p": p, "ode": casadi.vertcat(x[1], gravity - force / mass)}
    options = {"abstol": 1e-12, "reltol": 1e-12, "max_num_steps": 10**6}
    solve = casadi.integrator("solve", "cvodes", problem, 0.0, END, options)
    slope = solve.factory("slope", ["x0", "p"], ["jac:xf:p"])
    return np.array(slope(x0=[0.0, 0.0], p=VALUES)["jac_xf_p"])[1]


def diffrax_() -> np.ndarray:
    """Differentiate by diffrax."""
    import jax

    jax.config.update("jax_enable_x64", True)
    import diffrax
    import jax.numpy as jnp
    import optimistix

    def part(touches: bool) -> diffrax.ODETerm:
        def rates(t, y, p):
            force = p[2] * (y[0] - p[1]) + p[3] * y[1] if touches else 0.0
            return jnp.array([y[1], p[0] - force / p[4]])

        return diffrax.ODETerm(rates)

    control = diffrax.PIDController(rtol=1e-12, atol=1e-12)
    event = diffrax.Event(lambda t, y, args, **other: y[0] - args[1], optimistix.Newton(1e-13, 1e-13))
    common = {"stepsize_controller": control, "max_steps": 4096}

    def speed(p):
        fall = diffrax.diffeqsolve(
            part(False), diffrax.Dopri8(), 0.0, END, 1e-4, jnp.zeros(2), p, event=event, **common
        )
        end = diffrax.diffeqsolve(part(True), diffrax.Dopri8(), fall.ts[-1], END, 1e-6, fall.ys[-1], p, **common)
        return end.ys[-1, 1]

    return np.asarray(jax.jacrev(speed)(jnp.array(VALUES)))


def main() -> None:
    """Print the correct digits of each derivative, by program."""
    expected = exact()
    print(f"{'correct digits':16s}" + "".join(f"{name:>11s}" for name in NAMES))
    programs: dict[str, Callable[[], np.ndarray]] = {"linkages": linkages_, "CasADi": casadi_, "diffrax": diffrax_}
    for name, program in programs.items():
        try:
            errors = np.abs(program() / expected - 1.0)
        except ImportError:
            print(f"{name:16s} is not installed")
            continue
        print(f"{name:16s}" + "".join(f"{-math.log10(max(error, 1e-16)):11.1f}" for error in errors), flush=True)


if __name__ == "__main__":
    main()
