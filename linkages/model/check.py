"""Do a mechanism and an experiment fit each other? Every name must exist, every value suit what it is for."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, NoReturn

from linkages.errors import InputError, nearest
from linkages.files.keys import unit_of
from linkages.files.units import SLIDING, read
from linkages.laws import CONTACTS
from linkages.model.experiment import QUANTITIES, Experiment
from linkages.model.load_tables import Force, Spring, Torque, TorsionSpring
from linkages.model.mechanism import Frame, Mechanism
from linkages.model.tables import Drive, JointModel

#: Deepest wear, in parts of the bearing's radius, for which the geometry of overlaps holds.
DEEPEST = 0.2

#: Parts of a run that tables know without being told.
OWN_WINDOWS = ("whole", "report", "steady")


def check(mechanism: Mechanism, experiment: Experiment) -> None:
    """Refuse an experiment with names that the mechanism does not have, or values that do not suit it."""
    for kind in ("drives", "joints"):
        for name in getattr(experiment, kind):
            if name not in mechanism.joint:
                has_none = f"{mechanism.source.name} has no such joint; {nearest(name, mechanism.joint)}"
                raise InputError(experiment.source, f"{kind}.{name}", has_none)
    for name, drive in experiment.drives.items():
        _Check(mechanism, experiment, f"drives.{name}").drive(name, drive)
    for name in experiment.play:
        _Check(mechanism, experiment, f"joints.{name}").play(name, experiment.joints[name])
    taken = {"world", *mechanism.point, *mechanism.joint}
    for table, name in experiment.loads:
        load = _Check(mechanism, experiment, f"{table}.{name}")
        if name in taken:
            load.refuse("", "is also the name of a link, frame, joint or load; choose another one")
        if "." in name:
            load.refuse("", "has a dot in its name; choose another one")
        taken.add(name)
        checks: dict[str, Callable[[Any], None]] = {
            "forces": load.force,
            "torques": load.torque,
            "springs": load.spring,
            "torsion_springs": load.torsion_spring,
        }
        checks[table](getattr(experiment, table)[name])
    for name, window in experiment.windows.items():
        part = _Check(mechanism, experiment, f"windows.{name}")
        if name in OWN_WINDOWS:
            part.refuse("", "is the name of a window that is there by itself; choose another one")
        if window.end > experiment.duration:
            part.refuse("end", f"is {window.end:g} s, after the duration of {experiment.duration:g} s")
    if experiment.report_from is not None and experiment.report_from >= experiment.duration:
        problem = f"is {experiment.report_from:g} s; it must be before the duration of {experiment.duration:g} s"
        _Check(mechanism, experiment, "report_from").refuse("", problem)
    for output in experiment.outputs:
        _Check(mechanism, experiment, f'outputs: "{output}"').output(output)


@dataclass(frozen=True)
class _Check:
    """Checks of what the experiment has at the dotted path `where`."""

    mechanism: Mechanism
    experiment: Experiment
    where: str

    def drive(self, name: str, drive: Drive) -> None:
        if self.mechanism.joint[name].type == "fixed":
            self.refuse("", "a fixed joint cannot be driven")
        if name in self.experiment.play:
            self.refuse("", "a joint with clearance cannot be driven; make it ideal")
        if (drive.force, drive.forces) != (None, None) and self.mechanism.joint[name].type == "revolute":
            self.refuse("force", "belongs to a joint that slides; give this one, which turns, a torque")
        slides = self.mechanism.joint[name].type == "prismatic"
        for path, text in self.experiment.texts.items():
            key = path.removeprefix(f"{self.where}.")
            if key in Drive.model_fields:
                unit = unit_of(Drive.model_fields[key])
                try:
                    read(text, SLIDING.get(unit, unit) if slides else unit)
                except ValueError as problem:
                    self.refuse(key, str(problem))
        self.covers(drive.times)

    def play(self, name: str, model: JointModel) -> None:
        """Check a joint with play against the machine's bearing or slot."""
        joint, clearance = self.mechanism.joint[name], model.clearance or 0.0
        if self.experiment.start == "equilibrium" and any(model.offset):
            self.refuse("offset", 'is given beside start = "equilibrium", which finds it; remove one of them')
        if joint.type == "fixed":
            self.refuse("", "a fixed joint cannot have play")
        if joint.bearing is None and joint.slot is None:
            part = "bearing" if joint.type == "revolute" else "slot"
            where = f'in <joint name="{name}"> of {self.mechanism.source.name}'
            self.refuse("model", f'"{model.model}" needs a <linkages:{part}> {where}')
        if joint.bearing is not None:
            radius = joint.bearing.radius
            if clearance >= radius:
                least = f"it must be smaller than the bearing's radius of {radius:g} m"
                self.refuse("clearance", f"is {clearance:g} m; {least}")
            if radius - clearance == radius:
                self.refuse("clearance", f"is {clearance:g} m; beside a radius of {radius:g} m that is rounding")
            if sum(x * x for x in model.offset) >= clearance**2:
                self.refuse("offset", "must lie inside the clearance circle")
            if model.wear is not None and max(sum(model.wear.depths, [0.0])) > DEEPEST * radius:
                self.refuse("wear", f"depths must not exceed {DEEPEST:g} of the bearing's radius of {radius:g} m")
            return
        if model.model != "dry":
            self.refuse("model", f'is "{model.model}"; a guide with play is "dry"')
        if model.wear is not None:
            self.refuse("wear", "is that of a journal in a bearing; a guide does not wear")
        contact = model.contact
        if contact is not None and (contact.stiffness is None or CONTACTS[contact.law].conformal):
            self.refuse("contact", "a corner at a wall needs a power law and its stiffness [N/m^n]")

    def force(self, load: Force) -> None:
        self.covers(load.times)
        if self.point("point", load.point).link == "world":
            self.refuse("point", f'"{load.point}" is fixed to the world; name a link\'s')

    def torque(self, load: Torque) -> None:
        self.covers(load.times)
        self.known("link", load.link, self.mechanism.link)

    def spring(self, load: Spring) -> None:
        link = self.point("point", load.point).link
        other = "world" if load.to is None else self.point("to", load.to).link
        if link == other:
            self.refuse("", f'joins two points of the same link, "{link}"')

    def torsion_spring(self, load: TorsionSpring) -> None:
        if load.joint is not None:
            self.known("joint", load.joint, self.mechanism.joint)
            kind = self.mechanism.joint[load.joint].type
            if kind != "revolute":
                self.refuse("joint", f'"{load.joint}" is {kind}; a revolute joint can turn')
            return
        first, second = load.links or ["", ""]
        for link in (first, second):
            self.known("links", link, ("world", *self.mechanism.link))
        if first == second:
            self.refuse("links", "are one and the same")

    def output(self, name: str) -> None:
        point, _, quantity = name.rpartition(".")
        if point not in self.mechanism.point:
            near = nearest(point, self.mechanism.point)
            self.refuse("", f'{self.mechanism.source.name} has no link or frame "{point}"; {near}')
        if quantity not in QUANTITIES:
            self.refuse("", f'"{quantity}" is unknown; {nearest(quantity, QUANTITIES)}')

    def covers(self, times: list[float] | None) -> None:
        """Check that a table lasts as long as the run."""
        duration = self.experiment.duration
        if times is not None and times[-1] < duration:
            self.refuse("times", f"end at {times[-1]:g} s, before the duration of {duration:g} s")

    def point(self, key: str, name: str) -> Frame:
        """Find a named point."""
        if name == "world":
            self.refuse(key, 'is "world"; name a frame, or give a spring an anchor')
        self.known(key, name, self.mechanism.point)
        return self.mechanism.point[name]

    def known(self, key: str, name: str, names: Iterable[str]) -> None:
        """Check a name against those that the mechanism has."""
        if name not in names:
            self.refuse(key, f'"{name}" is not in {self.mechanism.source.name}; {nearest(name, names)}')

    def refuse(self, key: str, problem: str) -> NoReturn:
        raise InputError(self.experiment.source, f"{self.where}.{key}".rstrip("."), problem)
