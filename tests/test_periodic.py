"""Periodic motions, Floquet multipliers and branches against the literature, closed forms and other methods."""

import json
from typing import NamedTuple

import numpy as np
import pytest
from machines import joint, model, solid
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, root
from shipped import shipped

from linkages import InputError, RunError, bearing, branches, load, periodic_motion, stroboscopic
from linkages.cli.main import main
from linkages.explore.periodic.continuation import Residual, Settings, rescaled, solve
from linkages.explore.periodic.multipliers import (
    BRANCH_POINT,
    DOUBLING,
    FOLD,
    GRAZING,
    NEIMARK_SACKER,
    kind,
    multipliers,
)
from linkages.explore.periodic.tracing import CLOSED, LIMIT, LOST, MOST, trace, turned

# ---- equations ------------------------------------------------------------------------------------------------------


class Return(NamedTuple):
    """State after a period (n,), and its derivatives with respect to the state before and to the value."""

    end: np.ndarray
    monodromy: np.ndarray
    by_p: np.ndarray
    rate: np.ndarray | None = None


class Facts(NamedTuple):
    """What a branch knows of a point."""

    multipliers: np.ndarray = np.array([0.5 + 0.0j])
    monodromy: np.ndarray | None = None
    contacts: tuple[int, ...] = ()


def forced(return_map):
    """Equations of a motion with a given period, a fixed point of the return map."""

    def equations(u, p):
        found = return_map(u, p)
        facts = Facts(multipliers(found.monodromy), found.monodromy)
        return Residual(found.end - u, found.monodromy - np.eye(len(u)), found.by_p, facts)

    return equations


def flow_of(rate, jacobian, by_value):
    """Flow of an equation with its derivatives, from the variational equations."""

    def flow(state, duration, p):
        n = len(state)

        def together(t, y):
            slopes = jacobian(t, y[:n], p) @ y[n:].reshape(n, n + 1)
            slopes[:, -1] += by_value(t, y[:n], p)
            return np.concatenate([rate(t, y[:n], p), slopes.ravel()])

        start = np.concatenate([state, np.eye(n, n + 1).ravel()])
        y = solve_ivp(together, (0.0, duration), start, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
        slopes = y[n:].reshape(n, n + 1)
        return Return(y[:n], slopes[:, :n], slopes[:, n], np.array(rate(duration, y[:n], p)))

    return flow


def autonomous(flow, anchor, along):
    """Problem of a motion with an unknown period, u = (state, period), on the plane through `anchor` normal to `along`."""

    def problem(u, p):
        state, n = u[:-1], len(u) - 1
        found = flow(state, u[-1], p)
        by_u = np.zeros((n + 1, n + 1))
        by_u[:n, :n] = found.monodromy - np.eye(n)
        by_u[:n, n], by_u[n, :n] = found.rate, along
        value = np.append(found.end - state, along @ (state - anchor))
        spectrum = multipliers(found.monodromy)
        others = np.delete(spectrum, np.argmin(np.abs(spectrum - 1.0)))  # without the flow's own
        return Residual(value, by_u, np.append(found.by_p, 0.0), Facts(others, found.monodromy))

    return problem


def settings_of(scale, scale_p, **more):
    return Settings(np.array(scale), scale_p, np.ones(len(scale)), 1e-10, **more)


def test_van_der_pol_has_the_period_and_the_multiplier_of_the_literature():
    """Period at mu = 1: Andersen and Geer, SIAM J. Appl. Math. 42 (1982) 678; the multiplier follows from Liouville."""

    def jacobian(t, x, mu):
        return np.array([[0.0, 1.0], [-1.0 - 2.0 * mu * x[0] * x[1], mu * (1.0 - x[0] ** 2)]])

    def by_value(t, x, mu):
        return np.array([0.0, (1.0 - x[0] ** 2) * x[1]])

    def rate(t, x, mu):
        return np.array([x[1], mu * (1.0 - x[0] ** 2) * x[1] - x[0]])

    anchor = np.array([2.0, 0.0])
    problem = autonomous(flow_of(rate, jacobian, by_value), anchor, np.array([0.0, 1.0]))
    point = solve(problem, np.array([*anchor, 6.6]), 1.0, settings_of([1.0, 1.0, 1.0], 1.0))
    assert point.u[2] == pytest.approx(6.66328686, abs=5e-9)

    def divergence(t, y):
        return [*rate(t, y[:2], 1.0), 1.0 - y[0] ** 2]

    whole = solve_ivp(divergence, (0.0, point.u[2]), [*point.u[:2], 0.0], method="DOP853", rtol=1e-13, atol=1e-14)
    one, other = multipliers(point.detail.monodromy)
    assert one == pytest.approx(1.0, abs=1e-8)
    assert other == pytest.approx(np.exp(whole.y[2, -1]), abs=1e-10)


def test_a_cycle_of_an_adaptive_controller_doubles_where_matcont_says():
    """Lur'e's system: doubling at alpha = 0.6303020 with period 6.364071 (manual of MatCont, adaptive control)."""
    flow = flow_of(
        lambda t, x, a: np.array([x[1], x[2], -a * x[2] - x[1] - x[0] + x[0] ** 2]),
        lambda t, x, a: np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [2.0 * x[0] - 1.0, -1.0, -a]]),
        lambda t, x, a: np.array([0.0, 0.0, -x[2]]),
    )
    anchor = np.array([0.374, 0.0, -0.308])
    problem = autonomous(flow, anchor, np.array([0.0, 1.0, 0.0]))
    settings = settings_of([1.0, 1.0, 1.0, 10.0], 1.0)
    start = turned(solve(problem, np.append(anchor, 6.306), 0.9, settings))

    found = trace(problem, start, (0.58, 1.0), settings, 100)
    (event,) = found.bifurcations
    assert event.kind == DOUBLING
    assert event.point.p == pytest.approx(0.6303020, abs=5e-8)
    assert event.point.u[3] == pytest.approx(6.364071, abs=5e-7)
    assert event.multiplier == pytest.approx(-1.0, abs=1e-7)


