"""Agreement with Drake's rigid plant, and the command line."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from linkages.cli.main import main
from linkages.files.shipped import data_folder
from linkages.three_rrr.branch import Branch, follow
from linkages.three_rrr.direct import assemblies
from linkages.three_rrr.kinematics import Motion
from linkages.three_rrr.model import Model
from linkages.three_rrr.robot import Robot, changed, load_robot
from linkages.three_rrr.verify import RigidPlant, verify

OPTIONS = {
    "as shipped": {},
    "refined": {"model": {"elements": 4}},
    "joint masses": {"joint_masses": {"B": 0.3, "C": 0.5}},
    "aluminium": {"material": {"youngs_modulus": 7.1e10, "density": 2770.0}},
}


@pytest.mark.parametrize("options", OPTIONS.values(), ids=OPTIONS)
def test_everything_agrees_with_drake(robot: Robot, options: dict) -> None:
    for x in assemblies(robot.geometry, robot.phi0).x:
        branch = follow(robot.geometry, robot.phi0, robot.phidot, x, robot.duration)
        found = verify(changed(robot, **options), branch.motion(np.linspace(0.0, robot.duration, 13)))
        assert found.zero_modes == 3
        assert found.zero_eigenvalue <= 1e-10
        assert found.principal_angle <= 1e-10
        assert found.mass_error <= 1e-10
        for name in ("position", "velocity", "acceleration", "torque"):
            assert getattr(found, name) <= 1e-9


def test_drives_with_acceleration_agree_with_drake(robot: Robot, branch: Branch) -> None:
    """Accelerating drives, which no experiment has, exercise every term of the accelerations."""
    from linkages.three_rrr.kinematics import motion

    state = branch.motion(np.linspace(0.0, robot.duration, 9))
    pushed = np.random.default_rng(2).normal(size=state.phi.shape) * 5.0
    fast = motion(robot.geometry, state.time, state.phi, 8.0 * state.dphi, pushed, state.x)
    found = verify(robot, fast)
    assert max(found.position, found.velocity, found.acceleration, found.torque) <= 1e-9


def test_the_sdf_file_has_the_masses_of_the_robot_file(robot: Robot) -> None:
    mechanism = robot.load_mechanism()
    for key, value in robot.rigid_properties().items():
        _, link, quantity = key.split(".", 2)
        if quantity in ("mass", "inertia"):
            assert getattr(mechanism.link[link], quantity) == pytest.approx(value, rel=1e-12)
        else:
            assert mechanism.link[link].com_local["xyz".index(quantity[-1])] == pytest.approx(
                value, abs=1e-15
            )


def test_a_wrong_mass_or_motion_is_noticed(robot: Robot, poses: Motion) -> None:
    one = poses.part(slice(2, 3))
    plant = RigidPlant(robot)
    plant.solve(one.phi[0], one.dphi[0], one.ddphi[0], {"coupler1": 0.0, "platform": 1.5} | _couplers(one))
    space = plant.velocity_space()
    heavy = Model(changed(robot, drives={"roots": "free"}, material={"density": 7851.0}))
    rigid = plant.nodal_jacobian(heavy) @ space
    drake = space.T @ plant.plant.CalcMassMatrix(plant.context) @ space
    error = np.max(np.abs(rigid.T @ heavy.full_matrices(one)[1][0] @ rigid - drake)) / np.max(np.abs(drake))
    assert error == pytest.approx(1.0 / 7850.0, rel=1e-6)


def _couplers(state: Motion) -> dict[str, float]:
    return {f"coupler{leg}": float(state.psi[0, leg - 1]) for leg in (1, 2, 3)}


def test_modes_command_writes_what_it_promises(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out"
    status = main(
        [
            "modes",
            str(data_folder() / "three_rrr.toml"),
            "--verify",
            "--branch",
            "98",
            "--no-plots",
            "--out",
            str(out),
        ]
    )
    assert status == 0
    found = json.loads((out / "modes.json").read_text())
    angles = [np.rad2deg(a["theta"]) for a in found["assemblies"]]
    np.testing.assert_allclose(angles, [98.05, -87.51], atol=0.005)
    assert found["locked_frequencies"][0] == pytest.approx(133.56, abs=0.005)
    assert len(found["locked_frequencies"]) == len(found["ranges"]) == 21
    assert np.all(np.abs(found["free_frequencies"][:3]) < 1e-3)
    assert found["free_frequencies"][3] > 100.0
    low, high = found["ranges"][0]
    assert low <= found["locked_frequencies"][0] <= high
    check = found["verify"]
    assert check["zero_modes"] == 3
    assert max(check["principal_angle"], check["mass_error"]) <= 1e-10
    printed = capsys.readouterr().out
    assert "133.56" in printed
    assert "zero_modes" in printed
    assert sorted(p.name for p in out.iterdir()) == ["animation.html", "modes.json"]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "density        = 7850.0",
            "density        = 0.0",
            "material.density: is 0.0; it should be greater than 0",
        ),
        ("density        = 7850.0", "densty         = 7850.0", 'unknown key; did you mean "density"?'),
        ("coupler_diameter   = 0.04", "coupler_diameter   = -0.04", "sections.coupler_diameter: is -0.04"),
        ("elements = 1 ", "elements = 0 ", "model.elements: is 0; it should be greater than or equal to 1"),
        ("phi0   = [60.0, 0.0, 220.0]", "phi0   = [60.0, 0.0]", "drives.phi0"),
        ('roots  = "locked"', 'roots  = "servo"', "drives.servo_stiffness: is missing"),
        ('mechanism = "three_rrr.sdf"', 'mechanism = "none.sdf"', "none.sdf: cannot be read"),
        ("[drives]", "[drives", "is not valid TOML"),
    ],
)
def test_bad_robots_get_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], old: str, new: str, message: str
) -> None:
    check_refused(tmp_path, capsys, {"three_rrr.toml": (old, new)}, message)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            'attached_to="crank2"><pose>0.112',
            'attached_to="crank2"><pose>0.0',
            "crank2: has the length 0 m; it must be positive",
        ),
        ('name="B2"', 'name="Q2"', '<joint name="B2">: is missing; did you mean'),
        (
            "<parent>crank3_B</parent>",
            "<parent>world</parent>",
            '<joint name="B3">: is a revolute joint of world',
        ),
    ],
)
def test_bad_mechanisms_get_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], old: str, new: str, message: str
) -> None:
    check_refused(tmp_path, capsys, {"three_rrr.sdf": (old, new)}, message)


def check_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], changes: dict[str, tuple[str, str]], message: str
) -> None:
    run = edited(tmp_path, changes)
    assert run == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
    assert not (tmp_path / "out").exists()


def edited(tmp_path: Path, changes: dict[str, tuple[str, str]]) -> int:
    for name in ("three_rrr.sdf", "three_rrr.toml"):
        text = (data_folder() / name).read_text()
        old, new = changes.get(name, ("", ""))
        assert old in text
        (tmp_path / name).write_text(text.replace(old, new, 1) if old else text)
    return main(
        [
            "modes",
            str(tmp_path / "three_rrr.toml"),
            "--no-plots",
            "--no-animation",
            "--out",
            str(tmp_path / "out"),
        ]
    )


def test_no_assembly_and_wrong_branch_are_failures(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert edited(tmp_path, {"three_rrr.toml": ("branch    = 98.05", "branch    = 10.0")}) == 1
    error = capsys.readouterr().err
    assert "no-assembly: no assembly starts near theta = 10 deg; there are 98.05, -87.51 deg" in error
    assert error.count("\n") == 1
    far = (
        'attached_to="world"><pose relative_to="__model__">0.3 ',
        'attached_to="world"><pose relative_to="__model__">3.0 ',
    )
    assert edited(tmp_path, {"three_rrr.sdf": far}) == 1
    assert "no assembly at the crank angles 60, 0, 220 deg" in capsys.readouterr().err


def test_a_crossed_fold_ends_the_study_with_a_status(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from linkages.three_rrr.direct import count

    robot = load_robot(data_folder() / "three_rrr.toml")
    times = np.linspace(0.0, robot.duration, 2001)
    number = count(robot.geometry, robot.phi0 + times[:, None] * robot.phidot)
    phi0 = np.rad2deg(robot.phi0 + times[np.flatnonzero(number == 4)[0] + 5] * robot.phidot)
    found = assemblies(robot.geometry, np.deg2rad(phi0))
    kept = [assemblies(robot.geometry, robot.phi0).x]
    for x in found.x:
        branch = follow(robot.geometry, np.deg2rad(phi0), robot.phidot, x, robot.duration)
        if branch.status.value == "singular":
            kept.append(x)
    text = (data_folder() / "three_rrr.toml").read_text()
    text = text.replace("[60.0, 0.0, 220.0]", str(phi0.tolist())).replace(
        "98.05 ", f"{np.rad2deg(kept[1][0])} "
    )
    (tmp_path / "three_rrr.sdf").write_text((data_folder() / "three_rrr.sdf").read_text())
    (tmp_path / "fold.toml").write_text(text)
    assert (
        main(
            [
                "modes",
                str(tmp_path / "fold.toml"),
                "--no-plots",
                "--no-animation",
                "--out",
                str(tmp_path / "out"),
            ]
        )
        == 1
    )
    assert "ends at a fold" in capsys.readouterr().err
    result = json.loads((tmp_path / "out" / "modes.json").read_text())
    assert result["status"] == "singular"
    assert result["singularities"][-1]["type"] == 2
    assert result["duration"] < result["singularities"][-1]["time"] < robot.duration
    assert result["ranges"][0][0] > 1.0  # the last moments, where stiffness vanishes, are left out
    assert max(result["elastic_displacement"].values()) < 1e-3
