"""What motion a run ends in, and the numbers of its steady cycle."""

import re

import numpy as np
import pytest

import linkages
from linkages.results.steady_state import classify, common_period
from linkages.show.report.words import beyond

PHASES = 48
TURN = 2.0 * np.pi


def _back(signal, periods):
    """States of a signal (of time in periods), from its end back."""
    times = np.arange(periods * PHASES + 1)[::-1] / PHASES
    return np.array([signal(t) for t in times])


def _polygon(points):
    """Signal that takes these values after each period, and goes straight between them."""
    return lambda t: points[int(t)] + (t - int(t)) * (points[int(t) + 1] - points[int(t)])


def _henon(periods):
    points = [np.array([0.1, 0.1])]
    for _ in range(periods + 60):
        x, y = points[-1]
        points.append(np.array([1.0 - 1.4 * x * x + y, 0.3 * x]))
    return np.array(points[50:])


@pytest.mark.parametrize(
    ("signal", "periods", "kind", "of_drives"),
    [
        (lambda t: [np.cos(TURN * t), np.sin(TURN * t)], 2, "periodic", 1),
        (lambda t: [np.cos(TURN * t / 3.0), np.sin(TURN * t)], 10, "periodic", 3),
        (lambda t: [np.cos(TURN * t) + 2.0 * np.exp(-20.0 * t)], 2, "periodic", 1),
        (lambda t: [np.cos(TURN * t) + 0.3 * np.exp(-0.1 * t)], 20, "not settled", 0),
        (lambda t: [np.cos(TURN * t) + 0.03 * np.exp(-0.01 * t)], 20, "not settled", 0),
        (lambda t: np.exp(-0.05 * t) * np.array([np.cos(4.8 * t), np.sin(4.8 * t)]), 20, "not settled", 0),
        (lambda t: 0.05 * np.exp(-0.1 * t) * np.array([np.cos(np.pi * t), np.sin(np.pi * t)]), 4, "not settled", 0),
        (lambda t: [np.cos(4.8 * t), np.sin(4.8 * t), np.sin(TURN * t)], 20, "quasi-periodic", 0),
        (lambda t: [np.cos(4.8 * t), np.sin(4.8 * t), np.sin(TURN * t)], 7, "not settled", 0),  # too few to tell
        (_polygon(_henon(20)), 20, "chaotic", 0),  # Hénon's map, exponent 0.42
    ],
)
def test_motions_of_known_kind(signal, periods, kind, of_drives):
    found = classify(_back(signal, periods))
    assert found[:2] == (kind, of_drives)


@pytest.mark.parametrize("periods", [3, 5, 12])
def test_scatter_between_periods_is_no_trend(periods):
    """Changes by a run's errors from period to period, 1e-4, may shrink a little by chance."""
    random = np.random.default_rng(20260816)
    for _ in range(300):
        knots = random.uniform(-1e-4, 1e-4, (8 * periods + 1, 2))
        noise = [np.interp(np.arange(periods * PHASES + 1) / 6.0, np.arange(len(knots)), column) for column in knots.T]
        found = classify(_back(lambda t: [np.cos(TURN * t), np.sin(TURN * t)], periods) + np.array(noise).T)
        assert found[:2] == ("periodic", 1)


