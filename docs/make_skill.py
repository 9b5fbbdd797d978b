"""Write SKILL.md, what an assistant program needs to use the package, from the page of tasks: ``python docs/make_skill.py``."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
FILE = ROOT / "SKILL.md"
START, END = "<!-- tasks: docs/make_skill.py -->", "<!-- tasks end -->"


def tasks() -> str:
    """Return both tables of the page of tasks: commands, lines of Python; links lead from the top folder."""
    text = (ROOT / "docs" / "tasks.md").read_text(encoding="utf-8")
    _, tables = text.split("\n\n", 2)[1:]
    return re.sub(r"\]\((?!http)([\w.#-]+)\)", r"](docs/\1)", tables).replace("](docs/../", "](").strip()


def page(text: str) -> str:
    """Return the page with its generated part made again."""
    before, _, rest = text.partition(START)
    return f"{before}{START}\n\n{tasks()}\n\n{END}{rest.partition(END)[2]}"


if __name__ == "__main__":
    FILE.write_text(page(FILE.read_text(encoding="utf-8")), encoding="utf-8")
