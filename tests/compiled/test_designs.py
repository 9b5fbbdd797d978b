"""Rows of a batch are single runs to the last bit, whichever way their numbers come about; their failures too."""

import math

import numpy as np
import pytest
from machines import four_bar
from shipped import shipped

from linkages import AssemblyError, InputError, Status, laws, simulate, simulate_batch
from linkages.engines.compiled.batch import designs
from linkages.engines.compiled.batch.statistics import STATISTICS

PRESS, DRY = ("seven_bar", {"duration": 0.05}), ("slider_crank_dry", {"duration": 2e-3})
#: Drive of a four-bar, and a film at its crank pin.
FILM = """[drives.O]
speed = 20.0
[joints.A]
model = "lubricated"
clearance = 1e-3
viscosity = 0.1
"""

#: Machine, values replaced in it, and limits of variables; values beyond some of the limits are not valid.
CASES = {
    "masses and oil": (*PRESS, {"sdf.links.link2.mass": (-0.05, 0.4), "joints.A.viscosity": (-0.05, 0.5)}),
    "inertia and clearance": (*PRESS, {"sdf.links.link2.inertia": (5e-4, 1e-3), "joints.A.clearance": (-1e-5, 3e-4)}),
    "lengths and speed": (*PRESS, {"sdf.frames.link2_C.pose.x": (0.1, 0.2), "drives.O1.speed": (6.0, 7.0)}),
    "accuracy and duration": (*PRESS, {"solver.accuracy": (1e-7, 1e-5), "duration": (0.04, 0.06)}),
    "two values, one condition": (
        "six_bar_dry",
        {"duration": 4e-3, "joints.C.friction.static": 0.3},
        {"joints.C.friction.static": (0.1, 0.3), "joints.C.friction.coefficient": (0.05, 0.2)},
    ),
    "contact": (*DRY, {"joints.B.contact.restitution": (0.1, 1.1), "joints.B.contact.youngs_modulus": (1e11, 3e11)}),
    "offset": (*DRY, {"joints.B.clearance": (3e-4, 6e-4), "sdf.joints.B.bearing.radius": (4e-4, 1e-2)}),
    "guide": ("slider_crank_guide", {"duration": 5e-3}, {"sdf.links.slider.mass": (0.1, 0.3)}),
    "flexible link": (
        "slider_crank_flexible",
        {"duration": 3e-3},
        {"sdf.links.rod.beam.youngs_modulus": (1e11, 2e11), "links.rod.damping": (-1e-3, 0.02)},
    ),
}
OUTPUTS = {"seven_bar": ["A.force", "slider7.ax.jitter", "O1.torque"], "slider_crank_flexible": ["rod.stress"]}


def table(limits, rows=24):
    """Values between and at the limits, one of them no number."""
    low, high = np.array(list(limits.values())).T
    values = np.random.default_rng(0).uniform(low, high, (rows, len(low)))
    values[5:7], values[7, 0] = (low, high), np.nan
    return values


def alone(system, values, outputs):
    """Status, reason, steps and statistics of one run, of a system that is built for it."""
    try:
        batch = simulate_batch(system.replaced(values), outputs=outputs)
    except InputError as problem:
        return Status.BAD_INPUT, str(problem), 0, None
    return (
        batch.status[0],
        batch.reason[0],
        batch.steps[0],
        [batch.statistics[name][0].tobytes() for name in STATISTICS],
    )


def check(system, limits, outputs):
    values = table(limits)
    batch = simulate_batch(system, list(limits), values, outputs, threads=2)
    ran = 0
    for k, row in enumerate(values):
        given = dict(zip(limits, map(float, row), strict=True))
        status, reason, steps, statistics = alone(system, given, outputs)
        if batch.reason[k] == "a window ends after the run":  # of the nominal duration
            assert given["duration"] < system.experiment.duration
            continue
        if statistics is None or status is not Status.OK:
            assert (batch.status[k], batch.reason[k], batch.steps[k]) == (status, reason, steps)
            assert all(np.isnan(batch.statistics[name][k]).all() for name in STATISTICS)
        elif "duration" not in given:
            assert [batch.statistics[name][k].tobytes() for name in STATISTICS] == statistics
            ran += 1
        if status is Status.OK:
            run = simulate(system.replaced(given), "compiled")
            assert run.provenance["steps"] == batch.steps[k] == steps
    return ran


