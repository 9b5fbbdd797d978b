"""Which values of an experiment and its machine the page can change, and within which ranges.

Every number of the experiment and of its machine is a control, found by its dotted path; so are the models and laws
of joints and the start. A few are shown at first: speeds of drives, and for each clearance joint its model, clearance,
viscosity, and the coefficients of contact and friction.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

from linkages.base.errors import InputError, nearest
from linkages.elements.machine import all_elements_of
from linkages.input.files.toml import leaves
from linkages.laws import CONTACTS, FILMS, FRICTIONS
from linkages.show.naming import value_in_words
from linkages.system import System

_MODELS = ("ideal", "lubricated", "dry", "mixed")
_FIRST = ("clearance", "viscosity", "oil.temperature", "contact.restitution", "friction.coefficient")
_DECADE = ("clearance", "viscosity", "stiffness", "youngs_modulus", "density")
_FACTOR = 10.0  # range of a positive property of oil or material: value over factor to value times factor
_MASS = 5.0  # the same for masses and moments of inertia
_SHARES = ("restitution", "coefficient", "static", "film_limit", "share")
_LENGTH = 0.3  # of a length, or of the machine's size for a length of zero: half the range
_ANGLE = 0.7854  # half the range of an angle [rad]
_WIDE = 30.0  # ratio of the ends of a given range from which on a slider is logarithmic
_SPEEDS = 0.2, 5.0  # range of a drive, over its value: it keeps its sense
_OUT_OF_PLANE = (".z", ".roll", ".pitch")  # ends of paths that no run notices
_HIDDEN = ("mechanism", "title", "duration", "report_from", "solver.max_step", "solver.stabilisation")


@dataclass(frozen=True)
class Control:
    """A value that the page can change."""

    path: str  # dotted path, see `linkages.System.replaced`
    value: float | str | None  # in the experiment's file or its default, SI units; None: the file has no such value
    unit: str = ""  # SI unit; empty for a choice or where it is not known
    low: float = 0.0  # low end of a slider; a typed value may lie beyond it
    high: float = 0.0  # high end
    logarithmic: bool = False  # whether the slider's scale is logarithmic
    choices: tuple[str, ...] = ()  # values of a choice; empty for a number
    whole: bool = False  # whether the value is a whole number
    first: bool = False  # whether the page shows it at the start

    def content(self) -> dict[str, Any]:
        """Return it as the page has it: with its name in words, and the text that a search seeks in."""
        label, length = value_in_words(self.path), self.unit == "m" and ".com." not in self.path
        sought = f"{self.path} {label} {'length' if length else ''}".lower()
        return asdict(self) | {"label": label, "sought": sought, "aside": self.path.endswith(_OUT_OF_PLANE)}


def controls(system: System, vary: Mapping[str, tuple[float, float]] | None = None) -> dict[str, Control]:
    """Find every value that can be changed, by path.

    Controls with a range in `vary` [SI units] are shown first, instead of the usual ones; InputError if a path there is
    not the path of a number.
    """
    vary = vary or {}
    usual = set() if vary else set(_usual(system))
    found: dict[str, Control] = {}
    for path, value in _numbers(system):
        unit = system.value_unit(path)
        low, high, logarithmic = _range(system, path, value, unit)
        if low <= 0.0 <= value and not path.startswith("sdf."):
            ends = (low, 0, 1, value // 2) if isinstance(value, int) else (low, 0.0, _round(value / _FACTOR))
            low = next((end for end in ends if end < value and _is_allowed(system, path, end)), value)
        if path in vary:
            low, high = vary[path]
            logarithmic = 0.0 < _WIDE * low < high
        whole, first = isinstance(value, int), path in (vary or usual)
        found[path] = Control(path, value, unit, low, high, logarithmic, whole=whole, first=first)
    unknown = [path for path in vary if path not in found]
    if unknown:
        raise InputError("--vary", unknown[0], f"is not the path of a number; {nearest(unknown[0], found)}")
    for path, chosen, choices in _choices(system):
        found[path] = Control(path, chosen, choices=choices, first=path in usual)
    order = {path: k for k, path in enumerate((*vary, *_usual(system)))}
    return dict(sorted(found.items(), key=lambda item: order.get(item[0], len(order))))


def extended(known: Mapping[str, Control], system: System) -> dict[str, Control]:
    """Return the known controls, and further ones of a system, for which the file has no value."""
    new = controls(system).items()
    return {**known, **{path: replace(control, value=None) for path, control in new if path not in known}}


def _numbers(system: System) -> Iterator[tuple[str, float]]:
    """Path and value of every number of the experiment and its machine."""
    experiment = system.experiment
    for path, value in leaves(experiment.model_dump(exclude_none=True)):
        if isinstance(value, bool) or not isinstance(value, int | float) or path.startswith("sdf."):
            continue
        of_other_kind = path.startswith("controllers.") and not _is_allowed(system, path, value)  # a default
        if path not in _HIDDEN and not path.startswith("windows.") and not of_other_kind:
            yield path, value
    if system.determinate or system.tree.play:
        yield "duration", system.settings.duration
    for path, value in system.machine_values.items():
        kind, name, *rest = path.split(".")
        if kind == "links" and rest[0] in system.links[name].determined:
            continue
        yield f"sdf.{path}", float(value)


def _choices(system: System) -> Iterator[tuple[str, str, tuple[str, ...]]]:
    """Path, value and possible values of every choice: models and laws of joints for which the file has the data."""
    experiment = system.experiment
    yield "start", system.settings.start, ("centred", "equilibrium")
    for name, joint in experiment.joints.items():
        has = {
            "ideal": True,
            "lubricated": bool(joint.clearance and (joint.viscosity or joint.oil)),
            "dry": bool(joint.clearance and joint.contact),
            "mixed": bool(joint.clearance and (joint.viscosity or joint.oil) and joint.contact and joint.mixed),
        }
        models = tuple(model for model in _MODELS if has[model])
        if len(models) > 1:
            yield f"joints.{name}.model", joint.model, models
        if joint.has_film and system.joints[name].type == "revolute":
            yield f"joints.{name}.film", joint.film, tuple(FILMS)
        if joint.contact is not None:
            yield f"joints.{name}.contact.law", joint.contact.law, tuple(CONTACTS)
        if joint.friction is not None:
            yield f"joints.{name}.friction.law", joint.friction.law, tuple(FRICTIONS)


def _usual(system: System) -> Iterator[str]:
    """Paths of the controls that are shown first."""
    experiment = system.experiment
    for kind, name, keys in all_elements_of(system.parts):
        yield from (f"{kind.path(name)}.{key}" for key in kind.controls if getattr(keys, key) is not None)
    for name, joint in experiment.joints.items():
        if not joint.has_play:
            continue
        yield f"joints.{name}.model"
        for key in _FIRST:
            part: Any = joint
            for step in key.split("."):
                part = getattr(part, step, None)
            if part is not None and (key != "viscosity" or joint.has_film):
                yield f"joints.{name}.{key}"


def _range(system: System, path: str, value: float, unit: str) -> tuple[float, float, bool]:
    """Low and high end of a slider, and whether it is logarithmic."""
    key = path.rpartition(".")[2]
    if path == "solver.accuracy":
        return 1e-9, 1e-3, True
    if value > 0.0 and (key in _DECADE or unit in ("Pa", "Pa s", "m2/N")):
        return _round(value / _FACTOR), _round(value * _FACTOR), True
    if value > 0.0 and (key in ("mass", "inertia") or unit in ("kg", "kg m2")):
        return _round(value / _MASS), _round(value * _MASS), True
    if key in _SHARES and 0.0 <= value <= 1.0:
        return (0.01 if key == "restitution" else 0.0), 1.0, False
    if unit == "m" or (not unit and value and path.startswith("sdf.parameters.")):
        half = _LENGTH * (abs(value) or system.tree.extent)
        return value - half, value + half, False
    if unit == "rad":
        return value - _ANGLE, value + _ANGLE, False
    half = 2.0 * abs(value) or 1.0
    if key in ("speed", "torque", "force") and value:
        low, high = sorted(part * value for part in _SPEEDS)
        return low, high, True
    if key in ("speed", "torque", "force"):
        return -half, half, False
    return min(0.0, value - half), value + half, False


def _is_allowed(system: System, path: str, value: float) -> bool:
    try:
        system.experiment.replaced({path: value})
    except InputError:
        return False
    return True


def _round(value: float) -> float:
    return float(f"{value:.3g}")
