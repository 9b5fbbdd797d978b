"""Masses and moments of inertia of the bodies: the links' own, of rotors that turn with them, negligible ones."""

from __future__ import annotations

from linkages.elements.machine import all_elements_of
from linkages.input.model.experiment import Experiment
from linkages.input.model.mechanism import Mechanism
from linkages.system.lightness import negligible_inertials


def with_rotors(mechanism: Mechanism, experiment: Experiment) -> Mechanism:
    """Return the mechanism whose links have the inertias of the rotors that turn with them."""
    return mechanism.with_inertial(_rotors(mechanism, experiment))


def with_all_masses(mechanism: Mechanism, experiment: Experiment) -> Mechanism:
    """Return the same with negligible masses and inertias of links without."""
    return mechanism.with_inertial(negligible_inertials(mechanism) | _rotors(mechanism, experiment))


def _rotors(mechanism: Mechanism, experiment: Experiment) -> dict[str, float]:
    """Return the inertias of links with those of the rotors that turn with them, by path [kg m2]."""
    found: dict[str, float] = {}
    for kind, _, keys in all_elements_of(experiment.elements):
        rotor = kind.rotor(keys)
        if rotor is not None and rotor.inertia:
            joint = mechanism.joint[rotor.joint]
            link = mechanism.link[joint.child if joint.parent == "world" else joint.parent]
            path = f"links.{link.name}.inertia"
            found[path] = found.get(path, link.inertia) + rotor.inertia
    return found
