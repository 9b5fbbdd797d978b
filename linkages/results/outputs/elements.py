"""Outputs of the elements of `linkages.elements`: which numbers of a run their declared outputs are."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import lru_cache

import numpy as np

from linkages.elements.machine import KINDS, all_elements_of, elements_of
from linkages.elements.outputs import Quantities, Source
from linkages.mechanics.planar.closure_rows import term_rate
from linkages.mechanics.planar.contacts import COUPLE, PENETRATION
from linkages.mechanics.planar.loads import POWER
from linkages.results.outputs.bodies import along_link, at_frame, at_link, of_frame
from linkages.results.outputs.contacts import at_contact, contact_quantity
from linkages.results.outputs.joints import at_drive, at_wheel, effort, effort_on_wheel, load_size, load_value
from linkages.results.outputs.quantity import Declaration, OutputPlace, Owner, Snapshot, formula, quantities, quantity
from linkages.system import System


@formula("forces")
def _reaction(output: np.record, seen: Snapshot) -> float:
    k = len(seen.model.rows) + output.at
    reaction = seen.state.reaction[k]
    if output.column == 0:
        return output.constant * reaction
    return reaction * term_rate(seen.model.rows[k].term, seen.state.pose, seen.state.vel)


@formula()
def _between(output: np.record, seen: Snapshot) -> float:
    k, end = output.at, seen.model.ends[output.at]
    effort = seen.contacts[k, COUPLE] + seen.contacts[k + 1, COUPLE]
    apart = seen.contacts[k, PENETRATION] - seen.contacts[k + 1, PENETRATION]
    power = effort * term_rate(end.row.term, seen.state.pose, seen.state.vel)
    return (output.constant * effort, power, 0.5 * apart / end.lever)[output.column]


def _told(outputs: Quantities) -> dict[str, Declaration]:
    power = quantity("power that the load delivers to the linkage [W]", load_value, POWER)
    sizes = {name: quantity(text, load_size) for name, text in outputs.size.items()}
    return quantities(load_value, **outputs.texts) | sizes | {"power": power}


def _at_row(system: System, name: str) -> OutputPlace:
    loads = [load for _, load in system.named_loads]
    if name in loads:
        return OutputPlace(loads.index(name))
    names = [name for _, name, _ in elements_of(system.parts)]
    return OutputPlace(len(system.loads[0]) + names.index(name))


def _sign(system: System, name: str) -> float:
    """Return the change of the second coordinate over the change of the coupling's term."""
    one = system.tree.coupled.get(name) or system.tree.loose[name]
    return system.tree.seen_coordinate(one.joints[1], one.carrier)[1]


def _at_reaction(system: System, name: str) -> OutputPlace:
    tree = system.tree  # a loose coupling has a row of the ideal linkage
    names, after = (tree.coupled, 0) if name in tree.coupled else (tree.loose, len(tree.loop_rows))
    return OutputPlace([*names].index(name) - len(names) - after, constant=_sign(system, name))


def _at_pair(system: System, name: str) -> OutputPlace:
    return OutputPlace([owner for owner, _ in system.contacts].index(name), constant=_sign(system, name))


_Made = Callable[[Quantities], dict[str, Declaration]]
#: Of each source: how its quantities are made, and the numbers of an element in their records.
_SOURCES: Mapping[Source, tuple[_Made, Callable[[System, str], OutputPlace]]] = {
    Source.TOLD: (_told, _at_row),
    Source.REACTION: (lambda outputs: quantities(_reaction, **outputs.texts), _at_reaction),
    Source.BETWEEN: (lambda outputs: quantities(_between, **outputs.texts), _at_pair),
    Source.EFFORT: (lambda outputs: quantities(effort, **outputs.texts), at_drive),
    Source.EFFORT_OF_WHEEL: (lambda outputs: quantities(effort_on_wheel, **outputs.texts), at_wheel),
    Source.ALONG: (along_link, at_link),
    Source.FRAME: (of_frame, at_frame),
    Source.CONTACT: (
        lambda outputs: {
            name: contact_quantity(outputs.columns.get(name, name), text) for name, text in outputs.texts.items()
        },
        at_contact,
    ),
}


def _owner(outputs: Quantities) -> Owner:
    """Make the owner of outputs of elements: the elements, or their contacts, that have these."""

    @lru_cache(maxsize=8)  # each output's name is looked up among all owners
    def names(system: System) -> Iterable[str]:
        parts, slides = all_elements_of(system.parts), system.slides
        found = [(kind, name, keys) for kind, name, keys in parts if outputs in kind.outputs_of(keys, slides)]
        if outputs.source is Source.CONTACT:
            return [f"{name}{end}" for kind, name, keys in found for end in kind.contacts(keys)]
        if outputs.source is Source.FRAME:
            links = {name for _, name, _ in found}
            return [frame.name for frame in system.frames if frame.link in links]
        return [name for _, name, _ in found]

    made, element = _SOURCES[outputs.source]
    return Owner(outputs.label, names, element, made(outputs), real=outputs.real)


def _owners(*sources: Source) -> tuple[Owner, ...]:
    """Make the owners of the outputs of some sources; kinds share some."""
    every = {id(outputs): outputs for kind in KINDS for outputs in kind.outputs}.values()
    return tuple(_owner(outputs) for source in sources for outputs in every if outputs.source is source)


#: Loose couplings; drives; elements with forces and couplings; contacts of elements; deformable links.
BETWEEN, EFFORTS = _owners(Source.BETWEEN), _owners(Source.EFFORT, Source.EFFORT_OF_WHEEL)
FORCES, CONTACTS = _owners(Source.TOLD, Source.REACTION), _owners(Source.CONTACT)
LINKS = _owners(Source.FRAME, Source.ALONG)
