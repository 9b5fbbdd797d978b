"""The tableaus satisfy Butcher's order conditions; the controller keeps errors near the tolerance.

J. C. Butcher, Numerical Methods for Ordinary Differential Equations, section 31: a method has order p if b . phi(tree) =
1/gamma(tree) for every rooted tree with at most p vertices, where a tree is the multiset of its subtrees.
"""

from itertools import combinations_with_replacement

import numpy as np
import pytest

from linkages.base.kernel import kernel
from linkages.mechanics.integrate.controller import ELEMENTARY_3, PI_5_4, controller
from linkages.mechanics.integrate.tableau import DORMAND_PRINCE_5_4, RADAU_IIA_5


def trees(vertices):
    """Rooted trees with this number of vertices: sorted tuples of subtrees."""
    found = set()
    for count in range(vertices):
        for parts in combinations_with_replacement([t for n in range(1, vertices) for t in trees(n)], count):
            if sum(map(size, parts)) == vertices - 1:
                found.add(tuple(sorted(parts)))
    return sorted(found)


def size(tree):
    return 1 + sum(map(size, tree))


def gamma(tree):
    return size(tree) * np.prod([gamma(part) for part in tree], initial=1.0)


def phi(tree, a):
    """Weights of the stages in a tree's elementary differential, (s,)."""
    return np.prod([a @ phi(part, a) for part in tree], axis=0, initial=1.0) * np.ones(len(a))


def defects(a, b, order):
    """Largest violation of the conditions of each order up to this one."""
    return [max(abs(b @ phi(tree, a) - 1.0 / gamma(tree)) for tree in trees(n)) for n in range(1, order + 1)]


def with_end(tableau):
    """Coefficients and weights of an explicit pair with its last stage, the derivative at the end of the step."""
    a = np.zeros((len(tableau.c) + 1,) * 2)
    a[:-1, :-1], a[-1, :-1] = tableau.a, tableau.b
    return a, np.append(tableau.b, 0.0)


def test_there_are_as_many_trees_as_published():
    assert [len(trees(n)) for n in range(1, 7)] == [1, 1, 2, 4, 9, 20]  # Butcher, table 300(I)


@pytest.mark.parametrize("tableau", [RADAU_IIA_5, DORMAND_PRINCE_5_4], ids=lambda tableau: tableau.name)
def test_solutions_satisfy_the_conditions_of_their_order_and_no_more(tableau):
    *known, beyond = defects(tableau.a, tableau.b, tableau.order + 1)
    assert max(known) < 1e-14
    assert beyond > 1e-5
    np.testing.assert_allclose(tableau.a.sum(axis=1), tableau.c, atol=1e-15)


def test_the_embedded_solution_is_of_order_four():
    a, b = with_end(DORMAND_PRINCE_5_4)
    *known, beyond = defects(a, b - DORMAND_PRINCE_5_4.error, 5)
    assert max(known) < 1e-14
    assert beyond > 1e-5


def test_the_stages_of_radau_are_collocation():
    """Stage order 3: polynomials of degree 3 are integrated exactly at every stage; the last one is the solution."""
    c, a = RADAU_IIA_5.c, RADAU_IIA_5.a
    for k in range(3):
        np.testing.assert_allclose(a @ c**k, c ** (k + 1) / (k + 1), atol=1e-15)
    np.testing.assert_array_equal(a[-1], RADAU_IIA_5.b)
    np.testing.assert_allclose(10.0 * c**2 - 8.0 * c + 1.0, [0.0, 0.0, 3.0], atol=1e-14)  # Radau points


@pytest.mark.parametrize(("settings", "order"), [(PI_5_4, 5.0), (ELEMENTARY_3, 4.0)], ids=["pi", "elementary"])
def test_the_controller_leads_to_a_constant_error_below_the_tolerance(settings, order):
    """For an error proportional to h^order the steps settle at an error below 1, from sizes on either side."""
    ratio = controller(settings)

    @kernel
    def settled(h, order):
        previous, error = 1.0, 1.0
        for _ in range(200):
            error = h**order
            h *= ratio(error, previous, 0.9)
            previous = error if error <= 1.0 else previous
        return error

    ends = [settled(h, order) for h in (1e-6, 0.5, 3.0, 1e3)]
    np.testing.assert_allclose(ends, ends[0], rtol=1e-6)
    assert 0.3 < ends[0] < 0.9
