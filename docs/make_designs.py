"""Write the press's recorded designs in optim/designs/: ``python docs/make_designs.py``, half a minute.

Solves shipped studies, each with its own algorithm and seed. The pages that speak of these designs start from the
files: run the pages' scripts afterwards.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

from replication.recorded import write_record

from optim.evaluate.evaluator import Evaluator
from optim.evaluate.limits import in_units
from optim.problem.shipped import find_study
from optim.problem.study import load_study
from optim.search.run import run
from optim.search.task import described, task_of

STUDIES = ("sevenbar_force", "sevenbar_acceleration")


def record(name: str) -> None:
    """Solve a shipped study and keep its answer."""
    study = load_study(find_study(name))
    with tempfile.TemporaryDirectory() as folder:
        found = run(task_of(study, study.file.seed, Evaluator(study)), Path(folder) / "study.sqlite")
    objectives, _ = in_units(study, found.found, found.nominal)
    write_record(
        study, found.result.x[0], objectives[0], "python docs/make_designs.py", described(study),
        study.file.seed, found.evaluations,
    )  # fmt: skip


if __name__ == "__main__":
    for study_name in STUDIES:
        record(study_name)
