"""Sweeps, sensitivities and tolerances around the shown run, and what is kept of it."""

import contextlib
import io
import json

import numpy as np
import pytest

import linkages

CLEARANCE, MASS = "joints.A.clearance", "sdf.links.link2.mass"


@pytest.fixture
def ask():
    """Return a reply that is no error."""

    def reply_of(of, kind, **request):
        reply = of.answer(kind, {"values": {}, **request})
        assert "error" not in reply, reply
        return reply

    return reply_of


@pytest.fixture
def press(answers, settled):
    """Make the answers of a press whose motion is settled."""
    of = answers("seven_bar")
    settled(of, {})
    return of


def table(of):
    return {row["name"]: row["value"] for row in of.answer("numbers", {})["table"]}


def test_a_sweep_has_the_peaks_of_single_runs(press, ask):
    reply = ask(press, "sweep", path=CLEARANCE, low=1e-4, high=9e-4, count=3)
    assert reply["values"] == pytest.approx([1e-4, 3e-4, 9e-4])  # a clearance has a logarithmic scale
    page = next(iter(press._pages.values()))
    ran = page.values_shown({})
    start, end = page.part_shown({}, lambda: False)
    for k, clearance in enumerate(reply["values"]):
        offset = clearance / 3e-4 * np.array(ran["joints.A.offset"])
        values = ran | {CLEARANCE: clearance, "joints.A.offset": offset.tolist()}
        run = linkages.simulate(press.session.system.replaced(values))
        found = linkages.extremes(run.within(start, end), ["A.force", "slider7.ax"])
        for name, one in found.items():
            assert reply["peaks"][name][k] == pytest.approx(one.peak, rel=1e-9)
    assert reply["peaks"]["A.force"][1] == pytest.approx(table(press)["A.force"], rel=1e-9)


def test_a_run_of_a_sweep_that_fails_has_no_peak_and_a_reason(press, ask):
    reply = ask(press, "sweep", path="sdf.frames.link2_C.pose.x", low=0.18, high=3.0, count=2)
    assert reply["peaks"]["A.force"][0] > 0.0
    assert reply["peaks"]["A.force"][1] is None
    assert "loops do not close" in reply["reasons"][1]


@pytest.mark.slow  # derivatives
def test_sensitivities_are_the_slopes_of_sweeps(press, ask):
    found = ask(press, "sensitivities", paths=[MASS])
    mass = press.session.system.value(MASS)
    swept = ask(press, "sweep", path=MASS, low=0.99 * mass, high=mass / 0.99, count=3)["peaks"]  # a logarithmic scale
    for name in ("A.force", "B.force", "O1.torque"):
        low, middle, high = swept[name]
        assert found["peaks"][name] == pytest.approx(middle, rel=1e-6)
        assert found["changes"][MASS][name] == pytest.approx(np.log(high / low) / np.log(0.99**-2), rel=2e-3)


def test_tolerances_scatter_as_the_slope_says(press, ask):
    """For a small scatter a peak is normal: its deviation is slope times spread, 5 % are below mean - 1.645 of it."""
    mass, spread, count = press.session.system.value(MASS), 0.01, 400
    low, peak, high = ask(press, "sweep", path=MASS, low=0.99 * mass, high=1.01 * mass, count=3)["peaks"]["A.force"]
    reply = ask(press, "tolerances", spreads={MASS: spread}, runs=count)
    found, deviation = reply["peaks"]["A.force"], 0.5 * abs(high - low) / 0.01 * spread
    assert reply["failed"] == 0
    assert found["mean"] == pytest.approx(peak, abs=4.0 * deviation / np.sqrt(count))
    assert found["deviation"] == pytest.approx(deviation, rel=4.0 / np.sqrt(2.0 * count))
    low5, middle, high5 = found["quantiles"]
    assert (high5 - low5) / (2.0 * 1.645 * deviation) == pytest.approx(1.0, abs=4.0 * 2.11 / np.sqrt(count))
    band = np.array(reply["bands"]["A.force"])
    assert np.all(band[0] <= band[1])
    assert np.all(band[1] <= band[2])
    assert band[1].max() == pytest.approx(middle, rel=1e-2)
    assert len(reply["time"]) == band.shape[1]


