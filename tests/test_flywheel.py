"""The coefficient of speed fluctuation, against an independent integration of the press with a flywheel."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import minimize_scalar
from shipped import shipped

import optim
from linkages import assess, simulate, simulate_batch, summarize
from linkages.results.statistic_derivatives import Wanted, differentiate_statistics

R, L, ROD, TURN, SLIDER = 0.05, 0.12, 0.21, 2.5e-4, 0.14  # lengths; masses of rod and slider, inertia of the rod
WINDOW = 1.2, 2.0


def motion(angle):
    """Slider's place, its and the rod's velocity per crank speed: squares for the kinetic energy; of complex angles."""
    tilt = -R * np.sin(angle) / L
    cosine = np.sqrt(1.0 - tilt**2)
    turn = -R * np.cos(angle) / (L * cosine)
    slider = -R * np.sin(angle) - L * tilt * turn
    middle = -R * np.sin(angle) - 0.5 * L * tilt * turn, R * np.cos(angle) + 0.5 * L * cosine * turn
    inertia = SLIDER * slider**2 + ROD * (middle[0] ** 2 + middle[1] ** 2) + TURN * turn**2
    return R * np.cos(angle) + L * cosine, slider, inertia


def fluctuation(flywheel):
    """Integrate (J(a) w)' = Q + J'(a) w^2/2, and search the extremes of the crank's speed."""

    def rates(t, y):
        angle, speed = y
        place, slider, inertia = motion(angle)
        slope = motion(angle + 1e-30j)[2].imag / 1e-30
        slip = 1.0 - speed / 31.416
        force = -750.0 * (1.0 + np.tanh((place - 0.155) / 0.002)) * (1.0 + np.tanh(slider * speed / 0.02))
        torque = 24.0 * slip / (slip**2 + 0.04) + force * slider
        return speed, (torque - 0.5 * slope * speed**2) / (flywheel + 1e-5 + inertia)

    start = np.pi, 295.0 * 2.0 * np.pi / 60.0
    run = solve_ivp(rates, (0.0, 2.0), start, "DOP853", rtol=1e-12, atol=1e-12, max_step=1e-3, dense_output=True)
    times = np.linspace(*WINDOW, 20001)
    speed = run.sol(times)[1]

    def top(sign):
        best = np.argmax(sign * speed)
        ends = times[max(best - 1, 0)], times[min(best + 1, len(times) - 1)]
        found = minimize_scalar(
            lambda t: -sign * run.sol(t)[1], bounds=ends, method="bounded", options={"xatol": 1e-12}
        )
        return max(-found.fun, (sign * speed)[best])

    mean = np.diff(run.sol(np.array(WINDOW))[0])[0] / np.ptp(WINDOW)
    return (top(1.0) + top(-1.0)) / mean


EXACT = {"solver.accuracy": 1e-10}


def test_the_fluctuation_is_that_of_an_independent_integration():
    system = shipped("slider_crank_flywheel", **EXACT)
    expected = fluctuation(2.0)
    batch = simulate_batch(system, ["sdf.links.flywheel.inertia"], [[2.0], [1.0]], ["O.rate"], [WINDOW])
    assert batch.fluctuation[0, 0, 0] == pytest.approx(expected, rel=1e-6)
    assert batch.fluctuation[1, 0, 0] == pytest.approx(fluctuation(1.0), rel=1e-6)
    path = "sdf.links.flywheel.inertia"
    run = simulate(system, outputs=["O.rate"], wrt=[path])
    (found,) = differentiate_statistics(run, [Wanted("O.rate", "fluctuation", *WINDOW)])
    assert found.number == pytest.approx(expected, rel=1e-6)
    slope = (fluctuation(2.01) - fluctuation(1.99)) / 0.02
    assert found.rates[0] == pytest.approx(slope, rel=1e-4)


def test_the_summary_has_the_fluctuation_of_powered_drives():
    system = shipped("slider_crank_flywheel", **{"report_from": WINDOW[0]})
    summary = summarize(assess(system, "compiled"))
    assert summary["windows"]["report"]["drives"]["O"]["fluctuation"] == pytest.approx(fluctuation(2.0), rel=1e-4)
    driven = summarize(assess(shipped("slider_crank_lubricated", duration=1e-3), "compiled"))
    assert "fluctuation" not in driven["drives"]["O"]  # its speed is prescribed


def test_the_study_sizes_the_flywheel():
    """The optimum, where the limit of 3 % is active, has this fluctuation in the independent integration too."""
    study = optim.load_study(optim.find_study("slidercrank_flywheel"))
    best = 1.2577
    found = optim.Evaluator(study)(np.array([[2.0], [best]]))
    assert found.objectives[:, 0].tolist() == [2.0, best]
    assert fluctuation(best) == pytest.approx(0.03, rel=1e-3)
    np.testing.assert_allclose(found.constraints[:, 0], [fluctuation(2.0), fluctuation(best)], rtol=1e-3)
