"""The 3-RRR robot as one linkage among others, against `linkages.three_rrr`, which has other elements and equations."""

import numpy as np
import pytest
from linearised import slope
from shipped import shipped

from linkages import Status, ideal, modes, simulate
from linkages.engines.compiled.run.runner import Runner
from linkages.input.files.shipped import data_folder
from linkages.three_rrr.branch import follow, start_assembly
from linkages.three_rrr.finite_elements import FiniteElementModel
from linkages.three_rrr.geometry import from_mechanism
from linkages.three_rrr.modes import frequencies
from linkages.three_rrr.response import generalised_alpha, quasi_static_response
from linkages.three_rrr.robot import changed, load_robot

LINKS = [f"{kind}{leg}" for leg in (1, 2, 3) for kind in ("crank", "coupler")]
DRIVES = ("A1", "A2", "A3")
IDEAL = {f"joints.B{leg}.model": "ideal" for leg in (1, 2, 3)}


@pytest.fixture(scope="module")
def robot():
    """The paper's robot with a rigid platform; links of 32 elements."""
    return changed(load_robot(data_folder() / "three_rrr.toml"), model={"elements": 32, "platform": "rigid"})


def linkage(drives=None, **each):
    """The shipped linkage with ideal joints, with replaced keys of the drives and of all links."""
    keys = {f"drives.{name}.speed": speed for name, speed in zip(DRIVES, drives, strict=True)} if drives else {}
    keys |= {f"links.{link}.{key}": value for link in LINKS for key, value in each.items()}
    return shipped("three_rrr_clearance", outputs=["platform.x"], **IDEAL, **keys)


def start(robot, speeds):
    """Motion at t = 0 of the robot with the given crank speeds."""
    g = robot.geometry
    cranks = changed(robot, drives={"phidot": list(speeds)}).cranks
    branch = follow(g, cranks, start_assembly(g, robot.phi0, np.deg2rad(robot.branch)), 0.01)
    return branch.motion(np.zeros(1))


def test_it_is_the_same_robot(robot):
    mechanism = shipped("three_rrr_clearance").mechanism
    found = from_mechanism(mechanism)
    for name in ("base", "platform", "crank", "coupler"):
        np.testing.assert_allclose(getattr(found, name), getattr(robot.geometry, name), rtol=1e-12)
    for key, value in robot.rigid_properties().items():
        _, link, field = key.split(".", 2)
        if field in ("mass", "inertia"):
            assert getattr(mechanism.link[link], field) == pytest.approx(value, rel=1e-9), key


@pytest.mark.parametrize(("bending", "axial", "bound"), [(4, 1, 2e-3), (12, 5, 1e-5)])
def test_locked_natural_frequencies(robot, bending, axial, bound):
    """The first six with the cranks held: of the engine's own linearised equations, and of 32 elements in each link."""
    system = linkage((0.0, 0.0, 0.0), bending=bending, axial=axial, damping=0.0)
    runner = Runner(system)
    n, (matrix, _) = len(runner.model.free), slope(runner.aside(), 0.0, runner.start)
    squares = np.linalg.eigvals(-matrix[n:, :n])
    found = np.sqrt(np.sort(squares[squares.real > 1e5].real))[:6] / (2.0 * np.pi)
    expected = frequencies(FiniteElementModel(robot), start(robot, (0.0, 0.0, 0.0)), 6)[0]
    np.testing.assert_allclose(found, expected, rtol=bound)
    played = {
        f"joints.B{leg}": shipped("three_rrr_clearance").experiment.joints[f"B{leg}"].model_dump(exclude_unset=True)
        for leg in (1, 2, 3)
    }
    np.testing.assert_allclose(modes(system.replaced(played)).frequencies[:6], expected, rtol=bound)


