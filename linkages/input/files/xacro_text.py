"""Expansion of xacro, the macro language of URDF, by the package of that name."""

from __future__ import annotations

import io
import xml.etree.ElementTree as ET
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path

from linkages.base.errors import InputError
from linkages.base.packages import needed
from linkages.input.files.xml import parse_xml


def is_xacro(robot: ET.Element) -> bool:
    """Tell whether a <robot> has macros or expressions."""
    return any(
        element.tag.startswith("xacro:") or any("${" in value or "$(" in value for value in element.attrib.values())
        for element in robot.iter()
    )


def expanded(path: Path) -> ET.Element:
    """Return the <robot> of a xacro file; InputError in one line if it cannot be expanded."""
    xacro = needed("xacro", str(path.name), "is xacro")
    said = io.StringIO()
    try:
        with redirect_stdout(said), redirect_stderr(said):
            text = xacro.process_file(str(path)).toxml()
    except Exception as problem:  # of Python expressions in the file, too
        reason = " ".join(f"{problem} {said.getvalue()}".split()) or type(problem).__name__
        raise InputError(path, "", f"cannot be expanded by xacro ({reason})") from None
    return parse_xml(path, text.encode())
