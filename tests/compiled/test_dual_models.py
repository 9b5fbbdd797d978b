"""Derivatives with respect to values by models of duals: films, wear, laws that have no duals."""

import math

import numba
import numpy as np
import pytest
from machines import rotor_in_block
from shipped import WORN, shipped

import linkages
from linkages import laws
from linkages.laws.contact.contact_laws import CONTACTS
from linkages.laws.film.closed_form import half_film_long
from linkages.laws.film.films import FILMS


def _differences(system, path, step, times, name):
    """Differences of the fourth order of an output of runs."""
    h, value = step * system.value(path), system.value(path)
    near = [linkages.simulate(system.replaced({path: value + k * h}), outputs=[name]) for k in (-2, -1, 1, 2)]
    before, lower, upper, after = (run.evaluate(times)[name] for run in near)
    return ((before - after) / 12 + (upper - lower) * 2 / 3) / h


TILTED = """duration = 0.002
drives.O = {speed = 1000.0}
forces.F = {point = "block", force = [0.0, 300.0]}
[joints.A]
model = "lubricated"
clearance = 5e-5
viscosity = 0.03
tilt = [1e-3, -1.5e-3]
"""


def _compare(system, exact, steps, name, times, limits):
    """Compare derivatives of an output, at each time, with differences of exact runs."""
    found = linkages.simulate(system, outputs=[name], wrt=list(steps)).sensitivity.evaluate(times)
    for path, step in steps.items():
        expected = _differences(exact, path, step, times, name)
        assert np.all(np.abs(found[path][name] - expected) < limits * np.abs(expected)), path


@pytest.mark.parametrize(("accuracy", "limit"), [(1e-6, 5e-2), (1e-11, 5e-4)])
def test_a_tilted_film_has_the_derivatives_of_differences_of_runs(system_of, accuracy, limit):
    system, exact = (system_of(rotor_in_block(), TILTED, {"solver.accuracy": a}) for a in (accuracy, 1e-11))
    steps = {"joints.A.clearance": 1e-3, "joints.A.viscosity": 1e-2, "drives.O.speed": 1e-2}
    _compare(system, exact, steps, "A.ex", np.linspace(4e-4, 2e-3, 5), limit)


@pytest.mark.parametrize(("accuracy", "limits"), [(1e-9, (5e-5, 1e-2)), (1e-12, (1e-5, 5e-4))])
def test_worn_parts_have_the_derivatives_of_differences_of_runs(accuracy, limits):
    """After one impact and after two; the force between two worn parts has kinks that no step ends at.

    The steps of the differences are long: rounding and these kinks move the runs by 1e-10.
    """
    given = {"duration": 1.2e-3, **WORN}
    system, exact = (shipped("slider_crank_wear", **{"solver.accuracy": a}, **given) for a in (accuracy, 1e-12))
    steps = {"joints.B.clearance": 1e-3, "joints.B.friction.coefficient": 1e-3, "sdf.links.slider.mass": 1e-3}
    _compare(system, exact, steps, "slider.vx", np.array([5e-4, 1.1e-3]), limits)


def _one(x):
    """Return 1, by a function that dual numbers do not have."""
    return math.gamma(2.0 + 0.0 * x)


@pytest.fixture
def unknown_laws():
    """Register laws twice: as they are, and with a factor of 1 that does not compile for duals."""
    numbers = [laws.Parameter("hardness", "N/m^1.5", 3e8, "stiffness", gt=0.0)]
    unit, one = [laws.Parameter("gain", "1", 1.0, "factor of the force", gt=0.0)], numba.njit(_one)

    def spring(delta, ddelta, ddelta0, joint):
        return joint.hardness * math.sqrt(delta) * delta * (1.0 + 0.4 * ddelta / ddelta0)

    def film(eps, deps, ew, slenderness, joint):
        f_n, f_t, extent = half_film_long(eps, deps, ew, slenderness)
        return joint.gain * f_n, joint.gain * f_t, extent

    def slow_spring(delta, ddelta, ddelta0, joint):
        return joint.hardness * math.sqrt(delta) * delta * (1.0 + 0.4 * ddelta / ddelta0) * one(delta)

    def slow_film(eps, deps, ew, slenderness, joint):
        f_n, f_t, extent = half_film_long(eps, deps, ew, slenderness)
        return joint.gain * f_n * one(eps), joint.gain * f_t, extent

    laws.register_contact("known", spring, parameters=numbers)
    laws.register_contact("unknown", slow_spring, parameters=numbers)
    laws.register_film("known", film, parameters=unit)
    laws.register_film("unknown", slow_film, parameters=unit)
    yield
    for registry in (CONTACTS, FILMS):
        for name in ("known", "unknown"):
            del registry[name]


@pytest.mark.parametrize(
    ("name", "key", "given", "paths", "output"),
    [
        (
            "slider_crank_dry", "joints.B.contact.law", {"duration": 2e-3, "joints.B.contact.hardness": 4e8},
            ["joints.B.contact.hardness", "joints.B.clearance", "sdf.frames.rod_B.pose.x", "drives.O.speed"], "slider.vx",
        ),
        (
            "slider_crank_lubricated", "joints.B.film", {"duration": 5e-3},
            ["joints.B.gain", "joints.B.clearance", "joints.B.viscosity", "sdf.links.slider.mass"], "B.force",
        ),
    ],
)  # fmt: skip
@pytest.mark.usefixtures("unknown_laws")
def test_laws_without_duals_have_the_same_derivatives_by_differences(name, key, given, paths, output):
    """Also at a kink of the law, where its force ends before the bodies part: differences keep away from it."""
    given, times = given | {"solver.accuracy": 1e-10}, given["duration"] * np.linspace(0.2, 1.0, 9)
    known, unknown = (
        linkages.simulate(shipped(name, **given, **{key: law}), outputs=[output], wrt=paths).sensitivity.evaluate(times)
        for law in ("known", "unknown")
    )
    for path in paths:
        expected = known[path][output]
        assert np.abs(expected).max() > 0.0, path
        assert np.abs(unknown[path][output] - expected).max() < 1e-6 * np.abs(expected).max(), path
