"""Simeon's flexible slider-crank of the test set for initial value problems, with the set's mass error and without.

B. Simeon, Modelling a flexible slider crank mechanism by a mixed system of DAEs and PDEs, Mathematical Modelling of
Systems 2 (1996) 1-18; W. Lioen and J. de Swart, Test set for initial value problem solvers, CWI (1999), problem "slider
crank": two sines across the rod, a quadratic element along it, linear strain, no damping. The longitudinal mass matrix
of its code is 15 times the consistent one of that element.
"""

from dataclasses import replace

import numpy as np
import pytest
from machines import elastic_slider_crank
from numpy.polynomial import legendre

from linkages.engines.compiled.run.runner import Runner, join
from linkages.mechanics.flexible.component_modes import _constants, _Series
from linkages.system import flexible_link

#: At t = 0: rod's angle [rad] and elastic coordinates [m]: two sines, middle and end of the bar; their rates.
ANGLE, RATE = 0.0, -74.9957670
ELASTIC = np.array([0.0, 0.0, 0.103339863e-4, 0.169327969e-4])
ELASTIC_RATE = np.array([0.444896105, 0.463434311e-2, -0.178591076e-5, -0.268938672e-5])
#: At t = 0.1 s: rod's angle [rad], slider's place, first elastic coordinate [m]. As printed, with 15 times the mass; of
#: a correct beam, by an independent floating frame.
AT_END = {
    15.0: (-0.3311734987910881, 0.1697373326718410, 1.893192460247178e-4),
    1.0: (-0.331173426, 0.169737396, 1.893081788e-4),
}


def sines_and_parabolas(length):
    """Shapes across and along, as Legendre series over the rod."""
    x = np.cos(np.linspace(0.0, np.pi, 60))
    s = 0.5 * (x + 1.0)
    across = legendre.legfit(x, np.sin(np.pi * np.outer(s, [1.0, 2.0])), 24)
    along = legendre.legfit(x, np.column_stack([4.0 * s * (1.0 - s), s * (2.0 * s - 1.0)]), 2)
    nodes = np.array([0.0, length])
    return _Series(nodes, across[None]), _Series(nodes, along[None])


def diagonal(beam, along):
    """Combinations of the bar's two shapes that are orthogonal in mass and stiffness."""
    length = along.nodes[-1]
    mass = np.array([[8.0, 1.0], [1.0, 2.0]]) / 15.0 * beam.line_density * length
    stiffness = np.array([[16.0, -8.0], [-8.0, 7.0]]) / 3.0 * beam.axial / length
    half = np.linalg.inv(np.linalg.cholesky(mass))
    return half.T @ np.linalg.eigh(half @ stiffness @ half.T)[1]


@pytest.mark.parametrize("factor", AT_END)
def test_the_test_sets_slider_crank(system_of, monkeypatch, factor):
    turn = {}

    def modes(beam, *others):
        across, along = sines_and_parabolas(beam.length)
        turn["axial"] = diagonal(beam, along)
        along = _Series(along.nodes, along.terms @ turn["axial"])
        found = _constants(beam, along, across, stiffening=False)
        return replace(found, m0=found.m0 * np.array([1.0, 1.0, factor, factor]))

    monkeypatch.setattr(flexible_link, "component_modes", modes)
    toml = """duration = 0.1
[drives.O]
speed = 150.0
[links.rod]
model = "flexible"
bending = 2
axial = 2
damping = 0.0
start = "undeformed"
stiffening = false
[solver]
accuracy = 1e-9
"""
    system = system_of(elastic_slider_crank(), toml)
    runner, tree = Runner(system), system.tree
    eta, rate = ELASTIC.copy(), ELASTIC_RATE.copy()
    eta[2:], rate[2:] = np.linalg.solve(turn["axial"], eta[2:]), np.linalg.solve(turn["axial"], rate[2:])
    values = {
        f"rod.{name}": pair
        for name, pair in zip(tree.substructures["rod"].modes.names, zip(eta, rate, strict=True), strict=True)
    }
    values |= {"A": (ANGLE, RATE - 150.0), "B": (-ANGLE, -RATE), "guide": (ELASTIC[3], ELASTIC_RATE[3])}
    free = [tree.coordinates[i] for i in runner.model.free]
    start = np.array([[values[name][k] for name in free] for k in (0, 1)]).ravel()
    record = runner.run(0.0, start, 1e-8, 10**7)
    found = runner.outputs(join([record]), np.array([0.1]))
    chord = found["q.O"][0] + found["q.A"][0]
    got = chord, found["slider.x"][0], found["q.rod.bending1"][0]
    for value, expected, close in zip(got, AT_END[factor], (1e-8, 1e-9, 1e-9), strict=True):
        assert value == pytest.approx(expected, abs=close)
