"""A worn joint on both engines: other equations, other integrators, the same impacts."""

import numpy as np
import pytest
from measures import worst
from shipped import WORN, run_compiled, shipped
from slider_crank_impacts import table

from linkages import Status, impacts, simulate


@pytest.mark.slow
def test_the_engines_agree_on_a_worn_joint():
    """To the first impacts and through them; the round joint's impacts are others."""
    system = shipped("slider_crank_wear", duration=1e-3, **WORN, **{"solver.accuracy": 1e-11})
    ours, theirs = run_compiled(system), simulate(system.replaced({"solver.max_step": 2e-6}), "drake")
    assert theirs.status is Status.OK
    rows = table(impacts(ours, ["B"]))
    assert len(rows) >= 2
    np.testing.assert_allclose(table(impacts(theirs, ["B"])), rows, rtol=1e-5)
    times = np.linspace(0.0, 1e-3, 101)
    column, difference = worst(theirs.evaluate(times), ours.evaluate(times))
    assert difference < 1e-5, column
    plain = run_compiled(shipped("slider_crank_wear", duration=1e-3, **{"solver.accuracy": 1e-11}))
    assert impacts(plain, ["B"])[0].start < 0.99 * rows[0][0]
