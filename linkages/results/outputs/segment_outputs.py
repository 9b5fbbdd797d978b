"""Outputs of flexible links from a run with rigid segments, with the names of the flexible linkage."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from linkages.base.kernel import Array
from linkages.input.model.segment_model import SegmentChain
from linkages.results.outputs.registry import names
from linkages.system.rigid_segments import Segmented

Columns = dict[str, Array]


def whole_columns(system: Segmented, ideal: bool, tabulated: Callable[[Sequence[str]], Columns]) -> Columns:
    """Compute all outputs of a linkage with flexible links from rigid segments, except modal coordinates.

    Parameters
    ----------
    system : Segmented
    ideal : bool
        Whether clearance joints count as ideal.
    tabulated : callable
        Function that returns columns of the rigid linkage by name, and the times.

    Returns
    -------
    dict of (nt,) arrays
        Columns, including the coordinates of hinges.
    """
    wanted, own = names(system.whole, ideal), names(system, ideal)
    known = set(own)
    kept = [name for name in wanted if name in known]
    kept += [f"q.{name}" for name in system.tree.hinges]
    table = tabulated(own)
    found = {name: table[name] for name in ("time", *kept)}
    found["strain_energy"], found["damping_power"] = np.zeros((2, len(table["time"])))
    for chain in system.chains.values():
        for frame in system.whole.mechanism.frames:
            if frame.link == chain.link.name:
                found[f"{frame.name}.deflection"] = _deflection(chain, frame.name, frame.origin, table)
        found |= _within(chain, table) | _largest_deflection(chain, table)
        turns = np.array([table[f"q.{name}"] for name in chain.joints])
        rates = np.diff([table[f"{name}.omega"] for name in chain.segments], axis=0)
        found["strain_energy"] = found["strain_energy"] + 0.5 * chain.stiffnesses @ turns**2
        found["damping_power"] = found["damping_power"] + chain.damping * chain.stiffnesses @ rates**2
    return found


def _deflection(chain: SegmentChain, name: str, drawn: Array, table: Columns) -> Array:
    """Compute the change of a frame's distance from the beam's chord due to deformation."""
    (x, y), (x0, y0), (x1, y1) = ((table[f"{at}.x"], table[f"{at}.y"]) for at in (name, *chain.beam.frames))
    dx, dy = x1 - x0, y1 - y0
    (ux, uy), (rx, ry) = (chain.beam.end - chain.beam.start) / chain.beam.length, drawn - chain.beam.start
    distance: Array = (dx * (y - y0) - dy * (x - x0)) / np.hypot(dx, dy) - (ux * ry - uy * rx)
    return distance


def _largest_deflection(chain: SegmentChain, table: Columns) -> Columns:
    """Compute the largest distance of a hinge from the beam's chord, and its place."""
    edges = np.array([0.0, *chain.hinges, chain.beam.length])
    angles, lengths = np.array([table[f"{name}.angle"] for name in chain.segments]), np.diff(edges)[:, None]
    x, y = np.cumsum(lengths * np.cos(angles), axis=0), np.cumsum(lengths * np.sin(angles), axis=0)
    distances = np.abs(x[-1] * y - y[-1] * x) / np.hypot(x[-1], y[-1])
    name = chain.link.name
    return {
        f"{name}.deflection": distances.max(axis=0),
        f"{name}.deflection_place": edges[1 + distances.argmax(axis=0)],
    }


def _within(chain: SegmentChain, table: Columns) -> Columns:
    """Compute largest bending moment, normal stress and compression from the hinges' springs and forces."""
    beam, (places, factors) = chain.beam, chain.stations()
    moments = factors @ np.array([table[f"{name}.torque"] for name in chain.springs])
    way = np.arctan2(*(beam.end - beam.start)[::-1]) - chain.link.angle
    pulls = []
    for name, inner, outer in zip(chain.joints, chain.segments[:-1], chain.segments[1:], strict=True):
        angle = way + 0.5 * (table[f"{inner}.angle"] + table[f"{outer}.angle"])
        pulls.append(-np.cos(angle) * table[f"{name}.fx"] - np.sin(angle) * table[f"{name}.fy"])
    force = factors @ np.array(pulls)
    stress = np.abs(force) / beam.area + np.abs(moments) * 0.5 * beam.height / beam.second_moment
    name = chain.link.name
    return {
        f"{name}.bending": np.abs(moments).max(axis=0),
        f"{name}.stress": stress.max(axis=0),
        f"{name}.stress_place": places[stress.argmax(axis=0)],
        f"{name}.compression": np.maximum(-force, 0.0).max(axis=0),
    }
