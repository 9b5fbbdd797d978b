"""Public names and types of the packages, as an editor and a type checker see them."""

import importlib
from pathlib import Path

import pytest

PACKAGES = ["linkages", "linkages.show.plots", "linkages.engines.drake", "optim"]


@pytest.mark.parametrize("name", PACKAGES)
def test_public_names_are_listed_and_exist(name):
    package = importlib.import_module(name)
    assert package.__all__
    assert set(dir(package)) >= set(package.__all__)
    for public in package.__all__:
        assert getattr(package, public) is not None


def test_unknown_name_is_an_attribute_error():
    import linkages

    with pytest.raises(AttributeError, match="simulat_"):
        linkages.simulat_  # noqa: B018 - the access raises


@pytest.mark.parametrize("name", ["linkages", "optim"])
def test_type_checkers_read_the_types_of_the_packages(name):
    """By this file; mypy checks in `typed_use.py`, with the packages, that it sees the types of public functions."""
    assert (Path(importlib.import_module(name).__file__).parent / "py.typed").exists()
