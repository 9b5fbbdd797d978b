"""Write the press's recorded designs in docs/replication/designs/: ``python docs/make_designs.py``, half a minute.

Solves shipped studies, each with its own algorithm and seed. The pages that speak of these designs start from the
files: run the pages' scripts afterwards.
"""

from __future__ import annotations

from replication.recorded import write_record

from optim import find_study, load_study, optimise

STUDIES = ("sevenbar_force", "sevenbar_acceleration")


if __name__ == "__main__":
    for name in STUDIES:
        study = load_study(find_study(name))
        write_record(study, optimise(study), "python docs/make_designs.py")
