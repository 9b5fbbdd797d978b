"""The registry of outputs: every name it offers is given by both engines, and means the same wherever it is asked for."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from machines import four_bar
from measures import scales, worst
from newton_euler import free_bodies
from shipped import NAMES, shipped

import linkages
from linkages import InputError, Status
from linkages.explore.flow import Flow
from linkages.outputs import registry
from linkages.outputs.columns import columns

#: Seconds until the first contact is over, or of smooth motion: both engines have one solution there.
DURATION = {
    "seven_bar": 0.1,
    "seven_bar_rig": 0.1,
    "slider_crank_lubricated": 0.002,
    "four_bar_dry": 0.004,
    "five_bar_dry": 0.0014,
    "six_bar_dry": 0.005,
    "seven_bar_dry": 0.0125,
    "slider_crank_dry": 0.0006,
    "slider_crank_guide": 0.00115,
    "seven_bar_mixed": 0.04,
}

#: A crank-rocker with what no shipped machine has: every kind of load, a torque drive, bristles, an ideal loop.
LOADED = """duration = 0.004
gravity = [0.0, -9.81, 0.0]
[drives.O]
torque = 0.4
speed = 5.0
[joints.A]
model = "dry"
clearance = 1e-5
contact = {law = "flores", restitution = 0.5, youngs_modulus = 2e9}
friction = {law = "lugre", coefficient = 0.1, bristle_stiffness = 1e4}
[forces.P]
point = "follower_tip"
force = [2.0, -5.0]
axes = "body"
[torques.M]
link = "coupler"
times = [0.0, 0.3]
torques = [0.5, -0.2]
[springs.S]
point = "coupler_tip"
anchor = [-0.1, 0.1]
stiffness = 200.0
free_length = 0.2
damping = 3.0
[torsion_springs.T]
joint = "Q"
stiffness = 2.0
free_angle = 0.5
damping = 0.01
"""
CASES = [*NAMES, "loaded"]


@pytest.fixture(scope="session")
def system_named(tmp_path_factory):
    """Make the system of a case, tight enough for its columns to have ten digits."""
    folder = tmp_path_factory.mktemp("loaded")
    (folder / "machine.sdf").write_text(four_bar())
    (folder / "loaded.toml").write_text('mechanism = "machine.sdf"\n' + LOADED)

    @cache
    def made(name):
        changes = {"solver.accuracy": 1e-10}
        if name == "loaded":
            return linkages.load(folder / "loaded.toml", changes)
        return shipped(name, duration=DURATION[name], **changes)

    return made


@pytest.fixture(params=CASES)
def system(request, system_named):
    return system_named(request.param)


@cache
def run(system):
    """Run a system with the compiled engine."""
    result = linkages.simulate(system, "compiled")
    assert result.status is Status.OK
    return result


def points(system):
    """Names whose jitter there is."""
    named = [f"{point}." for point in system.mechanism.point]
    return [name for name in registry.names(system) if name.rpartition(".")[0] + "." in named]


def fine(times):
    """Times with each step divided by four."""
    parts = times[:-1, None] + np.diff(times)[:, None] * np.arange(4) / 4
    return np.unique(np.append(parts.ravel(), times[-1]))


# --- what is offered is given -----------------------------------------------------------------------------------------


def test_every_machine_is_asked():
    assert sorted(DURATION) == NAMES


def test_a_run_gives_every_name(system):
    names = registry.names(system)
    assert len(set(names)) == len(names)
    assert set(run(system).columns) == {"time", *names}


def test_a_batch_gives_the_extremes_of_every_name(system):
    """They are values of the run at their times, and no value of a finer grid lies beyond them.

    Where friction reverses, forces have peaks of nanoseconds, which a search finds to some 1e-5.
    """
    names, result = registry.names(system), run(system)
    batch = linkages.simulate_batch(system, outputs=names)
    assert batch.status == [Status.OK]
    found, scale = result.evaluate(fine(result.time)), scales(result.columns)
    lows, highs = (result.evaluate(at[0, 0]) for at in (batch.time_of_minimum, batch.time_of_maximum))
    for k, name in enumerate(names):
        low, high, values = batch.minimum[0, 0, k], batch.maximum[0, 0, k], found[name]
        near, beyond = 1e-6 * scale[name], (1e-4 if system.touching.any() else 1e-6) * scale[name]
        assert low == pytest.approx(lows[name][k], rel=0.0, abs=near), name
        assert high == pytest.approx(highs[name][k], rel=0.0, abs=near), name
        assert low <= values.min() + beyond, name
        assert high >= values.max() - beyond, name


def test_a_batch_finds_an_extreme_within_the_last_step():
    """As `linkages.extremes` does: a long step of free flight, in which a journal's place turns."""
    system = shipped("seven_bar_dry", duration=0.01, **{"solver.accuracy": 1e-10})
    batch = linkages.simulate_batch(system, outputs=["A.ey"])
    low = linkages.extremes(run(system), ["A.ey"])["A.ey"].min
    assert batch.minimum[0, 0, 0] == pytest.approx(low, rel=1e-3)


