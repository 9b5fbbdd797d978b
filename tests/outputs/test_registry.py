"""The registry of outputs: every name that it offers is given by both engines and by batches, no other is accepted."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from measures import scales, worst
from scipy.integrate import trapezoid
from shipped import NAMES, points, run_compiled, shipped

import linkages
from linkages import InputError, Status
from linkages.results.outputs import registry
from linkages.results.outputs.columns import columns


def fine(times):
    """Times with each step divided by four."""
    parts = times[:-1, None] + np.diff(times)[:, None] * np.arange(4) / 4
    return np.unique(np.append(parts.ravel(), times[-1]))


# --- all listed outputs can be computed -----------------------------------------------------------------------------------------


def test_a_run_gives_every_name(system):
    names = registry.names(system)
    assert len(set(names)) == len(names)
    assert set(run_compiled(system).columns) == {"time", *names}


def test_a_batch_gives_the_extremes_of_every_name(system):
    """They are values of the run at their times, and no value of a finer grid lies beyond them.

    Where friction reverses, forces have peaks of nanoseconds, which a search finds to some 1e-5.
    """
    names, result = registry.names(system), run_compiled(system)
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
    low = linkages.extremes(run_compiled(system), ["A.ey"])["A.ey"].min
    assert batch.minimum[0, 0, 0] == pytest.approx(low, rel=1e-3)


def test_a_batch_gives_the_mean_and_rms_of_every_name(system):
    """They come from parabolas through the run's steps: against a grid four times finer, with steps that are short."""
    system = system.replaced({"solver.max_step": 1e-3 * system.experiment.duration})
    names, result, duration = registry.names(system), run_compiled(system), system.experiment.duration
    batch = linkages.simulate_batch(system, outputs=names)
    times = fine(result.time)
    found, scale = result.evaluate(times), scales(result.columns)
    for k, name in enumerate(names):
        mean, square = (trapezoid(y, times) / duration for y in (found[name], found[name] ** 2))
        near = 1e-4 * scale[name]
        assert batch.mean[0, 0, k] == pytest.approx(mean, rel=0.0, abs=near), name
        assert batch.rms[0, 0, k] == pytest.approx(np.sqrt(square), rel=0.0, abs=near), name


QUICK = ("seven_bar", "slider_crank_dry", "slider_crank_guide", "six_bar_dry")


@pytest.mark.parametrize(
    "name", [*QUICK, *(pytest.param(name, marks=pytest.mark.slow) for name in [*NAMES, "loaded"] if name not in QUICK)]
)
def test_drake_gives_every_name_and_the_same_values(name, system_named):
    system = system_named(name)
    changes = {"solver.max_step": 5e-6} if system.touching.any() else {}
    theirs = linkages.simulate(system.replaced(changes), "drake")
    assert theirs.status is Status.OK
    assert theirs.columns.keys() == run_compiled(system).columns.keys()
    times = np.linspace(0.0, system.experiment.duration, 101)
    column, difference = worst(theirs.evaluate(times), run_compiled(system).evaluate(times))
    assert difference < (1e-5 if system.touching.any() else 1e-6), column


def test_the_ideal_linkage_gives_every_ideal_name(system):
    names = registry.names(system, ideal=True)
    real = [name for name in registry.names(system) if name not in names]  # outputs of clearances and flanks
    assert bool(real) == bool(system.experiment.play or system.experiment.loose)
    motion = linkages.ideal(system, "compiled")
    if system.determinate:
        assert set(motion.columns) == {"time", *names}
    else:  # a separate run, with other coordinates
        assert set(motion.columns) == {"time", *registry.names(system.ideal())}
    for name in names:
        registry.check_output(system, f"ideal.{name}")
        assert registry.unit(system, f"ideal.{name}") == registry.unit(system, name)
    for joint in system.mechanism.joint:
        registry.check_output(system, f"ideal.{joint}.turning_rate")
        assert registry.unit(system, f"ideal.{joint}.turning_rate") == "rad/s"


UNITS = {"1", "m", "m/s", "m/s2", "rad", "rad/s", "rad/s2", "N", "N m", "W", "J", "m3/s"}


def test_every_name_has_a_unit(system):
    for name in registry.names(system):
        assert registry.unit(system, name) in UNITS, name
    for name in points(system):
        assert registry.unit(system, f"{name}.jitter") == registry.unit(system, name)


# --- unlisted outputs are rejected -----------------------------------------------------------------------------------


def refusals(system, name):
    """The messages about a name, from all functions that take names."""
    result = run_compiled(system)
    states = result.evaluate.function.runner.evaluate(result.evaluate.function.steps, result.time[:1])
    for ask in (
        lambda: registry.check_output(system, name),
        lambda: registry.pack(system, [name]),
        lambda: registry.unit(system, name),
        lambda: columns(system, result.time[:1], *states, names=[name]),
        lambda: linkages.simulate_batch(system, outputs=[name]),
        lambda: linkages.stroboscopic(system, [name], revolutions=1),
    ):
        with pytest.raises(InputError) as caught:
            ask()
        yield str(caught.value)


NONSENSE = ("", ".", "force", "B", "B.", ".force", "B.forse", "b.force", "nothing.x", "q.B", "q.", "time", "B.force.x")


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
