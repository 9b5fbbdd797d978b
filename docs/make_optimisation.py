"""Write the lists of keys in docs/study_files.md and docs/identification_keys.md: ``python docs/make_optimisation.py``."""

from __future__ import annotations

from pathlib import Path

from make_experiment import lines

from linkages.input.files.table_keys import table_keys
from linkages.input.files.toml import Table
from optim.identify.schema import IdentificationFile
from optim.problem.schema import StudyFile

#: Pages, and the files that their lists of keys are of.
PAGES: dict[str, type[Table]] = {"study_files.md": StudyFile, "identification_keys.md": IdentificationFile}
MARK = "## All keys\n\n"


def page(text: str, name: str = "study_files.md") -> str:
    """Return a page with a fresh list."""
    return text.split(MARK)[0] + MARK + lines(table_keys(PAGES[name]))


if __name__ == "__main__":
    for name in PAGES:
        file = Path(__file__).with_name(name)
        file.write_text(page(file.read_text(encoding="utf-8"), name), encoding="utf-8")
