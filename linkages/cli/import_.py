"""``linkages import``: import of SDFormat, URDF, xacro and MJCF of other programs."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from linkages.base.errors import AssemblyError, InputError

if TYPE_CHECKING:
    from linkages.input.files.foreign import Entry
    from linkages.input.model.mechanism import Mechanism

HELP = "convert SDFormat, URDF, xacro or MJCF of another program to a mechanism (.sdf)"

EXAMPLES = """examples:
  linkages import robot.urdf --out robot.sdf
  linkages import cart_pole.xml --out cart_pole.sdf
  linkages import gripper/model.sdf --out gripper.sdf
  linkages import world.sdf --model arm --out arm.sdf
  linkages import four_bar.sdf --joints-at-parent --out four_bar_closed.sdf
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.add_argument("file", type=Path, metavar="FILE", help="SDFormat, URDF, xacro or MJCF")
    parser.add_argument("--model", default="", metavar="NAME", help="model of a world that has several")
    parser.add_argument(
        "--joints-at-parent",
        action="store_true",
        help="take the places of joints from the frames that <parent> names; SDFormat takes the frame's link only",
    )
    parser.add_argument("--out", type=Path, required=True, metavar="NAME.sdf", help="the new file of the mechanism")


def run(options: argparse.Namespace) -> int:
    """Write the mechanism; return the exit status."""
    from linkages.base.brief import counted
    from linkages.input.files.foreign import MARK
    from linkages.input.files.importing import USUAL_GRAVITY, import_model
    from linkages.input.files.sdf_text import sdf_text
    from linkages.input.files.writing import errors_of_writing, whole
    from linkages.input.model.mechanism import mechanism_of_text, planar
    from linkages.system.reference_configuration import Drawn, closed_within_limits

    out: Path = options.out
    if out.suffix != ".sdf":
        raise InputError("--out", str(out), "must end in .sdf")
    if out.exists():
        raise InputError("--out", str(out), "already exists; choose another name, or remove it")
    model, limits, notes, entries, gravity, displaced = import_model(
        options.file, options.model, options.joints_at_parent
    )
    found = Drawn(model, {})
    if limits or displaced:
        found = closed_within_limits(options.file, model, limits, displaced)
    drawn = found.model
    if drawn is not model:
        entries = [entry.redrawn(found.coordinates) for entry in entries]
        why = "the file has an open loop or joint, or exceeds a limit"
        notes.append(f"reference configuration computed{' within the joint limits' * bool(limits)}: {why}")
    plane = planar(options.file, drawn, {})
    entries = [_completed(entry.in_plane(plane.basis), plane) for entry in entries]
    notes += [entry.note for entry in entries]
    text = sdf_text(drawn, [f"made by `linkages import {options.file.name}`", *notes])
    machine = mechanism_of_text(options.file, text.encode())
    mobility = _mobility(machine, entries)
    with errors_of_writing(out):
        out.parent.mkdir(parents=True, exist_ok=True)
    with whole(out) as partial:
        partial.write_text(text, encoding="utf-8")
    for note in sorted(notes, key=lambda note: note.startswith(MARK)):
        print(note if note.startswith(MARK) else f"- {note}")
    said = "other programs assume, for the experiment" if gravity is None else "the file's gravity, for the experiment"
    print(f"{said}: gravity = {list(gravity or USUAL_GRAVITY)}  # m/s2")
    links, joints = len(machine.links), len(machine.joints)
    parts = counted(links, "link"), counted(joints, "joint"), counted(joints - links, "loop")
    print(f"written: {out}, with {', '.join(parts)}, {mobility}")
    return 0


def _completed(entry: Entry, machine: Mechanism) -> Entry:
    """Return the entry with the keys that the machine decides."""
    from linkages.elements.machine import OF_ELEMENTS

    kind = OF_ELEMENTS.get(entry.table)
    if kind is None or not machine.joint.keys() >= set(entry.joints):
        return entry
    return entry._replace(values={**kind.completed(entry.values, machine.meet)})


def _mobility(machine: Mechanism, entries: list[Entry]) -> str:
    """Describe the degrees of freedom, with the couplings of the entries and without."""
    from linkages.input.model.experiment import nothing_done
    from linkages.system import System

    tables = {entry.table for entry in entries if entry.couples}
    coupled = {table: {one.name: one.keys for one in entries if one.table == table} for table in tables}
    try:
        free, *more = (
            System(machine, nothing_done(machine.source, some)).assembly.mobility
            for some in ((coupled, {}) if coupled else ({},))
        )
    except (InputError, AssemblyError) as problem:
        return f"mobility unknown: {problem}"
    named = " and ".join(coupled)
    return f"mobility {free}" + "".join(f" with the {named} above, {without} without" for without in more)
