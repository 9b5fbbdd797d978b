"""Maps, figures, the animation, the replication table, and what may import what."""

from __future__ import annotations

import ast
import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from replication.three_rrr import PRINTED_CRANK, PRINTED_ERROR, rows, stress_bound

import linkages.three_rrr
from linkages.cli.main import main
from linkages.files.shipped import data_folder
from linkages.plots.three_rrr.animation import animation_data, write_animation
from linkages.plots.three_rrr.drawing import rest_lines, shape_lines
from linkages.three_rrr.branch import Branch
from linkages.three_rrr.direct import assemblies
from linkages.three_rrr.kinematics import determinants
from linkages.three_rrr.maps import drive_map
from linkages.three_rrr.robot import Robot, changed
from linkages.three_rrr.study import FlexibleStudy, run_study


@pytest.fixture(scope="module")
def study(robot: Robot) -> FlexibleStudy:
    return run_study(robot)


def test_map_agrees_with_single_solutions(robot: Robot) -> None:
    found = drive_map(robot.geometry, float(robot.phi0[2]), points=13)
    for row, second in enumerate(found.angles):
        for column, first in enumerate(found.angles):
            phi = np.array([first, second, robot.phi0[2]])
            single = assemblies(robot.geometry, phi)
            assert found.count[row, column] == len(single)
            two, one = determinants(robot.geometry, np.repeat(phi[None], len(single), 0), single.x)
            assert found.fold[row, column] == pytest.approx(np.min(np.abs(two)), rel=1e-6)
            assert found.reach[row, column] == pytest.approx(np.min(np.abs(one)), abs=1e-9)
    assert {2, 4} <= set(found.count.ravel())


def test_deformed_lines_meet_at_the_pivots(study: FlexibleStudy) -> None:
    """Neighbouring rods and the platform share their pivots, bent or not, and the base stays put."""
    for lines in (
        rest_lines(study.model, study.motion, 100),
        shape_lines(study.model, study.motion, 100, study.shapes[100, :, 3]),
    ):
        named = {name: line for line, name in lines}
        for leg in (1, 2, 3):
            base = study.robot.geometry.base[leg - 1]
            np.testing.assert_allclose(named[f"crank{leg}"][0], base, atol=1e-12)
            np.testing.assert_allclose(named[f"crank{leg}"][-1], named[f"coupler{leg}"][0], atol=1e-12)
            np.testing.assert_allclose(named[f"coupler{leg}"][-1], named["platform"][leg - 1], atol=1e-12)


def test_animation_needs_no_network(study: FlexibleStudy, tmp_path: Path) -> None:
    page = write_animation(study, tmp_path / "animation.html").read_text()
    assert not re.search(r"https?:|src=|@import|fetch\(|XMLHttp", page)
    data = json.loads(re.search(r"const D=(\{.*\});", page)[1])
    assert len(data["frames"]) == len(data["hz"]) == 121
    assert data["hz"][0][0] == pytest.approx(133.56, abs=0.01)
    want = animation_data(study)["frames"][60]
    assert data["frames"][60] == want
    size = max(np.max(np.linalg.norm(np.array(line), axis=1)) for line in want["shape"][2])
    assert size == pytest.approx(42.2, abs=0.2)  # a tenth of the coupler's length, in mm
    jumps = [
        np.max(np.abs(np.array(a["shape"][0][6]) - np.array(b["shape"][0][6])))
        for a, b in zip(data["frames"], data["frames"][1:], strict=False)
    ]
    assert max(jumps) < 20.0  # signs do not flip between frames


def test_command_writes_all_figures_and_repeats_itself(tmp_path: Path) -> None:
    """A short motion, twice: the same bytes of modes.json, and every figure of the paper."""
    text = (
        (data_folder() / "three_rrr.toml")
        .read_text()
        .replace("duration  = 12.566370614359172", "duration  = 1.5")
    )
    (tmp_path / "three_rrr.sdf").write_text((data_folder() / "three_rrr.sdf").read_text())
    (tmp_path / "short.toml").write_text(text)
    first, second = tmp_path / "first", tmp_path / "second"
    assert main(["modes", str(tmp_path / "short.toml"), "--out", str(first)]) == 0
    options = ["--no-plots", "--no-animation", "--out", str(second)]
    assert main(["modes", str(tmp_path / "short.toml"), *options]) == 0
    assert (first / "modes.json").read_bytes() == (second / "modes.json").read_bytes()
    names = {path.name[:5] for path in first.glob("fig*.png")}
    assert names == {f"fig{number:02d}" for number in range(5, 13)}
    for path in first.glob("*.png"):
        assert path.stat().st_size > 10_000
    assert (first / "animation.html").exists()


def test_printed_displacements_contradict_the_printed_stress(study: FlexibleStudy) -> None:
    """At 0.35 MPa the platform moves by less than 3 um; the paper prints more than 6 mm."""
    bound = stress_bound(study)
    e, d, length = 2.06e11, 0.03, 0.112
    moment = PRINTED_CRANK * np.pi * d**3 / 32
    assert bound.crank == pytest.approx(moment * length**2 / (3 * e * np.pi * d**4 / 64), rel=1e-12)
    assert max(bound.crank, bound.axial, bound.platform) < 3e-6
    assert min(PRINTED_ERROR[:2]) > 2000 * max(bound.crank, bound.axial, bound.platform)
    assert np.max(np.abs(study.static.platform[:, :2])) < 1e-6


def test_replication_rows_are_complete(robot: Robot) -> None:
    found = rows(changed(robot, duration=robot.duration))
    assert len(found) >= 15
    for row in found:
        for cell in (row.quantity, row.printed, row.ours, row.verdict):
            assert cell
            assert "|" not in cell
            assert "nan" not in cell
    printed = " ".join(row.printed for row in found)
    for number in ("6.456 mm", "9.158 mm", "1.263 deg", "346.7 kPa", "138 kPa", "2.708 kPa"):
        assert number in printed


def test_only_the_verification_knows_drake() -> None:
    folder = Path(linkages.three_rrr.__file__).parent
    for path in folder.glob("*.py"):
        imported = set()
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Import):
                imported |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                imported.add(node.module or "")
        forbidden = {
            name
            for name in imported
            if name.split(".")[0] == "pydrake" or name.startswith("linkages.engines.drake")
        }
        assert not forbidden or path.name == "verify.py"


def test_the_library_loads_without_drake_and_matplotlib() -> None:
    code = (
        "import sys, linkages.three_rrr.study, linkages.plots.three_rrr.animation, linkages.three_rrr.sweep;"
        "sys.exit(any(name in sys.modules for name in ('pydrake', 'matplotlib')))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_branch_times_are_checked(branch: Branch) -> None:
    assert branch.motion(np.array([0.0, branch.times[-1]])).x.shape == (2, 3)
