"""The Drake systems: ports, caching, loops, planes, torques, diagrams of the user's, failures."""

import numpy as np
import pytest
from machines import PLANES, four_bar, slider_crank
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource, LogVectorOutput

import linkages.engines.drake.clearance as clearance_module
from linkages.engines.drake import add_linkage, build_diagram, simulate
from linkages.engines.drake.clearance import JOINT_OUTPUTS
from linkages.engines.study import ideal
from linkages.errors import Status
from linkages.model.experiment import load
from linkages.outputs.columns import columns_from_states
from linkages.results.extremes import integral
from linkages.system.assembly import assemble

FILM = '[joints.{0}]\nmodel="lubricated"\nclearance=1e-4\nviscosity=0.1\n'
DRIVE = "duration=0.3\n[drives.O]\nspeed=15.0\n"


def test_both_ports_share_one_evaluation_of_the_laws(seven_bar, monkeypatch):
    calls = []
    original = clearance_module.clearance_forces

    def counted(*arguments):
        calls.append(1)
        return original(*arguments)

    monkeypatch.setattr(clearance_module, "clearance_forces", counted)
    diagram, linkage = build_diagram(*seven_bar)
    root = diagram.CreateDefaultContext()
    linkage.set_initial_state(root)
    context = linkage.clearance.GetMyContextFromRoot(root)
    linkage.clearance.get_joints_output_port().Eval(context)
    linkage.clearance.get_force_output_port().Eval(context)
    diagram.EvalTimeDerivatives(root)
    assert len(calls) == 1
    root.SetContinuousState(root.get_continuous_state_vector().CopyToVector() * 1.0000001)
    diagram.EvalTimeDerivatives(root)
    assert len(calls) == 2


def test_joints_port_can_be_logged_in_a_diagram_of_the_users(seven_bar):
    """Drake's own Simulator, default integrator settings aside, with a logger and an external force of zero."""
    mechanism, experiment = seven_bar
    builder = DiagramBuilder()
    linkage = add_linkage(builder, mechanism, experiment, external=True)
    nothing = builder.AddSystem(ConstantVectorSource(np.zeros(linkage.plant.num_velocities())))
    builder.Connect(nothing.get_output_port(), linkage.external)
    log = LogVectorOutput(linkage.clearance.get_joints_output_port(), builder, 1e-3)
    diagram = builder.Build()
    simulator = Simulator(diagram)
    linkage.set_initial_state(simulator.get_mutable_context())
    from pydrake.systems.analysis import ResetIntegratorFromFlags

    ResetIntegratorFromFlags(simulator, "radau3", 2e-3).set_target_accuracy(1e-7)
    simulator.AdvanceTo(0.1)
    found = log.FindLog(simulator.get_context())
    data = found.data().reshape(2, len(JOINT_OUTPUTS), -1)
    part = {name: data[:, i] for i, name in enumerate(JOINT_OUTPUTS)}
    run = simulate(mechanism, experiment.replaced({"duration": 0.1}))
    expected = run.evaluate(found.sample_times()[1:])
    for k, name in enumerate("AB"):
        size = np.abs(expected[f"{name}.ex"]).max()
        np.testing.assert_allclose(part["ex"][k, 1:], expected[f"{name}.ex"], atol=1e-3 * size)
        np.testing.assert_allclose(
            np.hypot(part["ex"], part["ey"])[k] / 3e-4, part["eccentricity_ratio"][k], atol=1e-15
        )
        np.testing.assert_allclose(np.arctan2(part["ey"], part["ex"])[k], part["attitude"][k])


def test_external_force_acts_on_the_linkage(seven_bar):
    """A constant push on the slider shows up in the drives' work."""
    mechanism, experiment = seven_bar
    forces = {}
    for push in (0.0, 5.0):
        builder = DiagramBuilder()
        linkage = add_linkage(builder, mechanism, experiment, external=True)
        vector = np.zeros(linkage.plant.num_velocities())
        vector[linkage.velocities[linkage.assembly.tree.coordinates.index("guide")]] = push
        source = builder.AddSystem(ConstantVectorSource(vector))
        builder.Connect(source.get_output_port(), linkage.external)
        diagram = builder.Build()
        root = diagram.CreateDefaultContext()
        linkage.set_initial_state(root)
        rates = diagram.EvalTimeDerivatives(root).CopyToVector()
        forces[push] = rates[linkage.plant.num_positions() + linkage.velocities]
    tree = linkage.assembly.tree
    guide = tree.coordinates.index("guide")
    assert forces[5.0][guide] - forces[0.0][guide] > 1.0
    np.testing.assert_allclose(forces[5.0][tree.driven_dofs], forces[0.0][tree.driven_dofs], atol=1e-9)


