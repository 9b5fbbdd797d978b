"""Records of the force laws from the joint models of an experiment."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.arrays import Array, Indices, Records
from linkages.files.raw_model import Bearing
from linkages.laws import CONTACTS, FILMS, FRICTIONS, PARAMETERS
from linkages.laws.contact.contact_forces import CLIP
from linkages.laws.contact.material import (
    contact_modulus,
    cylinder_stiffness,
    hertz_stiffness,
    line_shape,
    line_stiffness,
)
from linkages.laws.film.closed_form import THINNEST
from linkages.laws.film.film_history import LARGEST, history_table
from linkages.laws.film.film_map import MapCase
from linkages.laws.film.films import MAPPED
from linkages.laws.film.map_cache import load_map
from linkages.laws.film.map_table import table_limit
from linkages.laws.mixed import asperity_pressure
from linkages.laws.parameters import MODELS, SHEAR, set_parameters
from linkages.laws.viscosity import iso_vg_viscosity
from linkages.laws.wear.force import worn_address
from linkages.model.experiment_tables import Contact, Friction, JointModel, Mixed


class ContactLaws(NamedTuple):
    """Numbers of the laws of nc contacts; see the properties of `linkages.system.System` with these names."""

    records: Records
    film_tables: Array
    tables: Array
    film_limits: Array
    touching: NDArray[np.bool_]
    bristles: Indices


def contact_laws(bearings: tuple[Bearing | None, ...], models: tuple[JointModel, ...]) -> ContactLaws:
    """Collect the laws of contacts in bearings (or other ones), with these models."""
    records, maps = law_parameters(bearings, models), film_tables(bearings, models)
    return ContactLaws(
        records,
        maps,
        np.hstack([maps, profiles(models)]),
        film_limits(records, maps, models),
        np.array([model.can_touch for model in models], dtype=bool),
        np.flatnonzero(records["bristles"]),
    )


def law_parameters(bearings: Sequence[Bearing | None], models: Sequence[JointModel]) -> Records:
    """Make one record of `PARAMETERS` for each contact."""
    records: Records = np.zeros(len(models), PARAMETERS)
    for record, bearing, model in zip(records, bearings, models, strict=True):
        _fill(record, model, bearing)
    return records


def film_tables(bearings: Sequence[Bearing | None], models: Sequence[JointModel]) -> Array:
    """Load the maps of the finite films, or lay out their cells if they have a history; one line for each contact.

    Lines of contacts that need none are empty.
    """
    tables: dict[int, Array] = {}
    for k, (bearing, joint) in enumerate(zip(bearings, models, strict=True)):
        if bearing is None or not joint.has_film or joint.is_tilted or FILMS[joint.film].force is not None:
            continue
        slenderness, history = 0.5 * bearing.length / bearing.radius, joint.history
        if history is None:
            tables[k] = load_map(MapCase(slenderness, joint.cavitation, joint.feed))
        else:
            assert history.step is not None  # `linkages.system.unassembled.Unassembled.models`
            around, along = history.cells
            tables[k] = history_table(slenderness, joint.feed, (around, along), history.step, history.content)
    result = np.zeros((len(models), max(map(len, tables.values()), default=0)))
    for k, table in tables.items():
        result[k, : len(table)] = table
    return result


def profiles(models: Sequence[JointModel]) -> Array:
    """Make one line per contact, with the control depths of worn joints (bearing, journal) at its end."""
    rows = [np.concatenate(model.wear.depths) if model.is_worn and model.wear else np.zeros(0) for model in models]
    result = np.zeros((len(models), max(map(len, rows), default=0)))
    for line, row in zip(result, rows, strict=True):
        line[len(line) - len(row) :] = row
    return result


def film_limits(laws: Records, tables: Array, models: Sequence[JointModel]) -> Array:
    """Return the largest eccentricity ratio that the film of each contact covers, (nc,)."""
    limits = np.full(len(laws), 1.0 - THINNEST)
    limits -= laws["tilt"]  # an end could touch
    mapped = (laws["film"] == MAPPED) & (laws["tilt"] == 0.0)
    for k, model in enumerate(models):
        if mapped[k] and tables.shape[1]:
            limits[k] = min(limits[k], LARGEST if model.has_history else table_limit(tables[k]))
    return limits


def _fill(record: Any, joint: JointModel, bearing: Bearing | None) -> None:
    record["clearance"] = joint.clearance
    if bearing is not None:
        record["radius"], record["length"] = bearing.radius, bearing.length
    record["model"] = MODELS[joint.model]
    record["shear"] = SHEAR[joint.shear_film if joint.shear_torque else "none"]
    if joint.small_eccentricity is not None:
        record["small_eps"] = joint.small_eccentricity.ratio
        record["small_power"] = joint.small_eccentricity.power
    if joint.wear is not None:
        record["worn"] = worn_address()
        record["bearing_nodes"], record["journal_nodes"] = map(len, joint.wear.depths)
    if joint.has_film:
        film = FILMS[joint.film]
        record["film"] = film.address if record["shear"] == SHEAR["half"] else film.bare_address
        record["film_reads_record"] = bool(film.parameters)
        if joint.feed:
            record["groove_angle"] = joint.feed[0].angle
            record["supply_pressure"] = max(groove.pressure for groove in joint.feed)
        if joint.is_tilted and bearing is not None:
            record["tilt"] = 0.5 * bearing.length * math.hypot(*joint.tilt) / (joint.clearance or np.inf)
            record["tilt_angle"] = math.atan2(joint.tilt[1], joint.tilt[0])
        set_parameters(record, "film", film.parameters, joint.parameters)
        oil = joint.oil
        record["viscosity"] = (
            joint.viscosity if oil is None else iso_vg_viscosity(oil.grade, oil.temperature, oil.density)
        )
    if joint.contact is not None and joint.can_touch:
        _fill_contact(record, joint.contact, bearing, joint.clearance or 0.0)
    if joint.friction is not None and joint.friction.acts and joint.can_touch:
        _fill_friction(record, joint.friction)
    if joint.mixed is not None and joint.contact is not None and joint.model == "mixed":
        record["film_limit"] = joint.mixed.film_limit
        if joint.mixed.law == "blend":
            record["transition"] = joint.mixed.transition
        else:
            _fill_asperities(record, joint.mixed, joint.contact)


def _fill_friction(record: Any, friction: Friction) -> None:
    law, values = FRICTIONS[friction.law], friction.parameters
    record["friction"], record["bristles"] = law.address, law.rate_address
    record["mu_d"] = friction.coefficient or 0.0
    record["mu_s"] = friction.static or friction.coefficient or 0.0
    if law.bristles:
        record["bristle_scale"] = 1.0 / values["bristle_stiffness"]
    set_parameters(record, "friction", law.parameters, values)


def _fill_contact(record: Any, contact: Contact, bearing: Bearing | None, clearance: float) -> None:
    law = CONTACTS[contact.law]
    record["contact"], record["damping_limit"] = law.address, CLIP if contact.clip else np.inf
    set_parameters(record, "contact", law.parameters, contact.parameters)
    if contact.restitution is not None:
        record["restitution"], record["hysteresis"] = contact.restitution, law.factor(contact.restitution)
    if contact.stiffness is not None:
        record["stiffness"] = contact.stiffness
    if bearing is None:  # a corner at a wall: the check ensures that a required stiffness is given
        return
    journal = bearing.radius - clearance
    record["shape_ratio"] = line_shape(bearing.radius, journal, bearing.length)
    if contact.stiffness is not None or contact.youngs_modulus is None:
        return
    if law.conformal:
        record["stiffness"] = line_stiffness(bearing.length, _modulus(contact))
    elif law.linear:
        record["stiffness"] = cylinder_stiffness(bearing.length, _modulus(contact))
    else:
        record["stiffness"] = hertz_stiffness(bearing.radius, journal, _modulus(contact))


def _fill_asperities(record: Any, mixed: Mixed, contact: Contact) -> None:
    sigma, density, radius = mixed.roughness or 0.0, mixed.density or 0.0, mixed.tip_radius or 0.0
    record["roughness"] = np.hypot(sigma, sigma)
    record["asperity_pressure"] = asperity_pressure(sigma, sigma, density, radius, _modulus(contact))


def _modulus(contact: Contact) -> float:
    young, poisson = contact.youngs_modulus or 0.0, contact.poissons_ratio
    return contact_modulus(young, poisson, young, poisson)
