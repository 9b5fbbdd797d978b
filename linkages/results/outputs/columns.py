"""Named outputs over time from states, for runs and ideal motions; of flexible links also from rigid segments."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np

from linkages.base.arguments import Names
from linkages.base.kernel import Array, Records
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
                found[f"{frame.name}.deflection"] = chain.deflection(frame.name, frame.origin, table)
        found |= chain.internal_forces(table) | chain.largest_deflection(table)
        turns = np.array([table[f"q.{name}"] for name in chain.joints])
        rates = np.diff([table[f"{name}.omega"] for name in chain.segments], axis=0)
        found["strain_energy"] = found["strain_energy"] + 0.5 * chain.stiffnesses @ turns**2
        found["damping_power"] = found["damping_power"] + chain.damping * chain.stiffnesses @ rates**2
    return found
