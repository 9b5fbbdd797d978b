"""Flexible links as chains of rigid segments: the second model, which shares no modal kernel with the first."""

import pickle

import numpy as np
import pytest
from flexible_machines import MACHINES, bent_machine
from scipy.integrate import trapezoid

import linkages
from linkages.engines import engine
from linkages.results.summary import judge
from linkages.system.rigid_segments import segmented

# of a run: in dry joints until the second impact has begun, or well into the first if that continues
DURATIONS = {"ideal": 0.01, "lubricated": 0.01}
DRY = {"slider_crank": 6e-4, "four_bar": 1e-3, "seven_bar": 6.2e-4}
ENERGY = ("kinetic_energy", "potential_energy")

#: Differences [%], recorded: by the number of segments, in columns of machine and joint law.
COLUMNS = ["slider_crank ideal", "four_bar ideal", "seven_bar ideal", "slider_crank lubricated", "slider_crank dry"]
ROWS = {4: (2.7, 3.3, 3.0, 2.7, 3.9), 8: (0.69, 0.81, 0.77, 0.69, 3.3), 16: (0.19, 0.21, 0.20, 0.19, 0.91)}
PRINTED = {count: dict(zip(COLUMNS, row, strict=True)) for count, row in ROWS.items()}

every_machine = pytest.mark.parametrize(
    "name", ["slider_crank", *(pytest.param(name, marks=pytest.mark.slow) for name in ("four_bar", "seven_bar"))]
)
every_law = pytest.mark.parametrize("law", ["ideal", "lubricated", "dry"])


def in_segments(system, count):
    """Return the system with a number of cells in each flexible link."""
    return segmented(system.replaced({f"links.{name}.segments": count for name in system.experiment.deforming}))


def moved(system):
    """A run of the compiled engine, as a function of time."""
    run = engine("compiled").simulate(system)
    assert run.status.value == "ok"
    return run.evaluate


def difference(one, other, name):
    return np.sqrt(np.mean((one[name] - other[name]) ** 2) / np.mean(other[name] ** 2))


@every_machine
@every_law
def test_pieces_tend_to_the_modes_with_the_square_of_their_length(tmp_path, name, law):
    """Deflection until the second impact, or over 10 ms: a quarter is left at half the length.

    In dry contact from 8 segments on: with fewer ones the impact is too coarse.
    """
    duration = DURATIONS.get(law) or DRY[name]
    system = bent_machine(tmp_path, name, law, duration)
    times = np.linspace(0.0, duration, 401)
    exact = moved(system)(times)
    counts = (8, 16) if law == "dry" else (4, 8)
    coarse, fine = (moved(in_segments(system, n))(times) for n in counts)
    left = difference(coarse, exact, "middle.deflection"), difference(fine, exact, "middle.deflection")
    if f"{name} {law}" in COLUMNS:
        printed = [0.01 * PRINTED[count][f"{name} {law}"] for count in counts]
        assert left == pytest.approx(printed, rel=0.02)  # two digits
    assert left[1] < 0.01
    assert 3.5 < left[0] / left[1] < 4.5
    for force in () if law == "dry" else (f"{MACHINES[name][1][0]}.bending", "B.force"):
        assert difference(fine, exact, force) < 0.02


def test_pieces_of_simeons_rod_tend_to_those_of_another_code(tmp_path):
    """Equal segments by DOP853, extrapolated from 16 and 32: w(100 ms) = 0.1436662 mm; here the ends are half segments."""
    keys = 'axial = 0\nstiffness_damping = 1.5e-5\nstart = "undeformed"'
    system = bent_machine(tmp_path, "slider_crank", "ideal", 0.1, keys)
    coarse, fine = (moved(in_segments(system, n))(np.array([0.1]))["middle.deflection"][0] for n in (16, 32))
    assert fine + (fine - coarse) / 3.0 == pytest.approx(0.1436662e-3, abs=1e-8)  # its own error is of h^4


def test_no_energy_is_lost_but_in_damping(tmp_path):
    """Work of the drive minus the hinges' dissipation is the change of energy; the strain energy is in the springs."""
    system = in_segments(bent_machine(tmp_path, "slider_crank", keys="axial = 0"), 8)
    times = np.linspace(0.0, 0.01, 4001)
    columns = moved(system)(times)
    chain = system.chains["rod"]
    strain = sum(0.5 * k * columns[f"q.{joint}"] ** 2 for joint, k in zip(chain.joints, chain.stiffnesses, strict=True))
    np.testing.assert_allclose(columns["strain_energy"], strain, rtol=1e-12)
    rates = (np.gradient(columns[f"q.{joint}"], times, edge_order=2) for joint in chain.joints)
    taken = sum(chain.damping * k * rate**2 for rate, k in zip(rates, chain.stiffnesses, strict=True))
    np.testing.assert_allclose(columns["damping_power"], taken, atol=1e-3 * taken.max())
    change = sum(columns[name][-1] - columns[name][0] for name in ENERGY)
    work = trapezoid(columns["O.power"] - columns["damping_power"], times)
    assert change == pytest.approx(work, abs=1e-5 * trapezoid(np.abs(columns["O.power"]), times))