def test_a_batch_gives_the_mean_and_rms_of_every_name(system):
    """They come from parabolas through the run's steps: against a grid four times finer, with steps that are short."""
    system = system.replaced({"solver.max_step": 1e-3 * system.experiment.duration})
    names, result, duration = registry.names(system), run(system), system.experiment.duration
    batch = linkages.simulate_batch(system, outputs=names)
    times = fine(result.time)
    found, scale = result.evaluate(times), scales(result.columns)
    for k, name in enumerate(names):
        mean, square = (np.trapezoid(y, times) / duration for y in (found[name], found[name] ** 2))
        near = 1e-4 * scale[name]
        assert batch.mean[0, 0, k] == pytest.approx(mean, rel=0.0, abs=near), name
        assert batch.rms[0, 0, k] == pytest.approx(np.sqrt(square), rel=0.0, abs=near), name


QUICK = ("seven_bar", "slider_crank_dry", "slider_crank_guide", "six_bar_dry")


@pytest.mark.parametrize(
    "name", [*QUICK, *(pytest.param(name, marks=pytest.mark.slow) for name in CASES if name not in QUICK)]
)
def test_drake_gives_every_name_and_the_same_values(name, system_named):
    system = system_named(name)
    changes = {"solver.max_step": 5e-6} if system.touching.any() else {}
    theirs = linkages.simulate(system.replaced(changes), "drake")
    assert theirs.status is Status.OK
    assert theirs.columns.keys() == run(system).columns.keys()
    times = np.linspace(0.0, system.experiment.duration, 101)
    column, difference = worst(theirs.evaluate(times), run(system).evaluate(times))
    assert difference < (1e-5 if system.touching.any() else 1e-6), column


def test_the_ideal_linkage_gives_every_ideal_name(system):
    names = registry.names(system, ideal=True)
    assert {name for name in registry.names(system) if name not in names} != set()  # those of play
    motion = linkages.ideal(system, "compiled")
    if system.determinate:
        assert set(motion.columns) == {"time", *names}
    else:  # a run of its own, with coordinates of its own
        assert set(motion.columns) == {"time", *registry.names(system.ideal())}
    for name in names:
        registry.check_output(system, f"ideal.{name}")
        assert registry.unit(system, f"ideal.{name}") == registry.unit(system, name)
    for joint in system.mechanism.joint:
        registry.check_output(system, f"ideal.{joint}.turning_rate")
        assert registry.unit(system, f"ideal.{joint}.turning_rate") == "rad/s"


UNITS = {"1", "m", "m/s", "m/s2", "rad", "rad/s", "rad/s2", "N", "N m", "W", "J"}


def test_every_name_has_a_unit(system):
    for name in registry.names(system):
        assert registry.unit(system, name) in UNITS, name
    for name in points(system):
        assert registry.unit(system, f"{name}.jitter") == registry.unit(system, name)


# --- what is not offered is refused -----------------------------------------------------------------------------------


def refusals(system, name):
    """What is said to a name, by everything that takes names."""
    result = run(system)
    states = result.evaluate.runner.evaluate(result.evaluate.steps, result.time[:1])
    for ask in (
        lambda: registry.check_output(system, name),
        lambda: registry.pack(system, [name]),
        lambda: registry.unit(system, name),
        lambda: columns(system, result.time[:1], *states, names=[name]),
        lambda: linkages.simulate_batch(system, outputs=[name]),
        lambda: Flow(system).check_names([name]),
    ):
        with pytest.raises(InputError) as caught:
            ask()
        yield str(caught.value)


NONSENSE = (
    "",
    ".",
    "force",
    "B",
    "B.",
    ".force",
    "B.forse",
    "b.force",
    "nothing.x",
    "q.B",
    "q.",
    "time",
    "B.force.x",
)


@pytest.mark.parametrize("name", NONSENSE)
def test_nonsense_is_refused_everywhere_in_the_same_words(name):
    system = shipped("slider_crank_dry", duration=1e-4)
    said = set(refusals(system, name))
    assert len(said) == 1
    assert f'slider_crank_dry.toml: output "{name}": is unknown' in said.pop()


@given(st.text(alphabet="ABOqxyf.orce", max_size=12))
def test_a_name_is_offered_or_refused(name):
    system = shipped("slider_crank_dry", duration=1e-4)
    if name in registry.names(system):
        registry.check_output(system, name)
    else:
        with pytest.raises(InputError, match="is unknown"):
            registry.check_output(system, name)


