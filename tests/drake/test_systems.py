"""The Drake engine itself: ports, caching, diagrams of the user's, steps."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from machines import four_bar
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource, LogVectorOutput
from shipped import run as run_shipped
from shipped import shipped

import linkages
import linkages.engines.drake.clearance as clearance_module
from linkages import InputError, Status, simulate
from linkages.base.errors import RunError
from linkages.engines.drake import add_linkage, build_diagram, steps
from linkages.engines.drake.clearance import JOINT_OUTPUTS
from linkages.engines.drake.plant import tree_sdf
from linkages.engines.drake.steps import StepControl
from linkages.mechanics.planar.contacts import CLEARANCE_OUTPUTS


def test_both_ports_share_one_evaluation_of_the_laws(seven_bar, monkeypatch):
    calls = []
    original = clearance_module.joint_forces

    def counted(*arguments):
        calls.append(1)
        return original(*arguments)

    monkeypatch.setattr(clearance_module, "joint_forces", counted)
    diagram, linkage = build_diagram(seven_bar)
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


@pytest.mark.processes
def test_threads_may_evaluate_one_diagram_at_once(seven_bar):
    """Each context in a thread of its own has the derivatives that it has alone."""
    diagram, linkage = build_diagram(seven_bar)
    nominal = diagram.CreateDefaultContext()
    linkage.set_initial_state(nominal)
    state = nominal.get_continuous_state_vector().CopyToVector()

    def slopes(speed):
        """Derivatives at 300 states that move at this part of the speed."""
        root, found, moving = diagram.CreateDefaultContext(), [], np.ones(len(state))
        linkage.set_initial_state(root)
        moving[len(state) // 2 :] = speed
        for k in range(300):
            root.SetContinuousState(state * (moving + 1e-9 * k))
            found.append(diagram.EvalTimeDerivatives(root).CopyToVector())
        return np.array(found)

    speeds = [0.5, 0.7, 0.9, 1.1]
    with ThreadPoolExecutor(len(speeds)) as pool:
        together = list(pool.map(slopes, speeds))
    for speed, found in zip(speeds, together, strict=True):
        np.testing.assert_array_equal(found, slopes(speed))


def test_ports_are_the_documented_ones(seven_bar):
    from make_drake import ports

    powered = seven_bar.replaced({"drives.O4.torque": 0.0})
    linkage = build_diagram(powered)[1]
    assert tuple(JOINT_OUTPUTS)[: len(CLEARANCE_OUTPUTS)] == CLEARANCE_OUTPUTS
    for system in (linkage.clearance, linkage.drives):
        there = {system.get_input_port(k).get_name() for k in range(system.num_input_ports())}
        there |= {system.get_output_port(k).get_name() for k in range(system.num_output_ports())}
        said = {name for name, _, _ in ports(type(system))}
        drives = {f"{name}.speed" for name in ("O1", "O4")} | {"O4.torque"}
        assert there == {name for name in said if "DRIVE" not in name} | (drives if system is linkage.drives else set())


def test_a_motor_with_speed_and_torque_ports(seven_bar):
    """Torque on a powered crank through its own port, and as a generalised force: the same motion."""
    system = seven_bar.replaced({"drives.O1.torque": 0.0, "duration": 0.01})
    states = []
    for way in ("torque", "external"):
        builder = DiagramBuilder()
        linkage = add_linkage(builder, system, external=way == "external")
        force = np.zeros(linkage.plant.num_velocities())
        dof = linkage.place.velocities[system.tree.coordinates.index("O1")]
        force[dof] = 0.3
        source = builder.AddSystem(ConstantVectorSource(force if way == "external" else [0.3]))
        builder.Connect(source.get_output_port(), linkage.external if way == "external" else linkage.torque("O1"))
        simulator = Simulator(builder.Build())
        root = simulator.get_mutable_context()
        linkage.set_initial_state(root)
        assert linkage.advance(simulator, 0.01) is Status.OK
        states.append(root.get_continuous_state_vector().CopyToVector())
        speed = linkage.speed("O1").Eval(linkage.drives.GetMyContextFromRoot(root))
        assert speed == states[-1][linkage.place.v[system.tree.coordinates.index("O1")]]
        torques = linkage.drives.get_torques_output_port().Eval(linkage.drives.GetMyContextFromRoot(root))
        assert torques[-1] == (0.3 if way == "torque" else 0.0)
    np.testing.assert_allclose(states[0], states[1], rtol=1e-9, atol=1e-12)


def test_a_machine_in_millimetres_takes_no_more_steps_than_it_may(system_of):
    """300 m long and turning at 720 rad/s: 2.5 million steps for a second, all of them accurate."""
    contact = 'contact = {law = "flores", restitution = 0.5, youngs_modulus = 2e11}'
    joint = f'[joints.B]\nmodel = "dry"\nclearance = 1e-4\n{contact}\n'
    text = f"duration = 1.0\n[drives.O]\nspeed = 720.0\n{joint}"
    builder = DiagramBuilder()
    linkage = add_linkage(builder, system_of(four_bar(300.0, 100.0, 250.0, 200.0), text))
    simulator, times = Simulator(builder.Build()), []
    linkage.set_initial_state(simulator.get_mutable_context())
    assert linkage.advance(simulator, 1.0, times.append, limit=500) is Status.TOO_MANY_STEPS
    assert 0.0 < simulator.get_context().get_time() < 1e-2  # not a tenth of the crank's first turn
    assert len(times) == pytest.approx(500, abs=5)


def test_joints_port_can_be_logged_in_a_diagram_of_the_users(seven_bar):
    """Drake's own Simulator, default integrator settings aside, with a logger and an external force of zero."""
    builder = DiagramBuilder()
    linkage = add_linkage(builder, seven_bar, external=True)
    nothing = builder.AddSystem(ConstantVectorSource(np.zeros(linkage.plant.num_velocities())))
    builder.Connect(nothing.get_output_port(), linkage.external)
    log = LogVectorOutput(linkage.clearance.get_joints_output_port(), builder, 1e-3)
    diagram = builder.Build()
    simulator = Simulator(diagram)
    linkage.set_initial_state(simulator.get_mutable_context())
    ResetIntegratorFromFlags(simulator, "radau3", 2e-3).set_target_accuracy(1e-7)
    simulator.AdvanceTo(0.1)
    found = log.FindLog(simulator.get_context())
    data = found.data().reshape(2, len(JOINT_OUTPUTS), -1)
    part = {name: data[:, i] for i, name in enumerate(JOINT_OUTPUTS)}
    expected = run_shipped("drake", "seven_bar", duration=0.1).evaluate(found.sample_times()[1:])
    for k, name in enumerate("AB"):
        size = np.abs(expected[f"{name}.ex"]).max()
        np.testing.assert_allclose(part["ex"][k, 1:], expected[f"{name}.ex"], atol=1e-3 * size)
        np.testing.assert_allclose(
            np.hypot(part["ex"], part["ey"])[k] / 3e-4, part["eccentricity_ratio"][k], atol=1e-15
        )
        np.testing.assert_allclose(np.arctan2(part["ey"], part["ex"])[k], part["attitude"][k])


