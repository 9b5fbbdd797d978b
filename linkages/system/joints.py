"""Joints of a system: places and axes from the mechanism, clearance and model from the experiment."""

from __future__ import annotations

from dataclasses import dataclass

from linkages.input.model.experiment import Experiment
from linkages.input.model.experiment_tables import FilmHistory, JointModel
from linkages.input.model.mechanism import Joint, Mechanism
from linkages.laws.heat import Heat

_IDEAL = JointModel.model_validate({"model": "ideal"})  # of joints that an experiment does not name


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
    history : FilmHistory or None
        Cells, step and accuracy of a film whose content is part of the state.
    heat : Heat or None
        Heat balance of the oil.
    oil_temperature : float or None
        Temperature of the oil [degC], of which its viscosity follows; None if the viscosity is given.
    has_drive : bool
        Whether a drive acts at the joint, by a motion or an effort.
    """

    model: str
    clearance: float | None
    has_film: bool
    history: FilmHistory | None
    heat: Heat | None
    oil_temperature: float | None
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
    model = experiment.joints.get(joint.name, _IDEAL)
    return SystemJoint(
        **vars(joint),
        model=model.model,
        clearance=model.clearance,
        has_film=model.has_film,
        history=model.history,
        heat=_heat(model),
        oil_temperature=model.oil.temperature if model.oil is not None else None,
        has_drive=joint.name in experiment.drives,
    )


def _heat(model: JointModel) -> Heat | None:
    """Return the heat balance of a joint with oil; other models do not use it."""
    if model.heat is None or model.oil is None or not model.has_film:
        return None
    return model.heat.of(model.oil)