@pytest.mark.parametrize("case", CASES)
def test_rows_are_single_runs(case):
    name, overrides, limits = CASES[case]
    ran = check(shipped(name, **overrides), limits, OUTPUTS.get(name))
    assert ran or "duration" in limits


@pytest.mark.usefixtures("own_registries")
def test_rows_with_a_law_of_the_users_own_are_single_runs():
    def viscoelastic(delta, ddelta, ddelta0, joint):
        return joint.my_stiffness * math.sqrt(delta) * (delta + 1.5 * joint.relaxation * ddelta)

    names = (("my_stiffness", "N/m^1.5"), ("relaxation", "s"))
    own = [laws.Parameter(name, unit, None, name, gt=0.0) for name, unit in names]
    laws.register_contact("viscoelastic", viscoelastic, parameters=own)
    contact = {"law": "viscoelastic", "my_stiffness": 3e8, "relaxation": 2e-7}
    system = shipped("slider_crank_dry", duration=2e-3, **{"joints.B.contact": contact})
    paths = {"joints.B.contact.my_stiffness": (1e8, 4e8), "joints.B.contact.relaxation": (-1e-8, 3e-7)}
    assert check(system, paths, ["B.force"])


def test_rows_that_fail_in_the_run_are_single_runs(system_of):
    """A journal that leaves its film, and loops that do not close."""
    system = system_of(four_bar(), f"duration = 0.2\n{FILM}")
    assert check(system, {"joints.A.viscosity": (1e-9, 0.2)}, ["A.force"])
    with pytest.raises(AssemblyError, match="no-assembly"):
        _ = system.replaced({"drives.O.angle": 30.0, "sdf.frames.coupler_tip.pose.x": 0.05}).assembly
    check(system.replaced({"drives.O.angle": 30.0}), {"sdf.frames.coupler_tip.pose.x": (0.05, 0.4)}, ["A.force"])


#: Machine and limits of lengths and other variables. The slider-crank's crank starts at an angle; the four-bar is drawn
#: at several angles.
LENGTHS = {
    "press": (*PRESS, {"sdf.frames.link2_C.pose.x": (0.17, 0.19), "joints.A.viscosity": (0.1, 0.5)}),
    "press, two coordinates of a point": (
        *PRESS,
        {"sdf.frames.link6_D.pose.x": (0.29, 0.31), "sdf.frames.link6_D.pose.y": (-0.01, 0.01)},
    ),
    "slider-crank": (
        "slider_crank_lubricated",
        {"duration": 2e-3, "drives.O.angle": 1.0, "joints.B.offset": [1e-5, 0.0]},
        {"sdf.frames.rod_B.pose.x": (0.11, 0.13), "joints.B.clearance": (3e-4, 6e-4), "sdf.links.rod.mass": (0.1, 0.3)},
    ),
    "narrow clearance": (
        "slider_crank_lubricated",
        {"duration": 2e-3, "joints.B.clearance": 1e-5},
        {"sdf.frames.rod_B.pose.x": (0.11, 0.13)},
    ),
    "narrow clearances, which limit the errors of steps": (
        *PRESS,
        {
            "joints.A.clearance": (2e-5, 2e-4),
            "sdf.frames.link2_C.pose.x": (0.17, 0.19),
            "joints.B.clearance": (2e-5, 2e-4),
        },
    ),
    "narrow clearance, no length": (*PRESS, {"joints.A.clearance": (2e-5, 2e-4)}),
    "dry": (*DRY, {"sdf.frames.rod_B.pose.x": (0.11, 0.13), "sdf.frames.crank_A.pose.x": (0.04, 0.06)}),
    "guide": ("slider_crank_guide", {"duration": 2e-3}, {"sdf.frames.rod_B.pose.x": (0.11, 0.13)}),
    "mass centre": (
        "four_bar_dry",
        {"duration": 2e-3},
        {"sdf.frames.coupler_B.pose.x": (0.17, 0.19), "sdf.links.coupler.com.x": (0.08, 0.1)},
    ),
}


