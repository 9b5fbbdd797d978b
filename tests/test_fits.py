"""ISO fits against published tables."""

from itertools import pairwise

import numpy as np
import pytest

import linkages
from linkages.cli.main import main
from linkages.show.report.result_folder import load_results

#: hzpt.com, "ISO hole and shaft tolerances" (boretol): range of sizes [mm], then upper limit of H7 and of H8, and
#: (upper, lower) of f7, g6, k6, n6, p6, s6 [um]; its k6 lower limit up to 3 mm is zero.
CHART = {
    (0, 3): (10, 14, -6, -16, -2, -8, 6, 0, 10, 4, 12, 6, 20, 14),
    (3, 6): (12, 18, -10, -22, -4, -12, 9, 1, 16, 8, 20, 12, 27, 19),
    (6, 10): (15, 22, -13, -28, -5, -14, 10, 1, 19, 10, 24, 15, 32, 23),
    (10, 18): (18, 27, -16, -34, -6, -17, 12, 1, 23, 12, 29, 18, 39, 28),
    (18, 30): (21, 33, -20, -41, -7, -20, 15, 2, 28, 15, 35, 22, 48, 35),
    (30, 50): (25, 39, -25, -50, -9, -25, 18, 2, 33, 17, 42, 26, 59, 43),
    (50, 65): (30, 46, -30, -60, -10, -29, 21, 2, 39, 20, 51, 32, 72, 53),
    (80, 100): (35, 54, -36, -71, -12, -34, 25, 3, 45, 23, 59, 37, 93, 71),
}
#: precisemetal.in, "Tolerance tables, round bars": lower limits of h6 to h12 [um] by the upper limit of the range [mm].
BARS = {
    3: (6, 10, 14, 25, 40, 60, 100), 6: (8, 12, 18, 30, 48, 75, 120), 10: (9, 15, 22, 36, 58, 90, 150),
    18: (11, 18, 27, 43, 70, 110, 180), 30: (13, 21, 33, 52, 84, 130, 210), 50: (16, 25, 39, 62, 100, 160, 250),
    80: (19, 30, 46, 74, 120, 190, 300), 120: (22, 35, 54, 87, 140, 220, 350), 180: (25, 40, 63, 100, 160, 250, 400),
    250: (29, 46, 72, 115, 185, 290, 460), 315: (32, 52, 81, 130, 210, 320, 520),
}  # fmt: skip
#: ISO 286-2:1988, Technical Corrigendum 1 (2006): class, size, side and limit [um].
CORRECTED = [("A13", 340, 1, 2090), ("E8", 100, 1, 126), ("R10", 25, 1, -28), ("f9", 300, 0, -186)]


def limits(size, name):
    text = f"{size} {name}/h6" if name[0].isupper() else f"{size} H7/{name}"
    found = linkages.fit(text)
    return np.round(1e6 * np.array(found.hole if name[0].isupper() else found.shaft), 6)


@pytest.mark.parametrize(("above", "upto"), CHART)
def test_the_chart_of_preferred_fits_is_met_at_both_ends_of_each_range(above, upto):
    h7, h8, *shafts = CHART[above, upto]
    for size in (above + 0.5, upto):
        assert [*limits(size, "H7"), *limits(size, "H8")] == [0, h7, 0, h8]
        for name, high, low in zip(("f7", "g6", "k6", "n6", "p6", "s6"), shafts[::2], shafts[1::2], strict=True):
            assert [*limits(size, name)] == [low, high], (name, size)


@pytest.mark.parametrize("upto", BARS)
def test_drawn_bars_have_the_tolerances_of_the_table(upto):
    found = [limits(upto, f"h{grade}")[0] for grade in range(6, 13)]
    np.testing.assert_array_equal(found, np.negative(BARS[upto]))


@pytest.mark.parametrize(("name", "size", "side", "limit"), CORRECTED)
def test_values_of_the_corrigendum(name, size, side, limit):
    assert limits(size, name)[side] == limit


@pytest.mark.parametrize(("hole", "shaft"), [("K7", "k6"), ("N7", "n6"), ("P7", "p6"), ("S7", "s6"), ("R6", "r5")])
@pytest.mark.parametrize("size", [5, 25, 60, 200, 480])
def test_a_fit_keeps_its_play_when_hole_and_shaft_exchange_their_deviations(hole, shaft, size):
    """The rule behind Delta: H7/p6 and P7/h6 have the same clearance."""
    first = linkages.fit(f"{size} H{hole[1:]}/{shaft}").clearance
    second = linkages.fit(f"{size} {hole}/h{shaft[1:]}").clearance
    np.testing.assert_allclose(first, second, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("30 H7", "is no fit"), ("600 H7/f7", "at most 500 mm"), ("0 H7/f7", "more than 0"), ("30 Q7/f7", "known are"),
        ("30 H19/f7", "allowed are 1 to 18"), ("30 K9/h6", "not defined above 3 mm"), ("1 H7/a9", "up to 1 mm"), ("12 H7/cd6", "defined up to 10 mm"),
        ("20 H7/t6", "defined above 24 mm"), ("14 H7/v6", "defined above 14 mm"), ("10 Y7/h6", "defined above 18 mm"),
        ("20 H7/j8", "not defined for this size"), ("20 J9/h6", "give js or JS"),
    ],
)  # fmt: skip
def test_what_the_standard_does_not_define_is_refused(text, said):
    with pytest.raises(linkages.InputError, match=said):
        linkages.fit(text)


