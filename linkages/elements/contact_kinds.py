"""The contacts of a machine in arrays, and one compiled loop for each kind over each duty.

A machine compiles the loops of the kinds that it has: they are lazy kernels, which contain the kernels of their kind.
"""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from linkages.base.arrays import Array, Records
from linkages.base.generated import lazy, made
from linkages.base.kernel import inlined_kernel
from linkages.elements import film_with_history
from linkages.elements.film_with_history import FILM_WITH_HISTORY
from linkages.elements.journal import JOURNAL
from linkages.elements.limit import LIMIT
from linkages.elements.wall import WALL
from linkages.elements.worn import WORN
from linkages.laws.states import REMEMBERED
from linkages.mechanics.planar.contact_partials import Derivatives, derivatives_of
from linkages.mechanics.planar.contacts import ContactKind, acting, knowing, powering
from linkages.mechanics.planar.record_types import ENDS, MARKER

#: All kinds, in the order in which their forces are added.
CONTACT_KINDS: tuple[ContactKind, ...] = (JOURNAL, WORN, FILM_WITH_HISTORY, WALL, LIMIT)
#: Those that have exact derivatives.
EXACT_KINDS = tuple(kind for kind in CONTACT_KINDS if kind.action_of_cells is None)

_named_tuple: Any = namedtuple  # whose fields no type checker knows
#: The records of each kind by its name, and the place of each contact in the records of its kind, (nc,).
Contacts: Any = _named_tuple("Contacts", [*(kind.name for kind in CONTACT_KINDS), "places"])

Marker = tuple[int, float, float]  #: body, and place in its frame [m]


class ContactPart(NamedTuple):
    """A contact before it is packed."""

    kind: ContactKind
    bearing: Marker  # on the outer body
    journal: Marker  # on the inner body
    numbers: Mapping[str, Any] = {}  # of its record by field, without its index


def pack_contacts(parts: Sequence[ContactPart]) -> tuple[Records, Any]:
    """Pack contacts: the markers of their ends, (nc,), and their `Contacts`."""
    ends: Records = np.array([(part.bearing, part.journal) for part in parts], ENDS)
    found: dict[str, Records] = {}
    places = np.zeros(len(parts), np.int64)
    for kind in CONTACT_KINDS:
        own = [k for k, part in enumerate(parts) if part.kind is kind]
        places[own] = range(len(own))
        found[kind.name] = records = np.zeros(len(own), kind.record)
        for record, k in zip(records, own, strict=True):
            record["at"] = k
            for name, number in parts[k].numbers.items():
                record[name] = number
    return ends, Contacts(**found, places=places)


def modelled(part: ContactPart, model: Any) -> ContactPart:
    """Return a contact of a joint with this model: a round journal becomes one of the model's kind."""
    if part.kind is not JOURNAL:
        return part
    kind = WORN if model.is_worn else FILM_WITH_HISTORY if model.has_history else JOURNAL
    return part._replace(kind=kind, numbers={"oriented": bool(model.feed) or model.is_tilted or model.is_worn})


NO_CONTACTS = pack_contacts(())[1]


def contact_record(contacts: Any, k: int) -> tuple[ContactKind, Any]:
    """Return kind and record of contact k."""
    for kind in CONTACT_KINDS:
        records = getattr(contacts, kind.name)
        if k in records["at"]:
            return kind, records[contacts.places[k]]
    raise IndexError(k)


def contact_markers(contacts: Any, ends: Records, k: int) -> list[Any]:
    """List the markers at which contact k acts."""
    _, record = contact_record(contacts, k)
    return [ends[k]["bearing"], ends[k]["journal"], *markers_in(record)]


def markers_in(record: Any) -> Iterator[Any]:
    """Yield the markers in a record, and in the records within it."""
    for name, (kind, *_) in record.dtype.fields.items():
        if kind == MARKER:
            yield record[name]
        elif kind.fields:
            yield from markers_in(record[name])


# -- kernels over the kinds --------------------------------------------------------------------------------------------

_Make = Callable[[ContactKind], Callable[..., Any]]


def over_all(module: str, name: str, parameters: str, call: str, make: _Make, exact: bool = False) -> Any:
    """Make the kernel ``name(parameters)`` over all contacts: a loop for each kind.

    Parameters
    ----------
    module : str
        Module of the lazy kernels of the kinds.
    parameters : str
        Best references to named tuples alone: to hand over an array costs as much as a law of contact.
    call : str
        ``contacts, arguments``: the loop ``make(kind)`` has the records of its kind in these contacts, then these
        arguments.
    exact : bool
        Whether it serves kinds with exact derivatives alone.
    """
    contacts, _, arguments = call.partition(", ")
    lines, known = [f"def {name}({parameters}) -> None:"], dict[str, Any]()
    for kind in EXACT_KINDS if exact else CONTACT_KINDS:
        own, records, loop = f"{name}_{kind.name}", f"{contacts}.{kind.name}", {"loop": inlined_kernel(make(kind))}
        calling = [f"def {own}({parameters}) -> None:", f"    loop({records}, {arguments})"]
        known[own] = lazy(module, own, made(module, own, calling, loop))
        lines += [f"    if len({records}):", f"        {own}({parameters})"]
    return inlined_kernel(made(module, name, lines, known))


