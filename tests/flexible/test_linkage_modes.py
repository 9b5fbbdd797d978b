"""Natural frequencies and mode shapes of linkages at rest: closed forms, differences of accelerations, the command."""

import json

import numpy as np
import pytest
from linearised import right_hand_side
from machines import bar, elastic_bar, four_bar, joint, model, solid

import linkages
from linkages import InputError
from linkages.cli.main import main
from linkages.engines.compiled.run.linear import linearised
from linkages.engines.compiled.run.runner import Runner
from linkages.explore.modes import ModeShapes, modes_over
from linkages.system.linear_systems import static_systems

LENGTH = 0.4
DENSITY, STIFFNESS = 7870.0 * 6.4e-5, 2e11 * 0.008**4 / 12  # rho A, E I of the bars
FINE = '[links.rod]\nmodel = "flexible"\nbending = 12\naxial = 4\n'

CANTILEVER = model("cantilever", elastic_bar("rod", LENGTH, "__model__") + joint("O", "world", "rod"))


def frequencies(system, count):
    return linkages.modes(system).frequencies[:count]


@pytest.mark.parametrize("pieces", [1, 3])
def test_a_link_that_its_drive_holds_is_a_cantilever(system_of, pieces):
    """w = (k L)2 sqrt(E I / (rho A)) / L2 with cos(k L) cosh(k L) = -1; stretching: (pi / 2 L) sqrt(E / rho). Damping: beta w / 2."""
    system = system_of(
        CANTILEVER, f"duration = 1.0\n[drives.O]\nspeed = 3.0\n{FINE}stiffness_damping = 1e-6\npieces = {pieces}\n"
    )
    found = linkages.modes(system)
    bent = np.array([1.87510407, 4.69409113, 7.85475744, 10.99554073]) ** 2 * np.sqrt(STIFFNESS / DENSITY) / LENGTH**2
    stretched = np.pi / (2 * LENGTH) * np.sqrt(2e11 / 7870.0)
    expected = np.sort([*bent, stretched])[:4] / (2 * np.pi)
    np.testing.assert_allclose(found.frequencies[:4], expected, rtol=1e-5)
    np.testing.assert_allclose(found.damping[:4], 1e-6 * np.pi * expected, rtol=1e-4)
    assert found.conservative
    assert found.at_rest
    lines = ModeShapes(found).lines
    assert len(lines) == pieces
    ends = max((line.ways[:, -1] for line in lines), key=lambda way: abs(way[0, 1]))
    np.testing.assert_allclose(np.abs(ends[:2, 1]), 1.0, rtol=1e-9)  # in bending the tip moves farthest


TIE = model(
    "tie",
    f"""{elastic_bar("rod", LENGTH, "__model__")}
{solid("slider", 0.1, 1e-4, at="rod_tip")}
{joint("O", "world", "rod")}{joint("B", "rod_tip", "slider")}{joint("guide", "world", "slider", "prismatic", "1 0 0")}""",
)


@pytest.mark.parametrize("part", [0.0, 2.0, -0.5, -0.99])
def test_an_axial_force_stiffens_and_softens_bending(system_of, part):
    """Pinned ends: w_k2 = (k pi / L)4 E I / (rho A) (1 + N / (k2 N_E)), N_E = pi2 E I / L2."""
    euler = np.pi**2 * STIFFNESS / LENGTH**2
    toml = f'duration = 1.0\n[forces.N]\npoint = "slider"\nforce = [{part * euler}, 0.0]\n{FINE}'
    found = linkages.modes(system_of(TIE, toml.replace("axial = 4", "axial = 0")))
    k = np.array([1, 2, 3])
    expected = (k * np.pi / LENGTH) ** 2 * np.sqrt(STIFFNESS / DENSITY * (1 + part / k**2)) / (2 * np.pi)
    np.testing.assert_allclose(found.frequencies[:3], expected, rtol=1e-4)
    assert found.strain()["rod"] == pytest.approx(1.0)


