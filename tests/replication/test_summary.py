"""Counts and causes follow from the claims; misprints and rows agree."""

import re
from pathlib import Path

import pytest
from replication import summary
from replication.misprints import DATA, Misprints
from replication.verdicts import BRIEF, HEAD, Claim, Fitted, Number, Printed, parts, rows

from linkages.input.files.toml import read_toml, validate

DOCS = Path(__file__).resolve().parents[2] / "docs"
APPENDIX = DOCS / "replication_details.md"


def claim(name, *numbers, **more):
    return Claim(name, "p", "o", numbers, "w", **more)


GOOD, NEAR, BAD = Number(1.0, 1.0), Number(1.0, 1.5), Number(1.0, 9.0)


@pytest.fixture
def made_up(monkeypatch):
    """Claims of three sources."""
    found = {
        "press": [
            claim("length, Table 2", GOOD), claim("force, nominal, fig. 10", Fitted(1.0, 1.0)), claim("force, design 1, fig. 10", Fitted(1.0, 1.5)),
            claim("spike, fig. 8", BAD, because=[])._replace(why="unknown", unless="the start"), claim("speed", NEAR), claim("eq. (4)", Printed(1.0, -1.0)),
        ],
        "patent": [claim("gain, [0087]", BAD, because=[GOOD], chosen=True), claim("a guess", BAD, trial=True, stored="python x.py"), claim("a curve, fig. 2")],
        "robot": [claim("order", parts([True, True, False])), claim("the same, shown otherwise", GOOD)],
    }  # fmt: skip
    monkeypatch.setattr(summary, "claims", lambda source: [("section", one) for one in found[source]])


def cells(text):
    """Cells of a table's rows by their first cell."""
    lines = [
        line.removeprefix("| ").removesuffix(" |").split(" | ") for line in text.splitlines() if line.startswith("| ")
    ]
    return {re.sub(r"^\[(.*)\]\(.*\)$", r"\1", line[0]).strip("* "): line[1:] for line in lines}


@pytest.mark.usefixtures("made_up")
def test_claims_are_counted_by_kind_and_fits_apart():
    written = summary.counts()
    found = cells(written)
    assert found["source"] == ["equations", "numbers, fitted", "numbers, predicted", "statements", "open", "not judged"]
    assert found["the press"] == ["0 of 1", "1 of 2", "1 of 3", "-", "1", "0"]
    assert found["the four-bar"] == ["-", "0 of 1", "-", "-", "0", "2"]
    assert found["the robot"] == ["-", "-", "1 of 1", "0 of 1", "0", "0"]
    assert "Numbers that hold: 3 of 7; of these without a fit: 2 of 4." in written


@pytest.mark.usefixtures("made_up")
def test_claims_with_one_cause_share_a_line_and_trials_have_their_numbers():
    assert summary.causes("press").splitlines() == [
        "### press.section", "",
        "- **length; force, nominal, design 1; speed; eq. (4)**: w.", "- **spike**: unknown. *Missing:* the start.", "",
    ]  # fmt: skip
    assert summary.causes("patent").splitlines() == [
        "### patent.section", "", "Stored: `python x.py`.", "", "- **gain**: w.",
        "- **a guess** (trial, stored): p; ours o: *not reproduced*; w.", "- **a curve, fig. 2**: p; ours o: *nothing to compare*; w.", "",
    ]  # fmt: skip


def test_the_page_has_the_counts():
    text = (DOCS / "replication.md").read_text(encoding="utf-8")
    assert text.index("| source | equations |") < 900
    assert {"the press", "the four-bar", "the robot"} <= cells(text[: text.index("## The press")]).keys()
    assert re.search(r"of these without a fit: 1 of \d+\.", text)


def page_rows():
    """Cells of the tables under `BRIEF` of the written pages, by claim."""
    found = {}
    for name in ("replication", "replication_3rrr"):
        rows = cells((DOCS / f"{name}.md").read_text(encoding="utf-8"))
        found |= {
            key: dict(zip(BRIEF[1:], row, strict=True)) for key, row in rows.items() if len(row) == len(BRIEF) - 1
        }
    return found


@pytest.mark.parametrize("source", ["press", "robot"])
def test_misprints_are_wrong_on_the_page_too(source):
    """Each entry of the list of misprints has a failing row; an equation is not right on one page and a misprint on another."""
    listed = [m for m in getattr(validate(Misprints, read_toml(DATA)[0], DATA), source) if m.claim]
    written = page_rows()
    assert len(listed) >= 3
    for one in listed:
        assert written[one.claim]["verdict"].startswith(("wrong as printed", "does not hold")), one.claim


def test_equations_that_are_right_are_no_misprints():
    found = page_rows()
    for number in ("(2)", "(5)", "(13)"):
        assert any(f"eq. {number}" in name and row["verdict"] == "right as printed" for name, row in found.items())
    listed = [m.place for m in validate(Misprints, read_toml(DATA)[0], DATA).robot]
    assert not any(place.startswith(("(2)", "(5)")) for place in listed)
    assert [place for place in listed if place.startswith("(13)")] == ["(13), zero modes"]


def test_stored_numbers_are_named():
    """A section with numbers from a file names the file's program, which exists."""
    text = APPENDIX.read_text(encoding="utf-8")
    lines = [line for line in text.splitlines() if line.startswith("Stored: ")]
    commands = {found for line in lines for found in re.findall(r"`python ([^\s`]+)", line)}
    assert {"docs/make_dry.py", "docs/make_designs.py", "docs/make_conditions.py", "docs/make_robot.py"} <= commands
    assert all((DOCS.parent / command).exists() for command in commands)
    for stored in ("the same on Drake, drawn start", "best and mean fitness of each generation, section 2.2, step 5"):
        assert re.search(rf"\*\*{re.escape(stored)}\*\* \([^)]*stored\):", text)


def test_sections_that_read_a_file_mark_it(monkeypatch):
    """All claims of the patent's background come from a file."""
    assert all("(stored)" in row[HEAD.index("ours")] for row in rows("patent", ["background"]))
