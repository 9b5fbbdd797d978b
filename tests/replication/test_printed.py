"""Misprints of the press paper, against mechanics: its printed equations in numbers."""

import numpy as np
import paper_formulation
import pytest
from paper_formulation import Data, film, gamma, jacobian, start
from replication.press_designs import inside
from replication.press_equations import printed
from replication.press_steps import STABLE, STEP, explicit, fastest

from linkages.laws.film.closed_form import pinkus_sternlicht


@pytest.mark.parametrize("eps", [0.1, 0.5, 0.9])
def test_eq_4_pushes_a_returning_journal_on(eps):
    """A journal that moves straight back to the centre: the film must take energy, eq. (9) with |de/dt|/r gives some."""
    rate = -3.0
    right = pinkus_sternlicht(eps, rate, 0.0, 1.0)[0] * rate
    wrong = printed(eps, abs(rate), 1e-12)[0] * rate
    assert right < 0.0 < wrong


@pytest.mark.parametrize("angle", [0.7, 2.5, -2.5, -0.7])
def test_eq_5_turns_the_force_around_in_half_the_plane(angle):
    """A journal that moves outwards: the film of eq. (14) must take energy; with eq. (5) it gives some where e_x < 0."""
    e = 0.4 * np.array([np.cos(angle), np.sin(angle)])
    normal, tangential = printed(0.4, 3.0, 1e-12)
    gamma_5 = np.arctan(e[1] / e[0])
    force = [
        normal * np.cos(gamma_5) - tangential * np.sin(gamma_5),
        normal * np.sin(gamma_5) + tangential * np.cos(gamma_5),
    ]
    assert np.sign(force @ e) == (-1.0 if e[0] > 0.0 else 1.0)


def test_table_6_is_within_either_reading_of_table_1():
    assert inside(varied=True) == inside(varied=False) == 4


@pytest.mark.parametrize("rate", [2.0, -2.0])
def test_the_printed_film_is_ours_but_for_the_sign_of_eq_11(rate):
    eps, spin = 0.4, 1.3
    normal, tangential = printed(eps, rate, spin)
    ours = pinkus_sternlicht(eps, rate, eps * spin, 1.0)
    assert tangential == pytest.approx(ours[1], rel=1e-12)
    assert normal == pytest.approx(np.sign(rate) * ours[0], rel=1e-12)


@pytest.mark.filterwarnings("error")
def test_steps_of_the_papers_size_leave_the_bearing():
    """In two steps of 0.1 ms, beyond the method's stability; no force is evaluated outside the film.

    The end of a crank against the film has the smallest time constant; its mass is below the crank's.
    """
    assert explicit() == pytest.approx(2 * STEP)
    damping = -film(Data(), 0, np.zeros(2), np.array([1.0, 0.0]), 0.0)[0]
    assert fastest() < STEP / STABLE
    assert 0.01 < fastest() * damping / min(Data().mass) < 1.0


def test_l_s5_of_eq_17_is_l_5():
    """Table 2 has no L_s5. With its L_5 the slider is at the printed S_0 = 560 mm."""
    data = Data()
    assert start(data)[0][15] == pytest.approx(0.560, abs=1e-4)
    lengths = (
        paper_formulation.L1,
        paper_formulation.L2,
        paper_formulation.L3,
        paper_formulation.S3,
        paper_formulation.S6,
    )
    assert all(abs(length - paper_formulation.L5) > 0.01 for length in lengths)


def test_eq_19_has_one_derivative_too_many():
    """The right side is -(Phi_q v)_q v, a vector; (Phi_qq v)_q v, as printed, is a matrix, of third derivatives."""
    q, v = start(Data())
    h = 1e-4
    before, here, after = (jacobian(q + x * h * v) for x in (-1.0, 0.0, 1.0))
    np.testing.assert_allclose(-((after - before) / (2 * h)) @ v, gamma(q, v), atol=1e-5 * np.abs(gamma(q, v)).max())
    third = (after - 2 * here + before) / h**2
    assert third.shape == (14, 18)
    assert np.abs(third).max() > 0.1


def test_eq_20_multiplies_in_the_wrong_order():
    """Phi_q^T lambda does no work on motions that the constraints allow; lambda Phi_q^T does not even exist."""
    q, _ = start(Data())
    phi_q, multipliers = jacobian(q), np.arange(1.0, 15.0)
    allowed = np.linalg.svd(phi_q)[2][14:]
    np.testing.assert_allclose(allowed @ (phi_q.T @ multipliers), 0.0, atol=1e-12)
    with pytest.raises(ValueError, match="mismatch"):
        multipliers @ phi_q.T
