"""Write the list of keys in docs/study_files.md: ``python docs/make_optimisation.py``."""

from __future__ import annotations

from pathlib import Path

from make_experiment import lines

from linkages.input.files.table_keys import table_keys
from optim.problem.schema import StudyFile

PAGE = Path(__file__).with_name("study_files.md")
MARK = "## All keys\n\n"


def page(text: str) -> str:
    """Return the page with a fresh list."""
    return text.split(MARK)[0] + MARK + lines(table_keys(StudyFile))


if __name__ == "__main__":
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
