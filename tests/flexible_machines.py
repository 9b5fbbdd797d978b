"""Three linkages with flexible links, joint B ideal or with clearance: for both models of flexible links."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from machines import BEARING, bar, beam, circle_intersection, elastic_bar, joint, model

import linkages

_LAWS = {
    "ideal": "",
    "lubricated": '[joints.B]\nmodel = "lubricated"\nclearance = 1e-4\nviscosity = 0.02\n',
    "dry": '[joints.B]\nmodel = "dry"\nclearance = 1e-4\n[joints.B.contact]\nlaw = "lankarani-nikravesh"\n'
    "restitution = 0.8\nyoungs_modulus = 2e11\n",
}


def _slider_crank() -> str:
    text = linkages.find_file("slider_crank_flexible.sdf").read_text(encoding="utf-8")
    return text.replace('name="rod_mid"', 'name="middle"')


def _four_bar() -> str:
    """Coupler and follower bend: ground 0.3, crank 0.06, coupler 0.28, follower 0.24 m."""
    x, y = circle_intersection((0.06, 0.0), 0.28, (0.3, 0.0), 0.24)
    body = f"""
<frame name="pivot" attached_to="world"><pose relative_to="__model__">0.3 0 0 0 0 0</pose></frame>
{bar("crank", 0.06, "__model__")}{elastic_bar("coupler", 0.28, "crank_tip", np.arctan2(y, x - 0.06))}
{elastic_bar("follower", 0.24, "pivot", np.arctan2(y, x - 0.3))}
<frame name="middle" attached_to="coupler"><pose>0.14 0 0 0 0 0</pose></frame>
<frame name="end" attached_to="follower"><pose>0.24 0 0 0 0 0</pose></frame>
{joint("O", "world", "crank")}{joint("A", "crank_tip", "coupler")}{joint("Q", "world", "follower")}
{joint("B", "coupler_tip", "end", inner=BEARING)}"""
    return model("four_bar", body)


def _seven_bar() -> str:
    """The shipped press, its longest link a thin, flat bar of the same mass."""
    mass, length = 0.374, 0.318
    text = linkages.find_file("seven_bar.sdf").read_text(encoding="utf-8")
    inertia = f"<iyy>{mass * length**2 / 12}</iyy><izz>{mass * length**2 / 12}</izz>"
    text = text.replace("<iyy>3.595e-3</iyy><izz>3.595e-3</izz>", inertia)
    sizes = {"area": mass / length / 7870.0, "second_moment": 5e-11, "height": 0.008}
    section = "".join(f"<linkages:{key}>{value}</linkages:{key}>" for key, value in sizes.items())
    elastic = beam("link3", "link3_C", f"<linkages:section>{section}</linkages:section>")
    frame = f'<frame name="middle" attached_to="link3"><pose>{length / 2} 0 0 0 0 0</pose></frame>'
    text = text.replace('<visual name="link3_bar">', f'{elastic}<visual name="link3_bar">')
    return text.replace('<frame name="link3_C"', f'{frame}<frame name="link3_C"')


#: SDFormat text, flexible links, drives.
MACHINES = {
    "slider_crank": (_slider_crank, ("rod",), "[drives.O]\nspeed = 150\n"),
    "four_bar": (_four_bar, ("coupler", "follower"), "[drives.O]\nspeed = 150\n"),
    "seven_bar": (_seven_bar, ("link3",), "[drives.O1]\nspeed = 40\n[drives.O4]\nspeed = -20\n"),
}


def bent_machine(
    folder: Path,
    name: str,
    law: str = "ideal",
    duration: float = 0.01,
    keys: str = "bending = 8\naxial = 0",
    accuracy=1e-8,
) -> linkages.System:
    """Load a mechanism with eight bending modes in each flexible link and no axial mode."""
    text, links, drives = MACHINES[name]
    (folder / f"{name}.sdf").write_text(text(), encoding="utf-8")
    bending = "".join(f'[links.{link}]\nmodel = "flexible"\n{keys}\n' for link in links)
    head = f'mechanism = "{name}.sdf"\nduration = {duration}\noutputs = ["middle.deflection"]\n'
    path = folder / f"{name}_{law}.toml"
    path.write_text(f"{head}{drives}{_LAWS[law]}{bending}[solver]\naccuracy = {accuracy}\n", encoding="utf-8")
    return linkages.load(path)
