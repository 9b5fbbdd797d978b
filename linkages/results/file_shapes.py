"""Schemas of ``wear.json`` and ``record.json``; docs/summary_json.md explains the keys."""

from __future__ import annotations

from typing import Self

from pydantic import Field, model_validator

from linkages.input.files.entry import Entry, Number
from linkages.input.files.toml import Finite
from linkages.input.model.worn import WornJoint
from linkages.results.shape import StatusName


class _WornJoint(WornJoint):
    volume: Finite
    depth: Finite
    play: Finite
    clearance: Finite
    load_distance: Finite


class _WearBlock(Entry):
    cycles: int = Field(ge=0)
    error: Number
    peaks: dict[str, Finite]
    joints: dict[str, _WornJoint]


class RecordTable(Entry):
    """A table of a report; `text` are the indices of the columns with words."""

    caption: str
    head: list[str]
    rows: list[list[str]]
    text: list[int]


class Record(Entry):
    """The schema of ``record.json``: what a command was asked and what it found.

    `table` is the text of the terminal; `tables` and the numbers of the first screen, `tiles`, are for reports.
    """

    title: str
    question: str
    answer: list[str]
    table: str
    words: list[str]
    versions: dict[str, str]
    tiles: list[list[str]] = Field(default=[])
    tables: list[RecordTable] = Field(default=[])


class WearContent(Entry):
    """The schema of ``wear.json``."""

    cycles: int = Field(ge=0)
    status: StatusName
    title: str | None
    experiment: str
    joints: dict[str, _WornJoint]
    blocks: list[_WearBlock] = Field(min_length=1)
    simulated_cycles: int = Field(ge=0)
    tolerance: Finite

    @model_validator(mode="after")
    def _is_whole(self) -> Self:
        if missing := self.blocks[0].peaks.keys() - self.blocks[-1].peaks.keys():
            raise ValueError(f"blocks: the last one has no peak of {min(missing)}")
        return self
