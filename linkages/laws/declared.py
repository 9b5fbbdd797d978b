"""The laws by kind and name, with the parameters that they declare."""

from __future__ import annotations

import keyword
from collections.abc import Iterable, Mapping
from typing import Any

from linkages.laws.contact.contact_laws import CONTACTS
from linkages.laws.control import CONTROLLERS
from linkages.laws.film.films import FILMS
from linkages.laws.friction import FRICTIONS
from linkages.laws.parameters import NEEDS, PARAMETERS, SLOTS, Parameter

#: The laws by kind and name.
REGISTRIES: dict[str, dict[str, Any]] = {
    "contact": CONTACTS, "film": FILMS, "friction": FRICTIONS, "controller": CONTROLLERS,
}  # fmt: skip


def merged(laws: Iterable[Any]) -> tuple[Parameter, ...]:
    """Collect the parameters of laws; of equal names the first counts."""
    found: dict[str, Parameter] = {}
    for law in laws:
        for parameter in law.parameters:
            found.setdefault(parameter.name, parameter)
    return tuple(found.values())


def users(laws: Mapping[str, Any]) -> dict[Parameter, list[str]]:
    """Find the laws, by name, that declare each parameter; parameters of one name follow each other."""
    found: dict[Parameter, list[str]] = {}
    for name, law in laws.items():
        for parameter in law.parameters:
            found.setdefault(parameter, []).append(name)
    names = list(dict.fromkeys(parameter.name for parameter in found))
    return dict(sorted(found.items(), key=lambda item: names.index(item[0].name)))


#: Parameters of the built-in laws of each kind.
BUILT_IN_PARAMETERS = {kind: merged(registry.values()) for kind, registry in REGISTRIES.items()}


def declared(kind: str, parameters: Any, needs: Any) -> tuple[tuple[Parameter, ...], tuple[str, ...]]:
    """Return the parameters and the needs of a law, with their defaults."""
    if needs is None:
        needs = tuple(NEEDS[kind]) if parameters is None else ()
    for need in needs:
        if need not in NEEDS[kind]:
            raise ValueError(f'needs "{need}"; it can need {", ".join(NEEDS[kind])}')
    return BUILT_IN_PARAMETERS[kind] if parameters is None else tuple(parameters), tuple(needs)


def check_parameters(kind: str, law: str, parameters: tuple[Parameter, ...]) -> None:
    """Refuse parameters that records cannot hold, or whose key has another unit elsewhere."""
    for parameter in parameters:
        if not isinstance(parameter, Parameter):
            raise ValueError(f"{parameter!r} is not a linkages.laws.Parameter")
    names = [parameter.name for parameter in parameters]
    if len(parameters) > SLOTS:
        raise ValueError(f"has {len(parameters)} parameters; at most {SLOTS} are possible")
    others = merged(other for name, other in REGISTRIES[kind].items() if name != law)
    units = {other.name: other.unit for other in others}
    for name, parameter in zip(names, parameters, strict=True):
        if not (isinstance(name, str) and name.isidentifier()) or keyword.iskeyword(name) or name.startswith("_"):
            raise ValueError(f"parameter {name!r}: the name must be letters, digits and underscores")
        if name in (PARAMETERS.names or ()):
            raise ValueError(f'parameter "{name}": the name is taken by the record of the joint; choose another one')
        if names.count(name) > 1:
            raise ValueError(f'parameter "{name}" is declared twice')
        if units.get(name, parameter.unit) != parameter.unit:
            other = f"other {kind} laws have this key in {units[name]}"
            raise ValueError(f'parameter "{name}" [{parameter.unit}]: {other}; choose another name')
        if parameter.default is not None and not parameter.admits(parameter.default):
            raise ValueError(f'parameter "{name}": its default {parameter.default:g} must be {parameter.range}')
        if parameter.above and parameter.above not in names:
            raise ValueError(f'parameter "{name}" is above "{parameter.above}", which is not declared')
