"""Write recorded designs in docs/replication/designs/: ``python docs/make_designs.py [NAME...]``, each some minutes.

Solves shipped studies, each with its own algorithm and seed. The pages that speak of these designs start from the
files: run the pages' scripts afterwards. ``--drake NAME`` adds the objectives by Drake to a record that there is,
``--spread NAME`` the range of its one objective over tolerances and rounding.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from replication.recorded import generations, load_record, save, write_record

from optim import Evaluator, find_study, load_study, optimise
from optim.evaluate.single_runs import run_on_drake

STUDIES = (
    "sevenbar_force", "sevenbar_acceleration", "sevenbar_paper_force", "sevenbar_paper_acceleration", "sevenbar_robust", "fourbar_kept", "fivebar_jitter",
    "sixbar_jitter", "sevenbar_jitter",
)  # fmt: skip


def main(names: Sequence[str]) -> None:
    """Solve the named studies, or all of `STUDIES`."""
    if names and (added := {"--drake": add_drake, "--spread": add_spread}.get(names[0])):
        for name in names[1:]:
            added(name)
        return
    for name in names or STUDIES:
        study = load_study(find_study(name))
        with tempfile.TemporaryDirectory() as folder:
            store = Path(folder) / "study.sqlite"
            result = optimise(study, store)
            write_record(study, result, f"python docs/make_designs.py {name}", generations(study, store))


def add_drake(name: str) -> None:
    """Evaluate a recorded design on Drake, and keep that."""
    record, study = load_record(name), load_study(find_study(name))
    designs = np.array([study.nominal, record.design(study)])
    before, after = Evaluator(study, engine=run_on_drake)(designs).objectives
    relative = [quantity.relative for quantity in study.file.objectives.values()]
    found = np.where(relative, after / before, after)
    drake = dict(zip(study.file.objectives, map(float, found), strict=True))
    save(record.model_copy(update={"drake": drake}))


def add_spread(name: str) -> None:
    """Evaluate the one objective of a recorded design at tolerances down to a hundredth, and keep the range.

    Rounding, here of the design in its twelfth digit, has its part: both designs are evaluated with forty of them, or with eight if the
    objective is a mean over several starts.
    """
    record, study = load_record(name), load_study(find_study(name))
    (quantity,) = study.file.objectives.values()
    count = 40 if len(study.points) == 1 else 8
    rounding = 1.0 + 1e-12 * np.random.default_rng(1).uniform(-1.0, 1.0, (count, len(study.nominal)))
    rounding[0] = 1.0  # the design itself
    found = []
    for part in (1.0, 0.5, 0.1, 0.01):
        tight = {"solver.accuracy": part * study.points[0].system.experiment.solver.accuracy}
        evaluator = Evaluator(study.replaced(lambda _, tight=tight: tight))
        before, after = (evaluator(rounding * x).objectives[:, 0] for x in (study.nominal, record.design(study)))
        found += (
            [float(after.min() / before.max()), float(after.max() / before.min())]
            if quantity.relative
            else after.tolist()
        )
    save(record.model_copy(update={"spread": [float(min(found)), float(max(found))]}))


if __name__ == "__main__":
    main(sys.argv[1:])
