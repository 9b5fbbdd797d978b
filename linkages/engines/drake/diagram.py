"""The systems of a linkage, connected: for our own runs and for diagrams of the user's."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from pydrake.geometry import Meshcat, MeshcatVisualizer, SceneGraph
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlant, MultibodyPlantConfig
from pydrake.systems.framework import Context, Diagram, DiagramBuilder, InputPort
from pydrake.systems.primitives import Adder, ConstantVectorSource

from linkages.engines.drake.clearance import ClearanceJoints
from linkages.engines.drake.drives import Drives
from linkages.engines.drake.plant import Indices, add_tree, state_indices
from linkages.model.experiment import Experiment
from linkages.model.mechanism import Mechanism
from linkages.planar.motion import Motions
from linkages.system.assembly import Assembly, assemble
from linkages.system.law_records import film_tables, law_parameters
from linkages.system.loads import pack_loads


@dataclass(frozen=True)
class Linkage:
    """The systems of one linkage in a diagram.

    Attributes
    ----------
    assembly : Assembly
    plant, scene_graph
        Continuous plant of the linkage's spanning tree, and its geometry.
    clearance : ClearanceJoints or None
        None if no joint has play.
    drives : Drives
    external : InputPort or None
        If asked for: takes generalised forces (nv,) of the user's own systems, which the drives then know of.
    positions, velocities : arrays of int
        Where the tree's coordinates stand in the plant's positions and velocities.
    """

    assembly: Assembly
    plant: MultibodyPlant
    scene_graph: SceneGraph
    clearance: ClearanceJoints | None
    drives: Drives
    external: InputPort | None
    positions: Indices
    velocities: Indices

    def set_initial_state(self, root: Context) -> None:
        """Put the assembled state at t = 0 into a context of the whole diagram."""
        context = self.plant.GetMyMutableContextFromRoot(root)
        q, v = self.plant.GetPositions(context).copy(), self.plant.GetVelocities(context).copy()
        q[self.positions], v[self.velocities] = self.assembly.q, self.assembly.v
        self.plant.SetPositions(context, q)
        self.plant.SetVelocities(context, v)


def add_linkage(
    builder: DiagramBuilder, mechanism: Mechanism, experiment: Experiment, *, external: bool = False
) -> Linkage:
    """Add a linkage with its clearance joints and drives to a diagram under construction.

    Parameters
    ----------
    builder : DiagramBuilder
    mechanism, experiment
    external : bool
        Whether to provide an input for generalised forces of the user's own systems (`Linkage.external`).

    Raises
    ------
    AssemblyError, InputError
        If the linkage cannot be assembled.
    """
    assembly = assemble(mechanism, experiment)
    tree = assembly.tree
    plant, scene_graph = AddMultibodyPlant(MultibodyPlantConfig(time_step=0.0), builder)
    plant.mutable_gravity_field().set_gravity_vector(experiment.gravity)
    instance = add_tree(plant, tree)
    plant.Finalize()
    positions, velocities = state_indices(plant, tree, instance)
    order = (positions, velocities, plant.num_positions(), plant.num_velocities())
    torques = Motions([experiment.drives[name].torque_history() for name in tree.powered])
    gravity = mechanism.basis[:, :2].T @ np.array(experiment.gravity)
    state, clearance, port = plant.get_state_output_port(), None, None
    if tree.play:
        clearance = builder.AddSystem(
            ClearanceJoints(tree, law_parameters(tree, experiment), film_tables(tree, experiment), *order)
        )
        builder.Connect(state, clearance.get_input_port(0))
    direct = clearance.get_evaluation_output_port() if clearance is not None and not external else None
    extra = direct.size() - plant.num_velocities() if direct is not None else 0
    drives = builder.AddSystem(
        Drives(
            tree,
            assembly.motions,
            torques,
            pack_loads(tree, experiment),
            gravity,
            experiment.solver.stabilisation,
            *order,
            extra,
        )
    )
    builder.Connect(state, drives.get_state_input_port())
    builder.Connect(drives.get_force_output_port(), plant.get_applied_generalized_force_input_port())
    if direct is not None:
        builder.Connect(direct, drives.get_applied_input_port())
    elif clearance is not None:
        adder = builder.AddNamedSystem("applied_forces", Adder(2, plant.num_velocities()))
        builder.Connect(clearance.get_force_output_port(), adder.get_input_port(0))
        builder.Connect(adder.get_output_port(), drives.get_applied_input_port())
        port = adder.get_input_port(1)
    elif external:
        port = drives.get_applied_input_port()
    else:
        nothing = builder.AddNamedSystem("no_forces", ConstantVectorSource(np.zeros(plant.num_velocities())))
        builder.Connect(nothing.get_output_port(), drives.get_applied_input_port())
    return Linkage(assembly, plant, scene_graph, clearance, drives, port, positions, velocities)


def build_diagram(
    mechanism: Mechanism, experiment: Experiment, meshcat: Meshcat | None = None
) -> tuple[Diagram, Linkage]:
    """Build the diagram of an experiment, ready for Drake's `Simulator`.

    Parameters
    ----------
    mechanism, experiment
    meshcat : Meshcat, optional
        Shows the linkage while it runs.

    Returns
    -------
    diagram : Diagram
    linkage : Linkage
        Its systems; `Linkage.set_initial_state` puts the assembled state into a context.
    """
    builder = DiagramBuilder()
    linkage = add_linkage(builder, mechanism, experiment)
    if meshcat is not None:
        MeshcatVisualizer.AddToBuilder(builder, linkage.scene_graph, meshcat)
    diagram = builder.Build()
    diagram.set_name(mechanism.name)
    return diagram, linkage
