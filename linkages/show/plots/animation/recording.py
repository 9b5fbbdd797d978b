"""A Meshcat recording of a run, as one HTML file that plays offline: the linkage, its clearance joints magnified."""

from __future__ import annotations

import gc
import logging
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from markupsafe import Markup, escape
from pydrake.geometry import Meshcat, MeshcatParams, MeshcatVisualizer, MeshcatVisualizerParams
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlantConfig
from pydrake.systems.framework import Context, DiagramBuilder

from linkages.base.arrays import Array
from linkages.base.errors import AssemblyError
from linkages.base.palette import css
from linkages.engines.drake.plant import add_tree, state_place
from linkages.input.files.magnitudes import rounded
from linkages.results.assessment import Assessment
from linkages.show.plots.animation.bounds import bounds
from linkages.show.plots.animation.joint_views import GuideView, JournalView
from linkages.show.plots.animation.surroundings import SCALE, Surroundings
from linkages.show.plots.pages import columns, curves, embedded, filled, own_text, script, shared_style
from linkages.show.plots.style import round_length
from linkages.system import System
from linkages.system.ideal_motion import ideal_motion
from linkages.system.joints import SystemJoint
from linkages.system.rigid_segments import Segmented, segmented, system_of

_ASPECT = 2.0  # assumed width over height of the window
_FIELD_OF_VIEW = 25.0  # field of view [deg]; narrow, so that circles at the edge look round
_FRAMES_PER_SECOND = 60.0
_DEFLECTION = 0.05  # largest drawn deflection over the linkage's size
_POSES = 60  # about as many poses are looked at for the bounds of the shapes
_LENGTH = 8.0  # duration of every animation [s]

_VIEWPORT = '<meta name="viewport" content="width=device-width, initial-scale=1">'
Views = list[JournalView | GuideView]


def write_recording(assessment: Assessment, path: Path, exaggerate: float | None = None) -> None:
    """Write the run as a Meshcat recording, an HTML file.

    `exaggerate` is a factor on the journals' eccentricities and on the deflections of flexible links; default: true
    eccentricities, and deflections magnified until visible. The linkage is assembled again at each frame with its drive
    positions, magnified eccentricities and magnified deflections. ValueError if it cannot be assembled with these
    offsets, or its drives do not determine its motion.
    """
    page = _page(assessment, exaggerate)
    gc.collect()  # only the collector frees a diagram, and a Meshcat must end in the thread that created it
    path.write_text(page, encoding="utf-8")


