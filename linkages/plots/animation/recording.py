"""A Meshcat recording of a run, as one HTML file that plays offline: the linkage, its clearance joints magnified."""

from __future__ import annotations

import gc
import logging
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import Box, Cylinder, Meshcat, MeshcatParams, MeshcatVisualizer, MeshcatVisualizerParams
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlantConfig
from pydrake.systems.framework import DiagramBuilder

from linkages.engines.drake.plant import add_tree, state_place
from linkages.errors import AssemblyError
from linkages.files.numbers import rounded
from linkages.model.mechanism import Joint
from linkages.plots.animation.captions import Label, add_captions
from linkages.plots.animation.guide_view import GuideView
from linkages.plots.animation.journal_view import JournalView
from linkages.plots.animation.magnified import GROUND, View, joint_axes
from linkages.results.summary import Study
from linkages.system.ideal_motion import IdealMotion

Array = NDArray[np.float64]

_ASPECT = 1.5  # of the window for which the view is chosen
_FIELD_OF_VIEW = 25.0  # deg; narrow, so that circles at the rim look round
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
        Factor on the journals' eccentricities. The linkage is assembled anew at each frame, with its drives where
        they are and its journals that far from their bearings' centres.

    Raises
    ------
    ValueError
        If the linkage cannot be assembled with such large offsets, or its drives do not determine its motion.
    """
    page = _page(study, exaggerate)
    gc.collect()  # a diagram is freed by the collector alone, and a Meshcat must end in the thread that made it
    path.write_text(page, encoding="utf-8")


def _page(study: Study, exaggerate: float) -> str:
    tree = study.system.tree
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlant(MultibodyPlantConfig(time_step=0.0), builder)
    instance = add_tree(plant, tree)
    plant.Finalize()
    positions = state_place(plant, tree, instance).positions
    logging.getLogger("drake").setLevel(logging.WARNING)  # not the address of a server that nobody needs
    meshcat = Meshcat(MeshcatParams(show_stats_plot=False))
    visualizer = MeshcatVisualizer.AddToBuilder(
        builder, scene_graph, meshcat, MeshcatVisualizerParams(publish_period=1.0 / _FRAMES_PER_SECOND)
    )
    diagram = builder.Build()
    times, q = frames(study, exaggerate)
    slow = max(1.0, _LENGTH / times[-1])
    views = _joint_views(study, meshcat, times)
    _look_at(study, meshcat, views)
    _draw_ground(study, meshcat)
    root = diagram.CreateDefaultContext()
    context = plant.GetMyMutableContextFromRoot(root)
    full = plant.GetPositions(context).copy()
    visualizer.StartRecording(set_transforms_while_recording=False)
    for frame, (t, coordinates) in enumerate(zip(times, q, strict=True)):
        full[positions] = coordinates
        plant.SetPositions(context, full)
        root.SetTime(slow * t)
        diagram.ForcedPublish(root)
        for view in views:
            view.show(frame, slow * t)
    visualizer.StopRecording()
    visualizer.PublishRecording()
    places: dict[tuple[float, ...], list[Joint]] = {}
    for joint in study.system.mechanism.joints:  # those at one place are named together
        places.setdefault(tuple((joint.position / study.system.tree.extent).round(6) + 0.0), []).append(joint)
    names = [
        Label(_anchor(study, meshcat, group[0]), ", ".join(one.name for one in group), []) for group in places.values()
    ]
    return _captioned(meshcat.StaticHtml(), study, views, names, times, slow)


def _anchor(study: Study, meshcat: Meshcat, joint: Joint) -> str:
    """Fix a place to the link that a joint belongs to; returns its path in the scene."""
    mechanism = study.system.mechanism
    name, at = (joint.child, joint.position) if joint.child != "world" else (joint.parent, joint.position_on_parent)
    link = mechanism.link[name]
    path = f"/drake/visualizer/{mechanism.name}/{name}/name of {joint.name}"
    meshcat.SetTransform(path, RigidTransform(link.rotation.T @ (at - link.translation)))
    return path


def frames(study: Study, exaggerate: float = 1.0) -> tuple[Array, Array]:
    """Compute times (n,) [s] and tree coordinates (n, nq) of the frames; parameters as `write_animation`."""
    tree, run = study.system.tree, study.run
    count = int(np.ceil(max(_LENGTH, run.time[-1]) * _FRAMES_PER_SECOND / 2)) + 1
    times = np.linspace(0.0, run.time[-1], count)
    if not study.system.determinate:
        if exaggerate != 1.0:
            raise ValueError("the drives do not determine the motion: its clearance cannot be exaggerated")
        return times, _recorded(study, times)
    offset = np.zeros((len(times), len(tree.closure_rows)))
    for k, name in enumerate(tree.play):
        parts = ("ex", "ey") if study.system.mechanism.joint[name].bearing is not None else ("offset", "tilt")
        for axis, part in enumerate(parts):
            offset[:, 2 * k + axis] = exaggerate * np.interp(times, run.time, run[f"{name}.{part}"])
    try:
        return times, IdealMotion(study.system).states(times, offset)[0]
    except AssemblyError as problem:
        if exaggerate == 1.0:  # a run that came to a dead position, and through by its own errors
            return times, _recorded(study, times)
        raise ValueError(f"the linkage does not close with its clearance exaggerated {exaggerate:g} times") from problem


def _recorded(study: Study, times: Array) -> Array:
    """Tree coordinates between the run's steps."""
    columns = [study.run[f"q.{name}"] for name in study.system.tree.coordinates]
    return np.stack([np.interp(times, study.run.time, column) for column in columns], axis=1)


