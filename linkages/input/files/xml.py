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
#: Elements and attributes that are true or false.
_TRUTHS = ("static", "use_parent_model_frame"), ("degrees", "auto", "merge")
#: Elements that the package adds to SDFormat, by the table of their owners: sizes of joints and links.
ANNOTATIONS = {"joints": ("bearing", "slot"), "links": ("beam",)}
OURS = {table: tuple(f"linkages:{kind}" for kind in kinds) for table, kinds in ANNOTATIONS.items()}  #: prefixed
#: Elements that their owner has once; readers of other programs take the first one, or the last.
_ONCE = {
    "link": ("pose", "inertial", *OURS["links"]),
    "inertial": ("pose", "origin", "mass", "inertia"),
    "joint": ("pose", "origin", "parent", "child", "axis", "limit", "dynamics", *OURS["joints"]),
    "axis": ("xyz", "limit", "dynamics"),
    "frame": ("pose",),
    "model": ("pose", "static"),
    "sdf": ("world",),
}
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
    root = builder.close()
    for element in root.iter():
        _check_once(path, element)
        _unify_truths(path, element)
    return root


def _check_once(path: Path, owner: ET.Element) -> None:
    """Reject a second element of a kind that its owner has once."""
    for tag in _ONCE.get(owner.tag, ()):
        if len(found := owner.findall(tag)) > 1:
            raise InputError(path, label(owner), f"has {len(found)} <{tag}> elements; keep one")


def _unify_truths(path: Path, element: ET.Element) -> None:
    """Write "true" or "false" for the notations of both that SDFormat accepts: True, 1, FALSE, 0."""
    tags, keys = _TRUTHS
    if element.tag in tags:
        element.text = _truth(path, label(element), element.text or "false")
    for key in element.attrib.keys() & set(keys):
        element.set(key, _truth(path, f"{label(element)} {key}", element.get(key, "")))


def _truth(path: Path, where: str, text: str) -> str:
    word = text.strip().lower()
    if word not in ("true", "1", "false", "0"):
        raise InputError(path, where, f'is "{text.strip()}"; write true or false')
    return "true" if word in ("true", "1") else "false"


def label(element: ET.Element) -> str:
    """Name an element in an error: ``<joint name="A">``."""
    name = element.get("name")
    return f'<{element.tag} name="{name}">' if name else f"<{element.tag}>"


def _blank(found: re.Match[bytes]) -> bytes:
    """Replace a comment by its line breaks, so that line numbers in errors stay correct."""
    whole = found[0].startswith(b"<!--") and found[0].endswith(b"-->")
    return b"\n" * found[0].count(b"\n") if whole else found[0]