#: Formulas behind the tables, ISO 286-1:1988, Table 6: grade whose tolerance is added, and factor of the diameter.
FORMULAS = {"t": (7, 0.63), "u": (7, 1.0), "v": (7, 1.25), "x": (7, 1.6), "y": (7, 2.0), "z": (7, 2.5), "za": (8, 3.15),
            "zb": (9, 4.0), "zc": (10, 5.0)}  # fmt: skip
FIRST = {"t": 24, "v": 14, "y": 18}  # sizes up to this have no such deviation [mm]
EDGES = (1, 3, 6, 10, 14, 18, 24, 30, 40, 50, 65, 80, 100, 120, 140, 160, 180, 200, 225, 250, 280, 315, 355, 400, 450,
         500)  # fmt: skip


@pytest.mark.parametrize("name", FORMULAS)
def test_deviations_of_press_fits_follow_the_formulas_of_the_standard(name):
    """Above 30 mm the tables round the formulas to preferred numbers; smaller sizes have larger values, from practice."""
    grade, factor = FORMULAS[name]
    found = []
    for above, upto in pairwise(EDGES):
        if above < FIRST.get(name, 0):
            continue
        tolerance = np.diff(limits(upto, f"h{grade}"))[0]
        lower, upper = limits(upto, f"{name}6")
        assert upper - lower == np.diff(limits(upto, "h6"))[0]
        wanted = tolerance + factor * np.sqrt(above * upto)
        if above >= 30:
            assert lower == pytest.approx(wanted, rel=0.025, abs=1.5), (name, upto)
        else:
            assert lower >= 0.96 * wanted, (name, upto)
        found.append(lower)
    assert found == sorted(found)


def test_classes_of_other_tables():
    """Machinery's rows: j5 to j7 and J6 to J8 [um] at 30, 100, 400 mm; cd, ef and fg of instrument makers."""
    assert [*limits(30, "j5"), *limits(30, "j6"), *limits(30, "j7")] == [-4, 5, -4, 9, -8, 13]
    assert [*limits(100, "j6"), *limits(400, "j7")] == [-9, 13, -28, 29]
    assert [*limits(30, "J6"), *limits(30, "J7"), *limits(30, "J8")] == [-5, 8, -9, 12, -13, 20]
    assert [*limits(100, "J7"), *limits(400, "J6")] == [-13, 22, -7, 29]
    assert [*limits(5, "cd6"), *limits(5, "ef6"), *limits(5, "fg6")] == [-54, -46, -22, -14, -14, -6]
    assert [*limits(5, "CD8"), *limits(10, "FG7")] == [46, 64, 8, 23]
    assert [*limits(30, "U7"), *limits(60, "X8")] == [-61, -40, -168, -122]  # Delta of grade 7: 8 um


#: Fits that the package pressfit 0.1.0 prints: least and largest clearance [um].
OTHER = {
    "25 H7/g6": (7, 41),
    "25 H7/p6": (-35, -1),
    "25 H11/c11": (110, 370),
    "25 H7/u6": (-61, -27),
    "100 H7/u6": (-146, -89),
}


@pytest.mark.parametrize("text", OTHER)
def test_fits_of_another_package(text):
    np.testing.assert_allclose(1e6 * np.array(linkages.fit(text).clearance), OTHER[text], rtol=0.0, atol=1e-9)


FIT = "joints.A.fit"


def fitted(folder, text):
    """Write an experiment in which a fit replaces the clearance of joint A."""
    source = linkages.find_file("seven_bar.toml")
    lines = source.read_text().splitlines()
    at = lines.index("[joints.A]")
    of_clearance = next(k for k in range(at, len(lines)) if lines[k].startswith("clearance"))
    lines[of_clearance] = f'fit = "{text}"'
    (folder / "fitted.toml").write_text("\n".join(lines))
    (folder / "seven_bar.sdf").write_text(source.with_suffix(".sdf").read_text())
    return folder / "fitted.toml"


def test_a_fit_gives_the_mean_clearance_of_a_joint(tmp_path):
    system = linkages.load(fitted(tmp_path, "30 H7/f7"))
    assert system.value("joints.A.clearance") == pytest.approx(20.5e-6, rel=1e-12)  # (20 + 62) um / 4
    assert system.laws["clearance"][0] == pytest.approx(20.5e-6, rel=1e-12)
    looser = system.replaced({FIT: "30 H8/e8"})
    assert looser.value("joints.A.clearance") == pytest.approx(36.5e-6, rel=1e-12)  # (40 + 106) um / 4
    assert system.replaced({"joints.A.clearance": 1e-4}).value("joints.A.clearance") == 1e-4


def test_a_run_with_a_fit_has_a_report(tmp_path):
    words = ["--duration", "0.02", "--no-plots", "--no-animation", "--no-error-estimate", "-q", "--out", str(tmp_path)]
    assert main(["simulate", str(fitted(tmp_path, "30 H7/f7")), *words]) == 0
    assert load_results(tmp_path).play["A"]["clearance"] == pytest.approx(20.5e-6)
    assert main(["report", str(tmp_path)]) == 0
    assert "0.0205 mm" in (tmp_path / "report.html").read_text()


@pytest.mark.parametrize(("text", "said"), [("30 H7/p6", "can have interference"), ("30 H7f7", "is no fit")])
def test_a_fit_without_clearance_is_refused(tmp_path, capsys, text, said):
    assert main(["simulate", str(fitted(tmp_path, text))]) == 2
    error = capsys.readouterr().err
    assert "joints.A" in error
    assert said in error
    assert error.count("\n") == 1
