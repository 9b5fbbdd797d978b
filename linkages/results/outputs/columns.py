"""Named outputs over time from states, for runs and ideal motions; of flexible links also from rigid segments."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np

from linkages.base.arguments import Names
from linkages.base.kernel import Array, Records
from linkages.input.model.segment_model import SegmentChain
from linkages.mechanics.planar.contacts import WIDTH
from linkages.results.outputs.evaluation import make_snapshot, tabulate
from linkages.results.outputs.quantity import Snapshot
from linkages.results.outputs.registry import JITTER, pack
from linkages.results.outputs.registry import names as all_names
from linkages.system import System
from linkages.system.ideal_motion import ideal_motion
from linkages.system.rigid_segments import Segmented

Columns = dict[str, Array]


def columns(
    system: System,
    times: Array,
    q: Array,
    v: Array,
    a: Array,
    contacts: Array | None = None,
    names: Names | None = None,
) -> Columns:
    """Compute outputs over time by name, with the times as "time".

    Parameters
    ----------
    system : System
    times : (nt,) array
        Times [s].
    q, v, a : (nt, n) arrays
        Coordinates of the tree, their rates and accelerations.
    contacts : (nt, nc, WIDTH) array, optional
        `linkages.mechanics.planar.contacts.CLEARANCE_OUTPUTS` of each contact, from an engine. Without it clearance
        joints count as ideal, and their forces are computed like other joint forces.
    names : sequence of str, optional
        Outputs of `linkages.results.outputs.registry`; default: all (with rigid segments see `whole_columns`).

    Raises
    ------
    InputError, AssemblyError
        If an output is unknown; if jitter is requested and the ideal linkage does not close.
    """
    ideal = contacts is None
    if names is None and isinstance(system, Segmented):
        return whole_columns(system, ideal, lambda own: columns(system, times, q, v, a, contacts, own))
    wanted, outputs, with_forces = _records(system, None if names is None else tuple(names), ideal)
    nt = len(times)
    if contacts is None:
        contacts = np.zeros((nt, 0, WIDTH))
    out, idle = np.empty((len(wanted), nt)), _idle_snapshots(system, ideal)
    try:
        seen = idle.pop()
    except IndexError:
        seen = make_snapshot(system.ideal_arrays if ideal else system.arrays, q.shape[1])
    numbers = (np.ascontiguousarray(x, dtype=np.float64) for x in (times, q, v, a, contacts))
    tabulate(outputs, with_forces, seen, *numbers, out)  # type: ignore[call-arg]
    idle.append(seen)
    jitter = [name for name, output in zip(wanted, outputs, strict=True) if output["jitter"]]
    if jitter:
        states = ideal_motion(system).states(np.asarray(times, dtype=np.float64))
        exact = columns(system, times, *states, names=[name.removesuffix(JITTER) for name in jitter])
        for name in jitter:
            out[wanted.index(name)] -= exact[name.removesuffix(JITTER)]
    return {"time": times} | dict(zip(wanted, out, strict=True))


@lru_cache(maxsize=8)  # a search for peaks calls this repeatedly
def _records(system: System, names: tuple[str, ...] | None, ideal: bool) -> tuple[tuple[str, ...], Records, bool]:
    """Return the names of the requested outputs, their records, and whether they need forces in joints."""
    wanted = tuple(all_names(system, ideal)) if names is None else names
    outputs = pack(system, wanted, ideal)
    return wanted, outputs, bool(outputs["forces"].any())


@lru_cache(maxsize=8)
def _idle_snapshots(system: System, ideal: bool) -> list[Snapshot]:
    """Return the arrays of a system in which no thread computes outputs."""
    return []


def whole_columns(system: Segmented, ideal: bool, tabulated: Callable[[Sequence[str]], Columns]) -> Columns:
    """Compute all outputs of a linkage with flexible links from rigid segments, except modal coordinates.

    `tabulated` returns columns of the rigid linkage by name, and the times; with `ideal`, clearance joints count as
    ideal. The coordinates of hinges are added.
    """
    own = dict.fromkeys(all_names(system, ideal))
    kept = [name for name in all_names(system.whole, ideal) if name in own]
    kept += [f"q.{name}" for name in system.tree.hinges]
    table = tabulated([*own])
    found = {name: table[name] for name in ("time", *kept)}
    found["strain_energy"], found["damping_power"] = np.zeros((2, len(table["time"])))
    for chain in system.chains.values():
        for frame in system.whole.frames:
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
