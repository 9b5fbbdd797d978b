"""Plausibility of values: valid values that suggest a wrong unit give questions to the user, never errors."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from linkages.input.model.experiment import Experiment
from linkages.input.model.mechanism import Mechanism
from linkages.input.model.skeleton import skeleton

# limits of plausible values, all assumed
_GYRATION = 10.0  # radius of gyration over the size of linkage and link; kg mm2 make it 1000 times as large
_LONG = 20.0  # length of a link [m]
_STEEL = 7850.0  # density [kg/m3]: a link should be lighter than a steel cube of its length
_TURNS = 4.0 * math.pi  # start of a drive [rad]
_FAST = 1500.0  # speed of a drive [rad/s]
_HEAVY = 100.0  # gravity [m/s2]


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
    return [*_of_machine(mechanism, size), *_of_experiment(mechanism, experiment)]


def _of_machine(mechanism: Mechanism, size: float) -> Iterator[str]:
    lengths, sizes = {}, {}
    for link in mechanism.links:
        places = skeleton(mechanism, link, size).places
        lengths[link.name] = float(np.linalg.norm(places[:, None] - places, axis=2).max())
        sizes[link.name] = max(size, float(np.linalg.norm(places - link.com, axis=1).max()))
    longest = max(lengths, key=lambda name: lengths[name], default="")
    if lengths and lengths[longest] > _LONG:
        yield f"{longest} is {lengths[longest]:.3g} m long: is this file in millimetres? SDFormat has metres"
    for path, value in mechanism.values.items():
        if path.endswith((".roll", ".pitch", ".yaw")) and abs(value) > 2.0 * math.pi + 1e-6:
            yield f'{path} is {value:.3g} rad: are these degrees? Write <pose degrees="true">'
    for name in mechanism.unweighed:
        if mechanism.point[name].link != "world":
            yield f"{name} has no <inertial>: 0 kg here, 1 kg in other programs: is it massless? Write its <inertial>"
    for link in mechanism.links:
        length, mass = lengths[link.name], link.mass
        if length > 0.0 and mass > _STEEL * length**3:
            cube = "more than a cube of steel of that length"
            yield f"{link.name} has {mass:.3g} kg at a length of {length:.3g} m, {cube}: are these grams?"
        if mass > 0.0 and link.inertia > mass * (_GYRATION * sizes[link.name]) ** 2:
            reach = f"{math.sqrt(link.inertia / mass):.3g} m"
            yield (
                f"the moment of inertia of {link.name}, {link.inertia:.3g} kg m2, equals its mass {reach} away: is"
                " it in kg mm2?"
            )


def _of_experiment(mechanism: Mechanism, experiment: Experiment) -> Iterator[str]:
    for name, drive in experiment.drives.items():
        if mechanism.joint[name].type != "revolute":
            continue
        if abs(drive.angle) > _TURNS:
            yield f"drives.{name}.angle is {drive.angle:.3g} rad, more than two turns: are these degrees?"
        if abs(drive.speed or 0.0) > _FAST:
            rate = f"{abs(drive.speed or 0.0) * 30.0 / math.pi:.3g} r/min"
            yield f"drives.{name}.speed is {drive.speed:.3g} rad/s, which is {rate}: is it in r/min, or in degrees?"
    gravity = float(np.linalg.norm(experiment.gravity))
    if gravity > _HEAVY:
        yield f"gravity is {gravity:.4g} m/s2: is it in mm/s2?"
