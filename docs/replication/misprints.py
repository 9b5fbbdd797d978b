"""Misprints of the three sources: ``misprints.toml``, checked, as a page."""

from __future__ import annotations

from pathlib import Path

from pydantic import Field

from linkages.input.files.toml import Table, read_toml, validate

DATA = Path(__file__).with_name("misprints.toml")


class Misprint(Table):
    """An error or omission of a source; text for the page."""

    place: str = Field(min_length=1, description="equation, table or section")
    printed: str = Field(min_length=1, description="as printed")
    ours: str = Field(min_length=1, description="correction used here, and its reason")
    shown: str = Field(min_length=1, description="test or file that proves it")
    claim: str = Field("", description="its row on a replication page, if it has one")


class Misprints(Table):
    """The lists of the three sources."""

    press: list[Misprint] = Field([], description="Chen, Wang and Wang 2025")
    patent: list[Misprint] = Field([], description="Bai, Zhao and Sun 2016")
    robot: list[Misprint] = Field([], description="Lu, Shi, Gao and Dan 2010")


def page() -> str:
    """Return the whole page."""
    found = validate(Misprints, read_toml(DATA)[0], DATA)
    sections = [
        (
            "The press",
            "Chen, Wang and Wang, *Dynamics optimization design of multi-link mechanisms with lubrication clearances of"
            " revolute joints*, 2025. Symbols as in [theory](theory.md).",
            found.press,
        ),
        (
            "The four-bar",
            "CN106055749A, Bai, Zhao and Sun, *A method for improving the motion stability of linkages with clearance*, 2016.",
            found.patent,
        ),
        (
            "The robot",
            "Lu, Shi, Gao and Dan, *Elastic-dynamics of planar flexile parallel mechanism*, 2010. Symbols are the paper's.",
            found.robot,
        ),
    ]
    body = "\n".join(f"## {title}\n\n{source}\n\n{_rows(listed)}" for title, source, listed in sections if listed)
    return f"""# Misprints of the sources

For readers who use one of the three [replicated](replication.md) sources: equations, tables and numbers that cannot be used as printed, the correction used here, and the
test that proves it. `python docs/make_misprints.py` writes this page.

{body}"""


def _rows(listed: list[Misprint]) -> str:
    return "".join(f"- **{m.place}**: printed {m.printed}; ours {m.ours} (`{m.shown}`)\n" for m in listed)
