"""Do a mechanism and an experiment fit each other? Every name must exist, every value suit what it is for."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, NoReturn

from linkages.errors import InputError, nearest
from linkages.laws import CONTACTS
from linkages.model.experiment import QUANTITIES, Experiment
from linkages.model.load_tables import Force, Spring, Torque, TorsionSpring
from linkages.model.mechanism import Frame, Mechanism
from linkages.model.tables import JointModel


def check(mechanism: Mechanism, experiment: Experiment) -> None:
    """Check that every name in the experiment exists in the mechanism and that the values suit it.

    Raises
    ------
    InputError
        One line with key and reason.
    """
    source = experiment.source
    for kind in ("drives", "joints"):
        for name in getattr(experiment, kind):
            if name not in mechanism.joint:
                raise InputError(
                    source,
                    f"{kind}.{name}",
                    f"{mechanism.source.name} has no such joint; {nearest(name, mechanism.joint)}",
                )
    for name, drive in experiment.drives.items():
        where = f"drives.{name}"
        if mechanism.joint[name].type == "fixed":
            raise InputError(source, where, "a fixed joint cannot be driven")
        if name in experiment.play:
            raise InputError(source, where, "a joint with clearance cannot be driven; make it ideal")
        if drive.times is not None and drive.times[-1] < experiment.duration:
            raise InputError(
                source,
                f"{where}.times",
                f"end at {drive.times[-1]:g} s, before the duration of {experiment.duration:g} s",
            )
    for name, joint in experiment.joints.items():
        if not joint.has_play:
            continue
        _check_joint(mechanism, experiment, name, joint)
    check_loads(mechanism, experiment)
    for output in experiment.outputs:
        point, _, quantity = output.rpartition(".")
        if point not in mechanism.point:
            raise InputError(
                source,
                f'outputs: "{output}"',
                f'{mechanism.source.name} has no link or frame "{point}"; {nearest(point, mechanism.point)}',
            )
        if quantity not in QUANTITIES:
            raise InputError(
                source, f'outputs: "{output}"', f'"{quantity}" is unknown; {nearest(quantity, QUANTITIES)}'
            )


def _check_joint(mechanism: Mechanism, experiment: Experiment, name: str, model: JointModel) -> None:
    """Check a joint with play against the machine's bearing or slot."""
    source, joint, clearance = experiment.source, mechanism.joint[name], model.clearance or 0.0
    needs = {"revolute": "bearing", "prismatic": "slot"}.get(joint.type)
    if needs is None:
        raise InputError(source, f"joints.{name}", "a fixed joint cannot have play")
    if (joint.bearing or joint.slot) is None:
        raise InputError(
            source,
            f"joints.{name}.model",
            f'"{model.model}" needs a <linkages:{needs}> in <joint name="{name}"> of {mechanism.source.name}',
        )
    if joint.bearing is not None:
        if clearance >= joint.bearing.radius:
            raise InputError(
                source,
                f"joints.{name}.clearance",
                f"is {clearance:g} m; it must be smaller than the bearing's radius of {joint.bearing.radius:g} m",
            )
        if sum(x * x for x in model.offset) >= clearance**2:
            raise InputError(source, f"joints.{name}.offset", "must lie inside the clearance circle")
        return
    if model.model != "dry":
        raise InputError(source, f"joints.{name}.model", f'is "{model.model}"; a guide with play is "dry"')
    if model.contact is not None and (
        model.contact.stiffness is None or CONTACTS[model.contact.law].conformal
    ):
        raise InputError(
            source, f"joints.{name}.contact", "a corner at a wall needs a power law and its stiffness [N/m^n]"
        )


def check_loads(mechanism: Mechanism, experiment: Experiment) -> None:
    """Check that the names in the loads exist in the mechanism, and that tables cover the duration.

    Raises
    ------
    InputError
        One line with key and reason.
    """
    taken = {"world", *mechanism.point, *mechanism.joint}
    for table, name in experiment.loads:
        check = _Check(mechanism, experiment, f"{table}.{name}")
        if name in taken:
            check.refuse("", "is also the name of a link, frame, joint or load; choose another one")
        if "." in name:
            check.refuse("", "has a dot in its name; choose another one")
        taken.add(name)
        checks: dict[str, Callable[[Any], None]] = {
            "forces": check.force,
            "torques": check.torque,
            "springs": check.spring,
            "torsion_springs": check.torsion_spring,
        }
        checks[table](getattr(experiment, table)[name])


@dataclass(frozen=True)
class _Check:
    """Checks of one load at the dotted path `where`."""

    mechanism: Mechanism
    experiment: Experiment
    where: str

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