def test_external_force_acts_on_the_linkage(seven_bar):
    """A constant push on the slider shows up in the drives' work."""
    tree, forces = seven_bar.tree, {}
    guide = tree.coordinates.index("guide")
    for push in (0.0, 5.0):
        builder = DiagramBuilder()
        linkage = add_linkage(builder, seven_bar, external=True)
        vector = np.zeros(linkage.plant.num_velocities())
        vector[linkage.place.velocities[guide]] = push
        source = builder.AddSystem(ConstantVectorSource(vector))
        builder.Connect(source.get_output_port(), linkage.external)
        diagram = builder.Build()
        root = diagram.CreateDefaultContext()
        linkage.set_initial_state(root)
        rates = diagram.EvalTimeDerivatives(root).CopyToVector()
        forces[push] = rates[linkage.place.v]
    assert forces[5.0][guide] - forces[0.0][guide] > 1.0
    np.testing.assert_allclose(forces[5.0][tree.driven_dofs], forces[0.0][tree.driven_dofs], atol=1e-9)


def test_a_state_between_two_steps_costs_few_steps(monkeypatch):
    """An implicit scheme that keeps a matrix from before its step shrank would crawl, in tens of thousands of steps."""
    run = run_shipped("drake", "seven_bar", duration=0.6)
    taken = []
    take = StepControl.take
    monkeypatch.setattr(StepControl, "take", lambda steps, root: (taken.append(root.get_time()), take(steps, root))[1])
    most = 0
    for middle in 0.5 * (run.time[1:] + run.time[:-1])[run.time[:-1] > 0.5]:
        taken.clear()
        run.evaluate(np.array([middle]))
        most = max(most, len(taken))
    assert 1 < most < 300


def test_a_rejected_attempt_leaves_nothing_in_the_step_after_it():
    """Drake restores the state but not its derivatives: a driven crank lagged by 1e-11 rad."""
    system = shipped("four_bar_dry", duration=0.005)
    run = simulate(system, "drake")
    np.testing.assert_allclose(run["q.O"], system.motions(run.time)[0][:, 0], rtol=0, atol=1e-13)


def test_a_step_that_throws_the_journal_through_the_wall_is_cut():
    """Far too large a step for a contact."""
    system = shipped("seven_bar_dry", duration=0.02, **{"solver.max_step": 5e-3})
    run, other = simulate(system, "drake"), simulate(system, "compiled")
    assert run.status is other.status is Status.OK
    assert run["A.penetration"].max() > 0.0
    np.testing.assert_allclose(run["q.guide"][-1], other["q.guide"][-1], rtol=0, atol=1e-8)


def test_a_run_whose_steps_collapse_keeps_what_it_computed(monkeypatch):
    """A contact needs steps far below a microsecond."""
    monkeypatch.setattr(steps, "STEPS_SMALLEST", 0.1)
    run = simulate(shipped("seven_bar_dry", duration=0.05, **{"solver.max_step": 5e-4}), "drake")
    assert run.status is Status.STEP_SIZE_COLLAPSE
    assert run.time[-1] > 0.001
    assert np.isfinite(run["A.force"]).all()


