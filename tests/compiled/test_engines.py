"""Both engines on every shipped linkage: other integrators, other equations for the mechanics, one result."""

import numpy as np
import pytest
from slider_crank_impacts import slider_crank_impacts, table

from linkages.engines.compiled.simulation import simulate as compiled
from linkages.engines.drake import simulate as drake
from linkages.engines.study import ideal, touching
from linkages.errors import Status
from linkages.files.shipped import data_folder
from linkages.model.experiment import load
from linkages.results.impacts import impacts

FILES = {path.stem for path in data_folder().glob("*.toml") if not path.name.startswith("three_rrr")}

#: Films only: seconds to simulate, two revolutions; Drake's accuracy at which its own error is a few times 1e-7.
SMOOTH = {"seven_bar": (2.0, 1e-10), "seven_bar_rig": (2.0, 1e-10), "slider_crank_lubricated": (0.024, 1e-8)}

#: Contacts: seconds until two of them have ended.
DRY = {
    "four_bar_dry": 0.0055,
    "five_bar_dry": 0.0016,
    "six_bar_dry": 0.0065,
    "seven_bar_dry": 0.016,
    "slider_crank_dry": 0.0008,
    "slider_crank_guide": 0.0012,
}

#: Film and contact, from one to the other and back without end.
MIXED = {"seven_bar_mixed": 0.08}

TIGHT = 1e-12


def test_every_shipped_linkage_is_compared():
    assert {*SMOOTH, *DRY, *MIXED} == FILES


def shipped(name, duration, **overrides):
    return load(data_folder() / f"{name}.toml", {"duration": duration, **overrides})


def run(simulate, mechanism, experiment, accuracy):
    result = simulate(mechanism, experiment.replaced({"solver.accuracy": accuracy}))
    assert result.status is Status.OK
    return result


#: Columns of one kind are measured by the largest of them in the linkage: a moment that vanishes, or a component, has
#: the rounding errors of what it is made of.
KINDS = {"ax": "a", "ay": "a", "vx": "v", "vy": "v", "fx": "force", "fy": "force", "moment": "torque"}
KINDS |= {"x": "length", "y": "length"} | dict.fromkeys(
    ("force", "torque", "power", "alpha", "omega", "angle")
)


def differences(one, other):
    """Largest difference of each column, in parts of the largest value of its kind."""

    def kind(name):
        suffix = name.rpartition(".")[2]
        return (KINDS[suffix] or suffix) if suffix in KINDS else name

    largest = {}
    for name, values in other.items():
        largest[kind(name)] = max(largest.get(kind(name), 0.0), float(np.abs(values).max()))
    return {
        name: float(np.abs(values - other[name]).max()) / (largest[kind(name)] or 1.0)
        for name, values in one.items()
    }


@pytest.mark.slow
@pytest.mark.parametrize("name", SMOOTH)
def test_lubricated_linkages_move_alike(name):
    """Every column of the results over two revolutions, to 1e-6: what is promised."""
    duration, accuracy = SMOOTH[name]
    mechanism, experiment = shipped(name, duration)
    times = np.linspace(0.0, duration, 401)
    ours = run(compiled, mechanism, experiment, TIGHT).evaluate(times)
    theirs = run(drake, mechanism, experiment, accuracy).evaluate(times)
    assert ours.keys() == theirs.keys()
    found = differences(ours, theirs)
    worst = max(found, key=found.__getitem__)
    assert found[worst] <= 1e-6, worst


# --- contact ----------------------------------------------------------------------------------------------------------


def first_contacts(simulate, name, accuracy, count=2, **overrides):
    """Start, approach, sliding speed, duration, peaks of force and depth, separation speed of the first contacts."""
    mechanism, experiment = shipped(name, {**DRY, **MIXED}[name], **overrides)
    result = run(simulate, mechanism, experiment, accuracy)
    rows = impacts(result, touching(experiment, result))[:count]
    return [row.joint for row in rows], np.array([list(vars(row).values())[1:] for row in rows])


@pytest.mark.slow
@pytest.mark.parametrize("name", DRY)
def test_first_two_impacts_are_alike(name):
    """Times, speeds, durations and peaks to 1e-5: what is promised."""
    joints, ours = first_contacts(compiled, name, TIGHT)
    others, theirs = first_contacts(drake, name, 1e-10, **{"solver.max_step": 5e-6})
    assert joints == others
    assert len(joints) == 2
    assert np.all(np.isfinite(ours))
    np.testing.assert_allclose(ours, theirs, rtol=1e-5)


@pytest.mark.parametrize("friction", [None, 0.03])
def test_first_impacts_of_the_slider_crank_are_those_of_an_independent_model(friction):
    """Two coordinates, another integrator, written apart from the package: to 1e-6."""
    overrides = {"solver.accuracy": TIGHT}
    if friction is None:
        overrides["joints.B.friction"] = {"law": "ambrosio", "coefficient": 1e-12}
    mechanism, experiment = shipped("slider_crank_dry", 1e-3, **overrides)
    got = table(impacts(compiled(mechanism, experiment), ["B"]))[:2]
    np.testing.assert_allclose(got, slider_crank_impacts(friction or 0.0, 1e-3, 2), rtol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("name", MIXED)
def test_mixed_linkages_move_alike(name):
    mechanism, experiment = shipped(name, MIXED[name])
    times = np.linspace(0.0, MIXED[name], 401)
    ours = run(compiled, mechanism, experiment, TIGHT).evaluate(times)
    theirs = run(drake, mechanism, experiment, 1e-10).evaluate(times)
    found = differences(ours, theirs)
    worst = max(found, key=found.__getitem__)
    assert max(ours["A.penetration"].max(), ours["B.penetration"].max()) > 0.0
    assert found[worst] <= 1e-5, worst


# --- ideal ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", sorted(FILES))
def test_ideal_linkages_move_by_their_kinematics(name):
    """Loops integrated and projected, against each instant's closure and inverse dynamics."""
    mechanism, experiment = load(data_folder() / f"{name}.toml")
    times = np.linspace(0.0, experiment.duration, 101)
    result = run(compiled, mechanism, experiment.ideal(), 1e-10)
    exact = ideal(mechanism, experiment)
    assert exact.provenance["engine"] == "kinematics"
    found = differences(result.evaluate(times), exact.evaluate(times))
    worst = max(found, key=found.__getitem__)
    assert found[worst] <= 1e-7, worst
    assert result.provenance["loop_error"] <= 1e-10
