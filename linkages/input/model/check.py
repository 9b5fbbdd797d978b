"""Consistency of a mechanism and an experiment: all names exist, all values suit their objects."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from linkages.base.errors import InputError, nearest
from linkages.elements.analysis import Analysis
from linkages.elements.contact_tables import ContactTable
from linkages.elements.machine import (
    KINDS,
    OF_ELEMENTS,
    OF_PARTS,
    TABLES,
    absent_model,
    all_elements_of,
    outputs_of_models,
    outputs_of_part,
    owner_of,
)
from linkages.elements.outputs import Source
from linkages.elements.pictures import Point
from linkages.input.files.formula import CONSTANTS, FUNCTIONS, shown
from linkages.input.files.table_keys import bracketed
from linkages.input.files.toml import Table
from linkages.input.files.unit_conversion import SLIDING, read, si
from linkages.input.functions.definitions import OF_JOINTS, OF_OWN, OF_POINTS, TIME, inputs_of, over_time
from linkages.input.functions.smoothing import SmoothSignal
from linkages.input.model.beam_interfaces import substructures
from linkages.input.model.capabilities import check_analysis
from linkages.input.model.experiment import Experiment
from linkages.input.model.experiment_tables import JointModel
from linkages.input.model.mechanism import Frame, Joint, Mechanism
from linkages.input.model.output_names import PIN_QUANTITIES, QUANTITIES, SHAPE_QUANTITIES
from linkages.laws import CONTACTS
from linkages.laws.film.closed_form import THINNEST

#: Deepest wear, relative to the bearing's radius, for which the overlap geometry is valid.
DEEPEST = 0.2

_NAMED = {"drives": "joint", "joints": "joint", "links": "link"}  # tables of the mechanism's elements
_SAME = 1e-9  # distance below which a frame coincides with a joint [m]

#: Names of the predefined windows.
OWN_WINDOWS = ("whole", "report", "steady", "later")


def without_lost_outputs(mechanism: Mechanism, experiment: Experiment, replaced: Iterable[str]) -> Experiment:
    """Remove outputs of links that became rigid, and of joints that became ideal, by values replaced at these paths."""
    tables = {path.partition(".")[0] for path in replaced}
    if tables.isdisjoint(("links", "joints")) or "outputs" in tables:
        return experiment
    ideal = experiment.joints.keys() - set(experiment.play)

    def gone(name: str) -> bool:
        point, _, quantity = name.rpartition(".")
        if point in ideal:
            return not experiment.is_of_joint(point, quantity)
        link = mechanism.point[point].link if point in mechanism.point else ""
        modelled = any(link in experiment.elements[kind.table] for kind in OF_PARTS if kind.part == "link")
        return quantity in SHAPE_QUANTITIES and modelled and link not in experiment.deforming

    kept = [name for name in experiment.outputs if not gone(name)]
    return experiment if kept == experiment.outputs else experiment.replaced({"outputs": kept})


@contextmanager
def names_first(machine: Callable[[], Mechanism]) -> Iterator[None]:
    """Report a joint or link that a mechanism lacks rather than a fault of its table of the experiment."""
    try:
        yield
    except InputError as fault:
        table, _, rest = fault.where.partition(".")
        try:
            mechanism = machine() if table in _NAMED and rest else None
        except InputError:  # of a mechanism with faults nothing is known
            raise fault from None
        if mechanism is not None and not any(f"{rest}.".startswith(f"{name}.") for name in _known(mechanism, table)):
            check_name(mechanism, fault.source, table, rest.partition(".")[0])
        raise


def check_name(mechanism: Mechanism, source: str | Path, table: str, name: str) -> None:
    """Reject the name of a table of drives, joints or links that the mechanism lacks."""
    if name not in (known := _known(mechanism, table)):
        has_none = f"{mechanism.source.name} has no such {_NAMED[table]}; {nearest(name, known)}"
        raise InputError(source, f"{table}.{name}", has_none)


def _known(mechanism: Mechanism, table: str) -> Collection[str]:
    """Return the names that a table can have."""
    found: Collection[str] = getattr(mechanism, _NAMED[table])
    return found


def check(mechanism: Mechanism, experiment: Experiment) -> None:
    """Reject an experiment with names that the mechanism lacks, or values that do not suit it."""
    for table in _NAMED:
        for name in getattr(experiment, table):
            check_name(mechanism, experiment.source, table, name)
    for parameter, unit in mechanism.units.items():
        _Check(mechanism, experiment, f"sdf.{parameter}").measured(experiment.texts.get(f"sdf.{parameter}"), unit)
    for kind, name, keys in all_elements_of(experiment.elements, OF_PARTS):
        kind.check(keys, _Check(mechanism, experiment, kind.path(name)))
    for name in experiment.play:
        _Check(mechanism, experiment, f"joints.{name}").play(name, experiment.joints[name])
    if experiment.start == "equilibrium":
        check_analysis(experiment, Analysis.EQUILIBRIUM)
    taken = {"world", *mechanism.point, *mechanism.joint}
    own = [("values", name) for name in experiment.values]
    own += [(table, name) for table in TABLES for name in experiment.elements[table]]
    for table, name in dict.fromkeys((*experiment.named, *own)):
        load = _Check(mechanism, experiment, f"{table}.{name}")
        if name in taken:
            load.refuse("", "is also the name of a link, frame, joint or load; choose another one")
        if "." in name:
            load.refuse("", "has a dot in its name; choose another one")
        taken.add(name)
        if table in OF_ELEMENTS:
            OF_ELEMENTS[table].check(experiment.elements[table][name], load)
        else:
            getattr(load, table)(getattr(experiment, table)[name])
    derived = (kind for kind in KINDS if kind.derived is not None)
    for kind, name, keys in all_elements_of(experiment.elements, derived):
        kind.check(keys, _Check(mechanism, experiment, kind.path(name)))
    _check_quantities(mechanism, experiment)
    for name, window in experiment.windows.items():
        part = _Check(mechanism, experiment, f"windows.{name}")
        if name in OWN_WINDOWS:
            part.refuse("", "is the name of a predefined window; choose another one")
        if window.end > experiment.duration:
            part.refuse("end", f"is {window.end:g} s, after the duration of {experiment.duration:g} s")
    if experiment.report_from is not None and experiment.report_from >= experiment.duration:
        problem = f"is {experiment.report_from:g} s; it must be before the duration of {experiment.duration:g} s"
        _Check(mechanism, experiment, "report_from").refuse("", problem)
    for output in experiment.outputs:
        _Check(mechanism, experiment, f'outputs: "{output}"').output(output)


def _check_quantities(mechanism: Mechanism, experiment: Experiment) -> None:
    """Reject formulas of quantities with unknown names, and formulas that need themselves."""
    for name, quantity in experiment.quantities.items():
        if name in experiment.values:
            continue
        part = _Check(mechanism, experiment, ".".join(owner_of(experiment.elements, name)))
        try:
            inputs = [*inputs_of(quantity.definition, experiment.quantities, (name,))]
        except KeyError as cycle:
            part.refuse(
                "", f'its formulas need the value of "{cycle.args[0]}", which needs itself; use a state between'
            )
        for one in inputs:
            part.signal("", one, quantity.definition.formula.text)


@dataclass(frozen=True)
class _Check:
    """Checks of the experiment's value at the dotted path `where`; those of named elements have the tables' names."""

    mechanism: Mechanism
    experiment: Experiment
    where: str

    @property
    def name(self) -> str:
        """Return the name of the element, or of the joint or link."""
        return self.where.partition(".")[2]

    def in_file(self, kind: str) -> str:
        """Return where the part with the element's name is in the machine's file."""
        return f'<{kind} name="{self.name}"> of {self.mechanism.source.name}'

    def over_time(self, key: str, text: str | None) -> None:
        """Check that a formula of a motion has no names but the time and values."""
        try:
            over_time(text or "0", self.experiment.values)
        except ValueError as problem:
            self.refuse(key, str(problem))

    def slides(self, joint: str) -> bool:
        return self.mechanism.slides(joint)

    def measured(self, text: Any, unit: str, key: str = "") -> None:
        """Check that a value's text is measured in a unit of the same kind, if it has one."""
        try:
            read(text, unit)
        except ValueError as problem:
            self.refuse(key, str(problem))

    def unit(self, key: str, unit: str) -> None:
        """Refuse a value with a unit of another kind than this SI unit."""
        self.measured(self.experiment.texts.get(f"{self.where}.{key}"), unit, key)

    def units(self, table: type[Table], slides: bool) -> None:
        """Check the units of a table's values for a coordinate that is a displacement, or an angle."""
        start = f"{self.where}."
        for path, text in self.experiment.texts.items():
            key = path.removeprefix(start)
            if path.startswith(start) and key in table.model_fields:
                unit = bracketed(table.model_fields[key].description)
                self.measured(text, SLIDING.get(unit, unit) if slides else unit, key)

    def play(self, name: str, model: JointModel) -> None:
        """Check a clearance joint against its bearing or slot."""
        joint, clearance = self.mechanism.joint[name], model.clearance or 0.0
        if self.experiment.start == "equilibrium" and any(model.offset):
            self.refuse("offset", 'is given, but start = "equilibrium" computes it; remove one of them')
        if joint.type == "fixed":
            self.refuse("", "a fixed joint cannot have clearance")
        if joint.bearing is None and joint.slot is None:
            part = "bearing" if joint.type == "revolute" else "slot"
            self.refuse("model", f'"{model.model}" needs a <linkages:{part}> in {self.in_file("joint")}')
        if joint.bearing is not None:
            radius = joint.bearing.radius
            if clearance >= radius:
                least = f"it must be smaller than the bearing's radius of {radius:g} m"
                self.refuse("clearance", f"is {clearance:g} m; {least}")
            if radius - clearance == radius:
                self.refuse("clearance", f"is {clearance:g} m, a rounding error for a radius of {radius:g} m")
            if sum(x * x for x in model.offset) >= clearance**2:
                self.refuse("offset", "must lie inside the clearance circle")
            if model.is_tilted:
                self.tilt(model, clearance, joint.bearing.length)
            if model.wear is not None and max(sum(model.wear.depths, [0.0])) > DEEPEST * radius:
                self.refuse("wear", f"depths must not exceed {DEEPEST:g} of the bearing's radius of {radius:g} m")
            return
        if model.model != "dry":
            self.refuse("model", f'is "{model.model}"; a guide with clearance is "dry"')
        if model.wear is not None:
            self.refuse("wear", "applies to a journal in a bearing; a guide does not wear")
        if model.contact is not None:
            self.plain(model.contact)

    def tilt(self, model: JointModel, clearance: float, length: float) -> None:
        """Check that the ends of a tilted journal do not touch the bearing at t = 0."""
        most, slope = 2.0 * clearance / length, math.hypot(*model.tilt)
        if slope >= most * (1.0 - THINNEST):
            self.refuse("tilt", f"is {slope:g}; a centred journal touches the bearing at {most:g} (2 c/L) and above")
        if math.hypot(*model.offset) + 0.5 * length * slope >= clearance * (1.0 - THINNEST):
            self.refuse("offset", "must leave room for the tilt: an end of the journal touches the bearing")

    def plain(self, contact: ContactTable) -> None:
        """Check the law of a contact other than a journal in a bearing."""
        law = CONTACTS[contact.law]
        if law.conformal or ("stiffness" in law.needs and contact.stiffness is None):
            self.refuse("contact", "a corner at a wall needs a power law and its stiffness [N/m^n]")

    def interfaces(self, link: str) -> int:
        """Return the largest number of interfaces of a substructure of a link with a beam."""
        return max(len(one.held) for one in substructures(self.mechanism, self.experiment, link))

    def link_of(self, key: str, point: Point) -> str:
        """Return the link of a point, "world" for a fixed one; refuse an unknown one."""
        return self.point(key, point).link if isinstance(point, str) else "world"

    def known_link(self, key: str, name: str) -> str:
        """Return the name of a link or "world"; refuse an unknown one."""
        self.known(key, name, ("world", *self.mechanism.link))
        return name

    def moved_link(self, key: str, name: str) -> str:
        """Return the name of a link; refuse an unknown one, and the world."""
        self.known(key, name, self.mechanism.link)
        return name

    def revolute(self, key: str, name: str) -> str:
        """Return the name of a revolute joint; refuse others."""
        self.known(key, name, self.mechanism.joint)
        if (kind := self.mechanism.joint[name].type) != "revolute":
            self.refuse(key, f'"{name}" is {kind}; name a revolute joint')
        return name

    def moving(self, name: str) -> str:
        """Return the name of a joint; refuse an unknown or fixed one."""
        self.known("joint", name, self.mechanism.joint)
        if self.mechanism.joint[name].type == "fixed":
            self.refuse("joint", f'"{name}" is a fixed joint and cannot move')
        return name

    def joint(self, key: str, name: str) -> Joint:
        """Return a joint; refuse an unknown one."""
        self.known(key, name, self.mechanism.joint)
        return self.mechanism.joint[name]

    def has_clearance(self, joint: str) -> bool:
        """Tell whether a joint has clearance."""
        return joint in self.experiment.play

    def meet(self, one: str, other: str) -> bool:
        """Tell whether two joints share a link, or have links that fixed joints make one body."""
        return self.mechanism.meet(one, other)

    def bends(self, link: str) -> bool:
        """Tell whether a link is flexible."""
        return link in self.experiment.deforming

    def within(self, key: str) -> _Check:
        """Return the checks of the table at a key."""
        return replace(self, where=f"{self.where}.{key}")

    def signal(self, key: str, name: str, text: str) -> str:
        """Check an input of a formula, whose text is given; return its unit."""
        if name == TIME or name in self.experiment.quantities:
            return ""
        owner, _, part = name.rpartition(".")
        if not owner or part in OF_OWN:
            known = ", ".join(["t, the time", "POINT.x, JOINT.rate and the like", *self.experiment.quantities])
            self.refuse(key, f'"{shown(text)}" has "{name}"; it may have {known}')
        if owner == "world":
            self.refuse(key, 'a formula cannot use "world", which never moves')
        places = self.mechanism.place if part in PIN_QUANTITIES else self.mechanism.point
        owners: Iterable[str] = places if part in OF_POINTS else self.mechanism.joint
        self.known(key, owner, owners)
        unit = (OF_POINTS | OF_JOINTS)[part]
        if part in OF_JOINTS:
            kind = self.mechanism.joint[owner].type
            if kind == "fixed":
                self.refuse(key, f'"{owner}" is fixed; it has no {part}')
            unit = SLIDING[unit] if kind == "prismatic" else unit
        return unit

    def values(self, _: float) -> None:
        self.name_for_formulas()

    def is_free(self, joint: str) -> bool:
        """Tell whether a joint is ideal and has no prescribed motion."""
        drive = self.experiment.drives.get(joint)
        return joint not in self.experiment.play and not (drive is not None and drive.prescribed)

    def has_gearbox(self, joint: str) -> bool:
        """Tell whether the drive of a joint has backlash."""
        return joint in self.experiment.wheels

    def ends_of(self, joint: str) -> tuple[str, str]:
        """Return the parent and child of a joint."""
        return self.mechanism.joint[joint].parent, self.mechanism.joint[joint].child

    def has_beam(self, link: str) -> bool:
        """Tell whether a link has a beam."""
        return link in self.mechanism.beam

    def name_for_formulas(self) -> None:
        """Refuse a name that formulas cannot have."""
        name = self.where.partition(".")[2]
        if not name.isidentifier() or name in {TIME, *CONSTANTS, *FUNCTIONS}:
            self.refuse("", "cannot be a name in formulas; use letters and digits, and no name of a function")

    def output(self, name: str) -> None:
        """Check an output of a link, frame or joint; names of other elements are checked before a run.

        See `linkages.results.outputs.registry.check_outputs`.
        """
        point, _, quantity = name.rpartition(".")
        if point in self.mechanism.joint:
            self.joint_output(point, quantity)
            return
        elements = {label for _, label in self.experiment.acting}
        elements.update(*self.experiment.elements.values())
        if not point or point == "q" or point in elements or point.rpartition(".")[0] in elements:
            return
        if point not in self.mechanism.point:
            near = nearest(point, self.mechanism.place)
            self.refuse("", f'{self.mechanism.source.name} has no link, frame or joint "{point}"; {near}')
        link = self.mechanism.point[point].link
        source = Source.ALONG if point == link else Source.FRAME
        own = outputs_of_part(self.experiment.elements, "link", link, self.slides, source)
        if not own and (problem := absent_model("link", link, quantity)):
            self.refuse("", problem)
        if quantity not in (known := {*QUANTITIES, *own}):
            self.refuse("", f'"{quantity}" is unknown; {nearest(quantity, known)}')

    def joint_output(self, name: str, quantity: str) -> None:
        """Check an output of a joint."""
        if self.experiment.is_of_joint(name, quantity) or name in self.experiment.play:
            return
        if quantity in outputs_of_models("joint"):
            self.refuse("", absent_model("joint", name, quantity))
        near = nearest(
            quantity, (*PIN_QUANTITIES, *outputs_of_part(self.experiment.elements, "joint", name, self.slides))
        )
        self.refuse("", f'"{quantity}" of a joint is no output here; {near}')

    def covers(self, times: list[float] | None, fits: Iterable[SmoothSignal]) -> None:
        """Check that a table, or the signals of a file, cover the duration of the run."""
        if times is not None and times[-1] < (duration := self.experiment.duration):
            self.refuse("times", f"end at {times[-1]:g} s, before the duration of {duration:g} s")
        for fit in fits:
            first, last = fit.covered
            if first > 0.0 or last < self.experiment.duration:
                remedy = "change duration or shift"
                covers = f"is from {first:.6g} to {last:.6g} s, and the run from 0 to {self.experiment.duration:g} s"
                self.refuse("file", f"{covers}; {remedy}")

    def same_kind(self, key: str, text: str, unit: str) -> None:
        """Check that a unit is one of the same kind as another."""
        try:
            si(f"1 {text}", unit)
        except ValueError as problem:
            self.refuse(key, str(problem).replace('is "1 ', 'is "'))

    def point(self, key: str, name: str) -> Frame:
        if name == "world":
            self.refuse(key, 'is "world"; name a frame, or give a spring an anchor')
        if (pin := self.mechanism.pin.get(name)) is not None:
            there = [p.name for p in self.mechanism.point.values() if np.allclose(p.origin, pin.origin, atol=_SAME)]
            where = f", such as {' or '.join(sorted(there))}" if there else ""
            self.refuse(key, f'"{name}" is a joint of two links; name a link or frame{where}')
        self.known(key, name, self.mechanism.point)
        return self.mechanism.point[name]

    def known(self, key: str, name: str, names: Iterable[str]) -> None:
        if name not in names:
            self.refuse(key, f'"{name}" is not in {self.mechanism.source.name}; {nearest(name, names)}')

    def refuse(self, key: str, problem: str) -> NoReturn:
        raise InputError(self.experiment.source, f"{self.where}.{key}".rstrip("."), problem)