@pytest.mark.parametrize("case", LENGTHS)
def test_rows_with_lengths_are_single_runs(case, monkeypatch):
    """Few systems are built for them."""
    name, overrides, limits = LENGTHS[case]
    system, outputs = shipped(name, **overrides), OUTPUTS.get(name, ["A.force"])
    low, high = np.array(list(limits.values())).T
    values = np.random.default_rng(0).uniform(low, high, (100, len(low)))
    built = counted(monkeypatch)
    batch = simulate_batch(system, list(limits), values, outputs)
    assert len(built) < 50
    for k in range(0, 100, 10):
        status, _, steps, statistics = alone(system, dict(zip(limits, values[k].tolist(), strict=True)), outputs)
        assert (batch.status[k], batch.steps[k]) == (status, steps)
        assert status is Status.OK
        assert [batch.statistics[name][k].tobytes() for name in STATISTICS] == statistics


def test_with_limits_rows_with_lengths_do_not_depend_on_earlier_batches():
    """A study that is resumed, in another process, continues with the same bits."""
    paths = [
        "sdf.frames.link2_C.pose.x",
        "sdf.frames.link6_D.pose.x",
        "sdf.frames.link6_D.pose.y",
        "joints.A.viscosity",
    ]
    limits = np.array([[0.17, 0.29, -0.01, 0.2], [0.19, 0.31, 0.01, 0.4]])
    job, values = (shipped("seven_bar", duration=0.02), paths), np.random.default_rng(0).uniform(*limits, (40, 4))
    many = simulate_batch(*job, values, ["A.force"], limits=limits)
    designs.designs_of.cache_clear()
    few = [simulate_batch(*job, values[k : k + 1], ["A.force"], limits=limits).rms for k in range(40)]
    assert np.concatenate(few).tobytes() == many.rms.tobytes()


def test_lengths_that_do_not_close_between_others_are_single_runs(system_of):
    """The four-bar closes unless the crank's pin is nearer to the fixed pin than coupler and follower differ, 50 mm."""
    system, path = system_of(four_bar(), f"duration = 0.001\n{FILM}"), "sdf.frames.pivot.pose.x"
    values = np.linspace(-0.15, 0.35, 40)
    batch = simulate_batch(system, [path], values[:, None], ["A.force"])
    for value, status, reason in zip(values.tolist(), batch.status, batch.reason, strict=True):
        assert (status is Status.OK) == (abs(value - 0.1) > 0.05)
        single = simulate_batch(system, [path], [[value]], ["A.force"])
        assert (single.status[0], single.reason[0]) == (status, reason)


def counted(monkeypatch):
    """A list that gets an item for each system that is built."""
    built = []
    given = designs.Designs._given
    monkeypatch.setattr(designs.Designs, "_given", lambda *arguments: built.append(1) or given(*arguments))
    return built


def test_no_systems_are_built_for_values_that_are_numbers_of_a_run(monkeypatch):
    """Masses, moments of inertia, viscosities and clearances are; a speed also changes tolerances and the start."""
    built = counted(monkeypatch)
    system = shipped("seven_bar", duration=0.01)
    paths = ["sdf.links.link2.mass", "sdf.links.slider7.mass", "sdf.links.link2.inertia", "joints.A.viscosity"]
    low, high = [0.2, 0.3, 5e-4, 0.1, 1e-4], [0.4, 0.5, 9e-4, 0.5, 3e-4]
    values = np.random.default_rng(0).uniform(low, high, (100, 5))
    paths.append("joints.A.clearance")
    simulate_batch(system, paths, values, ["A.force"])
    assert len(built) < 30
    simulate_batch(system, paths, values[::-1], ["A.force"])  # another batch of the same designs
    assert len(built) < 30
    simulate_batch(system, ["drives.O1.speed"], np.linspace(3.0, 3.2, 100)[:, None], ["A.force"])
    assert len(built) > 100
