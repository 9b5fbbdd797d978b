"""Maps, the drawn robot, the animation, and imports without Drake and matplotlib."""

from __future__ import annotations

import itertools
import json
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from linkages.show.plots.three_rrr import figures
from linkages.show.plots.three_rrr.robot_lines import animation_data, displaced_lines, shape_lines, write_animation
from linkages.three_rrr.analysis import RobotResults
from linkages.three_rrr.direct import assemblies, drive_map
from linkages.three_rrr.kinematics import determinants
from linkages.three_rrr.robot import Robot
from linkages.three_rrr.vibration import Vibration


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


def test_deformed_lines_meet_at_the_pivots(results: RobotResults) -> None:
    """Neighbouring rods and the platform share their pivots, deformed or not, and the base is fixed."""
    for lines in (
        displaced_lines(results.model, results.motion.part(slice(100, 101))),
        shape_lines(results.model, results.motion, 100, results.shapes[100, :, 3]),
    ):
        named = {name: line for line, name in lines}
        for leg in (1, 2, 3):
            base = results.robot.geometry.base[leg - 1]
            np.testing.assert_allclose(named[f"crank{leg}"][0], base, atol=1e-12)
            np.testing.assert_allclose(named[f"crank{leg}"][-1], named[f"coupler{leg}"][0], atol=1e-12)
            np.testing.assert_allclose(named[f"coupler{leg}"][-1], named["platform"][leg - 1], atol=1e-12)


def test_figures_show_the_vibration_as_bands(results: RobotResults) -> None:
    """Figures 11 and 12: each band reaches from the least to the largest value; without a dynamic run there is none."""
    time = np.linspace(0.0, results.robot.duration, 50)
    band = np.stack([-np.ones((50, 3)), 2.0 + np.sin(time)[:, None] * np.ones(3)])
    shaken = Vibration(time, 50, 1e-6 * band, {link.name: 1e3 * band for link in results.stress}, {}, band)
    for draw, panels in ((figures._displacement, (0, 2, 4)), (figures._stress, (0, 2, 4))):
        before, after = draw(results), draw(replace(results, dynamic=shaken))
        for panel in panels:
            assert not before.axes[panel].collections
            for drawn in after.axes[panel].collections:
                heights = drawn.get_paths()[0].vertices[:, 1]
                assert (heights.min(), heights.max()) == pytest.approx((-1.0, 2.0 + np.sin(time).max()))
            assert len(after.axes[panel].collections) == (1 if draw is figures._displacement else 3)


@pytest.mark.slow
def test_animation_needs_no_network(results: RobotResults, tmp_path: Path) -> None:
    page = write_animation(results, tmp_path / "animation.html").read_text()
    assert not re.search(r"https?:(?!//www\.w3\.org/2000/svg)|src=|@import|fetch\(|XMLHttp", page)
    data = json.loads(re.search(r"const data = (\{.*\});", page)[1])
    lines = [line for line in data["machines"][0]["lines"] if line["moved"]]
    assert len(lines[0]["moved"]) == len(lines[0]["rest"]) == len(data["texts"]) == 121
    assert float(data["texts"][0][0].split()[4]) == pytest.approx(133.56, abs=0.1)
    want = animation_data(results)["frames"][60]
    assert [line["rest"][60] for line in lines] == want["rest"]
    assert [line["moved"][60][2] for line in lines] == want["shape"][2]
    size = max(np.max(np.linalg.norm(np.array(line), axis=1)) for line in want["shape"][2])
    assert size == pytest.approx(42.2, abs=0.2)  # a tenth of the coupler's length, in mm
    moved = lines[6]["moved"]
    jumps = [np.max(np.abs(np.array(a[0]) - np.array(b[0]))) for a, b in itertools.pairwise(moved)]
    assert max(jumps) < 20.0  # signs do not flip between frames


def test_the_library_loads_without_drake_and_matplotlib() -> None:
    code = (
        "import sys, linkages.show.plots.three_rrr.robot_lines, linkages.three_rrr.speed, linkages.three_rrr.direct;"
        "sys.exit(any(name in sys.modules for name in ('pydrake', 'matplotlib')))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