@pytest.mark.slow
def test_duffing_folds_where_its_amplitude_does():
    """x'' + d x' + x + b x^3 = f cos(w t): the frequencies of its folds also from harmonics, by another method."""
    d, b, f = 0.06, 0.05, 0.2

    def return_map(x, w):
        """Period 2 pi/w, in the phase w t."""
        flow = flow_of(
            lambda t, y, p: np.array([y[1], f * np.cos(t) / p**2 - d * y[1] / p - (y[0] + b * y[0] ** 3) / p**2]),
            lambda t, y, p: np.array([[0.0, 1.0], [-(1.0 + 3.0 * b * y[0] ** 2) / p**2, -d / p]]),
            lambda t, y, p: np.array(
                [0.0, -2.0 * f * np.cos(t) / p**3 + d * y[1] / p**2 + 2.0 * (y[0] + b * y[0] ** 3) / p**3]
            ),
        )
        return flow(x, 2.0 * np.pi, w)

    settings = settings_of([1.0, 1.0], 0.5, most=0.4)
    start = solve(forced(return_map), np.array([0.3, 0.0]), 0.8, settings)
    found = trace(forced(return_map), start, (0.8, 1.6), settings, 200)
    folds = [event for event in found.bifurcations if event.kind == FOLD]
    assert len(folds) == len(found.bifurcations) == 2
    for point in found.points:  # Liouville
        product = np.prod(multipliers(point.detail.monodromy))
        assert product == pytest.approx(np.exp(-d * 2.0 * np.pi / point.p), rel=1e-8)

    def harmonics(c, w, count=9, samples=128):
        """Residuals of the odd harmonics of x = sum c_k cos(k p) + s_k sin(k p), and x itself."""
        phase = 2.0 * np.pi * np.arange(samples) / samples
        k = 2 * np.arange(count) + 1
        basis = np.vstack([np.cos(np.outer(k, phase)), np.sin(np.outer(k, phase))])
        x = c @ basis
        first = np.concatenate([k * c[count:], -k * c[:count]]) * w
        second = -(np.concatenate([k, k]) ** 2) * c * w**2
        load = np.zeros(2 * count)
        load[0] = f
        return second + d * first + c + 2.0 / samples * basis @ (b * x**3) - load

    for event in folds:
        sample = solve_ivp(
            lambda t, y, w=event.point.p: [y[1], f * np.cos(w * t) - d * y[1] - y[0] - b * y[0] ** 3],
            (0.0, 2.0 * np.pi / event.point.p), [event.point.u[0], event.point.u[1] * event.point.p],
            method="DOP853", rtol=1e-12, atol=1e-12, t_eval=2.0 * np.pi / event.point.p * np.arange(64) / 64,
        ).y[0]  # fmt: skip
        k = 2 * np.arange(9) + 1
        c = np.fft.rfft(sample) / 32.0
        guess = np.concatenate([c[k].real, -c[k].imag])

        def singular(u):  # the Jacobian's null vector is part of the unknowns
            c, v, w = u[:18], u[18:36], u[36]
            h = 1e-6
            slope = (harmonics(c + h * v, w) - harmonics(c - h * v, w)) / (2.0 * h)
            return np.concatenate([harmonics(c, w), slope, [v @ v - 1.0]])

        matrix = np.array([(harmonics(guess + 1e-6 * e, event.point.p) - harmonics(guess - 1e-6 * e, event.point.p)) / 2e-6
                           for e in np.eye(18)]).T  # fmt: skip
        null = np.linalg.svd(matrix)[2][-1]
        solved = root(singular, np.concatenate([guess, null, [event.point.p]]), tol=1e-12)
        assert solved.x[36] == pytest.approx(event.point.p, rel=1e-8)


