"""Results that take too long to compute when a page is written, stored in ``docs/replication/computed/``, one JSON file for each program."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from linkages.input.files.writing import whole


def path_of(name: str) -> Path:
    """File of the results of a program."""
    return Path(__file__).resolve().parent / "computed" / f"{name}.json"


def read(name: str) -> dict[str, Any]:
    """Read the stored results of a program; nothing, if there are none."""
    path = path_of(name)
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}


def keep(name: str, found: dict[str, Any]) -> None:
    """Write the results of a program."""
    with whole(path_of(name)) as partial:
        partial.write_text(json.dumps(found) + "\n", encoding="utf-8")