def test_the_band_of_equal_machines_is_the_curve_also_through_impacts(answers, ask):
    """The motion of a dry joint does not repeat, and its forces last some microseconds."""
    of = answers("slider_crank_dry")
    curves = {curve["name"]: curve["run"] for curve in ask(of, "run")["curves"]}
    reply = ask(of, "tolerances", spreads={"joints.B.clearance": 1e-300}, runs=2)  # no number changes
    assert "B.force" in curves.keys() & reply["bands"].keys()
    for name in curves.keys() & reply["bands"].keys():
        time, values = (np.array(curves[name][key]) for key in ("time", "values"))
        for edge in reply["bands"][name]:
            outside = np.abs(np.interp(time, reply["time"], edge) - values) > 0.02 * np.ptp(values)
            assert outside.mean() < 0.02, name


def test_the_usual_tolerances_leave_the_drives_alone(press, ask):
    reply = ask(press, "tolerances", runs=2)
    assert set(reply["spreads"]) == {f"joints.{name}.{key}" for name in "AB" for key in ("clearance", "viscosity")}


@pytest.mark.parametrize(
    ("kind", "request_", "named"),
    [
        ("sweep", {"path": "nothing"}, "nothing"),
        ("sweep", {"path": "joints.A.model"}, "joints.A.model"),
        ("sweep", {"path": CLEARANCE, "low": 2.0, "high": 1.0}, "low < high"),
        ("sweep", {"path": CLEARANCE, "count": 1}, "count"),
        ("sweep", {"path": CLEARANCE, "count": True}, "count"),
        ("sensitivities", {}, "paths"),
        ("sensitivities", {"paths": ["joints.A.film"]}, "joints.A.film"),
        ("tolerances", {"spreads": {CLEARANCE: 2.0}}, CLEARANCE),
        ("tolerances", {"spreads": [1]}, "spreads"),
        ("tolerances", {"runs": 1.5}, "runs"),
    ],
)
def test_wrong_requests_are_refused_in_one_line(answers, kind, request_, named):
    reply = answers("seven_bar").answer(kind, {"values": {}, **request_})
    assert named in reply["error"]
    assert "\n" not in reply["error"]


def test_outdated_runs_end(press):
    for kind in ("sweep", "tolerances"):
        assert press.answer(kind, {"values": {}, "path": CLEARANCE}, lambda: True) == {"outdated": True}
    assert press.said == ""


def test_a_slow_run_is_coarse_until_it_is_refined(answers):
    """With a preview of no time at all the first reply is coarse; the refined one is the one without a preview."""
    of, patient = answers("slider_crank_dry", preview=1e-9), answers("slider_crank_dry")
    first = of.answer("run", {"values": {}})
    assert (first["status"], first["coarse"]) == ("ok", True)
    whole = of.answer("run", {"values": {}, "refine": True})
    assert not whole["coarse"]
    patient.answer("run", {"values": {}})
    assert table(of) == table(patient)


def test_a_design_that_locks_shows_the_pose_where_it_locks(answers, ask):
    """A rod of 30 mm on a crank of 50 mm reaches the guide until sin(angle) = 0.6."""
    of = answers("slider_crank_dry")
    values = {"sdf.frames.rod_B.pose.x": 0.03}
    reply = ask(of, "run", values=values)
    angle = np.arcsin(0.6)
    assert reply["status"] == "locked"
    assert reply["remedy"]
    assert reply["locked"] == pytest.approx(angle / of.session.system.value("drives.O.speed"), rel=1e-4)
    picture = ask(of, "picture", values=values)
    body = next(body for body, link in picture["bodies"].items() if link == "crank")
    assert picture["poses"][-1][body][2] == pytest.approx(angle, rel=1e-4)
    assert ask(of, "numbers")["table"]


