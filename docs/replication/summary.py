"""Counts of rows that follow from their verdicts, for the replication pages, and the causes for their appendix.

The counts leave trials, which are no claims of a source, and rows with nothing to compare out of all but the last column.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from replication.claims import table
from replication.verdicts import Claim, claims

#: Name and page of each source.
TITLES = {
    "press": ("the press", "replication.md#the-press"), "patent": ("the four-bar", "replication.md#the-four-bar"),
    "robot": ("the robot", "replication_3rrr.md"),
}  # fmt: skip
KINDS = ("equation", "number", "statement")
#: Where in a source a claim stands: its row says it.
_PLACE = re.compile(
    r"(?:, and|,| of)? (?:figs?\.|sections?|Table) [\d.]+(?: and [\d.]+|-\d+)?[abc]?(?=$|,|:)|,? \[\d{4}\]"
)


def counts() -> str:
    """Write how many rows of each source hold; numbers that take part in a fit stand apart from predictions."""
    found = {source: [claim for _, claim in claims(source)] for source in TITLES}
    head = ("source", "equations", "numbers, fitted", "numbers, predicted", "statements", "open", "not judged")
    rows = [[f"[{title}]({link})", *_counts(found[source])] for source, (title, link) in TITLES.items()]
    numbers = [claim for source in found.values() for claim in judged(source) if claim.kind == "number"]
    predicted = [claim for claim in numbers if not claim.fitted]
    return f"""{table(head, rows)}
Numbers that hold: {_held(numbers)}; of these without a fit: {_held(predicted)}."""


def causes(source: str) -> str:
    """List the claims of a source with their causes, by section; claims with one cause share a line."""
    sections: dict[str, list[Claim]] = {}
    for name, claim in claims(source):
        sections.setdefault(name, []).append(claim)
    return "".join(_section(f"{source}.{name}", found) for name, found in sections.items())


def judged(found: Sequence[Claim]) -> list[Claim]:
    """Select the claims of a source that have a verdict."""
    return [claim for claim in found if claim.numbers and not claim.trial]


def _counts(found: Sequence[Claim]) -> list[str]:
    """Count the claims that hold of each kind, the open ones, and the rest."""
    said = judged(found)
    equations, numbers, statements = ([claim for claim in said if claim.kind == kind] for kind in KINDS)
    fits = [claim for claim in numbers if claim.fitted]
    rest = [claim for claim in numbers if not claim.fitted]
    held = [_held(part) if part else "-" for part in (equations, fits, rest, statements)]
    return [*held, str(sum(claim.is_open for claim in said)), str(len(found) - len(said))]


def _held(part: Sequence[Claim]) -> str:
    """Say how many of the claims hold."""
    return f"{sum(claim.holds for claim in part)} of {len(part)}"


def _section(name: str, found: Sequence[Claim]) -> str:
    """Write a section of the appendix."""
    said: dict[str, list[Claim]] = {}
    for claim in found:
        said.setdefault(_cause(claim, claim in judged(found)), []).append(claim)
    lines = "".join(f"- **{_names(same)}**{cause}\n" for cause, same in said.items())
    commands = dict.fromkeys(f"`{claim.stored}`" for claim in found if claim.stored)
    stored = f"Stored: {', '.join(commands)}.\n\n" if commands else ""
    return f"### {name}\n\n{stored}{lines}\n"


def _cause(claim: Claim, on_page: bool) -> str:
    """Say why a claim has its verdict; numbers that no page has stand before."""
    marks = ", ".join(mark for mark, true in (("trial", claim.trial), ("stored", claim.stored)) if true)
    numbers = "" if on_page else f" {claim.printed}; ours {claim.ours}: *{claim.verdict}*;"
    missing = f". *Missing:* {claim.unless}" if claim.unless else ""
    return f"{f' ({marks})' if marks else ''}:{numbers} {claim.why}{missing}."


def _names(found: Sequence[Claim]) -> str:
    """Name claims; say the beginning that neighbours share up to a comma or colon once."""
    short: list[str] = []
    last = ""
    for name in (_PLACE.sub("", claim.claim) if claim.numbers else claim.claim for claim in found):
        stem = next((name[: name.index(mark) + 1] for mark in (":", ",") if mark in name), "")
        if stem and stem == last:
            short[-1] += f",{name.removeprefix(stem)}"
        else:
            short.append(name)
        last = stem
    return "; ".join(short)
