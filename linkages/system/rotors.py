"""Inertias of links with those of the motors that turn them."""

from __future__ import annotations

from collections.abc import Iterable

from linkages.input.model.mechanism import Mechanism
from linkages.input.model.state_tables import Motor


def rotor_inertias(mechanism: Mechanism, motors: Iterable[Motor]) -> dict[str, float]:
    """Return the inertias of links with the rotors of motors [kg m2], by path."""
    found: dict[str, float] = {}
    for motor in motors:
        joint = mechanism.joint[motor.joint]
        link = mechanism.link[joint.child if joint.parent == "world" else joint.parent]
        path = f"links.{link.name}.inertia"
        if motor.rotor_inertia:
            found[path] = found.get(path, link.inertia) + motor.ratio**2 * motor.rotor_inertia
    return found
