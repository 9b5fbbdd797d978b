"""The contacts of a system: clearance joints, limits of coordinates, points at lines; their records and laws."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.base.arrays import Array, Records
from linkages.input.model.experiment import Experiment
from linkages.input.model.experiment_tables import JointModel
from linkages.mechanics.planar.record_types import ORIENTED, REMEMBERING, WORN
from linkages.system.film_steps import with_film_step
from linkages.system.law_records import ContactLaws, LawStates
from linkages.system.load_records import unilateral_ends, unilateral_models
from linkages.system.tree import Tree, chained


class Contacts(NamedTuple):
    """Records of nc contacts."""

    ends: Records  # both ends of each
    own: ContactLaws

    @property
    def laws(self) -> Records:
        """Return the law records (`linkages.laws.PARAMETERS`)."""
        return self.own.records

    @property
    def tables(self) -> Array:
        """Return one line per contact: the map of its finite film, or its cells; the profiles of a worn joint last."""
        return self.own.tables

    @property
    def states(self) -> LawStates:
        """Return the continuous states of the laws."""
        return self.own.states

    @property
    def touching(self) -> NDArray[np.bool_]:
        """Return which contacts can touch, (nc,)."""
        return self.own.touching

    @property
    def reach(self) -> Array:
        """Return the eccentricity at which a journal leaves its film, (nc,) [m]; infinite where bodies can touch.

        States with such an eccentricity are not valid: runs end there, and searches for states refuse them.
        """
        return np.where(self.touching, np.inf, self.laws["clearance"] * self.own.film_limits)


def contact_labels(tree: Tree, experiment: Experiment) -> tuple[tuple[str, str], ...]:
    """Return owner and label of each contact: clearance joints (`Tree.contacts`), limits, points at lines."""
    labels = ((label.rpartition(".")[0] or label, label) for label in experiment.touches)
    return (*tree.contacts, *labels)


def contact_models(tree: Tree, experiment: Experiment, steps: dict[str, float]) -> tuple[JointModel, ...]:
    """Return the joint model of each contact; a film with history has its longest step, and its accuracy if any."""
    play = tuple(with_film_step(experiment, steps, name) for name, _ in tree.contacts)
    return (*play, *unilateral_models(tree, experiment))


def contact_ends(tree: Tree, experiment: Experiment, models: tuple[JointModel, ...]) -> Records:
    """Return both ends of each contact: `Tree.ends` with worn profiles, limits, points at lines."""
    ends = chained(tree.ends, unilateral_ends(tree, experiment))
    for k, model in enumerate(models):
        if model.feed or model.is_tilted or model.is_worn:  # the direction of the bearing matters
            ends["kind"][k] = WORN if model.is_worn else REMEMBERING if model.has_history else ORIENTED
    return ends
