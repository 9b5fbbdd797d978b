"""Fixtures that leave the registries of laws as they were."""

from collections.abc import Iterator

import pytest

from linkages.laws import CONTACTS, CONTROLLERS, FILMS, FRICTIONS, user_laws


def _keep_registries() -> Iterator[None]:
    """Leave the registries of laws as they were."""
    places = (CONTACTS, FILMS, FRICTIONS, CONTROLLERS, user_laws._registered)
    before = [dict(place) for place in places]
    yield
    for place, entries in zip(places, before, strict=True):
        place.clear()
        place.update(entries)


own_registries = pytest.fixture(_keep_registries)
registries_of_module = pytest.fixture(scope="module")(_keep_registries)
