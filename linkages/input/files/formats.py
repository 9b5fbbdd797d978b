"""Formats of mechanisms that are not read: one line names the format, and the readable ones."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

from linkages.base.errors import InputError

_READ = "SDFormat (<sdf>), URDF and xacro (<robot>) and MJCF (<mujoco>) are read"
#: Formats by the root of their XML files.
_ROOTS = {
    "COLLADA": "a COLLADA file, of shapes",
    "OpenSimDocument": "an OpenSim model",
    "Robot": "a robot of OpenRAVE",
    "Environment": "an environment of OpenRAVE",
    "KinBody": "a body of OpenRAVE",
    "fmiModelDescription": "the description of an FMU",
    "svg": "a drawing",
    "html": "a web page",
}
#: Formats by the ends of their names.
_SUFFIXES = {
    ".adm": "an Adams model",
    ".cmd": "a command file of Adams",
    ".dae": "a COLLADA file, of shapes",
    ".json": "a JSON file",
    ".mbd": "a model of MBDyn",
    ".mdl": "a Simulink model",
    ".mo": "a Modelica model",
    ".obj": "a file of shapes",
    ".osim": "an OpenSim model",
    ".slx": "a Simulink model",
    ".step": "a STEP file, of shapes",
    ".stl": "a file of shapes",
    ".stp": "a STEP file, of shapes",
    ".usd": "a USD scene",
    ".usda": "a USD scene",
    ".usdc": "a USD scene",
    ".usdz": "a USD scene",
    ".yaml": "a YAML file",
}


def check_suffix(path: Path) -> None:
    """Refuse a file whose name ends as files of another format do."""
    if named := _SUFFIXES.get(path.suffix.lower()):
        raise InputError(path, "", f"is {named}; {_READ}")


def check_root(path: Path, root: ET.Element) -> None:
    """Refuse an XML file of another format."""
    if root.tag != "sdf":
        named = _ROOTS.get(root.tag.rpartition("}")[2], "of an unknown format")
        raise InputError(path, f"<{root.tag}>", f"is {named}; {_READ}")