def test_small_deflections_are_those_of_linearised_elastodynamics(robot):
    """How far the platform yields is the paper's quasi-static response, but for a part that falls as deflections do, with 1/E."""
    speeds, away = (6.0, 5.0, 6.6), []
    rigid = simulate(linkage(speeds, model="rigid").replaced({"duration": 1e-6}), "compiled")
    for modulus in (2.06e10, 1.03e10):
        soft = {f"sdf.links.{link}.beam.youngs_modulus": modulus for link in LINKS}
        bent = simulate(linkage(speeds, bending=8, axial=2).replaced({"duration": 1e-6, **soft}), "compiled")
        assert bent.status is Status.OK
        model = FiniteElementModel(changed(robot, material={"youngs_modulus": modulus}))
        expected = quasi_static_response(model, start(robot, speeds)).platform[0]
        found = [bent[f"platform.{name}"][0] - rigid[f"platform.{name}"][0] for name in ("x", "y", "angle")]
        away.append(np.linalg.norm(found - expected) / np.linalg.norm(expected))
    assert away[0] < 2e-3
    assert away[1] / away[0] == pytest.approx(2.0, rel=0.1)


def parted(robot, compliance, turn):
    """How the platform yields over so much of a revolution of drive 2: how far the paper's response is from it, of its size; both rms.

    Compliance 1 is a tenth of steel's modulus; the material's damping goes with it.
    """
    speeds, modulus, damping = (6.0, 5.0, 6.6), 2.06e10 / compliance, 2e-4 * compliance
    steps = round(400 * turn)
    times = np.linspace(0.0, turn * 2.0 * np.pi / speeds[1], steps + 1)
    keys = {f"sdf.links.{link}.beam.youngs_modulus": modulus for link in LINKS}
    keys |= {"duration": times[-1], "solver.accuracy": 1e-7}
    bent, rigid = (
        simulate(linkage(speeds, **each).replaced(keys), "compiled").evaluate(times)
        for each in ({"stiffness_damping": damping}, {"model": "rigid"})
    )
    found = np.array([bent[f"platform.{name}"] - rigid[f"platform.{name}"] for name in ("x", "y", "angle")]).T
    steel = {"material": {"youngs_modulus": modulus}, "damping": {"mass": 0.0, "stiffness": damping}}
    model = FiniteElementModel(changed(robot, model={"elements": 2}, drives={"phidot": list(speeds)}, **steel))
    g = robot.geometry
    branch = follow(g, model.robot.cranks, start_assembly(g, robot.phi0, np.deg2rad(robot.branch)), times[-1])
    fine = np.linspace(0.0, times[-1], 15 * steps + 1)  # 60 and more in a period of the first mode
    expected = generalised_alpha(model, branch, fine, "quasi-static", radius=1.0).platform[::15]
    unit = (1.0, 1.0, 10.0)  # m, m, rad
    return np.linalg.norm((found - expected) / unit) / np.linalg.norm(expected / unit)


@pytest.mark.slow
def test_motion_tends_to_that_of_linearised_elastodynamics(robot):
    """Vibration with inertia of the deflections and damping: the neglected terms fall with 1/E, as deflections."""
    soft, stiff = parted(robot, 2.0, 0.2), parted(robot, 1.0, 0.2)
    assert stiff < 1.3e-3
    assert soft / stiff == pytest.approx(2.0, rel=0.02)


@pytest.mark.slow
def test_a_revolution_with_lubricated_joints():
    """It closes at all times, within clearances and deflections of the rigid robot, whose drives it follows."""
    system = shipped("three_rrr_clearance")
    result = simulate(system, "compiled")
    assert result.status is Status.OK
    times = np.linspace(0.0, system.experiment.duration, 401)
    bent, rigid = result.evaluate(times), ideal(system).evaluate(times)
    for name in ("platform.x", "platform.y"):
        away = np.abs(bent[name] - rigid[name])
        assert 1e-6 < away.max() < 4 * 5e-5, name
    for leg in (1, 2, 3):
        assert bent[f"B{leg}.eccentricity_ratio"].max() < 1.0
