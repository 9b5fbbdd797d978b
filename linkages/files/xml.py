"""XML as other readers of SDFormat and URDF take it: hyphens in comments, and prefixes that nothing declares.

Tags keep the prefix they are written with, as in ``drake:joint``; ours is ``linkages``, whatever the file declares.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from pathlib import Path
from xml.parsers import expat

from linkages.errors import InputError
from linkages.files.reading import read_whole

#: Levels of elements, of poses relative to one another and of models in models: reading recurses.
DEEPEST = 100
_OURS = "urn:linkages:sdf"
_ENCODINGS = ("utf-8", "utf-16", "us-ascii", "iso-8859-1")  # that every XML reader knows, or their common part
_COMMENT = re.compile(
    rb"<!\[CDATA\[.*?(?:\]\]>|\Z)|<!--.*?(?:-->|\Z)", re.DOTALL
)  # to the end, so that it takes no second look


def read_xml(path: Path) -> ET.Element:
    """Read the root element of a file.

    Raises
    ------
    InputError
        If it cannot be read, is no well-formed XML, nests too deep, declares a document type or an encoding that not
        every reader knows.
    """
    return parse_xml(path, read_whole(path))


def parse_xml(path: Path, text: bytes) -> ET.Element:
    """Make elements of the text of a file, named in errors; as `read_xml`."""
    builder, depth = ET.TreeBuilder(), 0
    ours: set[str] = set()

    def named(name: str) -> str:
        prefix, colon, rest = name.partition(":")
        return f"linkages:{rest}" if colon and prefix in ours else name

    def refuse(*_: object) -> None:
        problem = "document types and entities are refused; remove the declaration"
        raise InputError(path, "<!DOCTYPE>", problem)

    def declared(_: str, encoding: str | None, __: int) -> None:
        if encoding is not None and encoding.lower() not in _ENCODINGS:
            raise InputError(path, "<?xml?>", f'encoding "{encoding}" is not supported; save the file as UTF-8')

    def start(name: str, attributes: dict[str, str]) -> None:
        nonlocal depth
        depth += 1
        if depth > DEEPEST:
            raise InputError(path, f"<{name}>", f"is nested more than {DEEPEST} levels deep")
        ours.update(key.partition(":")[2] for key, value in attributes.items() if value == _OURS)
        builder.start(named(name), attributes)

    def end(name: str) -> None:
        nonlocal depth
        depth -= 1
        builder.end(named(name))

    parser = expat.ParserCreate()
    parser.XmlDeclHandler, parser.StartDoctypeDeclHandler = declared, refuse
    parser.StartElementHandler, parser.EndElementHandler, parser.CharacterDataHandler = start, end, builder.data
    try:
        parser.Parse(_COMMENT.sub(_blank, text), True)
    except expat.ExpatError as problem:
        raise InputError(path, "", f"is not well-formed XML: {problem}") from None
    return builder.close()


def label(element: ET.Element) -> str:
    """Name an element in an error: ``<joint name="A">``."""
    name = element.get("name")
    return f'<{element.tag} name="{name}">' if name else f"<{element.tag}>"


def _blank(found: re.Match[bytes]) -> bytes:
    """Keep no more of a comment than its lines, so that errors name the right ones."""
    whole = found[0].startswith(b"<!--") and found[0].endswith(b"-->")
    return b"\n" * found[0].count(b"\n") if whole else found[0]