def test_a_run_shorter_than_a_period_is_said_to_be_that():
    kind, *_, why = classify(_back(lambda t: [np.cos(TURN * t)], 1)[: PHASES // 2])
    assert (kind, why) == ("not settled", "the run is shorter than a period")


def test_what_does_not_repeat_is_told_how_far_it_is_from_that():
    """A whirl at half the drives' frequency: a period later it is on the other side, so twice its radius away."""
    *_, why = classify(_back(lambda t: [0.03 * np.cos(np.pi * t), 0.03 * np.sin(np.pi * t)], 3))
    assert why == "it does not repeat within 3 periods; the states of the last two periods differ by 0.06"


@pytest.mark.parametrize(("periods", "told"), [(1.0, "1 period"), (2.0, "2 periods"), (1.5, "1.5 periods")])
def test_a_number_of_periods_has_its_plural(periods, told):
    *_, why = classify(_back(lambda t: [0.03 * np.cos(0.7 * t), 0.5 * t], periods), scale="of the clearance")
    assert why.partition(";")[0] == f"it does not repeat within {told}"
    assert why.endswith("of the clearance") or periods == 1.0


def test_a_difference_of_states_says_what_it_is_measured_in():
    """Seven-bar, drives prescribed: states are eccentricities. A motion of free coordinates has angles too."""
    system = linkages.load(linkages.find_file("seven_bar.toml"), {"duration": 4.0})
    why = linkages.motion_of(system, linkages.simulate(system, "compiled")).why
    assert re.search(r"the states of the last two periods differ by [\d.]+ of the clearance$", why)


def test_a_motion_is_periodic_from_where_its_start_has_died_away():
    rate = 20.0  # per period: 2 exp(-20 t) (1 - exp(-20)) is 0.01 at t = 0.265
    _, _, reached, _ = classify(_back(lambda t: [np.cos(TURN * t) + 2.0 * np.exp(-rate * t)], 3))
    since = 3.0 - reached / PHASES
    assert since == pytest.approx(np.log(2.0 / 0.01) / rate, abs=1.0 / PHASES)


@pytest.mark.parametrize(
    ("values", "period"),
    [
        ({}, 1.0),
        ({"drives.O4.speed": -2.0 * TURN}, 1.0),
        ({"drives.O4.speed": 1.5 * TURN}, 2.0),
        ({"drives.O1.speed": 4.0 * TURN, "drives.O4.speed": 6.0 * TURN}, 0.5),
        ({"drives.O4.speed": np.sqrt(2.0) * TURN}, None),
        ({"drives.O4.speed": 0.0}, 1.0),
        ({"drives.O4": {"formula": "0.2*sin(4*pi*t) + 0.1*cos(8*pi*t)"}}, 1.0),  # its own 0.5 s, the other's 1 s
        ({"drives.O1": {"formula": "0.3*sin(2*pi*t/3)"}, "drives.O4.speed": 0.0, "duration": 7.0}, 3.0),
        ({"drives.O1": {"formula": "0.3*sin(2*pi*t/3)"}, "drives.O4.speed": 0.0, "duration": 5.0}, None),  # not twice
        ({"drives.O4": {"formula": "0.1*sin(5*t)"}}, None),
        ({"drives.O4": {"formula": "0.1*max(0, sin(4*pi*t))**4"}}, 1.0),  # it rests for half of its time
        ({"drives.O4": {"formula": "0.1*max(0, -sin(4*pi*t))**4"}}, 1.0),
        ({"drives.O4": {"formula": "0.1*exp(-t)*sin(8*pi*t)"}}, None),
        ({"drives.O4": {"formula": "0.1*sin(8*pi*t) + 0.001*t"}}, None),
    ],
)
def test_common_period_of_drives(values, period, fast_press):
    assert common_period(fast_press.replaced(values)) == (period and pytest.approx(period))


@pytest.fixture(scope="module")
def study():
    """Slider-crank with so much friction that it forgets its start, eight revolutions."""
    values = {"joints.B.friction.coefficient": 0.1, "duration": 0.096}
    return linkages.assess(linkages.load(linkages.find_file("slider_crank_dry.toml"), values), "compiled")


def test_the_steady_cycle_is_the_last_revolution(study):
    summary = linkages.summarize(study)
    motion, steady = summary["motion"], summary["windows"]["steady"]
    assert (motion["kind"], motion["periods"], summary["report"]) == ("periodic", 1, "steady")
    assert (steady["from"], steady["to"]) == (pytest.approx(0.084), 0.096)
    # by other code, which runs from revolution to revolution
    section = linkages.stroboscopic(study.system, ["B.force", "slider.ax"], revolutions=1, transient=7)
    for name, value in (("B.force", steady["joints"]["B"]["force"]), ("slider.ax", steady["outputs"]["slider.ax"])):
        error = steady["error"][f"{name}.peak"]
        assert error < 1e-3 * value["peak"]
        assert value["peak"] == pytest.approx(section.peaks(name)[0], abs=10.0 * error)


def test_the_start_up_stands_beside_the_steady_cycle(study):
    summary = linkages.summarize(study)
    whole, steady = (numbers["joints"]["B"]["force"] for numbers in (summary, summary["windows"]["steady"]))
    assert whole["time"] < summary["motion"]["since"] < steady["time"]
    assert whole["peak"] > 1.1 * steady["peak"]
    table = linkages.format_summary(summary)
    row, below = _row_and_remark(table, "B (dry)")
    assert f" {1e-3 * steady['peak']:.4g} " in row
    assert below.startswith("    whole run: ")
    assert below.endswith(f" at {whole['time']:.3g} s (start-up)")


def _row_and_remark(table, start):
    """Return the row of a table with this start, and the line below it."""
    lines = table.splitlines()
    first = next(k for k, line in enumerate(lines) if line.startswith(start))
    return lines[first], lines[first + 1]


def test_a_column_for_what_is_larger_in_the_whole_run_is_there_only_if_something_is(study):
    summary = linkages.summarize(study)
    steady = summary["windows"]["steady"]
    assert "whole run" in linkages.format_summary(summary)
    alike = {kind: steady[kind] for kind in ("outputs", "joints", "drives", "ideal")}
    assert "whole run" not in linkages.format_summary(summary | alike)


def test_only_headings_name_the_column_of_the_whole_run(study):
    summary = linkages.summarize(study).content
    for numbers in (summary, summary["windows"]["steady"]):
        for drives in (numbers["drives"], numbers["ideal"]["drives"]):
            next(iter(drives.values()))["fluctuation"] = 0.02
    lines = linkages.format_summary(summary).splitlines()
    row = next(line for line in lines if "speed fluctuation" in line)
    assert row.split("[1]")[1].split() == ["0.02", "0.02"]


def test_a_table_says_where_no_cycle_is_looked_for(study):
    none = {"motion": {"kind": None, "why": "the drives have no common period"}, "report": "whole"}
    line = "no search for a steady cycle: the drives have no common period"
    summary = linkages.summarize(study)
    assert line in linkages.format_summary(summary | none)
    ideal = {"joints": {name: one | {"model": "ideal"} for name, one in summary["joints"].items()}}  # nothing settles
    assert line not in linkages.format_summary(summary | none | ideal)


def test_windows_and_report_from_of_a_run(study):
    values = {"report_from": 0.03, "windows.second.start": 0.012, "windows.second.end": 0.024}
    system = study.system.replaced(values)
    other = linkages.Assessment(system, "compiled", study.run, study.ideal, study.tighter)
    summary = linkages.summarize(other)
    assert summary["report"] == "report"
    batch = linkages.simulate_batch(system, outputs=["B.force"], windows=[[0.03, 0.096], [0.012, 0.024]])
    for k, name in enumerate(("report", "second")):
        assert summary["windows"][name]["joints"]["B"]["force"]["peak"] == pytest.approx(batch.peak[0, k, 0], rel=1e-6)
    assert "the numbers belong to the run, 0.03 to 0.096 s" in linkages.format_summary(summary)


def test_the_whole_run_can_be_asked_for(study):
    system = study.system.replaced({"report": "whole"})
    summary = linkages.summarize(linkages.Assessment(system, "compiled", study.run, study.ideal, study.tighter))
    assert summary["report"] == "whole"
    table = linkages.format_summary(summary)
    assert "whole run" not in table
    assert f" {1e-3 * summary['joints']['B']['force']['peak']:.4g} " in table


@pytest.mark.parametrize(
    ("values", "problem"),
    [
        ({"report_from": 3.0}, "report_from: is 3 s; it must be before the duration of 2 s"),
        ({"windows.late.start": 1.0, "windows.late.end": 3.0}, "windows.late.end: is 3 s, after the duration of 2 s"),
        ({"windows.late.start": 1.0, "windows.late.end": 0.5}, "end must be after start"),
        ({"windows.steady.start": 0.0, "windows.steady.end": 1.0}, "is the name of a predefined window"),
    ],
)
def test_windows_that_cannot_be(values, problem, seven_bar):
    with pytest.raises(linkages.InputError, match=problem):
        seven_bar.replaced(values)


@pytest.mark.parametrize("ramp", [2.0, 2e16])
def test_a_ramp_that_outlasts_the_run_leaves_no_period(ramp):
    path = linkages.find_file("slider_crank_lubricated.toml")
    system = linkages.load(path, {"drives.O.ramp": ramp, "duration": 1.0}).ideal()
    motion = linkages.motion_of(system, linkages.ideal(system))
    assert (motion.kind, motion.periods, motion.since) == ("not settled", 0, None)
    assert motion.why == "the run is shorter than a period"


@pytest.mark.parametrize("engine", ["compiled", "drake"])
@pytest.mark.parametrize("name", ["slider_crank_dry", "seven_bar_mixed", "slider_crank_lubricated"])
def test_a_start_in_equilibrium_passes_what_the_ideal_joints_pass(engine, name):
    system = linkages.load(linkages.find_file(f"{name}.toml"), {"start": "equilibrium", "duration": 2e-5})
    run, ideal = linkages.simulate(system, engine), linkages.ideal(system)
    for joint in system.tree.play:
        for axis in ("fx", "fy"):
            force = ideal[f"{joint}.force"][0]
            # but for the load's own change in this time, and Drake's rounding of a contact 2 um deep
            assert run[f"{joint}.{axis}"] == pytest.approx(
                np.full(len(run.time), ideal[f"{joint}.{axis}"][0]), abs=0.01 * force
            )


def test_a_block_starts_in_equilibrium_in_its_slot():
    system = linkages.load(linkages.find_file("slider_crank_guide.toml"), {"start": "equilibrium", "duration": 1e-6})
    run, ideal = linkages.simulate(system, "compiled"), linkages.ideal(system)
    for what in ("fy", "moment"):
        assert run[f"guide.{what}"][0] == pytest.approx(ideal[f"guide.{what}"][0], rel=1e-6, abs=1e-9)


def test_without_the_flight_across_the_clearance_there_is_no_impact_at_the_start():
    path, values = linkages.find_file("slider_crank_dry.toml"), {"duration": 1e-3}
    centred = linkages.simulate(linkages.load(path, values), "compiled")
    resting = linkages.simulate(linkages.load(path, values | {"start": "equilibrium"}), "compiled")
    load = linkages.ideal(linkages.load(path, values))["B.force"].max()
    assert centred["B.force"].max() > 10.0 * load
    assert resting["B.force"].max() < 1.01 * load


@pytest.mark.parametrize(
    ("values", "problem"),
    [
        ({"start": "rest"}, "start"),
        ({"start": "equilibrium", "joints.A.offset": [1e-5, 0.0]}, "joints.A.offset: is given, but"),
    ],
)
def test_starts_that_cannot_be(values, problem, seven_bar):
    with pytest.raises(linkages.InputError, match=problem):
        seven_bar.replaced(values)


def test_a_film_in_which_nothing_turns_carries_nothing_at_rest(seven_bar):
    still = {"drives.O1.speed": 0.0, "drives.O4.speed": 0.0, "gravity": [5.0, 5.0, 5.0]}
    with pytest.raises(linkages.InputError, match=r"start: .*no offset of A balances .* N at zero velocity"):
        _ = seven_bar.replaced({"start": "equilibrium"} | still).assembly


def test_the_start_up_of_a_dry_joint_is_labelled_and_later_peaks_are_given():
    """A journal that starts in the middle strikes harder than ever after; at rest on its wall it does not."""
    system = linkages.load(linkages.find_file("slider_crank_dry.toml"))
    summary = linkages.summarize(linkages.assess(system, "compiled", error_estimate=False))
    contacts = linkages.impacts(linkages.simulate(system, "compiled"), ["B"])
    until = summary["start_up"]
    rest = next(row for row in contacts if row.duration > contacts[0].start)
    assert until == rest.start
    assert all(row.duration < contacts[0].start for row in contacts if row.start < until)
    later = summary["windows"]["later"]
    assert (summary["report"], later["from"], later["to"]) == ("later", until, summary["duration"])
    first, after = (one["joints"]["B"]["force"]["peak"] for one in (summary, later))
    assert first == pytest.approx(max(row.peak_force for row in contacts if row.start < until), rel=1e-6)
    assert after == pytest.approx(max(row.peak_force for row in contacts if row.start >= until), rel=1e-6)
    table = linkages.format_summary(summary)
    assert "the numbers belong to the run after its start-up" in table
    assert "s (start-up)" in table
    assert re.fullmatch(r"[\d.]+ N at [\d.]+ s \(start-up\)", beyond(summary, "B.force.peak", "N"))


def test_a_run_that_ends_in_its_start_up_says_so_and_one_from_rest_has_none():
    values = {"duration": 0.002}
    system = linkages.load(linkages.find_file("slider_crank_dry.toml"), values)
    summary = linkages.summarize(linkages.assess(system, "compiled", error_estimate=False))
    assert (summary["start_up"], summary["report"], summary["windows"]) == (0.002, "whole", {})
    assert "its peaks belong to the start-up" in linkages.format_summary(summary)
    resting = linkages.assess(system.replaced({"start": "equilibrium"}), "compiled", error_estimate=False)
    assert linkages.summarize(resting)["start_up"] is None


def test_the_start_up_of_a_film_is_labelled():
    """A film stops the journal with more than twice the load; a stiff one takes up its load without such an excess."""
    study = linkages.assess(linkages.load(linkages.find_file("slider_crank_lubricated.toml")), error_estimate=False)
    summary, time, force = linkages.summarize(study), study.run.time, study.run["B.force"]
    load = np.interp(time, study.ideal.time, study.ideal["B.force"])
    flight, until, peak = time[np.argmax(force > load)], summary["start_up"], summary["joints"]["B"]["force"]
    assert flight < peak["time"] < until < 3.0 * flight
    assert peak["peak"] > 2.0 * load.max()
    carried = (time >= until) & (time <= until + flight)
    assert np.count_nonzero(carried) > 5
    np.testing.assert_allclose(force[carried], load[carried], rtol=0.1)
    _, below = _row_and_remark(linkages.format_summary(summary), "B (lubricated)")
    assert below.endswith("s (start-up)")
    stiff = linkages.assess(
        linkages.load(linkages.find_file("seven_bar.toml"), {"duration": 0.1}), error_estimate=False
    )
    assert stiff.start_up is None


def test_a_peak_before_a_film_is_loaded_belongs_to_the_start_up():
    """A rod that starts stretched by its load springs back where the film does not pull yet: its modes decide how hard.

    The peak after the start-up needs no more modes: eight axial ones change it by less than a thousandth.
    """
    slow = {"drives.O.speed": 50.0, "duration": 0.005, "solver.accuracy": 1e-9}
    system = linkages.load(linkages.find_file("slider_crank_flexible.toml"), slow)
    summary = linkages.summarize(linkages.assess(system, "compiled", error_estimate=False))
    finer = linkages.simulate(system.replaced({"links.rod.axial": 8}), "compiled")
    until, later = summary["start_up"], summary["windows"]["later"]
    assert summary["report"] == "later"
    assert 0.0 < until < 1e-5
    exact = finer["A.force"][finer.time >= until].max()
    assert summary["joints"]["A"]["force"]["peak"] > 1.15 * exact
    assert later["joints"]["A"]["force"]["peak"] == pytest.approx(exact, rel=1e-3)
    resting = linkages.assess(system.replaced({"start": "equilibrium"}), "compiled", error_estimate=False)
    assert resting.start_up is None
    assert resting.run["A.force"].max() == pytest.approx(resting.ideal["A.force"].max(), rel=1e-3)
