"""What mechanism and experiment say of a system, for all later steps: the fields of a `System`."""

from __future__ import annotations

from typing import Any

import numpy as np

from linkages.input.model.experiment import Experiment
from linkages.input.model.mechanism import Mechanism
from linkages.system.description import description_of
from linkages.system.ideal_linkage import plane_gravity, start_states
from linkages.system.parts import parts_of
from linkages.system.settings import settings_of


def facts(mechanism: Mechanism, experiment: Experiment) -> dict[str, Any]:
    """Return the fields of a `System` that need no computation, by their names."""
    return {
        "settings": settings_of(experiment),
        "description": description_of(mechanism, experiment),
        "links": mechanism.link,
        "frames": mechanism.frames,
        "points": mechanism.point,
        "places": mechanism.place,
        "basis": mechanism.basis,
        "machine_values": mechanism.values,
        "parts": parts_of(experiment),
        "named_loads": experiment.loads,
        "wheels": experiment.wheels,
        "acting": experiment.acting,
        "drives": experiment.drives,
        "actuators": experiment.actuators,
        "functions_read": experiment.functions_read,
        "ramp": max((drive.ramp for drive in experiment.drives.values()), default=0.0),
        "play": experiment.play,
        "imperfect": experiment.imperfect,
        "can_touch": experiment.can_touch,
        "values": experiment.values,
        "unread_states": experiment.unread_states,
        "recorded": experiment.from_files,
        "start_states": start_states(experiment),
        "state_scales": np.array([one.scale for one in experiment.own_states.values()], float),
        "mass": sum(link.mass for link in mechanism.links),
        "gravity": plane_gravity(mechanism, experiment),
    }
