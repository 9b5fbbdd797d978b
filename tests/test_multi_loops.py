"""Twelve linkages with several loops against natural coordinates: mobility, dead points, transmission angles, horizon, energy."""

import numpy as np
import pytest
from multi_loops import LINES, MACHINES, natural

from linkages import Status, horizon, ideal, load, simulate
from linkages.cli.main import main
from linkages.explore.range_of_motion import movable, travel
from linkages.results.divergence import PARTED
from linkages.results.extremes import integral

STEEL = {"law": "lankarani-nikravesh", "restitution": 0.9, "youngs_modulus": 207e9, "poissons_ratio": 0.3}
SPEED, GRAVITY = 2.0 * np.pi, 9.81  # rad/s, m/s2


#: With and without dead points and transmission angles; a slide on a moving link. The others are slow.
QUICK = ("whitworth", "stephenson 3", "stephenson 3 driven at the output", "hart")


@pytest.fixture(
    scope="module", params=[name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in MACHINES]
)
def case(request, tmp_path_factory):
    """A machine of the table: its name, its system, its own model."""
    folder = tmp_path_factory.mktemp("machine")
    (folder / "made.machine.toml").write_text(MACHINES[request.param], encoding="utf-8")
    assert main(["new", "--from", str(folder / "made.machine.toml"), "--out", str(folder)]) == 0
    system = load(folder / "made.toml", {"gravity": [0.0, -GRAVITY, 0.0]})
    return request.param, system, natural(MACHINES[request.param], system.mechanism)


@pytest.fixture(scope="module")
def way(case):
    """The way of the machine's drive."""
    _, system, model = case
    return travel(movable(system.mechanism, {model.pivot: 0.0}), model.pivot)


def test_mobility_and_dead_points(case, way):
    _, system, model = case
    assert system.assembly.mobility == model.mobility() == 1
    end = model.farthest(1.0)
    assert way.full == (end >= 2.0 * np.pi)
    if not way.full:
        ends = model.farthest(-1.0), end
        assert way.ends == (Status.LOCKED, Status.LOCKED)
        np.testing.assert_allclose(way.values[[0, -1]], ends, rtol=0, atol=2e-7)


def test_transmission_angles_of_every_dyad(case, way):
    name, _, model = case
    assert {one.joint for one in way.transmissions} == set(LINES[name])
    assert bool(way.together) == (not LINES[name])
    part = (way.values - way.values[0]) / (way.values[-1] - way.values[0])
    chosen = np.flatnonzero((part > 0.01) & (part < 0.99))[::8]
    model.go_to(way.values[chosen[0]])
    points = model.at_each(way.values[chosen])
    for one in way.transmissions:
        own = acute_angles(LINES[name][one.joint], points)
        np.testing.assert_allclose(one.angle[chosen], own, rtol=0, atol=1e-8)


def test_extremes_of_transmission_angles_between_samples(case, way):
    name, _, model = case
    for one in way.transmissions:
        assert one.least[1] <= np.nanmin(one.angle)
        assert one.most[1] >= np.nanmax(one.angle)
        for value, angle in (one.least, one.most):
            step = 0.005 * (way.values[-1] - way.values[0])
            around = value + step * np.linspace(-1.0, 1.0, 41)
            inside = around if way.full else around[(around > way.values[0] + step) & (around < way.values[-1] - step)]
            if not len(inside):
                continue  # at an end of the way
            model.go_to(inside[0])
            own = acute_angles(LINES[name][one.joint], model.at_each(inside))
            best = own.min() if angle == one.least[1] else own.max()
            assert angle == pytest.approx(best, abs=2e-3 if best > 1.56 else 1e-5)  # own samples pass 90 degrees


def acute_angles(lines, points):
    """Acute angles between two lines: pairs of points, or a direction."""
    first, second = (points[line[1]] - points[line[0]] if isinstance(line, tuple) else line for line in lines)
    angle = np.abs(np.angle(second / first))
    return np.minimum(angle, np.pi - angle)


