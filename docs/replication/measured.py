"""What takes too long to compute when a page is written, kept in ``docs/replication/measured/``, one JSON file for each program."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from linkages.input.files.writing import whole


def path_of(name: str) -> Path:
    """File of what a program measured."""
    return Path(__file__).resolve().parent / "measured" / f"{name}.json"


def read(name: str) -> dict[str, Any]:
    """Read what a program has measured; nothing, if it has not."""
    path = path_of(name)
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}


def keep(name: str, found: dict[str, Any]) -> None:
    """Write what a program has measured."""
    with whole(path_of(name)) as partial:
        partial.write_text(json.dumps(found) + "\n", encoding="utf-8")