@pytest.mark.parametrize("sdf", [four_bar(), slider_crank(), slider_crank(offset=0.02, plane="xz")])
def test_ideal_loops_follow_the_exact_kinematics(experiment_file, sdf):
    """Every joint ideal on Drake: loops closed by multipliers, against closed kinematics and inverse dynamics."""
    mechanism, experiment = load(experiment_file(sdf, DRIVE + "[solver]\naccuracy=1e-9\n"))
    run = simulate(mechanism, experiment)
    assert run.status is Status.OK
    assert assemble(mechanism, experiment).tree.loops
    assert run.provenance["loop_error"] < 1e-9  # m
    exact = ideal(mechanism, experiment).evaluate(run.time)
    link = mechanism.links[-1].name
    np.testing.assert_allclose(run[f"{link}.x"], exact[f"{link}.x"], atol=1e-9)
    np.testing.assert_allclose(
        run["O.torque"], exact["O.torque"], atol=1e-6 * np.abs(exact["O.torque"]).max()
    )
    np.testing.assert_allclose(run["A.force"], exact["A.force"], atol=1e-6 * exact["A.force"].max())


def test_an_ideal_loop_beside_a_joint_with_play(seven_bar):
    """B ideal by multipliers against B with a film of a tenth of the clearance, which holds it a thousand times closer."""
    mechanism, experiment = seven_bar
    loop = experiment.replaced({"duration": 0.4, "joints.B": {"model": "ideal"}})
    run = simulate(mechanism, loop)
    assert assemble(mechanism, loop).tree.loops
    assert run.provenance["loop_error"] < 1e-8  # m
    tight = simulate(mechanism, experiment.replaced({"duration": 0.4, "joints.B.clearance": 3e-5}))
    times = np.linspace(0.02, 0.38, 10)
    a, b = run.evaluate(times), tight.evaluate(times)
    size = np.hypot(a["A.ex"], a["A.ey"]).max()
    np.testing.assert_allclose(a["A.ex"], b["A.ex"], atol=1e-3 * size)
    np.testing.assert_allclose(a["A.ey"], b["A.ey"], atol=1e-3 * size)
    np.testing.assert_allclose(a["B.force"], b["B.force"], rtol=2e-3)


@pytest.mark.parametrize("plane", [p for p in PLANES if p != "xy"])
def test_the_motion_does_not_depend_on_the_plane(experiment_file, plane):
    toml = DRIVE + FILM.format("A")
    flat = simulate(*load(experiment_file(four_bar(), toml)))
    tilted = simulate(*load(experiment_file(four_bar(plane=plane), toml)))
    times = np.linspace(0.02, 0.28, 8)
    a, b = flat.evaluate(times), tilted.evaluate(times)
    size = np.hypot(a["A.ex"], a["A.ey"]).max()
    np.testing.assert_allclose(
        np.hypot(b["A.ex"], b["A.ey"]), np.hypot(a["A.ex"], a["A.ey"]), atol=1e-3 * size
    )
    np.testing.assert_allclose(b["A.force"], a["A.force"], rtol=1e-3)
    np.testing.assert_allclose(b["O.torque"], a["O.torque"], atol=1e-3 * np.abs(a["O.torque"]).max())


def test_a_rod_that_floats_on_two_films(experiment_file):
    toml = DRIVE + FILM.format("A") + FILM.format("B")
    mechanism, experiment = load(experiment_file(slider_crank(), toml))
    run = simulate(mechanism, experiment)
    assert run.status is Status.OK
    exact = ideal(mechanism, experiment).evaluate(run.time)
    np.testing.assert_allclose(run["slider.x"], exact["slider.x"], atol=1e-4)
    settled = run.time > 0.02
    np.testing.assert_allclose(
        run["B.force"][settled], exact["B.force"][settled], atol=0.05 * exact["B.force"].max()
    )
    assert run["A.eccentricity_ratio"].max() > 0.01


def test_a_falling_four_bar_keeps_its_energy(experiment_file):
    """No drive at all: a closed loop under gravity, from rest; ideal joints lose nothing."""
    text = "duration=0.6\ngravity=[0.0, -9.81, 0.0]\n[solver]\naccuracy=1e-9\n"
    run = simulate(*load(experiment_file(four_bar(), text)))
    energy = run["kinetic_energy"] + run["potential_energy"]
    assert run["kinetic_energy"].max() > 0.05
    np.testing.assert_allclose(energy, energy[0], atol=1e-7)
    assert run.provenance["loop_error"] < 1e-8