@pytest.mark.parametrize("duration", [0.01, 1e9])
def test_an_interrupted_run_of_any_duration_keeps_its_steps(duration):
    """The shortest step that counts as a collapse does not depend on the duration."""

    def press(time):
        if time > 1e-4:
            raise KeyboardInterrupt

    run = simulate(shipped("slider_crank_dry", duration=duration), "drake", press)
    assert run.status is Status.INTERRUPTED
    assert 1e-4 < run.time[-1] < 2e-4


def test_masses_that_differ_by_all_their_digits_are_named():
    with pytest.raises(
        RunError, match="singular to rounding: its masses differ by all their digits; check their units"
    ):
        simulate(shipped("seven_bar", duration=0.01, **{"sdf.links.link2.mass": 2e26}), "drake")


@pytest.mark.parametrize("radius", ["x1", "nan"])
def test_a_visual_that_drake_refuses_is_bad_input_and_nothing_else_is_said(system_of, caplog, radius):
    """Drake raises and logs."""
    sphere = f'<visual name="v"><geometry><sphere><radius>{radius}</radius></sphere></geometry></visual>'
    text = four_bar().replace("</inertial>", f"</inertial>{sphere}", 1)
    with pytest.raises(InputError, match=r"<visual>: Drake rejects it: .*radius"):
        simulate(system_of(text, "duration = 0.1\n"), "drake")
    assert not caplog.records


def test_text_behind_a_visual_is_left_out(system_of):
    """It belongs to the link: SDFormat has no use for it."""
    sphere = '<visual name="v"><geometry><sphere><radius>0.01</radius></sphere></geometry></visual>'
    text = four_bar().replace("</inertial>", f"</inertial>{sphere} --&gt; a note", 1)
    assert simulate(system_of(text, "duration = 0.001\n"), "drake").status is Status.OK


def test_two_linkages_in_one_diagram_move_as_each_does_alone(seven_bar):
    """A film of one and dry contact of the other, beside a second one of the same mechanism; the references run alone."""
    end = 0.004
    systems = [seven_bar, shipped("slider_crank_dry"), seven_bar.replaced({"drives.O1.speed": 3.0})]
    builder = DiagramBuilder()
    parts = [add_linkage(builder, system) for system in systems]
    assert [part.name for part in parts] == ["", "slider_crank", "seven_bar"]
    simulator = Simulator(builder.Build())
    root = simulator.get_mutable_context()
    for part in parts:
        part.set_initial_state(root)
    assert parts[0].advance(simulator, end) is Status.OK
    assert root.get_time() == end
    for part, system in zip(parts, systems, strict=True):
        alone = simulate(system.replaced({"duration": end, "solver.accuracy": 1e-10}))
        plant = part.plant.GetMyContextFromRoot(root)
        q, v = part.plant.GetPositions(plant), part.plant.GetVelocities(plant)
        exact = np.array([alone[f"q.{name}"][-1] for name in system.tree.coordinates])
        start = np.array([alone[f"q.{name}"][0] for name in system.tree.coordinates])
        np.testing.assert_allclose(q[part.place.positions], exact, rtol=0, atol=1e-6 * np.abs(exact - start).max())
        torques = part.drives.get_torques_output_port().Eval(part.drives.GetMyContextFromRoot(root))
        assert torques == pytest.approx([alone[f"{name}.torque"][-1] for name in part.drives.joints], rel=1e-3)
        assert np.isfinite(v).all()


def test_names_of_linkages_in_one_diagram_differ(seven_bar):
    builder = DiagramBuilder()
    for name, wanted in (("left", "left"), (None, ""), (None, "seven_bar"), (None, "seven_bar_2")):
        part = add_linkage(builder, seven_bar, name=name)
        assert part.name == wanted
        assert part.drives.get_name() == (f"{wanted}_drives" if wanted else "drives")
    with pytest.raises(InputError, match='name: "left" is taken in this diagram'):
        add_linkage(builder, seven_bar, name="left")
    builder.Build()


def test_an_element_with_a_prefix_in_a_visual_is_passed_on(system_of):
    """As Drake's own, which declare no namespace."""
    own = "<drake:accepting_renderer>one</drake:accepting_renderer>"
    sphere = f'<visual name="v"><geometry><sphere><radius>0.01</radius></sphere></geometry>{own}</visual>'
    system = system_of(four_bar().replace("</inertial>", f"</inertial>{sphere}", 1), "duration = 0.001\n")
    assert own in tree_sdf(system.tree)
    assert simulate(system, "drake").status is Status.OK


def test_an_integrator_at_its_longest_step_is_renewed():
    """The last step exceeds the longest one by rounding; Drake would reject it as the first step of a renewed matrix."""
    changes = {"duration": 0.1, "solver.accuracy": 1e-3, "solver.max_step": 1e-3}
    run = simulate(linkages.load(linkages.find_file("seven_bar.toml"), changes), "drake")
    assert run.status is Status.OK
    assert np.diff(run.time).max() == pytest.approx(1e-3)  # reached