def test_a_strut_beyond_its_buckling_load_is_unstable(experiment_file, tmp_path, capsys):
    """It grows by e in 1 / sqrt(-p2), p2 = (pi / L)4 E I / (rho A) (1 - N / N_E)."""
    euler = np.pi**2 * STIFFNESS / LENGTH**2
    push = f'duration = 1.0\n[forces.N]\npoint = "slider"\nforce = [{-1.5 * euler}, 0.0]\n'
    file = experiment_file(TIE, push + FINE.replace("axial = 4", "axial = 0") + 'start = "undeformed"\n')
    assert main(["modes", str(file), "--no-plots", "--out", str(tmp_path / "out")]) == 0
    time = (LENGTH / np.pi) ** 2 * np.sqrt(DENSITY / STIFFNESS / 0.5)
    assert f"mode 1 is unstable: a disturbance grows by e in {time:.3g} s" in capsys.readouterr().out
    found = json.loads((tmp_path / "out" / "modes.json").read_text())
    assert found["modes"][0]["frequency"] is None
    assert found["at_rest"]


PENDULUM = model("pendulum", bar("rod", LENGTH, "__model__", -np.pi / 2) + joint("O", "world", "rod"))


@pytest.mark.parametrize("gravity", [-9.81, 0.0, 9.81])
def test_a_rigid_pendulum_hangs_rests_or_falls(system_of, gravity):
    """w2 = 3 g / (2 L); without gravity it moves freely, and standing on its head it is unstable."""
    found = linkages.modes(system_of(PENDULUM, f"duration = 1.0\ngravity = [0.0, {gravity}, 0.0]\n"))
    assert found.squares == pytest.approx([-1.5 * gravity / LENGTH], rel=1e-9, abs=1e-12)
    assert found.at_rest
    assert np.isnan(found.frequencies[0]) == (gravity > 0.0)


def test_a_pendulum_that_does_not_hang_is_not_at_rest(system_of):
    fallen = PENDULUM.replace(str(-np.pi / 2), "0.3")
    assert not linkages.modes(system_of(fallen, "duration = 1.0\ngravity = [0.0, -9.81, 0.0]\n")).at_rest


def elastic_four_bar():
    text = four_bar()
    for name, length in (("coupler", 0.25), ("follower", 0.2)):
        start = text.index(f'<link name="{name}">')
        old = text[start : text.index("</link>", start) + 7]
        frame = old[old.index('relative_to="') + 13 :].partition('"')[0]
        angle = float(old[: old.index("</pose>")].split()[-1])
        new = elastic_bar(name, length, frame, angle)
        text = text.replace(old, new[: new.index("</link>") + 7].strip())
    return text


LOADED = """duration = 1.0
gravity = [0.0, -9.81, 0.0]
{}[links.coupler]
model = "flexible"
[links.follower]
model = "flexible"
start = "{}"
[forces.F]
point = "coupler_tip"
force = [40.0, -30.0]
[springs.S]
point = "coupler_tip"
anchor = [0.5, 0.4]
stiffness = 2e3
free_length = 0.2
damping = 5.0
[torsion_springs.T]
joint = "O"
stiffness = 30.0
free_angle = 0.1
damping = 0.02
"""


@pytest.mark.parametrize("drive", ["[drives.O]\nspeed = 3.0\n", ""])
@pytest.mark.parametrize("start", ["quasi-static", "undeformed"])
def test_the_linear_equations_are_those_of_accelerations_by_differences(system_of, drive, start):
    """M^-1 K and M^-1 C along the ways in which closed loops move; with weight, springs, loads, a damper; driven and free."""
    pose = static_systems(system_of(elastic_four_bar(), LOADED.format(drive, start)), [0.0])[0]
    runner = Runner(pose)
    found, n = linearised(runner, 0.0), len(runner.model.free)
    equations = runner.aside()

    def acceleration(change):
        dy = np.zeros(2 * n)
        right_hand_side(equations, 0.0, runner.start + change, dy)
        return np.linalg.solve(found.mass, found.ways.T @ found.masses @ dy[n:])

    for matrix, first in ((found.stiffness, 0), (found.damping, n)):
        size = 1e-6
        columns = []
        for way in found.ways.T:
            change = np.zeros(2 * n)
            change[first : first + n] = size * way
            columns.append((acceleration(change) - acceleration(-change)) / (2 * size))
        expected = -found.mass @ np.column_stack(columns)
        np.testing.assert_allclose(matrix, expected, rtol=0, atol=3e-6 * np.abs(expected).max())
    eigenvalues = np.sort(np.linalg.eigvals(np.linalg.solve(found.mass, found.stiffness)).real)
    np.testing.assert_allclose(linkages.modes(pose).squares[:4], eigenvalues[:4], rtol=1e-3)


