"""Tolerant XML reader for SDFormat and URDF: accepts hyphens in comments, and undeclared prefixes.

Tags keep the prefix of the file, as in ``drake:joint``; the package's prefix is always ``linkages``.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from pathlib import Path
from xml.parsers import expat

from linkages.base.errors import InputError

#: Most levels of elements, of relative poses and of nested models (reading recurses).
DEEPEST = 100
_OURS = "urn:linkages:sdf"
_ENCODINGS = ("utf-8", "utf-16", "us-ascii", "iso-8859-1")  # supported by every XML reader, or their common subset
#: It matches to the end, to avoid backtracking.
_COMMENT = re.compile(rb"<!\[CDATA\[.*?(?:\]\]>|\Z)|<!--.*?(?:-->|\Z)", re.DOTALL)


def parse_xml(path: Path, text: bytes) -> ET.Element:
    """Parse the text of a file, which errors name.

    InputError if it is not well-formed, is nested too deeply, declares a document type or an unsupported encoding.
    """
    builder, depth = ET.TreeBuilder(), 0
    ours: set[str] = set()

    def named(name: str) -> str:
        prefix, colon, rest = name.partition(":")
        return f"linkages:{rest}" if colon and prefix in ours else name

    def refuse(*_: object) -> None:
        problem = "document types and entities are rejected; remove the declaration"
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
    """Replace a comment by its line breaks, so that line numbers in errors stay correct."""
    whole = found[0].startswith(b"<!--") and found[0].endswith(b"-->")
    return b"\n" * found[0].count(b"\n") if whole else found[0]