def _page(assessment: Assessment, exaggerate: float | None) -> str:
    shown = segmented(assessment.system)
    tree = shown.tree
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlant(MultibodyPlantConfig(time_step=0.0), builder)
    instance = add_tree(plant, tree)
    plant.Finalize()
    positions = state_place(plant, tree, instance).positions
    logging.getLogger("drake").setLevel(logging.WARNING)  # hides the address of an unneeded server
    meshcat = Meshcat(MeshcatParams(show_stats_plot=False))
    visualizer = MeshcatVisualizer.AddToBuilder(
        builder, scene_graph, meshcat, MeshcatVisualizerParams(publish_period=1.0 / _FRAMES_PER_SECOND)
    )
    diagram = builder.Build()
    times, q, magnified = frames(assessment, exaggerate, shown)
    start, slow = times[0], max(1.0, _LENGTH / (times[-1] - times[0]))
    root = diagram.CreateDefaultContext()
    context = plant.GetMyMutableContextFromRoot(root)
    full = plant.GetPositions(context).copy()

    def posed(rows: Array) -> Iterator[Context]:
        """Move the plant to the coordinates of each row."""
        for full[positions] in rows:
            plant.SetPositions(context, full)
            yield context

    few = q[:: 1 + len(q) // _POSES]
    surroundings = Surroundings(assessment, meshcat, bounds(plant, scene_graph, posed(few), shown.basis[:, :2]))
    span = surroundings.span()
    views = _joint_views(assessment, meshcat, times, *span)
    seen = _look_at(assessment, meshcat, views, *span)
    scale = surroundings.draw()
    visualizer.StartRecording(set_transforms_while_recording=False)
    for frame, (t, _) in enumerate(zip(times, posed(q), strict=True)):
        root.SetTime(slow * (t - start))
        diagram.ForcedPublish(root)
        for view in views:
            view.show(frame, slow * (t - start))
    visualizer.StopRecording()
    visualizer.PublishRecording()
    places: dict[tuple[float, ...], list[SystemJoint]] = {}
    for joint in assessment.system.joints.values():  # joints at one place get a common label
        places.setdefault(tuple((joint.position / assessment.system.tree.extent).round(6) + 0.0), []).append(joint)
    counts = range(len(times))
    labels = [_label(f"{view.path}/label", view.name, [view.caption(k) for k in counts]) for view in views]
    for group in places.values():
        anchor = _anchor(shown, meshcat, shown.joints[group[0].name])
        labels.append(_label(anchor, ", ".join(one.name for one in group)))
    labels.append(_label(SCALE, scale))
    said = _texts(assessment, views, times, slow, magnified)
    return add_captions(meshcat.StaticHtml(), {"labels": labels, "view": seen.tolist(), "aspect": _ASPECT, **said})


def _label(anchor: str, title: str, lines: Sequence[str] = ()) -> dict[str, Any]:
    """Make a label at a Meshcat path: a title, and below it a line for each frame, if any."""
    return {"path": anchor.strip("/").split("/"), "title": title, "lines": list(lines)}


def _anchor(shown: System, meshcat: Meshcat, joint: SystemJoint) -> str:
    """Fix an anchor to the link of a joint; return its path in the scene."""
    name, at = (joint.child, joint.position) if joint.child != "world" else (joint.parent, joint.position_on_parent)
    link = shown.links[name]
    path = f"/drake/visualizer/{shown.description.machine}/{name}/name of {joint.name}"
    meshcat.SetTransform(path, RigidTransform(link.rotation.T @ (at - link.translation)))
    return path


def frames(
    assessment: Assessment, exaggerate: float | None = None, shown: System | None = None
) -> tuple[Array, Array, float]:
    """Compute times (n,) [s], tree coordinates (n, nq) of the frames, and the factor on deflections.

    Parameters as `write_recording`; `shown` is the system of the coordinates, with rigid segments if flexible.
    """
    shown, run, clearances = shown or assessment.system, assessment.run, 1.0 if exaggerate is None else exaggerate
    start, end = run.time[[0, -1]]
    times = np.linspace(start, end, int(np.ceil(max(_LENGTH, end - start) * _FRAMES_PER_SECOND / 2)) + 1)
    source = system_of(assessment.system, run.columns)
    steps = [run[f"q.{name}"] for name in source.tree.coordinates]
    recorded = np.stack([np.interp(times, run.time, column) for column in steps], axis=1)
    if isinstance(shown, Segmented) and not isinstance(source, Segmented):
        recorded = shown.coordinates(recorded)
    if not assessment.system.determinate:
        if clearances != 1.0:
            raise ValueError("the drives do not determine the motion: its clearance cannot be exaggerated")
        return times, recorded, 1.0
    factor, hinges = 1.0, recorded[:, shown.tree.hinge_dofs]
    if isinstance(shown, Segmented):
        factor = exaggerate if exaggerate is not None else _seen(shown.largest_deflection(recorded), shown.tree.extent)
    offset = np.zeros((len(times), len(shown.tree.closure_rows)))
    for k, name in enumerate(shown.tree.play):
        parts = ("ex", "ey") if assessment.system.joints[name].bearing is not None else ("offset", "tilt")
        for axis, part in enumerate(parts):
            offset[:, 2 * k + axis] = clearances * np.interp(times, run.time, run[f"{name}.{part}"])
    try:
        return times, ideal_motion(shown).states(times, offset, factor * hinges)[0], factor
    except AssemblyError as problem:
        if exaggerate is None or exaggerate == 1.0:  # a run that passed a dead point by its errors
            return times, recorded, 1.0
        what = "its clearance and its deflections" if len(hinges[0]) else "its clearance"
        raise ValueError(f"the linkage does not close with {what} exaggerated {exaggerate:g} times") from problem


def _seen(largest: float, size: float) -> float:
    """Return a round factor >= 1 that magnifies a deflection to at most `_DEFLECTION` of the linkage's size."""
    return round_length(max(_DEFLECTION * size / largest, 1.0))[0] if largest > 0.0 else 1.0


def _joint_views(assessment: Assessment, meshcat: Meshcat, times: Array, low: Array, high: Array) -> Views:
    """Draw the clearance joints right of the linkage, in two rows."""
    names = assessment.system.tree.play
    height = max(high[1] - low[1], 0.75 * (high[0] - low[0]), 0.3 * assessment.system.tree.extent)
    rows = min(len(names), 2)
    radius = height / (3.0 * max(rows, 1.5))
    views: Views = []
    for k, name in enumerate(names):
        column, row = divmod(k, 2)
        right = high[0] + radius * (2.0 + 3.0 * column)
        up = 0.5 * (low[1] + high[1]) + 3.2 * radius * (0.5 * (rows - 1) - row)
        kind = JournalView if assessment.system.joints[name].type == "revolute" else GuideView
        view = kind(meshcat, assessment, name, np.array([right, up]), radius)
        view.draw(assessment, times)
        views.append(view)
    return views


def _look_at(assessment: Assessment, meshcat: Meshcat, views: Views, low: Array, high: Array) -> Array:
    """Aim the camera along the plane's normal at all moving parts; return their width and height [m]."""
    low = low - [0.0, 0.18 * max(*(high - low), assessment.system.tree.extent)]  # space for the scale
    for view in views:
        low = np.minimum(low, view.centre - 1.3 * view.radius)
        high = np.maximum(high, view.centre + 1.5 * view.radius)
    size = np.maximum(high - low, 0.3 * assessment.system.tree.extent)
    basis = assessment.system.basis
    middle = basis[:, :2] @ (0.5 * (low + high))
    shown = 1.25 * max(size[1], size[0] / _ASPECT)
    distance = 0.5 * shown / np.tan(0.5 * np.radians(_FIELD_OF_VIEW))
    meshcat.SetCamera(Meshcat.PerspectiveCamera(fov=_FIELD_OF_VIEW))
    meshcat.SetProperty("/Background", "top_color", [1.0, 1.0, 1.0])
    meshcat.SetProperty("/Background", "bottom_color", [0.93, 0.94, 0.96])
    for light in ("PointLightNegativeX", "PointLightPositiveX"):
        meshcat.SetProperty(f"/Lights/{light}", "visible", False)
    # light from everywhere and from above: faces in the plane get pi, and have the colours of the drawing
    meshcat.SetProperty("/Lights/AmbientLight/<object>", "intensity", 0.8 * np.pi)
    meshcat.SetProperty("/Lights/FillLight/<object>", "intensity", 0.2 * np.pi * np.sqrt(2.0))
    meshcat.SetProperty("/Lights/FillLight/<object>", "position", (10.0 * basis @ [0.0, 1.0, 1.0]).tolist())
    meshcat.SetProperty("/Grid", "visible", False)
    meshcat.SetProperty("/Axes", "visible", False)
    meshcat.SetCameraPose(middle + distance * (basis[:, 2] - 0.15 * basis[:, 1]), middle)
    return size


def _texts(assessment: Assessment, views: Views, times: Array, slow: float, magnified: float) -> dict[str, Any]:
    """Return time, legend and curves below the scene; see `add_captions`."""
    system, tree = assessment.system, assessment.system.tree
    pace = f"{rounded(slow)} times slower than real time" if slow > 1.0 else "real time"
    scales = "; ".join(f"{view.name}: {view.scales}" for view in views)
    legend = (
        "Magnified views: the largest force on journal or block within each frame (arrow; its length is proportional to"
        f" the square root), the point of contact (spot), the orbit of the journal's centre (line). {scales}"
    )
    bent = f"Deflections of links are magnified {rounded(magnified)} times. " if tree.deformable else ""
    names = columns(system.settings.outputs, tree.play, system.actuators)
    return {
        "title": system.description.title or system.description.machine,
        "clock": [f"t = {t:.4f} s, {pace}" for t in times],
        "legend": bent + (legend if views else ""),
        "curves": curves(names, assessment.run, assessment.ideal, assessment.noise),
        "start": float(times[0]),
        "end": float(times[-1]),
    }


def add_captions(page: str, shown: Mapping[str, Any]) -> str:
    """Add texts that Meshcat cannot draw, and a bar to play, stop and seek, to a recording's page.

    The script `overlay.html` writes the texts of the current frame. `shown` has ``labels`` in the scene; ``view`` and
    ``aspect``: width and height [m] of the visible scene, and the window's ratio of both for which the camera was set;
    ``clock``: a text for each frame; ``legend``: a text; ``curves``: from `linkages.show.plots.pages.curves`; ``start``
    and ``end``: times of the mechanism at the first and at the last frame [s].
    """
    head, found, tail = page.rpartition("</body>")
    if not found:
        raise ValueError("the recording has no body to write captions into")
    title = escape(str(shown.get("title", "Animation of a linkage")))
    head = re.sub(r"<title>.*?</title>", "", head, count=1, flags=re.DOTALL)
    head = head.replace("<head>", f"<head>{_VIEWPORT}<title>{title}</title>", 1)
    overlay = own_text("linkages.show.plots.animation", "overlay.html")
    scripts, style = Markup(script("curves", "player")), Markup(css() + shared_style())
    texts = {"legend_text": shown.get("legend", ""), "frames": len(shown["clock"])}
    strip = filled(overlay, scripts=scripts, style=style, data=embedded({"length": _LENGTH, **shown}), **texts)
    return f"{head}{strip}{found}{tail}"