# ---- an impact oscillator ----------------------------------------------------------------------------------------------

FREQUENCY, RESTITUTION = 2.8, 0.8


def impact_map(x, gap):
    """Return map of x'' + x = cos(w t), x <= gap, from impact to impact: the state is (phase, speed after impact)."""
    phase, speed = x
    w = FREQUENCY
    amplitude = 1.0 / (1.0 - w * w)

    def state(t, position, rate):
        a, b = position - amplitude * np.cos(phase), rate + amplitude * w * np.sin(phase)
        moved = a * np.cos(t) + b * np.sin(t) + amplitude * np.cos(phase + w * t)
        return moved, -a * np.sin(t) + b * np.cos(t) - amplitude * w * np.sin(phase + w * t)

    times = np.linspace(1e-3, 12.0, 6000)
    above = state(times, gap, -speed)[0] - gap
    hits = np.flatnonzero((above[:-1] < 0.0) & (above[1:] >= 0.0))
    if speed <= 0.0 or not hits.size:
        raise RunError("no impact")
    k = hits[0]
    t = brentq(lambda t: state(t, gap, -speed)[0] - gap, times[k], times[k + 1], xtol=1e-15)
    _, rate = state(t, gap, -speed)
    fly = np.array([[np.cos(t), np.sin(t)], [-np.sin(t), np.cos(t)]])
    of_phase = np.array([amplitude * np.sin(phase), amplitude * w * np.cos(phase)])
    own = np.array([-amplitude * np.sin(phase + w * t), -amplitude * w * np.cos(phase + w * t)])
    columns = np.column_stack([fly @ of_phase + own, fly @ [0.0, -1.0], fly @ [1.0, 0.0]])  # phase, speed, gap
    force = np.cos(phase + w * t) - gap
    dt = -(columns[0] - [0.0, 0.0, 1.0]) / rate
    dv = columns[1] + force * dt
    slopes = np.array([w * dt + [1.0, 0.0, 0.0], RESTITUTION * dv])
    end = np.array([phase + w * t - 2.0 * np.pi, RESTITUTION * rate])
    return Return(end, slopes[:, :2], slopes[:, 2])


def closed_form(gap):
    """Period-1 motion with one impact a period (Shaw and Holmes, J. Sound Vib. 90 (1983) 129): phase, speed after."""
    w, r = FREQUENCY, RESTITUTION
    period = 2.0 * np.pi / w
    amplitude = 1.0 / (1.0 - w * w)
    # x = a cos + b sin + amplitude cos(phase + w t): equal positions at both ends fix a and b by the speeds
    c, s = np.cos(period), np.sin(period)
    ratio = (1.0 - c) / s  # b = a (1 - c)/s
    # speed after -v at the start, v/r at the end: b - A w sin(phase) = -v, -a s + b c - A w sin(phase) = v/r
    per_a = -s + ratio * c - ratio  # v (1 + 1/r) = a per_a
    # a + A cos(phase) = gap, a ratio - A w sin(phase) = -a per_a/(1 + 1/r)
    lever = (ratio + per_a / (1.0 + 1.0 / r)) / w  # A sin(phase) = a lever
    p, q, z = 1.0 + lever**2, -2.0 * gap, gap**2 - amplitude**2
    a = (-q + np.array([1.0, -1.0]) * np.sqrt(q * q - 4.0 * p * z)) / (2.0 * p)
    phase = np.arctan2(a * lever / amplitude, (gap - a) / amplitude)
    return np.column_stack([phase, a * per_a / (1.0 + 1.0 / r)])


