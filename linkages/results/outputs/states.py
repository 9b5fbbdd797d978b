"""Outputs of the quantities that elements define for formulas: additional states, quantities of motors, controllers."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

from linkages.elements.element import Element
from linkages.elements.machine import DEFINING, count
from linkages.input.functions.definitions import Quantity
from linkages.results.outputs.joints import load_value
from linkages.results.outputs.quantity import OutputPlace, Owner, quantities
from linkages.system import System


def _named(known: Mapping[str, Quantity], name: str, key: str) -> str | None:
    """Return the quantity that is an output of an element: ``NAME.key``, or as its ``value`` the element's own."""
    own = name if key == "value" else f"{name}.{key}"
    return own if own in known else None


def _at(key: str) -> Callable[[System, str], OutputPlace]:
    """Return a function that gives the place of a quantity."""

    def place(system: System, name: str) -> OutputPlace:
        known, first = system.quantities, len(system.loads[0]) + count(system.elements)
        return OutputPlace(first - len(system.elements.told) + list(known).index(_named(known, name, key) or ""))

    return place


def _having(table: str, key: str) -> Callable[[System], Iterable[str]]:
    """List the elements that have a quantity."""
    return lambda system: [name for name in system.parts[table] if _named(system.quantities, name, key) is not None]


def _unit(kind: Element[Any]) -> Callable[[System, str], str] | None:
    """Return the function that gives the unit of a quantity, if the element's keys say it."""
    unit = kind.unit
    return None if unit is None else lambda system, name: unit(system.parts[kind.table][name])


def _owners(kind: Element[Any]) -> Iterator[Owner]:
    """Make the owners of the quantities of a kind, one for each."""
    for key, text in kind.own.items():
        texts = quantities(load_value, **{key: text})
        yield Owner(kind.label, _having(kind.table, key), _at(key), texts, unit=_unit(kind))


#: Quantities in addition to those of elements as loads.
OWN = tuple(owner for kind in DEFINING for owner in _owners(kind))
