"""Means of short forces: the impulse of a falling ball, and values within steps where the samples are too few."""

import numpy as np
import pytest

import linkages
from linkages.mechanics.integrate.peak_search import add_middles, doubtful, integrate_samples

BALL = """<sdf version="1.9" xmlns:linkages="urn:linkages:sdf">
  <model name="ball">
    <link name="ball"><inertial><mass>2.0</mass><inertia><ixx>1e-3</ixx><iyy>1e-3</iyy><izz>1e-3</izz></inertia>
    </inertial></link>
    <joint name="J" type="revolute"><parent>world</parent><child>ball</child><axis><xyz>0 0 1</xyz></axis>
      <linkages:bearing><linkages:radius>0.01</linkages:radius><linkages:length>0.02</linkages:length>
      </linkages:bearing></joint>
  </model>
</sdf>
"""
FALL = """mechanism = "ball.sdf"
duration = 0.05
gravity = [0.0, -9.81, 0.0]
outputs = ["ball.y", "ball.vy"]
[joints.J]
model = "dry"
clearance = 1e-3
[joints.J.contact]
law = "lankarani-nikravesh"
restitution = 0.9
youngs_modulus = 207e9
poissons_ratio = 0.3
"""


@pytest.mark.parametrize(("accuracy", "error"), [(1e-6, 1.5e-4), (1e-8, 5e-6), (1e-10, 1e-7)])
def test_the_mean_force_of_a_bouncing_ball_is_its_change_of_momentum(tmp_path, accuracy, error):
    """The ball touches its bearing twice, for a thousandth of the time: the mean force times the time is m (dv + g t).

    By parabolas through the steps alone the error was 8e-4, 4e-5 and 9e-7.
    """
    (tmp_path / "ball.sdf").write_text(BALL)
    (tmp_path / "fall.toml").write_text(FALL)
    system = linkages.load(tmp_path / "fall.toml", {"solver.accuracy": accuracy})
    run = linkages.simulate(system)
    span = np.ptp(run.time)
    exact = 2.0 * (run["ball.vy"][-1] - run["ball.vy"][0] + 9.81 * span)
    found = linkages.integral(run, "J.fy")
    batch = linkages.simulate_batch(system, outputs=["J.fy"], windows=[[0.0, 0.05]])
    assert abs(found) == pytest.approx(exact, rel=error)
    assert batch.mean[0, 0, 0] * span == pytest.approx(found, rel=1e-14)


def marked(times, values):
    marks = np.empty(len(times) - 1, dtype=np.int64)
    doubtful(times, values, 1e-6, marks)
    return marks


def test_smooth_values_need_no_others():
    times = np.linspace(0.0, 1.0, 41)
    assert not marked(times, 1.0 + times**2).any()
    assert not marked(times, np.sin(times)).any()


def test_values_at_both_sides_of_a_kink_are_integrated_apart():
    """The integral of 4 s + s^2 + t over [0, 1], s = max(0, t - 1/2), is 1/2 + 1/24 + 1/2; parabolas across the kink miss it."""
    times = np.concatenate([np.linspace(0.0, 0.5, 6), np.linspace(0.5, 1.0, 6)[1:]])

    def curve(t):
        return 4.0 * np.maximum(0.0, t - 0.5) + np.maximum(0.0, t - 0.5) ** 2 + t

    exact, values = 0.5 + 1.0 / 24.0 + 0.5, curve(times)
    marks = marked(times, values)
    assert np.flatnonzero(marks).tolist() == [4, 5]
    more, found = np.empty((2, 4 * len(times)))
    count = add_middles(times, values, marks, curve(0.5 * (times[1:] + times[:-1])), more, found)
    assert abs(integrate_samples(times, values, False) - exact) > 1e-4
    assert integrate_samples(more[:count], found[:count], False) == pytest.approx(exact, rel=1e-14)


def test_a_middle_without_a_value_is_left_out():
    times = np.linspace(0.0, 1.0, 6)
    values, marks = times**2, np.ones(5, dtype=np.int64)
    more, found = np.empty((2, 24))
    count = add_middles(times, values, marks, np.full(5, np.nan), more, found)
    assert more[:count].tolist() == times.tolist()
    assert found[:count].tolist() == values.tolist()
