"""Worn profiles of joints from a ``wear.json``, which ``linkages wear`` writes."""

from __future__ import annotations

import json
from pathlib import Path

from pydantic import ConfigDict, ValidationInfo

from linkages.input.files.toml import Finite, Positive, Table, TwoOf, validate
from linkages.input.model.experiment_tables import JointModel, WearTable

_OWN = ("bearing_depth", "journal_depth", "nodes")  # keys of a table of wear that the file gives


class WornPart(Table):
    """A bearing or journal of the file; additional keys are ignored."""

    model_config = ConfigDict(extra="ignore")

    profile: list[TwoOf[Finite]]  # angle [rad], depth [m]


class WornJoint(Table):
    """A joint of the file; additional keys are ignored."""

    model_config = ConfigDict(extra="ignore")

    coefficient: Positive
    bearing: WornPart | None = None
    journal: WornPart | None = None

    def table(self, given: WearTable | None) -> WearTable:
        """Return a table of wear with these profiles; what was given in the experiment remains."""
        values = {"coefficient": self.coefficient} | (given.model_dump(exclude_unset=True) if given else {})
        for side, part in (("bearing", self.bearing), ("journal", self.journal)):
            if part is not None:
                depths = [depth for _, depth in part.profile]
                values |= {f"{side}_depth": depths, "nodes": len(depths)}
        table = WearTable.model_validate(values)
        table.__pydantic_fields_set__.intersection_update(given.model_fields_set if given else ())
        return table


class WornFile(Table):
    """The joints of the file; additional keys are ignored."""

    model_config = ConfigDict(extra="ignore")

    joints: dict[str, WornJoint]


def read_worn(path: Path) -> dict[str, WornJoint]:
    """Read the joints of a ``wear.json``; ValueError (or an InputError, which is one) for another file."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as problem:
        raise ValueError(f"{path} cannot be read ({problem}); give a wear.json that `linkages wear` wrote") from None
    if not isinstance(content, dict):
        raise ValueError(f"{path} is not a JSON object; give a wear.json that `linkages wear` wrote")
    return validate(WornFile, content, path).joints


def with_worn(joints: dict[str, JointModel], info: ValidationInfo) -> dict[str, JointModel]:
    """Give joints with the key `worn` the profiles of its file; without a folder as context no file is read."""
    for name, joint in joints.items():
        if joint.worn is None or info.context is None:
            continue
        if not joint.can_touch:
            raise ValueError(f"{name}.worn: wear needs a contact; make the model dry or mixed")
        if joint.wear and (both := [key for key in _OWN if key in joint.wear.model_fields_set]):
            raise ValueError(f"{name}.wear.{both[0]}: the file of worn gives it; remove one of them")
        try:
            found = read_worn(info.context / joint.worn)
            if name not in found:
                raise ValueError(f"{joint.worn} has no joint {name}; it has {', '.join(found) or 'none'}")
            joint.__dict__["wear"] = found[name].table(joint.wear)  # not a value that was given
        except ValueError as problem:
            raise ValueError(f"{name}.worn: {problem}") from None
    return joints
