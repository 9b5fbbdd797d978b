"""Mechanics knows bodies with shape coordinates: here a rod whose only shape is no mode of a beam."""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest
from machines import bar, joint, model

import linkages
from linkages.mechanics.planar.bodies import ELASTIC, MATRIX, SHAPE, STIFFNESS
from linkages.mechanics.planar.composite_inertia import mass_matrix
from linkages.mechanics.planar.kinematics import body_states
from linkages.system.spanning import spanning_tree

LENGTH, MASS, STIFFNESS_OF_SHAPE = 0.4, 0.6, 50.0
RADIUS = LENGTH / np.sqrt(12.0)  # of gyration
ANGLE, ETA = 0.3, 2e-3  # of the joint [rad], amplitude of the shape [m]


@dataclass(frozen=True)
class Parabola:
    """A uniform rod along x that bends as (s/L)^2: its slopes are 2 s/L^2, and H(s) = 4 s^3/(3 L^4)."""

    name = "rod"
    carrier = ""
    origin = np.zeros(2)
    direction = np.array([1.0, 0.0])
    abscissas = (0.0, LENGTH)
    acting = frozenset({LENGTH})
    ends = (0.0, LENGTH)
    first = 0.0
    settles = is_chord = False
    size = bends = 1
    coordinates = ("rod.parabola",)
    frequencies = np.array([100.0])
    rod = SimpleNamespace(mass=MASS, com=np.array([0.5 * LENGTH, 0.0]), inertia=MASS * LENGTH**2 / 12.0)

    def abscissa(self, point):
        return self.nearest(float(point[0]))

    def nearest(self, s):
        return min(self.abscissas, key=lambda other: abs(other - s))

    def moves(self, s):
        return s != 0.0

    def slopes(self, places):
        return 2.0 * places[:, None] / LENGTH**2

    def fill(self, shapes):
        """Means over the mass, parts linear in f = (s - L/2)/k, and the remainder of b^2."""
        mean, linear = 1.0 / 3.0, LENGTH / RADIUS / 12.0
        shapes[SHAPE, 0] = 0.0, mean, 0.0, linear
        shapes[ELASTIC, 0, STIFFNESS] = STIFFNESS_OF_SHAPE
        remainder = MASS * (1.0 / 5.0 - mean**2 - linear**2)
        shapes[MATRIX, 0] = -1.0 / (3.0 * LENGTH), remainder, -1.0 / (10.0 * RADIUS), 0.0

    def fill_section(self, s, shapes):
        shapes[SHAPE, 0, :3] = 0.0, (s / LENGTH) ** 2, 2.0 * s / LENGTH**2
        shapes[MATRIX, 0, 0] = -4.0 * s**3 / (3.0 * LENGTH**4)


@pytest.fixture(scope="module")
def tree(tmp_path_factory):
    """The rod turns about the world; a bar is fixed to its end."""
    text = model("pendulum", bar("rod", LENGTH, "__model__") + bar("tip", 0.1, "rod_tip") + joint("O", "world", "rod"))
    text = text.replace("</model>", joint("T", "rod_tip", "tip", "fixed") + "</model>")
    file = tmp_path_factory.mktemp("shapes") / "pendulum.sdf"
    file.write_text(text, encoding="utf-8")
    return spanning_tree(linkages.load_mechanism(file), bend={"rod": lambda carrier: (Parabola(),)})


def points(tree, q):
    """Places (n, 2) and masses (n,) of the rod and of the bar at its end, from the kinematics alone."""
    angle, eta = q
    x, weight = np.polynomial.legendre.leggauss(12)
    s = 0.5 * LENGTH * (1.0 + x)
    along, across = s - 0.5 * eta**2 * 4.0 * s**3 / (3.0 * LENGTH**4), eta * (s / LENGTH) ** 2
    rod = np.column_stack([along, across])
    end = np.array([LENGTH - 0.5 * eta**2 * 4.0 / (3.0 * LENGTH), eta])
    slope, tip = 2.0 * eta / LENGTH, tree.links["tip"]
    way = np.sqrt(tip.inertia / tip.mass) * np.array([-1.0, 1.0]) + tip.com[0] - LENGTH  # two points with its inertia
    ends = end + way[:, None] * np.array([np.cos(slope), np.sin(slope)])
    turned = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    masses = np.concatenate([0.5 * MASS * weight, 0.5 * tip.mass * np.ones(2)])
    return np.vstack([rod, ends]) @ turned, masses


def test_a_shape_that_is_no_mode_of_a_beam_has_the_mass_matrix_of_its_points(tree):
    """Mass matrix of the composite-body algorithm: sum of m J'J over points, with J by central differences."""
    assert tree.coordinates == ("O", "rod.parabola")
    work, matrix = tree.workspace(tree.loop_rows), np.zeros((2, 2))
    work.q[:] = q = np.array([ANGLE, ETA])
    body_states(tree.bodies, work.q, work.v, work.pose, work.vel)
    mass_matrix(tree.bodies, work, matrix)
    steps = np.diag([1e-6, 1e-6])
    ways = [(points(tree, q + step)[0] - points(tree, q - step)[0]) / 2e-6 for step in steps]
    masses = points(tree, q)[1]
    exact = [[np.sum(masses * np.sum(one * other, axis=1)) for other in ways] for one in ways]
    np.testing.assert_allclose(matrix, exact, rtol=2e-6)  # the remainder of H is omitted: 8e-7 here
