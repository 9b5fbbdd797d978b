"""The systems of a linkage, connected: for `simulate` and for users' diagrams."""

from __future__ import annotations

import shutil
import subprocess
from dataclasses import dataclass
from itertools import chain, count

import numpy as np
from pydrake.geometry import Meshcat, MeshcatVisualizer, MeshcatVisualizerParams, SceneGraph
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlant, MultibodyPlantConfig
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, Diagram, DiagramBuilder, EventStatus, InputPort, OutputPort
from pydrake.systems.primitives import Adder, ConstantVectorSource

from linkages.base.errors import InputError, Status
from linkages.elements.analysis import Analysis
from linkages.engines.budget import Budget
from linkages.engines.drake.clearance import ClearanceJoints, JointsWithStates
from linkages.engines.drake.drives import Drives, StatefulDrives
from linkages.engines.drake.plant import StatePlace, add_tree, state_place
from linkages.engines.drake.steps import StepControl, drives_of, is_collapse
from linkages.engines.numerics import DIAGRAM_FIRST
from linkages.results.trajectory import TimeReport
from linkages.system import System
from linkages.system.ideal_motion import cause
from linkages.system.rigid_segments import segmented


@dataclass(frozen=True)
class Linkage:
    """The systems of one linkage in a diagram; made by `add_linkage`.

    Attributes
    ----------
    name : str
        Prefix of the names of its systems, ``name_plant``; empty without.
    system : System
        The simulated system: with rigid segments instead of flexible links.
    plant, scene_graph
        Continuous plant of the linkage's spanning tree, and its geometry.
    clearance : ClearanceJoints or None
        None without clearance joints, stops and points at lines.
    drives : Drives
    external : InputPort or None
        Optional input of generalised forces (nv,) of other systems, which the drives take into account.
    place : StatePlace
        Places of the tree's coordinates in the plant's state.
    """

    name: str
    system: System
    plant: MultibodyPlant
    scene_graph: SceneGraph
    clearance: ClearanceJoints | None
    drives: Drives
    external: InputPort | None
    place: StatePlace

    def set_initial_state(self, root: Context) -> None:
        """Set the assembled state at t = 0, and the contacts' memory, in a context of the whole diagram."""
        context = self.plant.GetMyMutableContextFromRoot(root)
        q, v = self.plant.GetPositions(context).copy(), self.plant.GetVelocities(context).copy()
        q[self.place.positions], v[self.place.velocities] = self.system.assembly.q, self.system.assembly.v
        self.plant.SetPositions(context, q)
        self.plant.SetVelocities(context, v)
        if self.clearance is not None:
            self.clearance.begin(self.clearance.GetMyMutableContextFromRoot(root))
        if isinstance(self.drives, StatefulDrives):
            self.drives.begin(self.drives.GetMyMutableContextFromRoot(root))

    def advance(
        self, simulator: Simulator, until: float, progress: TimeReport | None = None, limit: int | None = None
    ) -> Status:
        """Advance a simulator of a diagram with this linkage, where `Simulator.AdvanceTo` may stall.

        Use it instead of `Simulator.AdvanceTo` for stiff films: Drake's integrators can reduce the step to nanoseconds
        and never recover (`linkages.engines.drake.steps`). This function detects it and restarts the integrator. The
        simulator gets the integrator of the experiment's `solver`; its monitor is replaced during the call and cleared
        at the end. Several linkages in one diagram advance together, by one call for any of them, with the smallest
        accuracy and the shortest steps of their experiments.

        Parameters
        ----------
        simulator : Simulator
            Simulator of the whole diagram.
        until : float
            Final time [s].
        progress : callable, optional
            Called with the simulated time [s] after every step.
        limit : int, optional
            Largest number of steps; default: 5 million (more than an hour).

        Returns
        -------
        Status
            OK; LOCKED at a dead point of the drives; TOO_MANY_STEPS if the end is out of reach, as for a mechanism in
            millimetres; STEP_SIZE_COLLAPSE; LOOP_OPEN.
            The simulator keeps its last state and can be advanced further.
        """
        drives = {self.drives: None, **dict.fromkeys(drives_of(simulator.get_system()))}
        steps, budget = StepControl(simulator, *(each.system for each in drives)), Budget(self.system, limit)

        def look(root: Context) -> EventStatus:
            steps.take(root)
            if progress is not None:
                progress(root.get_time())
            if budget.spent(root.get_time()):
                return steps.end(Status.TOO_MANY_STEPS)
            if steps.kept and any(each.has_open_loop(root) for each in drives):
                return steps.end(Status.LOOP_OPEN)
            return steps.verdict()

        simulator.set_monitor(look)
        try:
            steps.begin(DIAGRAM_FIRST * steps.largest, steps.accuracy)
            steps.advance(until)
            status = steps.status
        except RuntimeError as problem:
            if not is_collapse(problem):
                raise
            status = Status.STEP_SIZE_COLLAPSE
        finally:
            simulator.clear_monitor()
        return cause(status, self.system, simulator.get_context().get_time())[0]

    def speed(self, drive: str) -> OutputPort:
        """Return the output port of a driven joint's speed, (1,) [rad/s or m/s]."""
        return self.drives.GetOutputPort(f"{drive}.speed")

    def torque(self, drive: str) -> InputPort:
        """Return the input port of a torque added to a drive by torque, (1,) [N m or N]; zero if not connected."""
        return self.drives.GetInputPort(f"{drive}.torque")


