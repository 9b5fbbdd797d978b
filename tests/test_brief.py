"""Representation of results and models at a prompt and in a notebook; errors of a wrong name."""

from html.parser import HTMLParser

import numpy as np
import pytest
from drake_missing import MISSING
from scipy.integrate import simpson

import linkages
import optim
from linkages.base.errors import UnknownNameError

LINE = 200  # characters: one line of a terminal, or two


@pytest.fixture(scope="module")
def system():
    return linkages.load(linkages.find_file("slider_crank_dry.toml"), {"duration": 0.005, "title": "a <b> & c"})


@pytest.fixture(scope="module")
def study(system):
    return linkages.assess(system, "compiled")


@pytest.fixture(scope="module")
def shown(system, study):
    """One object of each kind that a user is given."""
    batch = linkages.simulate_batch(system, ["joints.B.clearance"], [[1e-4], [2e-4]], ["B.force"])
    short = system.replaced({"duration": 0.0005})
    return {
        "Trajectory": study.run,
        "System": system,
        "Assessment": study,
        "Batch": batch,
        "Mechanism": system.mechanism,
        "Experiment": system.experiment,
        "Section": linkages.stroboscopic(system, ["B.force"], 2),
        "Sweep": linkages.sweep(system, "joints.B.clearance", [1e-4, 2e-4], ["B.force"], 1),
        "Grid": linkages.sweep_grid(
            system, "joints.B.clearance", [1e-4, 2e-4], "drives.O.speed", [400.0, 500.0], ["B.force"], 1
        ),
        "Exponent": linkages.largest_exponent(system, 2),
        "Spectrum": linkages.spectrum(study.run, "slider.x", samples=64),
        **({} if MISSING else {"Comparison": linkages.compare(short)}),
        "Life": linkages.wear_life(linkages.load(linkages.find_file("slider_crank_wear.toml")), 20),
        "optim.Study": optim.load_study(optim.find_study("sevenbar_force.toml")),
        "Evaluations": optim.Evaluations(np.zeros((300, 2)), np.zeros((300, 1)), ("ok",) * 300, ("",) * 300),
    }


class _Balanced(HTMLParser):
    """Counts the elements of a page and checks that each is closed."""

    def __init__(self, text):
        super().__init__()
        self.open, self.seen = [], []
        self.feed(text)
        assert not self.open

    def handle_starttag(self, tag, attrs):
        self.open.append(tag)
        self.seen.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def test_each_object_shows_itself_in_one_line(shown):
    for name, thing in shown.items():
        text = repr(thing)
        assert "\n" not in text, name
        assert str(thing) == text, name
        assert len(text) <= LINE, (name, len(text), text[:300])
        assert text.startswith(f"<{name.rpartition('.')[2]}: "), name


def test_each_object_shows_itself_as_a_table_in_a_notebook(shown):
    for name, thing in shown.items():
        text = thing._repr_html_()
        assert len(text) < 20_000, name
        assert "table" in _Balanced(text).seen, name


def test_text_of_the_user_is_escaped_in_a_notebook(shown):
    assert "a &lt;b&gt; &amp; c" in shown["System"]._repr_html_()


def test_the_lines_state_what_the_objects_hold(shown, system, study):
    assert "compiled engine, ok, 0 to 0.005 s" in repr(study.run)
    assert f"{len(study.run.time):,} samples" in repr(study.run)
    assert "B.force" in repr(shown["Sweep"]) or "joints.B.clearance" in repr(shown["Sweep"])
    assert "2 runs, 1 window, 1 output; 0 failed" in repr(shown["Batch"])
    rows = study.run._facts()[1]
    assert "force [N]" in rows["B"]
    assert "x [m]" in rows["slider"]
    assert system.mechanism._facts()[1]["joint B"] == "revolute, slider and rod"


def test_columns_behave_as_those_of_a_mapping(study):
    assert "B.force" in study.run
    assert "B.forc" not in study.run
    assert list(study.run) == list(study.run.columns)


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        ("B.forc", '"B.force"'),
        ("slidr.x", '"slider.x"'),
        ("B.temperature", "B has "),
        ("nothing", "there are quantities of "),
    ],
)
def test_a_wrong_column_is_answered_with_the_nearest_names(study, wrong, told):
    with pytest.raises(KeyError) as caught:
        study.run[wrong]
    assert isinstance(caught.value, UnknownNameError)
    assert isinstance(caught.value, linkages.InputError)
    text = str(caught.value)
    assert f'trajectory: has no column "{wrong}"; ' in text
    assert told in text
    assert "\n" not in text


def test_a_wrong_column_is_told_wherever_a_column_is_named(study):
    for ask in (
        lambda: linkages.extremes(study.run, ["B.forc"]),
        lambda: linkages.integral(study.run, "B.forc"),
        lambda: linkages.spectrum(study.run, "B.forc"),
        lambda: linkages.crossings(study.run, "B.forc"),
    ):
        with pytest.raises(linkages.InputError, match=r'did you mean .*"B\.force"'):
            ask()


def test_a_column_is_integrated_by_its_name(study):
    run = study.run
    fine = run.evaluate(np.linspace(0.0, run.time[-1], 20001))
    work = simpson(fine["O.power"], x=fine["time"])
    assert linkages.integral(run, "O.power") == pytest.approx(work, rel=1e-4)  # also evaluated between the samples
    assert linkages.integral(run, run["O.power"]) == pytest.approx(work, rel=1e-3)
    assert linkages.integral(run, "slider.vx") == pytest.approx(run["slider.x"][-1] - run["slider.x"][0], rel=1e-5)


@pytest.mark.parametrize("values", [[1.0, 2.0], 3.0, ["a"], np.zeros((3, 2))])
def test_values_that_are_not_one_number_a_sample_are_refused(study, values):
    with pytest.raises(linkages.InputError, match=r"argument: values: .*name of a column, or an array of \d+ numbers"):
        linkages.integral(study.run, values)