def test_the_impact_oscillator_has_its_closed_form_branch_and_fold():
    """The period-1 branch over the gap: it folds where the two solutions of the closed form meet."""
    gap = 0.05
    x = next(x for x in closed_form(gap) if x[1] > 0.0 and np.abs(impact_map(x, gap).end - x).max() < 1e-6)
    settings = settings_of([1.0, 1.0], 0.2, most=0.1)
    start = solve(forced(impact_map), x, gap, settings)
    assert start.residual < 1e-12

    found = [trace(forced(impact_map), end, (-0.3, 0.6), settings, 60) for end in (start, turned(start))]
    points = [point for part in found for point in part.points]
    assert len(points) > 8
    for point in points:
        near = [
            [x[0] + 2.0 * np.pi * np.round((point.u[0] - x[0]) / (2.0 * np.pi)), x[1]] for x in closed_form(point.p)
        ]
        np.testing.assert_allclose(point.u, min(near, key=lambda x: np.abs(x - point.u).max()), atol=1e-8)
        assert np.linalg.det(point.detail.monodromy) == pytest.approx(RESTITUTION**2, rel=1e-6)
    (event,) = [event for part in found for event in part.bifurcations]
    assert event.kind == DOUBLING

    def crosses(gap):  # a multiplier of -1: 1 + trace + determinant is zero
        x = min(closed_form(gap), key=lambda x: abs(x[1] - event.point.u[1]))
        return 1.0 + np.trace(impact_map(x, gap).monodromy) + RESTITUTION**2

    assert event.point.p == pytest.approx(brentq(crosses, -0.09, -0.05, xtol=1e-14), abs=1e-9)
    grazing = 1.0 / (FREQUENCY**2 - 1.0)  # the amplitude without impacts: the branch ends there, its speed vanishes
    assert max(point.p for point in points) == pytest.approx(grazing, abs=5e-4)


# ---- linkages -----------------------------------------------------------------------------------------------------------


SLIDES = model(
    "oscillator",
    solid("base", 1.0, 1e-4)
    + solid("mass", 1.0, 1e-4, "0.2 0 0 0 0 0")
    + joint("drive", "world", "base", "prismatic", "1 0 0")
    + joint("slide", "world", "mass", "prismatic", "1 0 0"),
)
M, K, C, AMPLITUDE, OMEGA, STOP = 1.0, 100.0, 4.0, 0.01, 8.0, 2000.0


@pytest.fixture
def oscillator(system_of):
    """A mass on a spring and a damper between it and a base that oscillates; a linear stop."""
    text = f"""duration = 10.0
gravity = [0.0, 0.0, 0.0]
[drives.drive]
formula = "{AMPLITUDE}*sin({OMEGA}*t)"
[springs.S]
point = "mass"
to = "base"
stiffness = {K}
free_length = 0.2
damping = {C}
[stops.end]
joint = "slide"
side = "upper"
limit = 0.03
[stops.end.contact]
law = "hertz"
stiffness = {STOP}
exponent = 1.0
restitution = 1.0
"""
    return system_of(SLIDES, text)


SHAKER = f"""duration = 10.0
gravity = [0.0, 0.0, 0.0]
outputs = ["mass.vx"]
[drives.drive]
formula = "{AMPLITUDE}*sin(28*t)"
[springs.S]
point = "mass"
to = "base"
stiffness = {K}
free_length = 0.2
damping = 1.0
[stops.end]
joint = "slide"
side = "upper"
limit = 0.0
[stops.end.contact]
law = "flores"
stiffness = 2e5
restitution = 0.8
"""


