"""All joint models against independent models: other equations, SciPy's integrators.

The film of the press is in `test_seven_bar`, one dry joint in `test_contact`.
"""

import guide_model
import joint_laws
import numpy as np
import paper_formulation
import pytest
from shipped import run as run_shipped

from linkages import impacts

TIGHT = {"solver.accuracy": 1e-10}
CUBIC = {"law": "cubic", "static": 0.15, "coefficient": 0.1, "v_0": 1e-3, "v_1": 1e-2}
LAWS = {"ambrosio": (joint_laws.ambrosio, {}), "cubic": (joint_laws.cubic, CUBIC)}


def rows(run, labels):
    """Contacts of a run as `contact_events.contacts` lists them."""
    found = [r for r in impacts(run, labels) if np.isfinite(r.separation_speed)]
    return np.array(
        [
            [
                labels.index(r.joint),
                r.start,
                r.approach_speed,
                r.duration,
                r.peak_force,
                r.peak_penetration,
                r.separation_speed,
            ]
            for r in found
        ]
    )


def assert_same_contacts(run, labels, expected, count, rtol):
    """The first contacts agree: joint, time, speed, force, duration; the models' peaks are sampled."""
    got = rows(run, labels)
    assert len(expected) >= count
    np.testing.assert_allclose(got[:count], expected[:count], rtol=rtol)


@pytest.mark.slow
@pytest.mark.parametrize("friction", LAWS)
def test_two_dry_joints_with_friction(friction):
    """Until 20 ms: Lankarani and Nikravesh's contact, the paper's 18 coordinates and multipliers."""
    law, changes = LAWS[friction]
    changes = {f"joints.{j}.friction.{key}": value for j in "AB" for key, value in changes.items()}
    run = run_shipped("compiled", "seven_bar_dry", duration=0.02, **TIGHT, **changes)
    expected = paper_formulation.contacts(paper_formulation.Data(law=joint_laws.dry(law)), 0.02)
    assert_same_contacts(run, ["A", "B"], expected, 2, 1e-4)
    assert set(expected[:2, 0]) == {0.0, 1.0}


@pytest.mark.slow
def test_mixed_joints():
    """Eq. (15) with the printed film in so thin an oil that both journals touch."""
    film = {"film": "pinkus-sternlicht", "viscosity": 8e-6}
    changes = {f"joints.{j}.{key}": value for j in "AB" for key, value in film.items()}
    run = run_shipped("compiled", "seven_bar_mixed", duration=0.02, **TIGHT, **changes)
    data = paper_formulation.Data(viscosity=(8e-6, 8e-6), law=joint_laws.mixed(joint_laws.ambrosio))
    expected = paper_formulation.contacts(data, 0.02)
    assert_same_contacts(run, ["A", "B"], expected, 2, 1e-4)
    assert set(expected[:2, 0]) == {0.0, 1.0}


@pytest.mark.slow
def test_corners_of_a_guide_with_play():
    run = run_shipped("compiled", "slider_crank_guide", duration=0.003, **TIGHT)
    assert_same_contacts(run, [f"guide.corner{k}" for k in range(1, 5)], guide_model.contacts(0.003), 2, 1e-4)


@pytest.mark.slow
def test_shear_torque_of_a_whole_film():
    """Petroff's torque around, with the moment of the pressure: orbits and forces of a third of a period."""
    shear = {
        f"joints.{j}.{key}": value for j in "AB" for key, value in (("shear_torque", True), ("shear_film", "full"))
    }
    run = run_shipped("compiled", "seven_bar_fast", duration=0.3, **shear)
    _, at = paper_formulation.solve(paper_formulation.Data(law=joint_laws.sheared), 0.3, rtol=1e-6)
    e, force, _ = at(run.time)
    for k, name in enumerate("AB"):
        for what, exact in (("e", e[:, k]), ("f", force[:, k])):
            got = np.stack([run[f"{name}.{what}x"], run[f"{name}.{what}y"]], axis=1)
            assert np.hypot(*(got - exact).T).max() < 1e-3 * np.hypot(*exact.T).max()


@pytest.mark.slow
def test_finite_film():
    """Forces along a run by the 2D Reynolds equation on one plain grid, which is right to 3e-3 of them."""
    run = run_shipped("compiled", "seven_bar_fast", duration=0.3, **{f"joints.{j}.film": "finite" for j in "AB"})
    c, mu, scale = 0.3e-3, 0.4, joint_laws.LENGTH * joint_laws.RADIUS**3 / 0.3e-3**2
    found = run.evaluate(np.linspace(0.02, 0.3, 5))
    for name, bearing, journal in (("A", "crank1", "link2"), ("B", "crank4", "link3")):
        e, v, force = (
            np.stack([found[f"{name}.e{x}"] for x in "xy"], axis=1),
            np.stack([found[f"{journal}.v{x}"] - found[f"{bearing}_{name}.v{x}"] for x in "xy"], axis=1),
            np.stack([found[f"{name}.f{x}"] for x in "xy"], axis=1),
        )
        for i, omega in enumerate(found[f"{journal}.omega"] + found[f"{bearing}.omega"]):
            n = e[i] / np.hypot(*e[i])
            t = np.array([-n[1], n[0]])
            eps = np.hypot(*e[i]) / c
            exact = mu * scale * joint_laws.finite(eps, v[i] @ n / c, eps * omega - 2 * (v[i] @ t) / c, 4 / 3, 120, 12)
            assert np.hypot(*(force[i] - exact @ [n, t])) < 5e-3 * np.hypot(*exact)
            assert np.hypot(*force[i]) > 0.1
