"""Viscosity against published examples and data sheets."""

import math

import pytest

from linkages.laws.viscosity import ISO_VG, density, iso_vg_viscosity, walther, walther_constants


def test_published_walther_examples():
    """Worked examples of ASTM D341 for a SAE 140 gear oil and an ISO VG 68 oil (olezol.com)."""
    assert walther(60.0, *walther_constants(404.0, 40.0, 28.0, 100.0)) == pytest.approx(132.126, rel=5e-4)
    assert walther(100.0, *walther_constants(68.0, 40.0, 14.85, 80.0)) == pytest.approx(8.8, abs=0.05)


@pytest.mark.parametrize(
    ("grade", "at_100"),
    # industrial reference table of ISO VG grades (lubesolut.com), typical viscosity at 100 deg C
    [(10, 2.5), (15, 3.5), (22, 4.5), (32, 5.5), (46, 6.5), (68, 8.5), (100, 11.4), (150, 14.5), (220, 19.0),
     (320, 24.5), (460, 32.0), (680, 42.0)],
)  # fmt: skip
def test_iso_grades_against_typical_oils(grade, at_100):
    """Typical oils have a viscosity index of 90 to 105, which is 8 % at 100 deg C; the table is rounded."""
    nu = iso_vg_viscosity(grade, 100.0) / density(100.0) * 1e6
    assert nu == pytest.approx(at_100, rel=0.08)
    assert nu == pytest.approx(ISO_VG[grade], rel=1e-12)
    assert iso_vg_viscosity(grade, 40.0) / density(40.0) * 1e6 == pytest.approx(grade, rel=1e-12)


def test_iso_vg_460_is_the_oil_of_chen_2025():
    """Chen et al. (2025), Table 5: 0.4 Pa s at 40 deg C; ISO VG 460 of 870 kg/m3 has 0.393."""
    assert iso_vg_viscosity(460, 40.0) == pytest.approx(0.4, rel=0.03)
    assert density(40.0) == pytest.approx(870.0 - 0.65 * 25.0)


def test_viscosity_falls_with_temperature():
    for grade in ISO_VG:
        values = [iso_vg_viscosity(grade, t) for t in range(0, 101, 5)]
        assert values == sorted(values, reverse=True)
        assert math.isfinite(values[0])


def test_bad_input_is_refused():
    with pytest.raises(ValueError, match="ISO VG 33"):
        iso_vg_viscosity(33, 40.0)
