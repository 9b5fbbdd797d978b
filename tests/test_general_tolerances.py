"""General tolerances against the table of the standard, in millimetres and in degrees and minutes."""

import math

import pytest

import linkages

#: ISO 2768-1:1989, Table 1: size [mm], then f, m, c, v [mm]; None where the standard has a dash.
LENGTHS = [
    (0.5, 0.05, 0.1, 0.2, None), (3.0, 0.05, 0.1, 0.2, None), (6.0, 0.05, 0.1, 0.3, 0.5), (6.001, 0.1, 0.2, 0.5, 1.0),
    (30.0, 0.1, 0.2, 0.5, 1.0), (120.0, 0.15, 0.3, 0.8, 1.5), (120.001, 0.2, 0.5, 1.2, 2.5), (400.0, 0.2, 0.5, 1.2, 2.5),
    (1000.0, 0.3, 0.8, 2.0, 4.0), (2000.0, 0.5, 1.2, 3.0, 6.0), (4000.0, None, 2.0, 4.0, 8.0),
]  # fmt: skip
#: Table 3: shorter side [mm], then f and m, c, v [degrees and minutes].
ANGLES = [
    (10, (1, 0), (1, 30), (3, 0)), (50, (0, 30), (1, 0), (2, 0)), (120, (0, 20), (0, 30), (1, 0)),
    (400, (0, 10), (0, 15), (0, 30)), (401, (0, 5), (0, 10), (0, 20)),
]  # fmt: skip


@pytest.mark.parametrize("row", LENGTHS)
def test_lengths(row):
    size, *wanted = row
    for name, value in zip("fmcv", wanted, strict=True):
        if value is None:
            with pytest.raises(linkages.InputError, match=f"class {name} has no general tolerance"):
                linkages.general_tolerance(name, 1e-3 * size)
        else:
            assert linkages.general_tolerance(name, 1e-3 * size) == pytest.approx(1e-3 * value, rel=1e-14)


@pytest.mark.parametrize("row", ANGLES)
def test_angles(row):
    side, fine, coarse, very_coarse = row
    for name, (degrees, minutes) in zip("fmcv", (fine, fine, coarse, very_coarse), strict=True):
        wanted = math.radians(degrees + minutes / 60.0)
        assert linkages.general_tolerance(name, 1e-3 * side, angle=True) == pytest.approx(wanted, rel=1e-14)


@pytest.mark.parametrize(("name", "size"), [("m", 4.1), ("m", 4e-4), ("m", -1.0), ("M", 0.1), ("m", math.nan)])
def test_what_the_standard_does_not_define_is_refused(name, size):
    with pytest.raises(linkages.InputError, match="argument: "):
        linkages.general_tolerance(name, size)