def in_pieces(limit):
    """State at the section of the oscillator with one contact a period, from matched closed-form pieces."""

    def forced_part(stiffness, rest):
        matrix = np.array([[0.0, 1.0], [-stiffness / M, -C / M]])
        load = AMPLITUDE * (K + 1j * OMEGA * C) / M  # of exp(i w t), times -i for the sine
        x = load / (stiffness / M - OMEGA**2 + 1j * OMEGA * C / M)
        values, vectors = np.linalg.eig(matrix)

        def at(t):
            return np.array([(x * np.exp(1j * OMEGA * t)).imag + rest, (1j * OMEGA * x * np.exp(1j * OMEGA * t)).imag])

        def moved(y, t0, t1):
            fly = (vectors * np.exp(values * (t1 - t0))) @ np.linalg.inv(vectors)
            return (fly @ (y - at(t0))).real + at(t1)

        return moved

    free, pressed = forced_part(K, 0.0), forced_part(K + STOP, STOP * limit / (K + STOP))
    period = 2.0 * np.pi / OMEGA

    def apart(u):
        begin, end, speed = u
        hit = np.array([limit, speed])
        left = pressed(hit, begin, end)
        back = free(left, end, begin + period)
        return [left[0] - limit, back[0] - limit, back[1] - speed]

    times = np.linspace(0.0, period, 4000)
    path = np.array([free(np.zeros(2), -20.0 * period, t)[0] for t in times])
    top = times[path.argmax()]
    found = root(apart, [top - 0.04, top + 0.03, 0.05], tol=1e-15)
    assert np.abs(apart(found.x)).max() < 1e-13
    begin, end, speed = found.x
    return free(pressed(np.array([limit, speed]), begin, end), end, period)


@pytest.mark.slow
def test_a_stop_that_springs_has_the_closed_form_branch_and_grazing(oscillator):
    grazing = AMPLITUDE * np.hypot(K, C * OMEGA) / np.hypot(K - M * OMEGA**2, C * OMEGA)
    given = {"start": 0.0225, "transient": 20, "step": 0.2, "tolerance": 1e-9}
    (branch,) = branches(oscillator, "stops.end.limit", 0.02, 0.0225, **given).branches
    (event,) = branch.events
    assert event.kind == GRAZING
    assert event.motion.value == pytest.approx(grazing, rel=1e-8)
    touching = [motion for motion in branch.motions if motion.passage.contacts == (1,)]
    assert len(touching) > 3
    for motion in touching:
        position, speed = in_pieces(motion.value)
        assert motion.state["q.slide"] == pytest.approx(position, abs=1e-8 * grazing)
        assert motion.state["v.slide"] == pytest.approx(speed, abs=1e-8 * grazing * OMEGA)
        assert motion.stable
        # Liouville: the damping alone contracts
        product = np.prod(motion.multipliers)
        assert product == pytest.approx(np.exp(-C / M * motion.period), rel=1e-7)


@pytest.mark.parametrize(("speed", "revolutions"), [pytest.param(-2.0, 1, marks=pytest.mark.slow), (-1.5, 2)])
def test_drives_in_a_ratio_of_integers_have_a_common_period(speed, revolutions):
    """A five-bar with two drives: the motion is the one to which a run settles."""
    film = {"model": "lubricated", "clearance": 2e-4, "film": "short", "viscosity": 0.1}
    slow = shipped("five_bar_dry").value("drives.O1.speed")
    changed = {"joints.C": film, "drives.O2.speed": speed * slow, "solver.accuracy": 1e-10}
    system = shipped("five_bar_dry", **changed)
    motion = periodic_motion(system, transient=2, accuracy=1e-10)
    assert motion.stable
    assert motion.period == pytest.approx(revolutions * 2.0 * np.pi / slow, rel=1e-12)
    settled = stroboscopic(system, ["C.ex", "C.ey"], 5 * revolutions, 0, "O1")
    for name, values in motion.section(["C.ex", "C.ey"]).strobe.items():
        assert values[0] == pytest.approx(settled.strobe[name][-1], rel=1e-7)


@pytest.mark.slow
def test_a_branch_switches_at_a_period_doubling(system_of):
    """Runs settle to the doubled branch beyond the doubling, and to the first branch before it."""
    system = system_of(SLIDES, SHAKER)
    given = {"outputs": ["mass.vx"], "transient": 40, "step": 0.4, "doublings": 1}
    one, two = branches(system, "stops.end.limit", -1.8e-3, -1.2e-3, **given).branches
    (event,) = one.events
    assert (event.kind, one.periods, two.periods, two.source) == (DOUBLING, 1, 2, (0, 0))
    assert two.motions[0].value == pytest.approx(event.motion.value, abs=2e-5)
    assert [one.motions[0].stable, one.motions[-1].stable, two.motions[-1].stable] == [True, False, True]
    for branch, k in ((one, 0), (two, -1)):
        motion = branch.motions[k]
        settled = system.replaced({"stops.end.limit": motion.value, "solver.accuracy": 1e-10})
        section = stroboscopic(settled, ["mass.vx"], 2, transient=120)
        own = np.sort(np.resize(motion.outputs.strobe["mass.vx"], 2))
        np.testing.assert_allclose(np.sort(section.strobe["mass.vx"]), own, atol=2e-7)
    # the product of multipliers: the damper and the impacts contract
    assert np.prod(two.motions[-1].multipliers).real < np.exp(-1.0 / M * two.motions[-1].period)