def add_linkage(
    builder: DiagramBuilder,
    system: System,
    *,
    external: bool = False,
    meshcat: Meshcat | None = None,
    name: str | None = None,
    samples: bool = False,
) -> Linkage:
    """Add a linkage with its clearance joints and drives to a diagram under construction.

    Parameters
    ----------
    builder : DiagramBuilder
    system : System
        From `linkages.load`. Flexible links become chains of rigid segments (`linkages.system.rigid_segments`).
    external : bool
        Whether to provide an input for generalised forces of other systems (`Linkage.external`).
    meshcat : Meshcat, optional
        Shows the linkage while it runs.
    name : str, optional
        Prefix of the names of its systems in the diagram: ``name_plant``. Default: none for the first linkage, and
        for others the mechanism's name, with a number if it is taken.
    samples : bool
        Whether the caller pauses at the sampling instants of states, and calls `StatefulDrives.sample` there.

    Raises
    ------
    AssemblyError
        If the linkage cannot be assembled.
    InputError
        If Drake does not support a model (`linkages.input.model.capabilities`), or the diagram has a linkage of this
        name.
    """
    name = _free_name(builder, system) if name is None else name
    if _is_taken(builder, name):
        raise InputError("argument", "name", f'"{name}" is taken in this diagram; choose another one, or leave it out')
    system.check_analysis(Analysis.DRAKE)
    if not samples:
        system.check_analysis(Analysis.DIAGRAM)
    if external and (system.loads[0]["joint"] >= 0).any():
        raise InputError(
            "argument", "external", "adds forces that the friction of a joint cannot know; use no coefficient"
        )
    system = segmented(system)
    system.assembly  # noqa: B018 (raises before anything is added)
    tree = system.tree
    plant, scene_graph = AddMultibodyPlant(MultibodyPlantConfig(time_step=0.0), builder)
    plant.mutable_gravity_field().set_gravity_vector(system.experiment.gravity)
    plant.set_name(_named(name, "plant"))
    scene_graph.set_name(_named(name, "scene_graph"))
    instance = add_tree(plant, tree)
    plant.Finalize()
    if meshcat is not None:
        shown = MeshcatVisualizer.AddToBuilder(
            builder, scene_graph, meshcat, MeshcatVisualizerParams(prefix=_named(name, "visualizer"))
        )
        shown.set_name(_named(name, "meshcat_visualizer"))
    place = state_place(plant, tree, instance)
    state, clearance, port = plant.get_state_output_port(), None, None
    if system.contacts:
        kind = JointsWithStates if len(system.law_states.names) else ClearanceJoints
        clearance = builder.AddNamedSystem(_named(name, "clearance_joints"), kind(system, place))
        builder.Connect(state, clearance.get_input_port(0))
    direct = clearance.GetOutputPort("evaluation") if clearance is not None and not external else None
    extra = direct.size() - plant.num_velocities() if direct is not None else 0
    kind_of_drives = StatefulDrives if system.own_states else Drives
    drives = builder.AddNamedSystem(_named(name, "drives"), kind_of_drives(system, place, extra))
    builder.Connect(state, drives.GetInputPort("state"))
    builder.Connect(drives.get_force_output_port(), plant.get_applied_generalized_force_input_port())
    if direct is not None:
        builder.Connect(direct, drives.GetInputPort("applied"))
    elif clearance is not None:
        adder = builder.AddNamedSystem(_named(name, "applied_forces"), Adder(2, plant.num_velocities()))
        builder.Connect(clearance.get_force_output_port(), adder.get_input_port(0))
        builder.Connect(adder.get_output_port(), drives.GetInputPort("applied"))
        port = adder.get_input_port(1)
    elif external:
        port = drives.GetInputPort("applied")
    else:
        nothing = builder.AddNamedSystem(
            _named(name, "no_forces"), ConstantVectorSource(np.zeros(plant.num_velocities()))
        )
        builder.Connect(nothing.get_output_port(), drives.GetInputPort("applied"))
    return Linkage(name, system, plant, scene_graph, clearance, drives, port, place)