def test_torque_drive_does_its_work(experiment_file):
    """A crank under a tabulated torque: the work is the kinetic energy; its ideal counterpart is a run of its own."""
    text = "duration=0.4\n[drives.O]\ntimes=[0.0, 0.2, 0.4]\ntorques=[0.02, 0.05, 0.01]\n[solver]\naccuracy=1e-9\n"
    mechanism, experiment = load(
        experiment_file(four_bar(), text + FILM.format("A").replace("lubricated", "ideal"))
    )
    run = simulate(mechanism, experiment)
    work = integral(run, run["O.torque"] * run["O.rate"])
    assert work > 1e-3
    assert run["kinetic_energy"][-1] == pytest.approx(work, rel=1e-5)
    assert run["O.torque"][run.time >= 0.2][0] == pytest.approx(0.05, abs=2e-3)
    counterpart = ideal(mechanism, experiment)
    assert counterpart.provenance["engine"] == "drake"


def test_ramped_drive_starts_at_rest_and_follows(experiment_file):
    text = "duration=0.4\n[drives.O]\nspeed=15.0\nramp=0.2\n" + FILM.format("A")
    run = simulate(*load(experiment_file(four_bar(), text)))
    assert run["O.rate"][0] == 0.0
    assert run["O.rate"][-1] == pytest.approx(15.0, abs=1e-5)
    assert run["q.O"][-1] == pytest.approx(15.0 * (0.4 - 0.1), abs=1e-6)


def test_reactions_of_the_run_satisfy_newtons_law_of_the_slider(seven_bar):
    """Only D and the guide act on the slider: m a_x = F_D,x whatever path it was computed by."""
    mechanism, experiment = seven_bar
    run = simulate(mechanism, experiment.replaced({"duration": 0.2}))
    np.testing.assert_allclose(run["D.fx"], 0.139 * run["slider7.ax"], atol=1e-9)


def test_a_film_too_thin_ends_with_a_status(seven_bar):
    mechanism, experiment = seven_bar
    weak = {f"joints.{name}.viscosity": 1e-7 for name in "AB"}
    run = simulate(mechanism, experiment.replaced({"duration": 0.5, **weak}))
    assert run.status is Status.JOURNAL_LEFT_BEARING
    assert 0.0 < run.time[-1] < 0.1
    assert max(run[f"{name}.eccentricity_ratio"][-1] for name in "AB") > 0.9998


def test_a_finite_film_ends_where_its_map_does(experiment_file):
    """Never extrapolated: the run stops with a status when the journal passes the map's largest eps, 0.999."""
    text = DRIVE + FILM.format("A").replace("viscosity=0.1", 'viscosity=1e-6\nfilm="finite"')
    run = simulate(*load(experiment_file(four_bar(), text)))
    assert run.status is Status.JOURNAL_LEFT_BEARING
    assert run["A.eccentricity_ratio"][-1] == pytest.approx(0.999, abs=2e-4)
    assert run["A.eccentricity_ratio"][:-1].max() < 0.999


def test_interruption_keeps_the_run_so_far(seven_bar):
    def stop(time):
        if time > 0.05:
            raise KeyboardInterrupt

    mechanism, experiment = seven_bar
    run = simulate(mechanism, experiment, progress=stop)
    assert run.status is Status.INTERRUPTED
    assert 0.05 < run.time[-1] < 0.1
    assert len(run["A.force"]) == len(run.time)


def test_runs_are_repeatable(seven_bar):
    mechanism, experiment = seven_bar
    experiment = experiment.replaced({"duration": 0.05})
    first, second = simulate(mechanism, experiment), simulate(mechanism, experiment)
    for name, column in first.columns.items():
        np.testing.assert_array_equal(column, second[name])


def test_energies_and_reactions_do_not_depend_on_the_tree(seven_bar):
    """The same state described by two spanning trees gives the same columns."""
    mechanism, experiment = seven_bar
    one, other = assemble(mechanism, experiment), assemble(mechanism, experiment.ideal())
    assert one.tree.coordinates != other.tree.coordinates
    columns = [
        columns_from_states(a.tree, experiment.ideal(), np.zeros(1), a.q[None], a.v[None], 0 * a.v[None])
        for a in (one, other)
    ]
    for name in ("kinetic_energy", "slider7.vx", "link3.y", "link6.omega"):
        assert columns[0][name][0] == pytest.approx(columns[1][name][0], abs=1e-12)
