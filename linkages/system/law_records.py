"""Records of the force laws from the joint models of an experiment."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from linkages.base.arrays import Array, Indices, Records
from linkages.input.files.raw_model import BearingSize
from linkages.input.model.experiment_tables import JointModel
from linkages.laws import CONTACTS, FILMS, FRICTIONS, PARAMETERS
from linkages.laws.film.closed_form import THINNEST
from linkages.laws.film.film_history import LARGEST, history_table
from linkages.laws.film.film_map import MapCase, load_map
from linkages.laws.film.map_table import table_limit
from linkages.laws.mixed import fill_mixed
from linkages.laws.parameters import MODELS, SHEAR, slots
from linkages.laws.states import FIRST_STATE, NEW, SCALES, Remembered, places
from linkages.laws.viscosity import iso_vg_viscosity
from linkages.laws.wear.force import worn_address


class LawStates(NamedTuple):
    """The ns continuous states of the laws of contacts, in the order of the state vector."""

    places: Indices  # contact, place among its states, (ns, 2)
    names: tuple[str, ...]
    starts: Array  # values at the start of a run, (ns,)
    scales: Array  # magnitudes

    def remembered(self, contact: int) -> Remembered:
        """Return what a contact remembers at the start of a run, before it begins."""
        values, own = np.array(NEW), self.places[:, 0] == contact
        values[FIRST_STATE + self.places[own, 1]] = self.starts[own]
        return cast(Remembered, tuple(values.tolist()))


class ContactLaws(NamedTuple):
    """Numbers of the laws of nc contacts; see the properties of `linkages.system.System` with these names."""

    records: Records
    tables: Array
    film_limits: Array
    touching: NDArray[np.bool_]
    states: LawStates


def contact_laws(
    bearings: tuple[BearingSize | None, ...], models: tuple[JointModel, ...], least_force: float = 0.0
) -> ContactLaws:
    """Collect the laws of contacts in bearings (or other ones), with these models.

    `least_force` of a film with history: errors of smaller forces do not count [N].
    """
    records: Records = np.zeros(len(models), PARAMETERS)
    films, profiles, limits = list[Array](), list[Array](), np.zeros(len(models))
    for k, (bearing, joint) in enumerate(zip(bearings, models, strict=True)):
        _fill(records[k], joint, bearing)
        films.append(_film_table(joint, bearing, least_force))
        profiles.append(np.concatenate(joint.wear.depths) if joint.is_worn and joint.wear else np.zeros(0))
        limits[k] = _film_limit(joint, records["tilt"][k], films[k])
    return ContactLaws(
        records,
        _tables(films, profiles),
        limits,
        np.array([model.can_touch for model in models], dtype=bool),
        _law_states(models, records),
    )


def _law_states(models: Sequence[JointModel], records: Records) -> LawStates:
    """Collect the states of the laws of contacts with these models."""
    owned = [
        (k, place, state)
        for k, joint in enumerate(models)
        for kind, law in _acting(joint).items()
        for place, state in zip(places(kind, len(law.states)), law.states, strict=True)
    ]
    return LawStates(
        np.array([(k, place) for k, place, _ in owned], dtype=np.int64).reshape(-1, 2),
        tuple(state.name for _, _, state in owned),
        np.array([state.start for _, _, state in owned]),
        np.array([records[SCALES[place]][k] for k, place, _ in owned]),
    )


def _acting(joint: JointModel) -> dict[str, Any]:
    """Return the contact law and the friction law that act in a joint, by kind."""
    laws: dict[str, Any] = {}
    if joint.can_touch and joint.contact is not None:
        laws["contact"] = CONTACTS[joint.contact.law]
    if joint.can_touch and joint.friction is not None and joint.friction.acts:
        laws["friction"] = FRICTIONS[joint.friction.law]
    return laws


def _tables(films: Sequence[Array], profiles: Sequence[Array]) -> Array:
    """Make a table with one line for each contact: its film's numbers at the beginning, its profiles at the end."""
    tables = np.zeros((len(films), sum(max(map(len, rows), default=0) for rows in (films, profiles))))
    for line, film, profile in zip(tables, films, profiles, strict=True):
        line[: len(film)] = film
        line[len(line) - len(profile) :] = profile
    return tables


