"""No run is ok with an open loop: poses that cannot be left, dead points, and the check of every run."""

import numpy as np
import pytest
from machines import bar, four_bar, joint, model, solid

from linkages import AssemblyError, Status, ideal, simulate, simulate_batch
from linkages.results.trajectory import Loops, sample

TURN = "duration = 0.01\n[drives.O]\nspeed = 1.0\n"
PUSH = "duration = 0.01\n[drives.O]\ntorque = 0.1\n"
FALL = "duration = 0.01\ngravity = [0.0, -9.81, 0.0]\n"


def point_coupler(crank=0.1, follower=0.35) -> str:
    """Crank and follower in line, joined by a coupler without length: its spin is the only motion."""
    body = f"""
<frame name="pivot" attached_to="world"><pose relative_to="__model__">{crank + follower} 0 0 0 0 0</pose></frame>
{bar("crank", crank, "__model__")}{bar("follower", follower, "pivot", np.pi)}
{solid("coupler", 0.1, 1e-4, at="crank_tip")}
{joint("O", "world", "crank")}{joint("A", "crank_tip", "coupler")}{joint("Q", "world", "follower")}
{joint("B", "coupler", "follower_tip")}"""
    return model("point_coupler", body)


def drawn_slider_crank(angle, crank=0.05, rod=0.12):
    """In-line slider-crank drawn at a crank angle, and the way of its slider from there to where it is stretched."""
    x, y = crank * np.cos(angle), crank * np.sin(angle)
    at = x + np.sqrt(rod**2 - y**2)
    body = f"""
{bar("crank", crank, "__model__", angle)}{bar("rod", rod, "crank_tip", np.arctan2(-y, at - x) - angle)}
{solid("slider", 0.14, 1e-4, f"{at} 0 0 0 0 0")}
{joint("O", "world", "crank")}{joint("A", "crank_tip", "rod")}
{joint("B", "rod_tip", "slider")}{joint("guide", "world", "slider", "prismatic", "1 0 0")}"""
    return model("slider_crank", body), crank + rod - at


@pytest.mark.parametrize("done", [TURN, PUSH, FALL])
@pytest.mark.parametrize("sdf", [four_bar(0.4, 0.1, 0.2, 0.1), point_coupler()], ids=["stretched", "point coupler"])
def test_a_pose_that_the_links_cannot_leave_is_locked(system_of, sdf, done):
    """Sum of the moving lengths = ground: one position only, although two infinitesimal motions seem possible."""
    with pytest.raises(AssemblyError, match="just long enough to close the loops") as caught:
        _ = system_of(sdf, done).assembly
    assert caught.value.status is Status.LOCKED


def test_a_rod_as_long_as_the_distance_of_its_rails_lets_both_sliders_move(system_of):
    """Both slide together at every position, while the rod cannot turn: it is redundant, but nothing is immobile."""
    sliders = solid("one", 0.1, 1e-4) + solid("two", 0.1, 1e-4, "0 0.3 0 0 0 0") + bar("rod", 0.3, "one", np.pi / 2)
    rails = joint("G", "world", "one", "prismatic", "1 0 0") + joint("H", "world", "two", "prismatic", "1 0 0")
    sdf = model("rails", sliders + rails + joint("A", "one", "rod") + joint("B", "rod_tip", "two"))
    with pytest.raises(AssemblyError, match="just long enough to close the loops") as caught:
        _ = system_of(sdf, "duration = 0.01\n[drives.G]\nspeed = 0.05\n").assembly
    assert "A cannot move" in str(caught.value)
    assert not any(word in str(caught.value) for word in ("immobile", " G ", " H "))


@pytest.mark.parametrize("short", [0.0, 1e-13])
@pytest.mark.parametrize("angle", [0.1, 1.0, 2.0])
def test_a_slider_driven_from_its_dead_point_is_singular(system_of, angle, short):
    """At r + l the crank's speed has no bound; Newton's method finds such a position to the root of its tolerance."""
    sdf, way = drawn_slider_crank(angle)
    done = f"duration = 0.01\n[drives.guide]\nspeed = -0.01\nangle = {float(way - short)!r}\n"
    with pytest.raises(AssemblyError, match="the start position is singular"):
        _ = system_of(sdf, done).assembly


def test_a_crank_that_reaches_its_dead_point_ends_there_locked(engine, system_of):
    """Ground a nanometre short of stretched: by the law of cosines the crank turns by 1.2e-4 rad at most."""
    ground, crank, rest = 0.4 - 1e-9, 0.1, 0.3
    most = np.arccos((ground**2 + crank**2 - rest**2) / (2.0 * ground * crank))
    system = system_of(four_bar(ground, crank, 0.2, 0.1), TURN)
    for motion in (simulate(system, engine), ideal(system)):
        assert motion.status is Status.LOCKED
        assert 0.9 * most < motion.time[-1] < 1.05 * most
        assert motion.provenance["loop_error"] < 1e-8


def test_a_batch_has_no_numbers_of_runs_beyond_a_dead_point(system_of):
    batch = simulate_batch(system_of(four_bar(0.4 - 1e-9, 0.1, 0.2, 0.1), TURN), outputs=["O.torque"])
    assert batch.status == [Status.LOCKED]
    assert np.isnan(batch.peak).all()


def test_a_run_whose_loop_comes_apart_ends_before(engine, system_of):
    """As above with a free pendulum: the drive does not determine the motion, so that no dead point is known."""
    pendulum = bar("pendulum", 0.1, "__model__", -1.0) + joint("P", "world", "pendulum")
    found = simulate(system_of(four_bar(0.4 - 1e-9, 0.1, 0.2, 0.1, extra=pendulum), TURN), engine)
    assert found.status is (Status.LOOP_OPEN if engine == "compiled" else Status.STEP_SIZE_COLLAPSE)
    assert found.time[-1] < 0.01
    pin = [found[f"coupler_tip.{axis}"] - found[f"B_on_follower.{axis}"] for axis in "xy"]
    assert np.hypot(*pin).max() < 1e-6 * 0.4


@pytest.mark.parametrize(("gap", "status"), [(2e-6, Status.LOOP_OPEN), (1e-7, Status.OK)])
def test_a_trajectory_ends_before_its_first_open_loop(system_of, gap, status):
    """The follower's coordinate is moved until the pin that it carries is open by a share of the linkage's size."""
    system = system_of(four_bar(), TURN)
    tree = system.tree
    exact = ideal(system)

    def evaluate(times):
        columns = exact.evaluate(times)
        turned = columns["q.Q"] + np.where(times > 0.005, gap * tree.extent / 0.2, 0.0)
        return columns | {"q.Q": turned}

    found = sample(exact.time, evaluate, Status.OK, {}, Loops(tree, tree.closure_rows))
    assert found.status is status
    assert (found.time[-1] <= 0.005) == (status is Status.LOOP_OPEN)
    assert found.provenance["loop_error"] < 1e-6 * tree.extent