def test_the_command_writes_branches_and_a_sweep(experiment_file, tmp_path, capsys):
    file = str(experiment_file(SLIDES, SHAKER))
    words = ["continue", file, "--vary", "stops.end.limit=-3e-3:-2.8e-3", "--out", str(tmp_path / "out")]
    assert main([*words, "--transient", "40", "--step", "0.8", "--sweep", "2"]) == 0
    assert "branch 1: period of 1 drive period(s)" in capsys.readouterr().out
    found = json.loads((tmp_path / "out" / "branches.json").read_text())
    (branch,) = found["branches"]
    first, last = branch["motions"][0], branch["motions"][-1]
    assert (first["value"], last["value"]) == (-3e-3, -2.8e-3)
    assert first["stable"]
    assert first["residual"] < 1e-7
    assert first["contacts"] == [1]
    section = stroboscopic(load(file, {"stops.end.limit": -3e-3}), ["mass.vx"], 1, transient=80)
    assert first["outputs"]["mass.vx"]["strobe"][0] == pytest.approx(section.strobe["mass.vx"][0], rel=1e-4)
    assert (tmp_path / "out" / "branches.png").stat().st_size > 10_000
    for wrong, said in (
        (["--vary", "stops.end.limit=1:2:3"], "write PATH=LO:HI"),
        (["--vary", "stops.end.limit=2:1"], "needs LO < HI"),
        (["--vary", "stops.end.limt=1:2"], "limit"),
        (["--periods", "0"], "must be 1 or more"),
        (["--step", "0"], "must be greater than 0"),
        (["--start", "5"], "is not from -0.003 to -0.0028"),
    ):
        right = words[:2] + words[4:] if "--vary" in wrong else words
        assert main([*right, *wrong]) == 2
        assert said in capsys.readouterr().err


def test_an_interrupted_search_keeps_the_motions_up_to_then(experiment_file, tmp_path, monkeypatch, capsys):
    """A motion with many impacts takes seconds, a branch of them hours."""
    file = str(experiment_file(SLIDES, SHAKER))
    words = ["continue", file, "--vary", "stops.end.limit=-3e-3:-2.8e-3", "--no-plots", "--step", "0.2"]
    words += ["--transient", "40", "--doublings", "0"]
    assert main([*words, "--out", str(tmp_path / "whole")]) == 0
    told = []

    def interrupt(done):
        told.append(done)
        if len(told) == 2:
            raise KeyboardInterrupt

    monkeypatch.setattr("linkages.cli.continue_.stages", lambda *_: lambda name: interrupt)
    assert main([*words, "--sweep", "2", "--out", str(tmp_path / "part")]) == 130
    assert capsys.readouterr().err.endswith("interrupted; the results up to then are written\n")
    whole, part = (json.loads((tmp_path / name / "branches.json").read_text()) for name in ("whole", "part"))
    assert whole["branches"][0]["ends"] == ["limit"]
    assert part["branches"][0]["ends"] == ["interrupted"]
    assert part["branches"][0]["motions"] == whole["branches"][0]["motions"][:3]
    assert len(told) == 2


RADIUS, CLEARANCE, VISCOSITY, ROTOR = 0.05, 1e-4, 0.03, 50.0