def test_contacts_have_what_their_laws_give():
    """No penetration of a journal that cannot touch, no film thickness without a film."""
    film, dry = registry.names(shipped("seven_bar")), registry.names(shipped("seven_bar_dry"))
    assert "A.film_thickness" in film
    assert "A.penetration" in dry
    assert not {"A.penetration", "A.closing", "A.sliding"} & {*film}
    assert "A.film_thickness" not in dry
    assert {"A.film_thickness", "A.penetration"} <= {*registry.names(shipped("seven_bar_mixed"))}


# --- what they mean ---------------------------------------------------------------------------------------------------


def test_jitter_is_the_run_less_the_ideal_motion(system):
    """Of every point, over continuous time, in batches."""
    names = [f"{name}.jitter" for name in points(system)]
    if not system.determinate:
        with pytest.raises(InputError, match="do not determine an ideal motion"):
            linkages.simulate_batch(system, outputs=names)
        return
    batch = linkages.simulate_batch(system, outputs=names)
    result, exact = run(system), linkages.ideal(system)
    scale = scales(result.columns)
    for when, extreme in (
        (batch.time_of_minimum, batch.minimum),
        (batch.time_of_maximum, batch.maximum),
    ):
        real, still = result.evaluate(when[0, 0]), exact.evaluate(when[0, 0])
        for k, name in enumerate(points(system)):
            deviation = pytest.approx(real[name][k] - still[name][k], rel=0.0, abs=1e-8 * scale[name])
            assert extreme[0, 0, k] == deviation, name


def test_jitter_is_the_run_less_the_ideal_motion_in_sections_and_in_batches():
    """Peaks: of one revolution over continuous time, by a section and by the batch's own statistics."""
    name = "slider.vx"
    system = shipped("slider_crank_dry")
    section = linkages.stroboscopic(system, [name, f"{name}.jitter"], revolutions=1)
    ideal = linkages.ideal(system).evaluate(section.times)[name]
    np.testing.assert_allclose(section.strobe[f"{name}.jitter"], section.strobe[name] - ideal, rtol=1e-12)
    batch = linkages.simulate_batch(system, outputs=[f"{name}.jitter"], windows=[[0.0, section.period]])
    assert section.peaks(f"{name}.jitter")[0] == pytest.approx(batch.peak[0, 0, 0], rel=1e-6)
    assert batch.peak[0, 0, 0] > 0.1  # m/s: the linkage does rattle


def forces_agree(system, found, expected):
    """Compare columns with the oracle's forces, moments and drive forces, to round-off."""
    force, moment, drive = expected
    largest = max(np.abs(values).max() for values in force.values())
    atol = 1e-9 * largest * system.tree.extent
    for name in system.mechanism.joint:
        got = np.stack([found[f"{name}.fx"], found[f"{name}.fy"]], axis=1)
        np.testing.assert_allclose(got, force[name], rtol=0, atol=1e-9 * largest, err_msg=name)
        np.testing.assert_allclose(found[f"{name}.moment"], moment[name], rtol=0, atol=atol, err_msg=name)
    for name, values in drive.items():
        np.testing.assert_allclose(found[f"{name}.torque"], values, rtol=0, atol=atol, err_msg=name)


def test_forces_of_a_run_are_those_of_free_bodies(system):
    """Newton and Euler for each body by itself, in absolute coordinates."""
    replay = run(system).evaluate
    times = np.linspace(0.0, system.experiment.duration, 51)
    states = replay.runner.evaluate(replay.steps, times)
    forces_agree(system, columns(system, times, *states), free_bodies(system, times, *states))


def test_forces_of_the_ideal_linkage_are_those_of_free_bodies(system):
    """Over the whole of the shipped experiment's motion."""
    if not system.determinate:
        system = system.ideal()
        replay = run(system).evaluate
        times = np.linspace(0.0, system.experiment.duration, 51)
        *states, _ = replay.runner.evaluate(replay.steps, times)
    else:
        motion = linkages.IdealMotion(system.replaced({"duration": shipped_duration(system)}))
        times = np.linspace(0.0, motion.times[-1], 51)
        states = motion.states(times)
    forces_agree(system, columns(system, times, *states), free_bodies(system, times, *states))


def shipped_duration(system):
    return linkages.load(system.experiment.source).experiment.duration


def test_columns_do_not_depend_on_the_tree(seven_bar):
    """The same state described by two spanning trees gives the same columns."""
    other = seven_bar.ideal()
    assert seven_bar.tree.coordinates != other.tree.coordinates
    one, two = (
        columns(each, np.zeros(1), each.assembly.q[None], each.assembly.v[None], 0 * each.assembly.v[None])
        for each in (seven_bar, other)
    )
    for name in ("kinetic_energy", "slider7.vx", "link3.y", "link6.omega"):
        assert one[name][0] == pytest.approx(two[name][0], abs=1e-12)
