"""Write recorded designs in docs/replication/designs/: ``python docs/make_designs.py [NAME...]``, each some minutes.

Solves shipped studies, each with its own algorithm and seed. The pages that speak of these designs start from the
files: run the pages' scripts afterwards. ``--drake NAME`` adds the objectives by Drake to a record that there is.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

import numpy as np
from replication.recorded import load_record, save, write_record

from optim import Evaluator, find_study, load_study, optimise
from optim.evaluate.drake_runs import run_on_drake

STUDIES = ("sevenbar_force", "sevenbar_acceleration", "fourbar_kept", "fivebar_jitter")


def main(names: Sequence[str]) -> None:
    """Solve the named studies, or all of `STUDIES`."""
    if names[:1] == ["--drake"]:
        for name in names[1:]:
            add_drake(name)
        return
    for name in names or STUDIES:
        study = load_study(find_study(name))
        write_record(study, optimise(study), f"python docs/make_designs.py {name}")


def add_drake(name: str) -> None:
    """Evaluate a recorded design on Drake, and keep that."""
    record, study = load_record(name), load_study(find_study(name))
    designs = np.array([study.nominal, record.design(study)])
    before, after = Evaluator(study, engine=run_on_drake)(designs).objectives
    relative = [quantity.relative for quantity in study.file.objectives.values()]
    found = np.where(relative, after / before, after)
    drake = dict(zip(study.file.objectives, map(float, found), strict=True))
    save(record.model_copy(update={"drake": drake}))


if __name__ == "__main__":
    main(sys.argv[1:])