@pytest.fixture
def rotor(system_of):
    """A rigid rotor of 50 kg that a drive turns in a short bearing; two nearly massless slides let it move."""
    bearing_of = f"""<linkages:bearing><linkages:radius>{RADIUS}</linkages:radius>
<linkages:length>{RADIUS}</linkages:length></linkages:bearing>"""
    joints = (
        joint("along", "world", "x", "prismatic", "1 0 0")
        + joint("up", "x", "y", "prismatic", "0 1 0")
        + joint("spin", "y", "rotor")
        + joint("B", "world", "rotor", inner=bearing_of)
    )
    text = f"""duration = 1.0
gravity = [0.0, -9.80665, 0.0]
start = "equilibrium"
[drives.spin]
speed = 800.0
[joints.B]
model = "lubricated"
clearance = {CLEARANCE}
film = "short"
viscosity = {VISCOSITY}
"""
    return system_of(
        model("rotor", solid("x", 1e-9, 1e-4) + solid("y", 1e-9, 1e-4) + solid("rotor", ROTOR, 1e-4) + joints), text
    )


def test_a_journal_begins_to_whirl_at_the_threshold_speed(rotor):
    (branch,) = branches(rotor, "drives.spin.speed", 800.0, 920.0, transient=5, step=0.5).branches
    (event,) = branch.events
    assert event.kind == NEIMARK_SACKER
    speed = event.motion.value
    point = bearing(
        diameter=2.0 * RADIUS, length=RADIUS, clearance=CLEARANCE, viscosity=VISCOSITY, speed=speed,
        load=ROTOR * 9.80665, film="short", mass=ROTOR,
    ).content  # fmt: skip
    assert speed == pytest.approx(point["threshold_speed"], rel=1e-7)
    turn = abs(np.angle(event.multiplier)) / (2.0 * np.pi)  # of the whirl in a revolution, as a fraction of it
    assert min(turn, 1.0 - turn) == pytest.approx(1.0 - point["whirl_ratio"], rel=1e-5)
    assert branch.motions[0].stable
    assert not branch.motions[-1].stable


@pytest.mark.slow
def test_a_branch_of_the_dry_slider_crank_passes_through_the_points_of_a_sweep():
    """Friction makes its motion periodic: the states to which runs settle lie on the branch."""
    names = ["B.ex", "B.ey", "B.force"]
    system = shipped("slider_crank_dry", **{"joints.B.friction.coefficient": 0.1, "solver.accuracy": 1e-10})
    given = {"start": 5e-4, "outputs": names, "transient": 20, "doublings": 0, "step": 1.0}
    (branch,) = branches(system, "joints.B.clearance", 4.9e-4, 5e-4, **given, accuracy=1e-10, tolerance=1e-6).branches
    assert branch.motions[-1].value == 4.9e-4
    motion = branch.motions[-1]
    assert motion.stable
    section = stroboscopic(system.replaced({"joints.B.clearance": motion.value}), names, 1, transient=20)
    for name in ("B.ex", "B.ey"):
        assert motion.outputs.strobe[name][0] == pytest.approx(section.strobe[name][0], abs=1e-5 * motion.value)
    assert motion.outputs.peaks("B.force")[0] == pytest.approx(section.peaks("B.force")[0], rel=1e-4)


@pytest.mark.parametrize("distance", [0.2, 1e-3, 1e-6])
def test_a_branch_that_starts_near_a_fold_goes_around_it(distance):
    """The parabola p = -u^2, in units of which u is the larger the farther the branch goes."""

    def parabola(u, p):
        return Residual(np.array([u[0] ** 2 + p]), np.array([[2.0 * u[0]]]), np.array([1.0]), Facts())

    settings = Settings(np.array([0.01]), 1.0, np.array([1.0]), tolerance=1e-12)
    start, settings = rescaled(solve(parabola, np.array([-np.sqrt(distance)]), -distance, settings), settings)
    found = trace(parabola, start, (-1.0, 0.5), settings, 3000)
    assert found.end == LIMIT
    assert found.points[-1].u[0] == pytest.approx(1.0, abs=1e-9)
    assert [event.kind for event in found.bifurcations] == [FOLD]
    assert trace(parabola, start, (-1.0, 0.5), settings, 3).end == MOST


def test_a_circle_is_closed_and_a_branch_without_an_end_is_lost():
    def circle(u, p):
        return Residual(np.array([u[0] ** 2 + p**2 - 1.0]), np.array([[2.0 * u[0]]]), np.array([2.0 * p]), Facts())

    def half(u, p):
        if p > 0.5:
            raise RunError("no motion")
        return circle(u, p)

    settings = Settings(np.array([1.0]), 1.0, np.array([1.0]), tolerance=1e-12)
    for problem, end in ((circle, CLOSED), (half, LOST)):
        start = solve(problem, np.array([1.0]), 0.1, settings)
        assert trace(problem, start, (-2.0, 2.0), settings, 500).end == end


