"""Records of joints for the tests of the laws."""

from types import SimpleNamespace

import numpy as np
from numba import config

from linkages.laws import CONTACTS, FILMS, FRICTIONS, PARAMETERS
from linkages.laws.contact.forces import CLIP
from linkages.laws.parameters import SHEAR


def joint(film=None, contact=None, friction="none", shear="full", restitution=0.0, **numbers):
    """Record of a joint with these laws."""
    record = np.zeros((), PARAMETERS)
    record["shear"] = SHEAR[shear]
    if film is not None:
        record["film"] = FILMS[film].address
    if contact is not None:
        law = CONTACTS[contact]
        record["contact"], record["hysteresis"] = law.address, law.factor(restitution)
        record["restitution"], record["exponent"], record["damping_limit"] = restitution, 1.5, CLIP
    record["friction"], record["bristles"] = FRICTIONS[friction].address, FRICTIONS[friction].bristles
    for name, value in numbers.items():
        record[name] = value
    if config.DISABLE_JIT:  # attributes of NumPy's records are slow
        return SimpleNamespace(**{name: record[name].item() for name in PARAMETERS.names})
    return record[()]