@pytest.mark.slow
def test_a_joint_turns_back_where_its_velocity_does(case, way):
    _, _, model = case
    ends = (0.0, 1.0) if way.full else (0.01, 0.99)
    inside = way.values[0] + (way.values[-1] - way.values[0]) * np.linspace(*ends, 250)
    for one in way.transmissions:
        if not one.grounded:
            assert one.turns == ()
            continue
        model.go_to(inside[0])
        rates = np.array([model.rate(one.joint, angle) for angle in inside])
        back = np.flatnonzero((rates[1:] * np.conj(rates[:-1])).real < 0.0)
        turns = np.sort(np.mod(one.turns, 2.0 * np.pi) if way.full else one.turns)
        assert len(turns) == len(back)
        step = inside[1] - inside[0]
        assert np.all((turns >= inside[back] - 1e-3) & (turns <= inside[back] + step + 1e-3))


@pytest.fixture(scope="module")
def turning(case, way):
    """The system with its drive at a constant speed for 0.4 s, or for most of its way."""
    _, system, model = case
    duration = 0.4 if way.full else 0.8 * way.values[-1] / SPEED
    return system.replaced({"duration": duration, f"drives.{model.pivot}.speed": SPEED})


@pytest.mark.slow
def test_the_drive_does_the_work_that_changes_the_energy(case, turning):
    """Torque at a constant speed = derivative of kinetic and potential energy to the angle."""
    _, _, model = case
    times = np.linspace(0.0, turning.experiment.duration, 6)
    exact = ideal(turning).evaluate(times)[f"{model.pivot}.torque"]
    own = [model.torque(SPEED * time, SPEED, GRAVITY) for time in times]
    np.testing.assert_allclose(exact, own, rtol=0, atol=1e-6 * np.abs(exact).max())


def test_the_energy_of_a_run_balances(case, turning):
    """Work of the drive in a run of the compiled engine = change of the model's own energy."""
    _, _, model = case
    run = simulate(turning, "compiled")
    assert run.status is Status.OK
    assert run.provenance["loop_error"] < 1e-9
    work = SPEED * integral(run, f"{model.pivot}.torque")
    energies = []
    for angle in (0.0, SPEED * turning.experiment.duration):
        model.go_to(angle)
        energies.append(model.energy(angle, SPEED, GRAVITY))
    size = max(map(abs, energies)) + np.abs(run["kinetic_energy"]).max()
    assert work == pytest.approx(energies[1] - energies[0], abs=1e-6 * size)


@pytest.mark.slow
def test_runs_can_be_reproduced_up_to_the_horizon(case, turning):
    """The run agrees with one at 1e-12 up to the horizon, and with a ten times looser one no longer beyond it."""
    _, _, model = case
    pin = next(one.name for one in turning.mechanism.joints if one.type == "revolute" and one.parent != "world")
    clearance, speed = 1e-4, 5.0 * SPEED
    dry = {
        f"drives.{model.pivot}.speed": speed,
        "duration": turning.experiment.duration * SPEED / speed,
        f"joints.{pin}": {"model": "dry", "clearance": clearance, "contact": STEEL},
    }
    system = turning.replaced(dry)
    period = 2.0 * np.pi / speed
    turns = system.experiment.duration / period
    found = horizon(system, most=turns)
    assert horizon(system, most=0.5 * turns) == pytest.approx(min(found, 0.5 * turns), abs=1 / 200)
    times = np.arange(1, int(200 * turns) + 1) / 200 * period
    run, looser, exact = (
        places(system.replaced({"solver.accuracy": accuracy}), pin, times) / clearance
        for accuracy in (1e-7, 1e-6, 1e-12)
    )
    before = times <= found * period * (1.0 + 1e-9)
    assert before.any()
    assert np.abs(run - exact)[:, before].max() < 10.0 * PARTED  # the looser run may err alike by chance
    if not before.all():
        assert np.abs(run - looser)[:, ~before][:, 0].max() > PARTED


def places(system, pin, times):
    """Places (2, nt) of a journal in its bearing at given times [m]."""
    columns = simulate(system, "compiled").evaluate(times)
    return np.array([columns[f"{pin}.ex"], columns[f"{pin}.ey"]])
