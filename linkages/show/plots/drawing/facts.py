"""Properties of a mechanism before a run, in sentences and tables."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from linkages.base.brief import counted
from linkages.base.errors import Status, listed
from linkages.explore.range_of_motion import Travel
from linkages.explore.transmission import Transmission
from linkages.input.model.experiment import Experiment
from linkages.input.model.mechanism import Mechanism
from linkages.input.model.skeleton import skeleton
from linkages.system import System

_CLOSED = 1e-9  # smallest gap over the linkage's size; smaller gaps are rounding of the file's digits
Rows = tuple[tuple[str, ...], ...]


def facts(
    mechanism: Mechanism, system: System | None, ways: Sequence[Travel], starts: Mapping[str, float], size: float
) -> Iterator[str]:
    """Describe parts, mobility and mass of a mechanism of a size [m] in sentences.

    The system is None if the loops do not close; `starts` are the start positions of the experiment's drives.
    """
    kinds = Counter(joint.type for joint in mechanism.joints)
    joints = listed(counted(count, f"{kind} joint") for kind, count in kinds.items())
    parts = f"{len(mechanism.links)} moving links, {joints}"
    if system is not None:
        mobility = system.assembly.mobility
        parts += f"; {counted(mobility, 'degree')} of freedom"
        driven = list(system.drives)
        if spare := [name for name in starts if name not in driven]:
            parts += f", {counted(len(starts), 'drive')}: {listed(spare)} cannot be moved by itself"
    yield parts
    gaps = {}
    for joint in mechanism.joints:  # distance of the joint's ends, without the part along a slot
        between = joint.on_child - joint.on_parent
        apart = between - (between @ joint.direction) * joint.direction
        gaps[joint.name] = 0.0 if joint.type == "fixed" else float(np.linalg.norm(apart))
    worst = max(gaps, key=lambda name: gaps[name], default="")
    gap = gaps.get(worst, 0.0)
    closed = gap < _CLOSED * size
    yield "drawn closed" if closed else f"as drawn, its loops are open by up to {_length(gap)}, at {worst}"
    for way in ways:
        turns = mechanism.joint[way.drive].type == "revolute"
        yield f"drive {way.drive} {_reach(way, turns)}"
        for one in way.transmissions:
            yield _passed(way, one, turns)
        if way.together:
            yield f"{listed(way.together)} move together: no transmission angle is defined for them"
    masses = [f"{link.name} {link.mass:.3g} kg" for link in mechanism.links if link.mass > 0.0]
    total = sum(link.mass for link in mechanism.links)
    yield f"masses: {', '.join(masses)}; {total:.3g} kg in all" if len(masses) > 1 else f"mass: {total:.3g} kg"


def joint_table(mechanism: Mechanism, experiment: Experiment) -> Rows:
    """Tabulate the joints: kind, links, bearing or slot, model."""
    rows = []
    for joint in mechanism.joints:
        part = ""
        if joint.bearing is not None:
            part = f"bearing, radius {_length(joint.bearing.radius)}, length {_length(joint.bearing.length)}"
        elif joint.slot is not None:
            part = f"slot, block {_length(joint.slot.length)} by {_length(joint.slot.height)}"
        model = experiment.joints.get(joint.name)
        how: str = model.model if model else "ideal"
        if model is not None and model.clearance:
            how += f", clearance {_length(model.clearance)}"
        if joint.name in experiment.drives:
            how += ", driven"
        rows.append((joint.name, joint.type, joint.parent, joint.child, part, how))
    return ("joint", "kind", "parent", "child", "made as", "model"), *rows


def link_table(mechanism: Mechanism, size: float) -> Rows:
    """Tabulate the links: length, mass, moment of inertia."""
    rows = []
    for link in mechanism.links:
        places = skeleton(mechanism, link, size).places
        length = float(np.linalg.norm(places[:, None] - places, axis=2).max())
        shown = _length(length) if length else ""
        rows.append((link.name, shown, f"{link.mass:.4g} kg", f"{link.inertia:.4g} kg m²"))
    return ("link", "length", "mass", "moment of inertia"), *rows


def _reach(way: Travel, turns: bool) -> str:
    if way.full:
        return "turns fully"
    ends = zip(way.values[[0, -1]], way.ends, strict=True)
    below, above = (f"{_value(value, turns)} ({_END[status]})" for value, status in ends)
    return f"goes from {below} to {above}"


_END = {Status.LOCKED: "a dead point", Status.NO_ASSEMBLY: "the end of closed loops", Status.OK: "or farther"}


def _passed(way: Travel, one: Transmission, turns: bool) -> str:
    """State the transmission angles of a dyad, and the dead centres of its driven joint."""
    meeting = f"{one.link} moves {one.joint}" if one.grounded else f"{one.link} and {one.other} meet at {one.joint}"
    value, least = one.least
    text = (
        f"{meeting} at transmission angles from {np.degrees(least):.1f}° (at {way.drive} = {_value(value, turns)})"
        f" to {np.degrees(one.most[1]):.1f}°"
    )
    if one.turns:
        text += f"; {one.joint} turns back at {listed(_value(value, turns) for value in one.turns)}"
    return text


def _value(value: float, turns: bool) -> str:
    return f"{np.degrees(value) + 0.0:.1f}°" if turns else _length(value)


def _length(value: float) -> str:
    if value == 0.0:
        return "0 m"
    for unit, factor in (("m", 1.0), ("mm", 1e3), ("µm", 1e6)):
        if abs(value) * factor >= 0.9995:
            return f"{value * factor:.4g} {unit}"
    return f"{1e6 * value:.2g} µm"
