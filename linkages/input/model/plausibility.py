"""Plausibility of values: valid values that suggest a mistake give questions to the user, never errors.

Cranes, micromachines and sewing machines have unusual values too: one unusual value alone raises no question.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np

from linkages.base.arrays import Array
from linkages.input.files.unit_conversion import is_quantity
from linkages.input.model.experiment import Experiment
from linkages.input.model.mechanism import Joint, Link, Mechanism
from linkages.input.model.skeleton import skeleton

# limits of plausible values, all assumed
_GYRATION = 10.0  # radius of gyration over the size of linkage and link; kg mm2 make it 1000 times as large
_LONG = 20.0  # length of a link [m]
_THIN = 1e-4  # mass over the cube of a link's length [kg/m3]: the boom of a crane has some hundred times as much
_STEEL = 7850.0  # density [kg/m3]: a link should be lighter than a steel cube of its length
_BAR = math.sqrt(12.0)  # length of a uniform bar over its radius of gyration
_TURNS = 4.0 * math.pi  # start of a drive [rad]
_TIP = 25.0  # speed of the joints of a driven link [m/s]
_FAST = 1500.0  # speed of a drive [rad/s]; round numbers count below it too
_ROUND = 10.0  # multiples of it count as round [rad/s]
_HEAVY = 100.0  # gravity [m/s2]
_FREE_FALL = 9.81  # [m/s2]
_BESIDE = 0.4  # distance of a mass centre from the joint, over that of the link's other joints
_PULLED = 10.0  # centrifugal force over weight


def doubts(mechanism: Mechanism, size: float, experiment: Experiment) -> list[str]:
    """List a question for each value that is implausible in SI units; `size` is the extent of the linkage [m].

    Examples
    --------
    >>> import linkages
    >>> from linkages.input.model.plausibility import doubts
    >>> system = linkages.load(linkages.find_file("four_bar_dry.toml"), {"sdf.links.crank.pose.yaw": 90.0})
    >>> doubts(system.mechanism, system.tree.extent, system.experiment)
    ['links.crank.pose.yaw is 90 rad: are these degrees? Write <pose degrees="true">']
    """
    return [
        *_of_machine(mechanism, size),
        *_of_drives(mechanism, size, experiment),
        *_of_gravity(mechanism, experiment),
    ]


def _lengths(mechanism: Mechanism, size: float) -> tuple[dict[str, float], dict[str, float]]:
    """Return the length of each link between its places, and the largest distance of a place from its mass centre."""
    lengths, sizes = {}, {}
    for link in mechanism.links:
        places = skeleton(mechanism, link, size).places
        lengths[link.name] = float(np.linalg.norm(places[:, None] - places, axis=2).max())
        sizes[link.name] = max(size, float(np.linalg.norm(places - link.com, axis=1).max()))
    return lengths, sizes


def _of_machine(mechanism: Mechanism, size: float) -> Iterator[str]:
    lengths, sizes = _lengths(mechanism, size)
    yield from _of_lengths(mechanism, lengths)
    for path, value in mechanism.values.items():
        if path.endswith((".roll", ".pitch", ".yaw")) and abs(value) > 2.0 * math.pi + 1e-6:
            yield f'{path} is {value:.3g} rad: are these degrees? Write <pose degrees="true">'
    for name in mechanism.unweighed:
        if mechanism.point[name].link != "world":
            yield f"{name} has no <inertial>: 0 kg here, 1 kg in other programs: is it massless? Write its <inertial>"
    for link in _heavy(mechanism, size):
        length, cube = lengths[link.name], "more than a cube of steel of that length"
        yield f"{link.name} has {link.mass:.3g} kg at a length of {length:.3g} m, {cube}: are these grams?"
    for link in _wide(mechanism, sizes):
        reach = f"{_gyration(link):.3g} m"
        yield (
            f"the moment of inertia of {link.name}, {link.inertia:.3g} kg m2, equals its mass {reach} away: is"
            " it in kg mm2?"
        )


def _of_lengths(mechanism: Mechanism, lengths: Mapping[str, float]) -> Iterator[str]:
    """Ask about millimetres if the longest link is very long, and light for its length."""
    longest = max(lengths, key=lambda name: lengths[name], default="")
    if lengths and (length := lengths[longest]) > _LONG:
        mass = mechanism.link[longest].mass or sum(link.mass for link in mechanism.links)
        if mass < _THIN * length**3:
            of = f", and has {mass:.3g} kg" if mass else ""
            yield f"{longest} is {length:.3g} m long{of}: is this file in millimetres? SDFormat has metres"


def _heavy(mechanism: Mechanism, size: float) -> list[Link]:
    """Return links that are heavier than steel cubes of their lengths: all of them, or some as the whole linkage."""
    lengths, _ = _lengths(mechanism, size)
    of_length = [link for link in mechanism.links if lengths[link.name] > 0.0 and link.mass > 0.0]
    heavy = [link for link in of_length if link.mass > _STEEL * max(lengths[link.name], _BAR * _gyration(link)) ** 3]
    alike = len(heavy) == len(of_length) > 1
    return [link for link in heavy if alike or link.mass > _STEEL * size**3]


def _wide(mechanism: Mechanism, sizes: Mapping[str, float]) -> list[Link]:
    """Return links whose radius of gyration is much larger than the linkage."""
    return [link for link in mechanism.links if _gyration(link) > _GYRATION * sizes[link.name]]


def _gyration(link: Link) -> float:
    """Return the radius of gyration of a link [m]; zero without mass."""
    return math.sqrt(link.inertia / link.mass) if link.mass > 0.0 else 0.0


def _of_drives(mechanism: Mechanism, size: float, experiment: Experiment) -> Iterator[str]:
    wrong = [*_heavy(mechanism, size), *_wide(mechanism, _lengths(mechanism, size)[1])]
    for name, drive in experiment.drives.items():
        if mechanism.joint[name].type != "revolute":
            continue
        if abs(drive.angle) > _TURNS:
            yield f"drives.{name}.angle is {drive.angle:.3g} rad, more than two turns: are these degrees?"
        speed, given = abs(drive.speed or 0.0), str(experiment.texts.get(f"drives.{name}.speed"))
        pure = not is_quantity(given) and (speed > _FAST or speed % _ROUND == 0.0)
        turned = _turned(mechanism, name)
        if pure and speed * max((arm or _gyration(link) for link, _, arm in turned), default=0.0) > _TIP:
            rate = f"{speed * 30.0 / math.pi:.3g} r/min"
            yield f"drives.{name}.speed is {drive.speed:.3g} rad/s, which is {rate}: is it in r/min, or in degrees?"
        if speed * experiment.duration > 2.0 * math.pi:
            yield from _of_centres(name, speed, [one for one in turned if one[0] not in wrong])


def _turned(mechanism: Mechanism, name: str) -> list[tuple[Link, Array, float]]:
    """List the link that a joint turns about the world, its place in the joint, its largest distance of a joint."""
    ends = _ends(mechanism.joint[name])
    if "world" not in ends:
        return []
    (link,) = ends.keys() - {"world"}
    places = [place for joint in mechanism.joints for end, place in _ends(joint).items() if end == link]
    return [(mechanism.link[link], ends[link], max(float(np.linalg.norm(one - ends[link])) for one in places))]


def _ends(joint: Joint) -> dict[str, Array]:
    """Return the places of a joint on its links [m]."""
    return {joint.parent: joint.on_parent, joint.child: joint.on_child}


def _of_centres(name: str, speed: float, turned: list[tuple[Link, Array, float]]) -> Iterator[str]:
    """Ask about the mass centre of a link that is shaped like a disc, and pulls like an unbalanced one."""
    for link, place, arm in turned:
        beside = float(np.linalg.norm(link.com - place))
        pull = beside * speed**2
        disc = _gyration(link) > beside or link.mass > _STEEL * arm**3
        if link.mass > 0.0 and beside > _BESIDE * arm and pull > _PULLED * _FREE_FALL and disc:
            yield (
                f"the mass centre of {link.name} turns {beside:.3g} m beside {name}, and pulls with"
                f" {link.mass * pull:.3g} N, {pull / _FREE_FALL:.3g} times its weight: is it a balanced wheel?"
                " Put its centre into the joint"
            )


def _of_gravity(mechanism: Mechanism, experiment: Experiment) -> Iterator[str]:
    gravity = np.array(experiment.gravity)
    total, across = float(np.linalg.norm(gravity)), abs(float(mechanism.basis[:, 2] @ gravity))
    if total > _HEAVY:
        yield f"gravity is {total:.4g} m/s2: is it in mm/s2?"
    if across > np.linalg.norm(mechanism.basis[:, :2].T @ gravity):
        upright = [round(float(x), 6) + 0.0 for x in -total * mechanism.basis[:, 1]]
        yield (
            f"gravity has {across:.4g} m/s2 across the plane of the motion, where no weight acts: does the machine lie"
            f" flat? If it stands upright, write gravity = {upright}"
        )