def over_one(module: str, name: str, parameters: str, make: _Make, result: str = "None", exact: bool = False) -> Any:
    """Make the kernel ``name(contacts, k, parameters)`` of contact k, for the kind that it has.

    Parameters
    ----------
    module : str
        Module of the lazy kernels, which are ``make(kind)`` with the parameters ``(record, parameters)``.
    result : str
        Annotation of the result.
    exact : bool
        Whether it serves kinds with exact derivatives alone.
    """
    kinds = EXACT_KINDS if exact else CONTACT_KINDS
    kernels = {kind.name: lazy(module, f"{name}_{kind.name}", make(kind)) for kind in kinds}
    lines = [f"def {name}(contacts, k, {parameters}) -> {result}:", "    i = contacts.places[k]"]
    for kind in kernels:
        lines += [f"    if i < len(contacts.{kind}) and contacts.{kind}[i].at == k:"]
        lines += [f"        return {kind}(contacts.{kind}[i], {parameters})"]
    lines += ["    return 0.0"] if result == "float" else []
    return inlined_kernel(made(module, name, lines, kernels))


def each(make: _Make) -> _Make:
    """Make the loops over the contacts of a kind, of the kernels of one contact."""

    def loop_of(kind: ContactKind) -> Callable[..., None]:
        one = inlined_kernel(make(kind))

        def loop(records: Records, *given: Any) -> None:
            for i in range(len(records)):
                one(records[i], *given)

        return loop

    return loop_of


#: Kernels to differentiate the laws of each kind, by its name.
DERIVATIVES: dict[str, Derivatives] = {kind.name: derivatives_of(__name__, kind) for kind in CONTACT_KINDS}


class ContactWork(NamedTuple):
    """The arrays of `add_contacts`, which are fields of a run's work, too."""

    dynamics: Any  # workspace
    memory: Array  # of `linkages.mechanics.planar.contact_memory`, (nc, ...)
    contacts: Array  # `linkages.mechanics.planar.contacts.CLEARANCE_OUTPUTS`, content, flow, rates, (nc, WIDTH)


#: ``add_contacts(model, work)`` adds the force pairs of all contacts to the bodies' wrenches, and fills the outputs.
add_contacts = over_all(
    __name__, "add_contacts", "model, work",
    "model.contacts, model, work.dynamics, work.memory, work.contacts", acting,
)  # fmt: skip
#: ``add_known_contacts(model, w, known)`` adds the force pairs of all contacts, of their lines of outputs ``known``
#: (nc, WIDTH).
add_known_contacts = over_all(
    __name__, "add_known_contacts", "model, w, known", "model.contacts, model.ends, known, w.pose, w.wrench",
    each(knowing),
)  # fmt: skip
#: ``add_known_contact(contacts, k, ends, known, pose, wrench)`` adds the force pair of contact k, of its line of
#: outputs ``known`` (nc, WIDTH).
add_known_contact = over_one(__name__, "add_known_contact", "ends, known, pose, wrench", knowing)
#: ``contact_power(contacts, k, ends, known, pose, vel)``, which the force pair of contact k delivers [W].
contact_power = over_one(__name__, "contact_power", "ends, known, pose, vel", powering, "float")
#: ``fill_partials(model, work)`` fills the partial derivatives of all contacts, ``work.scratch.partials``.
fill_partials = over_all(
    __name__, "fill_partials", "model, work",
    "model.contacts, model, work.dynamics, work.memory, work.scratch.bounds, work.scratch.partials",
    lambda kind: DERIVATIVES[kind.name].partials,
)  # fmt: skip


# -- cells -------------------------------------------------------------------------------------------------------------

_start_cells = lazy(__name__, "start_film_cells", film_with_history.start)
_advance_cells = lazy(__name__, "advance_film_cells", film_with_history.advance)


def make_memory(contacts: Any, tables: Array) -> Array:
    """Make the memory of contacts, (nc, `REMEMBERED`), or wider if a film remembers; all zero."""
    return np.zeros((len(contacts.places), REMEMBERED + film_with_history.cells_of(contacts.film_with_history, tables)))


@inlined_kernel
def has_cells(contacts: Any, k: int) -> bool:
    """Whether contact k has cells."""
    i, films = contacts.places[k], contacts.film_with_history
    return bool(i < len(films) and films[i].at == k)


@inlined_kernel
def start_cells(contacts: Any, model: Any, w: Any, memory: Array, t: float, fresh: bool) -> None:
    """Set time and place of the cells of contacts, and with ``fresh`` their content at the start of a run."""
    _start_cells(contacts.film_with_history, model, w, memory, t, fresh)


@inlined_kernel
def advance_cells(contacts: Any, model: Any, w: Any, memory: Array, t: float) -> None:
    """Move the content of the cells of contacts to time t and this state, and choose the next steps of their films."""
    _advance_cells(contacts.film_with_history, model, w, memory, t)


@inlined_kernel
def longest_step(contacts: Any, memory: Array) -> float:
    """Return the longest step of a run that the cells of contacts allow [s]; infinite without cells."""
    return film_with_history.longest_step(contacts.film_with_history, memory)
