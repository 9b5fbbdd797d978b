"""Records of joints, and all quantities of a film map, for the tests of the laws."""

from types import SimpleNamespace

import numpy as np
from numba import config

from linkages.laws import CONTACTS, FILMS, FRICTIONS, PARAMETERS
from linkages.laws.declared import BUILT_IN_PARAMETERS
from linkages.laws.film.map_table import mapped_film, mapped_flow
from linkages.laws.parameters import SHEAR


def joint(film=None, contact=None, friction="none", shear="full", restitution=0.0, **numbers):
    """Record of a joint with these laws; numbers are fields of the record, or parameters of the laws."""
    record = np.zeros((), PARAMETERS)
    record["shear"] = SHEAR[shear]
    laws = {"friction": FRICTIONS[friction]}
    if film is not None:
        laws["film"] = FILMS[film]
    if contact is not None:
        laws["contact"] = CONTACTS[contact]
    names = {}
    for kind, law in laws.items():
        law.fill(
            record, {p.name: numbers.get(p.name, p.default) for p in law.parameters} | {"restitution": restitution}
        )
        names |= {p.name: f"{kind}_{slot}" for slot, p in enumerate(law.parameters)}
    for name in numbers.keys() & set(PARAMETERS.names):
        record[name] = numbers[name]
    unknown = (
        numbers.keys() - {*PARAMETERS.names, *names} - {p.name for each in BUILT_IN_PARAMETERS.values() for p in each}
    )
    assert not unknown, unknown
    if config.DISABLE_JIT:  # attributes of NumPy's records are slow
        names |= {name: name for name in PARAMETERS.names}
        return SimpleNamespace(**{name: record[place].item() for name, place in names.items()})
    return record[()]


def map_quantities(eps, deps, ew, alpha, table):
    """Force, extent and flow of a film from its map."""
    return *mapped_film(eps, deps, ew, alpha, table, True), mapped_flow(eps, deps, ew, alpha, table)
