"""Actuators of MJCF without control: feedback is a spring and a damper, everything else pushes with nothing."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from typing import NamedTuple

from linkages.base.errors import InputError
from linkages.input.files.foreign import MARK
from linkages.input.files.mjcf_defaults import Mjcf
from linkages.input.files.xml import label


class Feedback(NamedTuple):
    """Stiffness and damping of a joint by its actuators [N m/rad, N m s/rad]."""

    stiffness: float
    damping: float


def feedback_of(file: Mjcf, notes: list[str]) -> dict[str, Feedback]:
    """Return the feedback of each joint's actuators with the target zero; a note for each actuator."""
    found: dict[str, Feedback] = {}
    for section in file.root.findall("actuator"):
        for element in section:
            actuator = file.defaults.of(element)
            name, joint = label(element), actuator.get("joint", "")
            if not joint:
                notes.append(f"{MARK}{name} left out: it does not act on a joint; write [forces] into the experiment")
                continue
            if actuator.tag not in _GAINS:
                notes.append(f"{MARK}{name} of joint {joint} left out: it is of another kind than motors and servos")
                continue
            gear = float(file.numbers(actuator, "gear", None, "1")[0])
            if actuator.get("dampratio") is not None:
                raise InputError(file.path, f"{name} dampratio", "is not supported; write kv")
            stiffness, damping = (gear**2 * gain for gain in _gains(file, actuator))
            if not stiffness and not damping:
                notes.append(f'{name} of joint {joint}, gear {gear:g}: write its torque as drives."{joint}"')
                continue
            old = found.get(joint, Feedback(0.0, 0.0))
            found[joint] = Feedback(old.stiffness + stiffness, old.damping + damping)
            held = "spring and damper of the joint, which hold it at MuJoCo's zero"
            notes.append(f"{MARK}{name} of joint {joint}: {held}; other targets are left out")
    return found


def _gains(file: Mjcf, actuator: ET.Element) -> tuple[float, float]:
    """Return stiffness and damping of an actuator, per unit of its length."""
    if actuator.tag == "general":
        if actuator.get("biastype", "none") != "affine":
            return 0.0, 0.0
        _, stiffness, damping = [*file.numbers(actuator, "biasprm", None, "0 0 0"), 0.0, 0.0, 0.0][:3]
        return -stiffness, -damping
    stiffness, damping = (
        float(file.numbers(actuator, key, 1, usual)[0]) if key else 0.0 for key, usual in _GAINS[actuator.tag]
    )
    return stiffness, damping


#: Attributes of stiffness and damping, with MuJoCo's usual values.
_GAINS = {
    "motor": (("", ""), ("", "")),
    "general": (("", ""), ("", "")),
    "position": (("kp", "1"), ("kv", "0")),
    "velocity": (("", ""), ("kv", "1")),
}
