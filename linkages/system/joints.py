"""Joints of a system: places and axes from the mechanism, clearance and model from the experiment."""

from __future__ import annotations

from dataclasses import dataclass

from linkages.input.model.experiment import Experiment
from linkages.input.model.mechanism import Joint, Mechanism


@dataclass(frozen=True, eq=False)
class SystemJoint(Joint):
    """A joint of a system: a `linkages.input.model.mechanism.Joint`, and what its model adds.

    Attributes
    ----------
    model : str
        "ideal", "dry", "lubricated" or "mixed".
    clearance : float or None
        Radial clearance [m]; an ideal joint can have one, which does not act.
    has_film : bool
        Whether oil is between journal and bearing.
    has_drive : bool
        Whether a drive acts at the joint, by a motion or an effort.
    """

    model: str
    clearance: float | None
    has_film: bool
    has_drive: bool

    @property
    def turns(self) -> bool:
        """Tell whether the joint is revolute."""
        return self.type == "revolute"

    @property
    def slides(self) -> bool:
        """Tell whether the joint is prismatic."""
        return self.type == "prismatic"


def joints_of(mechanism: Mechanism, experiment: Experiment) -> dict[str, SystemJoint]:
    """Return the joints by name, in the order of the mechanism."""
    return {joint.name: _joint(joint, experiment) for joint in mechanism.joints}


def _joint(joint: Joint, experiment: Experiment) -> SystemJoint:
    given, driven = experiment.joints.get(joint.name), joint.name in experiment.drives
    if given is None:
        return SystemJoint(**vars(joint), model="ideal", clearance=None, has_film=False, has_drive=driven)
    return SystemJoint(
        **vars(joint), model=given.model, clearance=given.clearance, has_film=given.has_film, has_drive=driven
    )
