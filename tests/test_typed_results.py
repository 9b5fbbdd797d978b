"""Results as data: attributes in a program, keys of the file, and nothing between the two."""

import json
import math

import pytest
from pydantic import Field, ValidationError
from shipped import shipped

import linkages
import optim
from linkages.input.files.entry import Entry, Number
from linkages.input.files.writing import content_of, json_text
from linkages.results.shape import Peak, Summary, SummaryFile


class Part(Entry):
    """Stands for an object of a file."""

    start: Number = Field(alias="from")
    name: str
    note: str = ""
    peaks: dict[str, Peak] = Field({})


@pytest.fixture(scope="module")
def summary():
    return linkages.summarize(linkages.assess(shipped("seven_bar", duration=0.05), "compiled", error_estimate=False))


def test_an_entry_has_the_keys_that_it_was_given_in_the_order_of_their_declaration():
    part = Part.model_validate({"name": "a", "from": 1.0})
    assert part.keys() == ["from", "name"]
    assert dict(part) == {"from": 1.0, "name": "a"}
    assert (part.note, part.get("note"), "note" in part) == ("", None, False)
    with pytest.raises(KeyError):
        part["note"]


def test_an_entry_equals_its_content_which_may_be_extended():
    part = Part.model_validate({"from": 1.0, "name": "a", "peaks": {"A": Peak(peak=2.0, time=0.5)}})
    assert part == {"from": 1.0, "name": "a", "peaks": {"A": {"peak": 2.0, "time": 0.5}}}
    assert part["peaks"]["A"]["time"] == part.peaks["A"].time == 0.5
    assert part | {"name": "b"} == part.content | {"name": "b"}


def test_a_number_that_is_not_finite_is_unknown_in_a_program_as_in_the_file():
    peak = Peak(peak=math.nan, time=math.inf)
    assert (peak.peak, peak.time) == (None, None)
    assert json.loads(json_text([peak])) == [{"peak": None, "time": None}]


def test_a_wrong_type_in_a_result_is_an_error_where_it_is_made():
    with pytest.raises(ValidationError, match="peak"):
        Peak(peak="2.0")


def test_the_summary_is_the_content_of_its_file(summary):
    """Attributes, keys and the file agree, and the file is read as the same summary."""
    assert isinstance(summary, Summary)
    assert summary.joints["A"].force.peak == summary["joints"]["A"]["force"]["peak"] > 0.0
    written = json.loads(json_text(summary))
    assert written == summary.content
    read = SummaryFile.model_validate(written)
    assert read.joints == summary.joints
    assert read.peaks == summary.peaks
    assert list(written)[:5] == ["engine", "duration", "status", "mechanism", "outputs"]


def test_keys_that_a_run_does_not_have_are_not_written(summary):
    assert summary.links == {}
    assert "links" not in summary
    assert "links" not in summary.content
    assert "no_ideal" not in summary.content
    assert summary.content["start_up"] is summary.start_up


def test_a_study_has_a_typed_result_with_the_keys_of_its_file():
    study = optim.load_study(optim.find_study("sevenbar_force"))
    result = optim.optimise(study, algorithm={"name": "ga", "population": 4, "generations": 1})
    assert result.best.variables == result["best"]["variables"]
    assert set(result.best.variables) == set(study.paths)
    assert content_of(result) == json.loads(json_text(result))
    assert "reason" not in result.content["best"]
