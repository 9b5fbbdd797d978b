"""Animations as GIF and MP4 files: the drawn bodies follow the run, the loops are closed, bad input is refused."""

import shutil
from itertools import pairwise

import matplotlib as mpl
import numpy as np
import pytest
from PIL import Image

import linkages
from linkages.cli.main import main
from linkages.show.plots.drawing import draw, moving
from linkages.show.plots.drawing.poses import body_poses
from linkages.show.plots.drawing.scene import Scene

RUN = "simulate seven_bar.toml --duration 0.05 --no-plots --no-animation --no-error-estimate --quiet --out"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("press") / "out"
    assert main([*RUN.split(), str(out)]) == 0
    return out


@pytest.mark.parametrize("machine", ["seven_bar", "four_bar_dry", "slider_crank_flexible"])
def test_the_links_of_an_ideal_motion_meet_in_the_joints(machine):
    system = linkages.load(linkages.find_file(f"{machine}.toml"), {"duration": 0.02})
    run = linkages.ideal(system)
    drawing = draw(system)
    poses = body_poses(drawing, system.links, run, run.time)
    body = {name: k for k, name in drawing.links_of.items()}
    for joint in system.mechanism.joints:
        ends = []
        for link, place in ((joint.parent, joint.on_parent), (joint.child, joint.on_child)):
            x, y, angle = poses[:, body[link]].T
            along = place - drawing.reference[body[link], :2]
            ends.append(np.column_stack([x + np.cos(angle) * along[0] - np.sin(angle) * along[1],
                                         y + np.sin(angle) * along[0] + np.cos(angle) * along[1]]))  # fmt: skip
        apart = np.linalg.norm(ends[1] - ends[0], axis=1)
        if joint.type == "revolute":
            np.testing.assert_allclose(apart, 0.0, atol=1e-9)
        else:  # a block moves along its axis only
            across = np.array([-joint.axis[1], joint.axis[0]])
            np.testing.assert_allclose((ends[1] - ends[0]) @ across, 0.0, atol=1e-9)


def test_a_gif_has_its_frames_and_duration_and_is_small(folder, capsys):
    assert main(["animate", str(folder), "--seconds", "0.4"]) == 0
    assert "10 frames" in " ".join(capsys.readouterr().out.split())  # a long path breaks the line
    path = folder / "animation.gif"
    with Image.open(path) as image:
        assert (image.n_frames, image.info["duration"], image.info["loop"]) == (10, 40, 0)
        assert image.size[0] == 640
        first = np.asarray(image.convert("RGB"))
        image.seek(5)
        assert (np.asarray(image.convert("RGB")) != first).any()
    assert path.stat().st_size < 0.2e6  # 100 frames are below 2 MB


def test_a_part_of_a_run(folder, tmp_path, capsys):
    words = ["animate", str(folder), "--seconds", "0.1", "--from", "0.01", "--to", "20 ms"]
    assert main([*words, "--out", str(tmp_path / "part.gif")]) == 0
    with Image.open(tmp_path / "part.gif") as image:
        assert image.n_frames == 2
    assert main([*words[:-4], "--from", "3", "--out", str(tmp_path / "none.gif")]) == 2
    assert "leave nothing of" in capsys.readouterr().err
    assert not (tmp_path / "none.gif").exists()


def test_mp4_without_ffmpeg_is_refused_in_one_line(folder, tmp_path, capsys, monkeypatch):
    monkeypatch.setitem(mpl.rcParams, "animation.ffmpeg_path", str(tmp_path / "nothing"))
    assert main(["animate", str(folder), "--format", "mp4"]) == 2
    error = capsys.readouterr().err
    assert error == "error: --format: mp4: needs ffmpeg, which is not found; install it, or give --format gif\n"
    assert not (folder / "animation.mp4").exists()


@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="writes through ffmpeg")
def test_an_mp4_file(folder):
    assert main(["animate", str(folder), "--format", "mp4", "--seconds", "0.4"]) == 0
    assert (folder / "animation.mp4").read_bytes()[4:8] == b"ftyp"


@pytest.mark.parametrize(
    ("words", "said"),
    [(["--seconds", "0"], "must be above 0"), (["--seconds", "1e9"], "at most 120"), (["--format", "avi"], "invalid")],
)
def test_wrong_animations_are_refused_in_one_line(folder, words, said, capsys):
    assert main(["animate", str(folder), *words]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert said in error


def test_a_folder_without_a_run_is_refused(tmp_path, capsys):
    assert main(["animate", str(tmp_path)]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_a_film_of_a_periodic_motion_begins_again_without_a_jump(tmp_path):
    """The run lasts two and a half revolutions: the film shows the last one, and closes its loop."""
    words = "simulate four_bar_dry.toml --no-plots --no-animation --no-error-estimate --quiet"
    system = linkages.load(linkages.find_file("four_bar_dry.toml"))
    ideal = [word for name in system.play for word in ("--set", f'joints.{name}={{model = "ideal"}}')]
    period = 2.0 * np.pi / abs(system.drives["O"].speed)
    assert main([*words.split(), *ideal, "--duration", str(2.5 * period), "--out", str(tmp_path / "out")]) == 0
    assert main(["animate", str(tmp_path / "out"), "--seconds", "0.8"]) == 0
    with Image.open(tmp_path / "out" / "animation.gif") as image:
        frames = []
        for k in range(image.n_frames):
            image.seek(k)
            frames.append(np.asarray(image.convert("L"), dtype=float)[: image.size[1] // 2])  # without the curve
    assert len(frames) == 20
    steps = [np.abs(after - before).mean() for before, after in pairwise([*frames, frames[0]])]
    assert steps[-1] < 1.5 * max(steps[:-1])


def test_a_magnified_journal_touches_its_wall_when_the_contact_is_closed():
    """The clearance is 0.4 of the view's radius, and the journal's radius the rest."""
    system = linkages.load(linkages.find_file("seven_bar_dry.toml"), {"duration": 0.05})
    run = linkages.simulate(system)
    scene = Scene(draw(system), system, run, np.linspace(0.0, 0.05, 60))
    assert {view.name for view in scene.views} == {"A", "B"}
    for view in scene.views:
        for k in range(60):
            disc = view.at(k)[0]
            reach = np.hypot(*disc.center) + disc.radius
            assert (reach >= 1.0 - 1e-9) == bool(view.frames.touching[k])
            assert reach < 1.02


def test_a_large_gif_has_fewer_frames_that_last_longer(folder, tmp_path, monkeypatch):
    sizes = {}
    for most in (2_000_000, 60_000):
        monkeypatch.setattr(moving, "_BYTES", most)
        assert main(["animate", str(folder), "--seconds", "0.4", "--out", str(tmp_path / f"{most}.gif")]) == 0
        path = tmp_path / f"{most}.gif"
        with Image.open(path) as image:
            lasts = [image.seek(k) or image.info["duration"] for k in range(image.n_frames)]
        assert sum(lasts) == 400
        sizes[most] = len(lasts)
        assert path.stat().st_size <= most or len(lasts) == 2
    assert sizes[60_000] < sizes[2_000_000] == 10