def _named(name: str, part: str) -> str:
    return f"{name}_{part}" if name else part


def _is_taken(builder: DiagramBuilder, name: str) -> bool:
    """Tell whether a diagram has a linkage of this name."""
    return any(builder.HasSubsystemNamed(_named(name, part)) for part in ("plant", "scene_graph", "drives"))


def _free_name(builder: DiagramBuilder, system: System) -> str:
    """Return a name that the diagram does not have yet: none, the mechanism's, the same with a number."""
    own = system.description.machine
    names = chain(["", own], (f"{own}_{number}" for number in count(2)))
    return next(name for name in names if not _is_taken(builder, name))


def build_diagram(system: System, meshcat: Meshcat | None = None, samples: bool = False) -> tuple[Diagram, Linkage]:
    """Build the diagram of a system, ready for Drake's `Simulator`.

    Parameters
    ----------
    system : System
        From `linkages.load`.
    meshcat : Meshcat, optional
        Shows the linkage while it runs.
    samples : bool
        See `add_linkage`.

    Returns
    -------
    diagram : Diagram
    linkage : Linkage
        The linkage's systems; `Linkage.set_initial_state` sets the assembled state in a context.
    """
    builder = DiagramBuilder()
    linkage = add_linkage(builder, system, meshcat=meshcat, samples=samples)
    diagram = builder.Build()
    diagram.set_name(system.description.machine)
    return diagram, linkage


@dataclass(frozen=True)
class DiagramPicture:
    """The Jupyter view of a diagram, drawn by Graphviz or as a table of its connections; made by `picture`.

    Attributes
    ----------
    svg : str or None
        Graphviz's drawing; None if the program ``dot`` is not installed.
    connections : tuple of (str, str)
        Output and input ports that are connected, as ``system.port``.
    """

    svg: str | None
    connections: tuple[tuple[str, str], ...]

    def _repr_mimebundle_(self, **_: object) -> dict[str, str]:
        if self.svg is not None:
            return {"image/svg+xml": self.svg, "text/plain": str(self)}
        rows = "".join(f"| `{output}` | `{taker}` |\n" for output, taker in self.connections)
        note = "\n*Install Graphviz (`dot`) to see the diagram drawn.*\n"
        return {"text/markdown": f"| output | input |\n|---|---|\n{rows}{note}", "text/plain": str(self)}

    def __str__(self) -> str:
        width = max((len(output) for output, _ in self.connections), default=0)
        return "\n".join(f"{output:{width}s} -> {taker}" for output, taker in self.connections)


def picture(diagram: Diagram) -> DiagramPicture:
    """Draw a diagram's systems and the connections between them."""
    connections = sorted(
        (
            f"{giver.get_name()}.{giver.get_output_port(output).get_name()}",
            f"{taker.get_name()}.{taker.get_input_port(entry).get_name()}",
        )
        for (taker, entry), (giver, output) in diagram.connection_map().items()
    )
    svg = None
    if dot := shutil.which("dot"):
        text = diagram.GetGraphvizString(max_depth=1)
        svg = subprocess.run([dot, "-Tsvg"], input=text, capture_output=True, text=True, check=True).stdout
    return DiagramPicture(svg, tuple(connections))