def _film_table(joint: JointModel, bearing: BearingSize | None, least_force: float) -> Array:
    """Load the map of a finite film, or lay out its cells if it has a history; empty for a contact without both."""
    if bearing is None or not joint.has_film or joint.is_tilted or FILMS[joint.film].force is not None:
        return np.zeros(0)
    slenderness, history = 0.5 * bearing.length / bearing.radius, joint.history
    if history is None:
        return load_map(MapCase(slenderness, joint.cavitation, joint.feed))
    assert history.step is not None  # `linkages.system.contacts.contact_models`
    around, along = history.cells
    accuracy = history.accuracy or 0.0  # of a constant film step
    return history_table(slenderness, joint.feed, (around, along), history.step, history.content, accuracy, least_force)


def values_of(joint: JointModel, bearing: BearingSize | None) -> dict[str, str]:
    """Return the keys of a joint that its record has as they are, and that nothing else follows, by its fields."""
    touches, found = joint.can_touch and joint.contact is not None, dict[str, str]()
    if not (joint.is_tilted or joint.is_worn or (touches and bearing is not None)):
        found["clearance"] = "clearance"
    if joint.has_film:
        found |= slots("film", FILMS[joint.film].parameters)
        found |= {"viscosity": "viscosity"} if joint.oil is None else {}
        if joint.mixed is not None and touches:
            found["film_limit"] = "mixed.film_limit"
            found |= {"transition": "mixed.transition"} if joint.mixed.law == "blend" else {}
    for kind, law in _acting(joint).items():
        if not any(callable(state.scale) for state in law.states):  # a scale follows other values
            found |= {field: f"{kind}.{key}" for field, key in law.own(dict(getattr(joint, kind))).items()}
    return found


def _film_limit(joint: JointModel, tilt: float, table: Array) -> float:
    """Return the largest eccentricity ratio that the film of a contact covers; where it is tilted, no end touches."""
    limit = 1.0 - THINNEST - tilt
    if len(table):
        limit = min(limit, LARGEST if joint.has_history else table_limit(table))
    return limit


def _fill(record: Any, joint: JointModel, bearing: BearingSize | None) -> None:
    """Write the numbers of a contact into its record of `PARAMETERS`: its geometry, then those of each law."""
    record["clearance"], record["model"] = joint.clearance, MODELS[joint.model]
    if bearing is not None:
        record["radius"], record["length"] = bearing.radius, bearing.length
    if joint.wear is not None:
        record["worn"] = worn_address()
        record["bearing_nodes"], record["journal_nodes"] = map(len, joint.wear.depths)
    if joint.has_film:
        _fill_film(record, joint)
    if joint.can_touch and joint.contact is not None:
        CONTACTS[joint.contact.law].fill(record, dict(joint.contact))
        if joint.mixed is not None and joint.has_film:
            fill_mixed(record, dict(joint.mixed), dict(joint.contact))
    if joint.can_touch and joint.friction is not None and joint.friction.acts:
        FRICTIONS[joint.friction.law].fill(record, dict(joint.friction))


def _fill_film(record: Any, joint: JointModel) -> None:
    record["shear"] = SHEAR[joint.shear_film if joint.shear_torque else "none"]
    FILMS[joint.film].fill(record, joint.parameters)
    oil = joint.oil
    record["viscosity"] = joint.viscosity if oil is None else iso_vg_viscosity(oil.grade, oil.temperature, oil.density)
    if joint.small_eccentricity is not None:
        record["small_eps"], record["small_power"] = joint.small_eccentricity.ratio, joint.small_eccentricity.power
    if joint.feed:
        record["groove_angle"] = joint.feed[0].angle
        record["supply_pressure"] = max(groove.pressure for groove in joint.feed)
    if joint.is_tilted:
        record["tilt"] = 0.5 * record["length"] * math.hypot(*joint.tilt) / record["clearance"]
        record["tilt_angle"] = math.atan2(joint.tilt[1], joint.tilt[0])
