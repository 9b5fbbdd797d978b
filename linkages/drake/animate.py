"""A Meshcat recording of a run, as one HTML file that plays offline."""

from __future__ import annotations

import logging
from pathlib import Path

import numpy as np
from pydrake.geometry import (
    Box,
    Cylinder,
    Meshcat,
    MeshcatParams,
    MeshcatVisualizer,
    MeshcatVisualizerParams,
    Rgba,
)
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlantConfig
from pydrake.systems.framework import DiagramBuilder

from linkages.assembly import AssemblyError, IdealMotion
from linkages.drake.plant import add_tree, state_indices
from linkages.run import Study

_FRAMES_PER_SECOND = 60.0
_LENGTH = 8.0  # shown seconds of an animation of a run of any duration


def write_animation(study: Study, path: Path, exaggerate: float = 1.0) -> None:
    """Write the run as an animation.

    Parameters
    ----------
    study : Study
    path : Path
        The HTML file.
    exaggerate : float
        Factor on the journals' offsets from their bearings. With a factor other than one the linkage is assembled
        anew at each frame, with its drives as they are and its journals offset by the factor.

    Raises
    ------
    ValueError
        If the linkage cannot be assembled with such large offsets, or its drives do not determine its motion.
    """
    tree = study.assembly.tree
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlant(MultibodyPlantConfig(time_step=0.0), builder)
    instance = add_tree(plant, tree)
    plant.Finalize()
    positions, _ = state_indices(plant, tree, instance)
    logging.getLogger("drake").setLevel(logging.WARNING)  # not the address of a server that nobody needs
    meshcat = Meshcat(MeshcatParams(show_stats_plot=False))
    visualizer = MeshcatVisualizer.AddToBuilder(
        builder, scene_graph, meshcat, MeshcatVisualizerParams(publish_period=1.0 / _FRAMES_PER_SECOND)
    )
    diagram = builder.Build()
    times, q = _frames(study, exaggerate)
    slow = max(1.0, _LENGTH / times[-1])
    _look_at(study, meshcat)
    _draw_ground(study, meshcat)
    root = diagram.CreateDefaultContext()
    context = plant.GetMyMutableContextFromRoot(root)
    full = plant.GetPositions(context).copy()
    visualizer.StartRecording(set_transforms_while_recording=False)
    for t, coordinates in zip(times, q, strict=True):
        full[positions] = coordinates
        plant.SetPositions(context, full)
        root.SetTime(slow * t)
        diagram.ForcedPublish(root)
    visualizer.StopRecording()
    visualizer.PublishRecording()
    path.write_text(meshcat.StaticHtml(), encoding="utf-8")


def _frames(study: Study, exaggerate: float) -> tuple[np.ndarray, np.ndarray]:
    """Compute times and tree coordinates of the frames."""
    tree, run = study.assembly.tree, study.run
    frames = int(np.ceil(max(_LENGTH, run.time[-1]) * _FRAMES_PER_SECOND / 2)) + 1
    times = np.linspace(0.0, run.time[-1], frames)
    if not study.assembly.determinate:
        if exaggerate != 1.0:
            raise ValueError("the drives do not determine the motion: its clearance cannot be exaggerated")
        q = np.stack([np.interp(times, run.time, run[f"q.{name}"]) for name in tree.coordinates], axis=1)
        return times, q
    offset = np.zeros((len(times), len(tree.closure_rows)))
    for k, name in enumerate(tree.play):
        parts = ("ex", "ey") if study.mechanism.joint[name].bearing is not None else ("offset", "tilt")
        for axis, part in enumerate(parts):
            offset[:, 2 * k + axis] = exaggerate * np.interp(times, run.time, run[f"{name}.{part}"])
    try:
        return times, IdealMotion(study.assembly, study.experiment).states(times, offset)[0]
    except AssemblyError as problem:
        raise ValueError(
            f"the linkage does not close with its clearance exaggerated {exaggerate:g} times"
        ) from problem


def _look_at(study: Study, meshcat: Meshcat) -> None:
    """Look along the plane's normal at the middle of everything that moves."""
    names = [link.name for link in study.mechanism.links]
    x = np.concatenate([study.run[f"{name}.x"] for name in names])
    y = np.concatenate([study.run[f"{name}.y"] for name in names])
    basis = study.mechanism.basis
    middle = basis[:, 0] * (x.min() + x.max()) / 2 + basis[:, 1] * (y.min() + y.max()) / 2
    distance = 0.8 * max(np.ptp(x), np.ptp(y), 0.5 * study.assembly.tree.extent) + 0.05
    meshcat.SetProperty("/Background", "top_color", [1.0, 1.0, 1.0])
    meshcat.SetProperty("/Background", "bottom_color", [0.93, 0.94, 0.96])
    meshcat.SetProperty("/Grid", "visible", False)
    meshcat.SetProperty("/Axes", "visible", False)
    meshcat.SetCameraPose(middle + distance * (basis[:, 2] - 0.25 * basis[:, 1]), middle)


def _draw_ground(study: Study, meshcat: Meshcat) -> None:
    """Mark the joints on the ground: a pivot for each revolute joint, a rail for each prismatic one."""
    mechanism, size = study.mechanism, study.assembly.tree.extent
    basis = mechanism.basis
    for joint in mechanism.joints:
        if "world" not in (joint.parent, joint.child):
            continue
        if joint.type == "revolute":
            shape = Cylinder(0.012 * size, 0.03 * size)
            pose = RigidTransform(RotationMatrix(basis), joint.position)
        elif joint.type == "prismatic":
            reach = max(
                np.ptp(study.run[f"{joint.child}.x"]), np.ptp(study.run[f"{joint.child}.y"]), 0.1 * size
            )
            shape = Box(2.4 * reach, 0.004 * size, 0.004 * size)
            along = basis[:, :2] @ joint.direction
            axes = np.column_stack([along, np.cross(basis[:, 2], along), basis[:, 2]])
            pose = RigidTransform(RotationMatrix(axes), joint.position)
        else:
            continue
        meshcat.SetObject(f"/ground/{joint.name}", shape, Rgba(0.25, 0.25, 0.25, 1.0))
        meshcat.SetTransform(f"/ground/{joint.name}", pose)
