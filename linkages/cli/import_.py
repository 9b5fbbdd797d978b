"""``linkages import``: import of SDFormat or URDF of other programs."""

from __future__ import annotations

import argparse
from pathlib import Path

from linkages.errors import InputError

HELP = "convert SDFormat or URDF of another program to a mechanism (.sdf)"

_EXAMPLES = """examples:
  linkages import robot.urdf --out robot.sdf
  linkages import gripper/model.sdf --out gripper.sdf
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.epilog = _EXAMPLES
    parser.add_argument("file", type=Path, metavar="FILE", help="SDFormat or URDF; xacro must be expanded first")
    parser.add_argument(
        "--out", type=Path, required=True, metavar="NAME.sdf", help="the mechanism's file; it must not exist"
    )


def run(options: argparse.Namespace) -> int:
    """Write the mechanism; return the exit status."""
    from linkages.files.importing import import_model
    from linkages.files.sdf import read_root
    from linkages.files.sdf_text import sdf_text
    from linkages.files.writing import errors_of_writing, whole
    from linkages.files.xml import parse_xml
    from linkages.model.mechanism import planar
    from linkages.system.reference_configuration import Drawn, closed_within_limits

    out: Path = options.out
    if out.suffix != ".sdf":
        raise InputError("--out", str(out), "must end in .sdf")
    if out.exists():
        raise InputError("--out", str(out), "already exists; choose another name, or remove it")
    model, limits, notes, entries = import_model(options.file)
    found = closed_within_limits(options.file, model, limits) if limits else Drawn(model, {})
    if found is None:
        problem = (
            "no pose was found in which all loops close and every joint is within its limits; check or remove them"
        )
        raise InputError(options.file, "<limit>", problem)
    drawn = found.model
    if drawn is not model:
        entries = [entry.redrawn(found.coordinates) for entry in entries]
        notes.append(
            "reference configuration computed within the joint limits: the file has an open loop, or exceeds a limit"
        )
    notes += [entry.note for entry in entries]
    text = sdf_text(drawn, [f"made by `linkages import {options.file.name}`", *notes])
    machine = planar(
        options.file, read_root(options.file, parse_xml(options.file, text.encode())), {}
    )  # check that it can be read
    with errors_of_writing(out):
        out.parent.mkdir(parents=True, exist_ok=True)
    with whole(out) as partial:
        partial.write_text(text, encoding="utf-8")
    for note in notes:
        print(f"- {note}")
    print(f"written: {out}, with {len(machine.links)} links and {len(machine.joints)} joints")
    print("if the other program assumed gravity, its experiment needs: gravity = [0.0, 0.0, -9.81]  # m/s2")
    return 0
