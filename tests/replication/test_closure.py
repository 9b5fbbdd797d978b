"""Hard constraints of the length studies say where a linkage closes over its whole turn: against the turn itself, step by step."""

import numpy as np
import pytest

from optim import find_study, load_study

TURN = np.linspace(0.0, 2.0 * np.pi, 7201)


def random_designs(study, count=40):
    """Values of everything that formulas name, of designs between the bounds."""
    rng = np.random.default_rng(1)
    designs = study.lower + rng.random((count, study.lower.size)) * (study.upper - study.lower)
    return [study.named(design) for design in designs]


def cosine(one, two, distance):
    """Cosine of the angle between two bars whose other ends are that far apart; beyond 1 where they do not reach."""
    return (one**2 + two**2 - distance**2) / (2.0 * one * two)


def six_bar(d):
    """Cosines between coupler and rocker, and between link and output, over a turn of the crank (plane as complex numbers)."""
    gap = d["L_1"] * np.exp(1j * TURN) - d["g"]  # from the rocker's pivot to the crank pin
    first = cosine(d["L_2"], d["L_3"], abs(gap))
    if abs(first).max() >= 1.0:
        return None
    rocker = np.angle(gap) - np.arccos(cosine(d["L_3"], abs(gap), d["L_2"]))  # as drawn, above the ground
    arm = d["x_4"] / np.cos(d["delta"]) * np.exp(1j * (rocker - d["delta"]))
    return first, cosine(d["L_5"], d["L_6"], abs(arm - d["g"]))


def seven_bar(d):
    """Cosine between links 2 and 3, and height of their pin, over a turn of both cranks."""
    a, b = d["L_1"] * np.exp(1j * TURN), 1j * d["L_5"] + d["L_4"] * np.exp(1j * (TURN + d["lag"]))
    first = cosine(d["L_2"], d["L_3"], abs(b - a))
    if abs(first).max() >= 1.0:
        return None
    pin = a + d["L_2"] * np.exp(1j * (np.angle(b - a) - np.arccos(cosine(d["L_2"], abs(b - a), d["L_3"]))))
    return first, pin.imag


@pytest.mark.parametrize(
    ("name", "turned", "pairs"),
    [
        ("sixbar_jitter", six_bar, [("crank_farthest", "crank_nearest"), ("output_farthest", "output_nearest")]),
        ("sevenbar_jitter", seven_bar, [("farthest", "nearest")]),
    ],
)
def test_formulas_are_the_extremes_over_the_turn(name, turned, pairs):
    study, seen = load_study(find_study(name)), 0
    for design in random_designs(study):
        found = turned(design)
        limits = {key: study.formulas[key](design) for pair in pairs for key in pair}
        if found is None:  # the first loop does not close
            assert limits[pairs[0][0]] < -0.999 or limits[pairs[0][1]] > 0.999
            continue
        seen += 1
        for (farthest, nearest), values in zip(pairs, found, strict=False):
            assert limits[farthest] == pytest.approx(values.min(), abs=1e-5)
            assert limits[nearest] == pytest.approx(values.max(), abs=1e-5)
    assert seen > 20


def test_the_slider_is_within_reach_wherever_the_cranks_are():
    study = load_study(find_study("sevenbar_jitter"))
    for design in random_designs(study):
        found = seven_bar(design)
        if found is not None:
            assert abs(found[1]).max() / design["L_6"] <= study.formulas["slider"](design)