def test_a_branch_with_short_steps_is_not_closed():
    """The first points are nearer to the start than half the longest step."""

    def cubic(u, p):
        return Residual(
            np.array([u[0] ** 3 + u[0] - p]), np.array([[3.0 * u[0] ** 2 + 1.0]]), np.array([-1.0]), Facts()
        )

    settings = Settings(np.array([1.0]), 1.0, np.array([1.0]), tolerance=1e-12, first=1e-4)
    start = solve(cubic, np.array([0.0]), 0.0, settings)
    found = trace(cubic, start, (-1.0, 1.0), settings, 500)
    assert found.end == LIMIT
    assert np.linalg.norm([found.points[6].u[0], found.points[6].p]) < 0.5 * settings.most


def test_steps_do_not_depend_on_unknowns_that_change_with_the_value_along_the_whole_branch():
    """The rod turns with the drive: its rate changes by many clearances in the time of the motion."""
    given = {"transient": 3, "doublings": 0, "step": 0.25, "accuracy": 1e-9, "tolerance": 1e-5}
    (branch,) = branches(shipped("slider_crank_lubricated"), "drives.O.speed", 100.0, 110.0, **given).branches
    assert branch.ends == (LIMIT,)
    assert len(branch.motions) < 15


def test_kinds_of_bifurcations_follow_from_the_multiplier():
    assert kind(1.0 + 0.0j, True) == FOLD
    assert kind(1.0 + 0.0j, False) == BRANCH_POINT
    assert kind(-1.0 + 0.0j, False) == DOUBLING
    assert kind(-0.6 + 0.8j, False) == NEIMARK_SACKER


@pytest.mark.parametrize("drive", ["force = 3.0\nspeed = 0.2", "force = 3.0\nspeed = -5.0\nangle = 0.1"])
def test_a_constant_force_with_a_speed_at_the_start_has_any_period(system_of, drive):
    """A damped mass on a moving base, m (x'' + u'') + c x' + k x = F: response, multipliers and start in closed form."""
    body = solid("base", 1.0) + solid("block", 2.0) + joint("shaker", "world", "base", "prismatic", "1 0 0")
    sdf = model("m", body + joint("slide", "base", "block", "prismatic", "1 0 0"))
    text = "duration = 2.0\n[drives.shaker]\nformula = '0.05*sin(10*t)'\n[drives.slide]\n" + drive
    text += "\n[springs.S]\npoint = 'block'\nto = 'far'\nstiffness = 80.0\nfree_length = 1.0\ndamping = 4.0\n"
    far = '<frame name="far" attached_to="base"><pose>1 0 0 0 0 0</pose></frame>'
    motion = periodic_motion(system_of(sdf.replace("</model>", far + "</model>"), text), transient=2)
    m, c, k, w = 2.0, 4.0, 80.0, 10.0
    x = -0.05j * m * w**2 / (k - m * w**2 + 1j * c * w)  # for u = -0.05j exp(iwt)
    assert motion.state["q.slide"] == pytest.approx(3.0 / k + x.real, abs=1e-8)
    assert motion.state["v.slide"] == pytest.approx((1j * w * x).real, abs=1e-7)
    roots = np.exp(np.roots([m, c, k]) * 2.0 * np.pi / w)
    assert np.sort_complex(np.asarray(motion.multipliers)) == pytest.approx(np.sort_complex(roots), abs=1e-7)


def test_what_has_no_period_is_refused(oscillator):
    with pytest.raises(InputError, match="have no common period"):
        periodic_motion(oscillator.replaced({"drives.drive": {"formula": "0.1*t**2"}}))
    with pytest.raises(InputError, match="range 2 to 1 is empty"):
        branches(oscillator, "stops.end.limit", 2.0, 1.0)
    with pytest.raises(InputError, match="whole motion"):
        periodic_motion(shipped("slider_crank_dry", joints={}))
    with pytest.raises(InputError, match="periods: is 0; it must be 1 or more"):
        periodic_motion(oscillator, periods=0)
    with pytest.raises(InputError, match="step: is 0; it must be greater than 0"):  # it would never end
        branches(oscillator, "stops.end.limit", 1.0, 2.0, step=0.0)
