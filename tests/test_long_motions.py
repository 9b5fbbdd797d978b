"""Ideal motions that are long, fast or small: each is sampled densely enough, or refused with the true reason."""

import re

import numpy as np
import pytest
from machines import bar, four_bar, joint, model, solid

from linkages import IdealMotion, InputError, Status, assess, ideal, load_trajectory, summarize
from linkages.cli.main import main
from linkages.system import ideal_motion

CRANK_ROCKER = four_bar(0.3, 0.1, 0.25, 0.2)
TURN = 2.0 * np.pi / 10.0


#: Drives at 10 rad/s: with a vanishing acceleration, and at a constant speed, whose revolutions are equal.
FOLLOWED, EQUAL = "formula = '10*t + 1e-30*t**2'", "speed = 10.0"


@pytest.mark.parametrize(
    ("drive", "duration", "most"),
    [(FOLLOWED, 2001.0, "3183: give 2000 s"), (EQUAL, 125664.0, "31831 equal ones: give 2e+04 s")],
)
def test_a_motion_of_too_many_revolutions_is_refused_before_it_is_run(system_of, drive, duration, most):
    system = system_of(CRANK_ROCKER, f"duration = {duration}\n[drives.O]\n{drive}\n")
    found = f"{duration * 10.0 / (2.0 * np.pi):.0f} revolutions"
    reason = rf"duration: is {found} .* at most {re.escape(most)} or less"
    for ask in (ideal, lambda one: assess(one, "compiled")):
        with pytest.raises(InputError, match=reason):
            ask(system)


def test_the_command_line_says_that_a_motion_is_too_long(experiment_file, tmp_path, capsys):
    file = experiment_file(CRANK_ROCKER, "duration = 1e6\n[drives.O]\nspeed = 10.0\n")
    out = tmp_path / "out"
    assert main(["simulate", str(file), "--engine", "compiled", "--out", str(out)]) == 2
    assert "experiment.toml: duration: is 1591549 revolutions" in capsys.readouterr().err
    assert not out.exists()


def test_one_revolution_gives_the_ideal_motion_of_five_thousand(system_of):
    """The needle bar of a sewing machine at 5,000 r/min for a minute: r w^2 (1 + r/l) at the outer dead centre."""
    r, rod, speed = 0.0155, 0.0655, 5000.0 * np.pi / 30.0
    body = (
        bar("crank", r, "__model__")
        + bar("rod", rod, "crank_tip")
        + solid("needle", 0.05, 1e-5, f"{r + rod} 0 0 0 0 0")
    )
    body += joint("O", "world", "crank") + joint("A", "crank_tip", "rod") + joint("B", "rod_tip", "needle")
    body += joint("guide", "world", "needle", "prismatic", "1 0 0")
    text = f"duration = 60.0\noutputs = ['needle.x', 'needle.ax']\n[drives.O]\nspeed = {speed}\n"
    motion = ideal(system_of(model("sewing", body), text))
    assert motion.status is Status.OK
    assert motion.time[-1] == 60.0
    assert -motion["needle.ax"].min() == pytest.approx(r * speed**2 * (1.0 + r / rod), rel=1e-9)
    times = 60.0 - np.linspace(0.0, 0.012, 20)
    angle = speed * times
    place = r * np.cos(angle) + np.sqrt(rod**2 - (r * np.sin(angle)) ** 2)
    np.testing.assert_allclose(motion.evaluate(times)["needle.x"], place, atol=1e-11)


def test_a_long_motion_has_the_extremes_of_one_revolution(system_of, monkeypatch):
    """With fewer positions a motion is long sooner; omega of the rocker at the dead centres' sides is known from one turn."""
    turn = 2.0 * np.pi / 10.0
    once = ideal(system_of(CRANK_ROCKER, f"duration = {turn}\n[drives.O]\nspeed = 10.0\n"))["follower.omega"]
    monkeypatch.setattr(ideal_motion, "_MANY", 2000)
    long = ideal(system_of(CRANK_ROCKER, f"duration = {31.0 * turn}\n[drives.O]\nspeed = 10.0\n"))
    assert len(long.time) == 31 * 65 + 1
    assert long.status is Status.OK
    np.testing.assert_allclose(long["follower.omega"].min(), once.min(), rtol=1e-3)
    np.testing.assert_allclose(long["follower.omega"].max(), once.max(), rtol=1e-3)
    with pytest.raises(InputError, match="is 32 revolutions"):
        IdealMotion(system_of(CRANK_ROCKER, f"duration = {32.0 * turn}\n[drives.O]\n{FOLLOWED}\n"))


@pytest.mark.parametrize("speed", [10.0, -10.0])
@pytest.mark.parametrize("turns", [31.0, 30.4])
def test_a_long_motion_at_constant_speed_repeats_its_first_turn(system_of, monkeypatch, speed, turns):
    """A drive with a vanishing acceleration is followed all the way."""
    monkeypatch.setattr(ideal_motion, "_MANY", 2000)
    end = turns * TURN
    motion = IdealMotion(system_of(CRANK_ROCKER, f"duration = {end}\n[drives.O]\nspeed = {speed}\n"))
    followed = IdealMotion(
        system_of(CRANK_ROCKER, f'duration = {end}\n[drives.O]\nformula = "{speed}*t + 1e-30*t**2"\n')
    )
    assert motion.times[-1] == followed.times[-1] == pytest.approx(end)
    times = np.array([0.0, 0.37, 7.7, 15.31, 25.02]) * TURN
    for found, expected in zip(motion.states(times), followed.states(times), strict=True):
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9)
    near = np.clip(np.searchsorted(motion.times, times), 0, len(motion.times) - 1)
    stored = np.append(motion.times[near], end)  # whose positions are known, but for the last one
    for at in (stored[:-1], stored):
        for found, expected in zip(motion.states(at), followed.states(at), strict=True):
            np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9)
    assert len(motion.q) < 70  # of one turn, without the other thirty


