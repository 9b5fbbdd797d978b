"""Constants that tune numerics stand in one module of a folder, each with its unit and effect."""

import re
from pathlib import Path

import pytest
from constants import constants

ROOMS = [str(path.parent) for path in sorted(Path("linkages").rglob("numerics.py"))]
ROOMS += [str(path.parent) for path in sorted(Path("optim").rglob("numerics.py"))]


@pytest.mark.parametrize("room", ROOMS)
def test_each_number_has_a_unit_and_an_effect_and_is_read(room):
    for one in constants(f"{room}/numerics.py"):
        assert re.match(r"\[[^\]]+\] \w", one.comment), (
            f"{one.file}:{one.line}: write the unit in brackets, and the effect"
        )
        assert one.readers, f"{one.file}:{one.line}: {one.name} is not read"
        assert not one.compiled, f"{one.file}:{one.line}: {one.name} is compiled: it belongs to its kernel"


@pytest.mark.parametrize("room", ROOMS)
def test_a_folder_with_such_a_module_has_no_other_private_numbers(room):
    """Nor have the folders in it; but those that name a format, or that kernels read."""
    for path in sorted(Path(room).rglob("*.py")):
        if path.name != "numerics.py":
            left = [one.name for one in constants(str(path)) if not one.compiled and not one.at_import]
            assert not left, f"{path}: move {left} to {room}/numerics.py"


def test_a_constant_changes_by_a_factor_and_a_small_count_by_one():
    (pace,) = [one for one in constants("linkages/elements/flexible/numerics.py") if one.name == "LINK_LOADS_POINTS"]
    assert (pace.times(3.0), pace.times(1.0 / 3.0)) == (9, 1)