def test_a_notebook_repeats_the_table(press, ask, tmp_path):
    reply = ask(press, "notebook", name="mine")
    cell = json.loads((tmp_path / "mine.ipynb").read_text())["cells"][0]
    assert "".join(cell["source"]) == reply["code"]
    printed, shown = io.StringIO(), table(press)
    with contextlib.redirect_stdout(printed):
        exec(reply["code"], {})
    numbers = dict(line.split() for line in printed.getvalue().splitlines())
    assert len(numbers) > 5
    assert numbers == {name: f"{shown[name]:.6g}" for name in numbers}
    assert "exists" in press.answer("notebook", {"values": {}, "name": "mine"})["error"]


def test_a_saved_file_names_its_machine_from_there(tmp_path, ask):
    """Machine and saved file can be moved together."""
    from linkages.show.live.answers import Answers
    from linkages.show.live.controls import controls
    from linkages.show.live.session import Session

    for folder in ("machines", "studies"):
        (tmp_path / folder).mkdir()
    text = linkages.find_file("slider_crank_dry.toml").read_text()
    (tmp_path / "machines" / "slider_crank.sdf").write_bytes(linkages.find_file("slider_crank.sdf").read_bytes())
    (tmp_path / "machines" / "dry.toml").write_text(text)
    system = linkages.load(tmp_path / "machines" / "dry.toml")
    ask(Answers(Session(system), controls(system), tmp_path / "studies"), "save", name="mine")
    assert linkages.load(tmp_path / "studies" / "mine.toml").experiment.mechanism == "../machines/slider_crank.sdf"


def test_a_warning_has_its_remedy(answers, ask):
    """A short film is no law for an L/D of 1.33; the finite film is."""
    of, values = answers("seven_bar"), {"joints.A.film": "short"}
    ask(of, "run", values=values)
    warned = [one for one in ask(of, "warnings")["warnings"] if "outside its validity" in one["text"]]
    assert warned[0]["remedies"] == [{"label": "A.film = finite", "values": {"joints.A.film": "finite"}}]
    ask(of, "run", values=values | warned[0]["remedies"][0]["values"])
    assert not [one for one in ask(of, "warnings")["warnings"] if "outside its validity" in one["text"]]


LARGE = 10**400  # no floating-point number
STRANGE = {
    "a place that is too far": ("move", {"joint": "A", "to": [LARGE, 0], "phase": 0}),
    "a phase that is too large": ("move", {"joint": "A", "to": [0, 0], "phase": LARGE}),
    "an end of a sweep": ("sweep", {"path": "drives.O1.speed", "low": 1, "high": LARGE, "count": 5}),
    "a number of runs of a sweep": ("sweep", {"path": "drives.O1.speed", "low": 1, "high": 2, "count": LARGE}),
    "a list for a path": ("sensitivities", {"paths": [["x"]]}),
    "a table for a path": ("sensitivities", {"paths": [{"x": 1}]}),
    "a deviation": ("tolerances", {"runs": 2, "spreads": {"joints.A.clearance": LARGE}}),
    "a number of machines": ("tolerances", {"runs": LARGE}),
    "a value": ("run", {"values": {"joints.A.clearance": LARGE}}),
}


@pytest.mark.parametrize("case", STRANGE)
def test_numbers_and_paths_that_are_none_are_refused(answers, case):
    kind, request = STRANGE[case]
    assert answers("seven_bar").answer(kind, request)["error"]


def test_values_without_effect_are_named_and_the_others_are_explored(answers):
    """A bearing's length has an effect on its film alone."""
    of = answers("slider_crank_lubricated", duration=0.02)
    idle = "sdf.joints.A.bearing.length"
    found = of.answer("sensitivities", {"paths": ["joints.B.viscosity", idle]})
    assert [*found["changes"]] == ["joints.B.viscosity"]
    assert found["without"][idle].endswith("joint A is ideal; give it a clearance with joints.A.model")
    assert "joint A is ideal" in of.answer("sweep", {"path": idle})["error"]
    assert "joint A is ideal" in of.answer("sensitivities", {"paths": [idle]})["error"]