@pytest.mark.parametrize("start", ["sin", "cos"])
def test_small_oscillations_are_sampled_one_by_one(system_of, start):
    """120 oscillations by a milliradian: the way is short, and times spaced evenly can keep pace with them."""
    sdf = model("arm", bar("arm", 0.1, "__model__") + joint("O", "world", "arm"))
    system = system_of(sdf, f'duration = 1.0\n[drives.O]\nformula = "0.001*{start}(2*pi*120*t)"\n')
    assert system.drive_rate == pytest.approx(0.001 * 2.0 * np.pi * 120.0, rel=1e-3)
    angle = ideal(system)["q.O"]
    np.testing.assert_allclose([angle.min(), angle.max()], [-1e-3, 1e-3], rtol=1e-3)


def test_a_motion_that_starts_beside_a_dead_point_is_followed(system_of):
    """The crank's angle grows with the root of the slider's way; the law of cosines gives it at the end."""
    crank, rod, way = 0.05, 0.12, 0.03
    body = f"""
{bar("crank", crank, "__model__", 1e-5)}{bar("rod", rod, "crank_tip", -(1.0 + crank / rod) * 1e-5)}
{solid("slider", 0.14, 1e-4, f"{crank + rod - 3.5e-12} 0 0 0 0 0")}
{joint("O", "world", "crank")}{joint("A", "crank_tip", "rod")}
{joint("B", "rod_tip", "slider")}{joint("guide", "world", "slider", "prismatic", "1 0 0")}"""
    system = system_of(model("slider_crank", body), f"duration = 1.0\n[drives.guide]\nspeed = {-way}\n")
    motion = ideal(system)
    assert motion.status is Status.OK
    x = crank + rod - way
    exact = np.arccos((crank**2 + x**2 - rod**2) / (2.0 * crank * x))
    assert motion["crank.angle"][-1] == pytest.approx(exact, abs=1e-9)


DRIVEN = "[drives.O]\nspeed = 10.0\n"


@pytest.fixture
def long(system_of):
    """A run of 120 revolutions."""
    return assess(system_of(CRANK_ROCKER, f"duration = {120.0 * TURN}\n{DRIVEN}"))


def test_the_first_cycles_of_a_long_run_estimate_its_errors(system_of, long):
    """The exact motion gives the true errors; a run of these cycles alone has the same estimates."""
    summary = summarize(long)
    assert long.tighter.time[-1] == pytest.approx(20.0 * TURN) == pytest.approx(summary["error_until"])
    short = summarize(assess(system_of(CRANK_ROCKER, f"duration = {20.0 * TURN}\n{DRIVEN}")))
    assert short["error_until"] is None
    steady = summary["windows"]["steady"]
    for name in summary["joints"]:
        key = f"{name}.force.peak"
        true = steady["joints"][name]["force"]["peak"] - steady["ideal"]["joints"][name]["force"]["peak"]
        for numbers in (summary, steady):
            assert abs(true) < numbers["error"][key]
        assert steady["error"][key] == pytest.approx(short["windows"]["steady"]["error"][key], rel=0.5)
    assert summary["error"].keys() == short["error"].keys()


def test_a_window_late_in_a_long_run_has_the_errors_of_an_earlier_one(system_of):
    late = f"[windows.late]\nstart = {100.3 * TURN}\nend = {101.1 * TURN}\n"
    most = f"[windows.most]\nstart = {0.5 * TURN}\nend = {119.0 * TURN}\n"
    found = assess(system_of(CRANK_ROCKER, f"duration = {120.0 * TURN}\n{DRIVEN}{late}{most}"))
    assert found.repeating.earlier(100.3 * TURN, 101.1 * TURN) == pytest.approx((18.3 * TURN, 19.1 * TURN))
    windows = summarize(found)["windows"]
    assert None not in {*windows["late"]["error"].values(), *windows["most"]["error"].values()}


def test_figures_of_a_long_run_show_its_last_cycles(long):
    shown = long.latest()
    for motion in (shown.run, shown.ideal):
        assert motion.time[[0, -1]] == pytest.approx([100.0 * TURN, 120.0 * TURN])


def test_a_compressed_trajectory_is_smaller_and_the_same(long, tmp_path):
    for name, compress in (("plain", False), ("small", True)):
        long.ideal.save(tmp_path / name, compress)
    assert (tmp_path / "small").stat().st_size < 0.9 * (tmp_path / "plain").stat().st_size
    for name in ("plain", "small"):
        loaded = load_trajectory(tmp_path / name)
        assert all((loaded[column] == long.ideal[column]).all() for column in long.ideal)