def _span(study: Study) -> tuple[Array, Array]:
    """Lower left and upper right corner of everything that moves, plane axes [m]."""
    paths = [_path(study, name) for name in study.system.mechanism.point]
    places = np.concatenate([*paths, *_rails(study).values()])
    return places.min(axis=0), places.max(axis=0)


def _path(study: Study, name: str) -> Array:
    """Positions (n, 2) of a link or frame over the run, plane axes [m]."""
    return np.column_stack([study.run[f"{name}.x"], study.run[f"{name}.y"]])


def _rails(study: Study) -> dict[str, Array]:
    """Find the ends (2, 2) of each rail on the ground, plane axes [m]: the travel of a prismatic joint, and more."""
    result = {}
    for joint in study.system.mechanism.joints:
        if joint.type == "prismatic" and "world" in (joint.parent, joint.child):
            block, at = (joint.child, joint.on_child) if joint.parent == "world" else (joint.parent, joint.on_parent)
            travel = (_path(study, block) - study.system.mechanism.link[block].origin) @ joint.direction
            margin = 0.2 * np.ptp(travel) + 0.05 * study.system.tree.extent
            reach = [travel.min() - margin, travel.max() + margin]
            result[joint.name] = at + np.outer(reach, joint.direction)
    return result


def _joint_views(study: Study, meshcat: Meshcat, times: Array) -> list[View]:
    """Draw the clearance joints right of the linkage, two above each other."""
    names = study.system.tree.play
    low, high = _span(study)
    height = max(high[1] - low[1], 0.75 * (high[0] - low[0]), 0.3 * study.system.tree.extent)
    rows = min(len(names), 2)
    radius = height / (3.0 * max(rows, 1.5))
    views: list[View] = []
    for k, name in enumerate(names):
        column, row = divmod(k, 2)
        right = high[0] + radius * (2.0 + 3.0 * column)
        up = 0.5 * (low[1] + high[1]) + 3.2 * radius * (0.5 * (rows - 1) - row)
        kind = JournalView if study.system.mechanism.joint[name].type == "revolute" else GuideView
        views.append(kind(meshcat, study, name, np.array([right, up]), radius, times))
    return views


def _look_at(study: Study, meshcat: Meshcat, views: list[View]) -> None:
    """Look along the plane's normal at the middle of everything that moves."""
    low, high = _span(study)
    for view in views:
        low = np.minimum(low, view.centre - 1.3 * view.radius)
        high = np.maximum(high, view.centre + 1.5 * view.radius)
    size = np.maximum(high - low, 0.3 * study.system.tree.extent)
    basis = study.system.mechanism.basis
    middle = basis[:, :2] @ (0.5 * (low + high))
    shown = 1.25 * max(size[1], size[0] / _ASPECT)
    distance = 0.5 * shown / np.tan(0.5 * np.radians(_FIELD_OF_VIEW))
    meshcat.SetCamera(Meshcat.PerspectiveCamera(fov=_FIELD_OF_VIEW))
    meshcat.SetProperty("/Background", "top_color", [1.0, 1.0, 1.0])
    meshcat.SetProperty("/Background", "bottom_color", [0.93, 0.94, 0.96])
    meshcat.SetProperty("/Grid", "visible", False)
    meshcat.SetProperty("/Axes", "visible", False)
    meshcat.SetCameraPose(middle + distance * (basis[:, 2] - 0.15 * basis[:, 1]), middle)


def _draw_ground(study: Study, meshcat: Meshcat) -> None:
    """Mark the joints on the ground: a pivot for each revolute joint, a rail for each prismatic one."""
    mechanism, size = study.system.mechanism, study.system.tree.extent
    basis = mechanism.basis
    for joint in mechanism.joints:
        if "world" not in (joint.parent, joint.child):
            continue
        if joint.type == "revolute":
            shape, position = Cylinder(0.012 * size, 0.03 * size), joint.position
        elif joint.type == "prismatic":
            start, end = _rails(study)[joint.name]
            shape = Box(float(np.linalg.norm(end - start)), 0.004 * size, 0.004 * size)
            position = basis[:, :2] @ (0.5 * (start + end)) + basis[:, 2] * (basis[:, 2] @ joint.position)
        else:
            continue
        pose = RigidTransform(RotationMatrix(joint_axes(mechanism, joint)), position)
        meshcat.SetObject(f"/ground/{joint.name}", shape, GROUND)
        meshcat.SetTransform(f"/ground/{joint.name}", pose)


def _captioned(page: str, study: Study, views: list[View], names: list[Label], times: Array, slow: float) -> str:
    """Write names, eccentricities, forces and the time over the recording."""
    labels = [
        Label(f"{view.path}/label", view.name, [view.caption(frame) for frame in range(len(times))]) for view in views
    ] + names
    pace = f"{rounded(slow)} times slower than the machine" if slow > 1.0 else "as fast as the machine"
    clock = [f"t = {t:.4f} s, {pace}" for t in times]
    scales = "; ".join(f"{view.name}: {view.scales}" for view in views)
    legend = (
        "Beside the linkage: clearances magnified; the orbit of the journal's centre (line), the largest force on it"
        f" within each frame (arrow, its length by the square root) and where it touches (spot). {scales}"
    )
    return add_captions(page, labels, clock, legend if views else "")
