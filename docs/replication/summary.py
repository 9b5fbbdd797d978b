"""Counts and lists of rows that follow from their verdicts, for the replication pages.

Trials, which are no claims of a source, and rows with nothing to compare are left out of all but the last column.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Sequence

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


def lists() -> str:
    """List the rows of all sources by verdict."""
    found = {source: [claim for _, claim in claims(source)] for source in TITLES}
    heads = [f"[{title}]({link})" for title, link in TITLES.values()]
    rows = [[name, *(words(found[source], choose) for source in TITLES)] for name, words, choose in _LISTS]
    return table(("", *heads), rows)


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


def _names(found: Sequence[Claim], choose: Callable[[Claim], bool]) -> list[str]:
    """Name the chosen claims; rows that go on with the one before ("the same ...") are only counted."""
    names = [claim.claim for claim in judged(found) if choose(claim)]
    return [_PLACE.sub("", name) for name in names if not name.startswith("the same")]


def _full(found: Sequence[Claim], choose: Callable[[Claim], bool]) -> str:
    """List the chosen claims; say the beginning that neighbours share up to a comma or colon once."""
    short: list[str] = []
    last = ""
    for name in _names(found, choose):
        stem = next((name[: name.index(mark) + 1] for mark in (":", ",") if mark in name), "")
        if stem and stem == last:
            short[-1] += f",{name.removeprefix(stem)}"
        else:
            short.append(name)
        last = stem
    return "; ".join(short) or "none"


def _brief(found: Sequence[Claim], choose: Callable[[Claim], bool]) -> str:
    """List the chosen claims, cut at the first comma or colon; count those that become the same."""
    names = Counter(re.split(r"[,:] ", name)[0] for name in _names(found, choose))
    return "; ".join(f"{name} ({count})" if count > 1 else name for name, count in names.items()) or "none"


#: Rows of the lists: name, how claims are listed, and which.
_LISTS = (
    ("**holds**", _brief, lambda claim: claim.holds),
    ("**holds in part, or nearly**", _full, lambda claim: not claim.holds and not claim.fails),
    ("**does not hold**", _full, lambda claim: claim.fails and not claim.is_open),
    ("**open**", _full, lambda claim: claim.is_open),
)