def test_shapes_have_the_symmetry_of_mass_and_stiffness(system_of):
    found = linkages.modes(system_of(elastic_four_bar(), LOADED.format("[drives.O]\nspeed = 3.0\n", "quasi-static")))
    np.testing.assert_allclose(found.shapes.T @ found.mass @ found.shapes, np.eye(len(found.squares)), atol=1e-9)
    assert found.conservative
    assert found.at_rest
    assert sum(found.strain().values()) == pytest.approx(1.0)


def test_modes_are_followed_over_a_revolution(system_of):
    """The first mode depends on the pose alone; after a revolution all frequencies are as before."""
    system = system_of(elastic_four_bar(), LOADED.format("[drives.O]\nspeed = 6.283185307179586\n", "quasi-static"))
    times = np.linspace(0.0, 1.0, 13)
    found = modes_over(system, times, 3)
    np.testing.assert_allclose(found.frequencies[0], found.frequencies[-1], rtol=1e-6)
    for k in (3, 7):
        alone = linkages.modes(system, times[k]).frequencies
        assert np.abs(found.frequencies[k][:, None] / alone - 1.0).min(axis=1) == pytest.approx(0.0, abs=1e-9)


def test_a_machine_in_which_nothing_can_move_is_refused(system_of):
    with pytest.raises(InputError, match=r'no link is flexible.*set links\.NAME\.model = "flexible"'):
        linkages.modes(system_of(four_bar(), "duration = 1.0\n[drives.O]\nspeed = 1.0\n"))


def test_the_command_writes_numbers_and_figures(tmp_path, capsys):
    options = ["--count", "3", "--cycle", "8", "--out", str(tmp_path)]
    assert main(["modes", "slider_crank_flexible.toml", *options]) == 0
    found = json.loads((tmp_path / "modes.json").read_text())
    assert found["ideal"] == ["B"]
    assert found["held"] == {"O": 0.0}
    first = found["modes"][0]
    assert first["frequency"] == pytest.approx(203.2, abs=0.05)
    assert first["damping"] == pytest.approx(0.01, rel=1e-3)
    assert first["strain"] == {"rod": 1.0}
    middle = np.hypot(*first["points"]["rod_mid"][:2])
    assert middle == pytest.approx(1.0, abs=1e-3)  # the largest displacement of any point
    assert np.array(found["over"]["frequencies"]).shape == (9, 3)
    assert {path.name for path in tmp_path.iterdir()} == {
        *("record.json", "modes.json", "mode_shapes.png", "mode_frequencies.png")
    }
    said = capsys.readouterr().out
    assert "drives held: O" in said
    assert "clearance joints that are ideal here: B" in said
    assert "203.2" in said


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["slider_crank_flexible.toml", "--branch", "98"], "--branch"),
        (["slider_crank_flexible.toml", "--verify"], "--verify"),
        (["three_rrr.toml", "--cycle", "8"], "--cycle"),
        (["slider_crank_flexible.toml", "--count", "0"], "--count"),
        (["slider_crank_flexible.toml", "--cycle", "1"], "--cycle"),
        (["slider_crank_flexible.toml", "--set", "links.rod.model=rigid"], "no link is flexible"),
    ],
)
def test_the_command_refuses_in_one_line(tmp_path, capsys, options, said):
    assert main(["modes", *options, "--out", str(tmp_path / "out")]) == 2
    error = capsys.readouterr().err.strip()
    assert said in error
    assert len(error.splitlines()) == 1
    assert not (tmp_path / "out").exists()