def test_the_pieces_have_the_mass_and_inertia_of_the_beam(tmp_path):
    """In sum, about the beam's middle, with one cell too."""
    whole = bent_machine(tmp_path, "four_bar")
    for count in (2, 7):
        machine = in_segments(whole, count).mechanism
        for name in ("coupler", "follower"):
            parts = [machine.link[piece] for piece in in_segments(whole, count).chains[name].segments]
            link = whole.mechanism.link[name]
            assert len(parts) == count + 1
            assert sum(part.mass for part in parts) == pytest.approx(link.mass, rel=1e-12)
            centre = sum(part.mass * part.com for part in parts) / link.mass
            np.testing.assert_allclose(centre, link.com, atol=1e-12)
            turning = sum(p.inertia + p.mass * np.sum((p.com - link.com) ** 2) for p in parts)
            assert turning == pytest.approx(link.inertia, rel=1e-12)


def test_a_start_in_pieces_is_that_of_the_modes(tmp_path):
    """Quasi-static: the same deflection to the second order, loops closed, and the machine goes through a pickle."""
    system = bent_machine(tmp_path, "slider_crank", duration=1e-3).replaced({"drives.O.angle": 1.0})
    exact = moved(system)(np.zeros(1))["middle.deflection"][0]
    assert abs(exact) > 1e-4  # m
    missed = [moved(in_segments(system, n))(np.zeros(1))["middle.deflection"][0] - exact for n in (4, 8)]
    assert missed[0] / missed[1] == pytest.approx(4.0, rel=0.15)
    again = pickle.loads(pickle.dumps(in_segments(system, 4)))
    np.testing.assert_array_equal(again.assembly.q, in_segments(system, 4).assembly.q)


def test_drake_moves_the_same_pieces(tmp_path):
    """Its own plant, and the compiled engine with the same machine, to the tolerance; names agree with the modal model's."""
    whole = bent_machine(tmp_path, "slider_crank", duration=5e-4, accuracy=1e-6)
    system = whole.replaced({"links.rod.segments": 4})
    run, times = linkages.simulate(system, "drake"), np.linspace(0.0, 5e-4, 11)
    drake, compiled = run.evaluate(times), moved(in_segments(whole, 4))(times)
    assert drake.keys() == compiled.keys()
    for name in ("middle.deflection", "slider.x", "rod.stress", "O.torque", "B.force", "strain_energy"):
        np.testing.assert_allclose(drake[name], compiled[name], rtol=1e-4, atol=1e-6 * np.abs(compiled[name]).max())
    missing = linkages.simulate(system, "compiled").columns.keys() - run.columns.keys()
    assert missing == {f"q.rod.bending{k + 1}" for k in range(8)}
    assert (run.units["q.rod/hinge1"], run.units["rod.stress"], run.units["middle.deflection"]) == ("rad", "Pa", "m")


@pytest.mark.slow
@every_law
@pytest.mark.parametrize("name", list(MACHINES))
def test_drake_moves_the_pieces_of_all_linkages(tmp_path, name, law):
    """As the compiled engine, whose pieces tend to the modes (above): over 2 ms, in dry joints until the second impact."""
    duration = DRY[name] if law == "dry" else 2e-3
    system = in_segments(bent_machine(tmp_path, name, law, duration, accuracy=1e-6), 4)
    times = np.linspace(0.0, duration, 401)
    drake, compiled = (engine(which).simulate(system).evaluate(times) for which in ("drake", "compiled"))
    for column in ("middle.deflection", "B.force", "strain_energy"):
        assert difference(drake, compiled, column) < 1e-4, column  # a hundred times the accuracy


def test_what_segments_cannot_do_is_said(tmp_path):
    """Links that may stretch are warned of, by the engine that does not stretch them; no stiffening is refused."""
    keys = "bending = 4\nsegments = 2"
    system = bent_machine(tmp_path, "slider_crank", "ideal", 1e-4, keys, 1e-5)
    found = linkages.assess(system, "drake")
    kinds = [one["kind"] for one in judge(found, linkages.summarize(found))["warnings"]]
    assert kinds.count("segments") == 1
    assert found.tighter.columns.keys() - found.run.columns.keys() == {"q.rod/hinge3", "q.rod/hinge4"}
    other = linkages.assess(system, "compiled", error_estimate=False)
    assert "segments" not in [one["kind"] for one in judge(other, linkages.summarize(other))["warnings"]]
    with pytest.raises(linkages.InputError, match=r"links\.rod\.stiffening: is false, but Drake's rigid segments"):
        linkages.simulate(system.replaced({"links.rod.stiffening": False}), "drake")
