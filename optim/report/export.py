"""The store of a study as a few lines of text; every evaluation in it as a table: CSV or Parquet."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from linkages import InputError
from linkages.input.files.table_formats import write_csv, write_parquet
from linkages.input.files.writing import whole
from linkages.input.model.experiment import value_unit
from optim.evaluate.evaluations import INFEASIBLE
from optim.store.store import Store


def format_store(store: Store) -> str:
    """Format the content of a store: study, progress, failures."""
    task = store.meta("task")
    count, failures = store.count()
    unrun = failures.pop(INFEASIBLE, 0)
    rows = store.iterations()
    lines = [
        f"{store.path}: {task['algorithm']['name']}, seed {task['seed']}",
        f"variables:   {', '.join(f'{path} [{u}]' if (u := value_unit(path)) else path for path in store.variables)}",
        f"objectives:  {', '.join(store.objectives)}",
        f"constraints: {', '.join(store.constraints) or 'none'}",
        f"evaluations: {count}, of which failed: {sum(failures.values())}"
        + "".join(f"; {n} {status}" for status, n in failures.items())
        + (f"; infeasible, not run: {unrun}" if unrun else ""),
        f"time:        {store.meta('elapsed'):.1f} s",
        f"versions:    {', '.join(f'{name} {version}' for name, version in store.meta('versions').items())}",
    ]
    if failures:
        found = store.evaluations()[1]
        first = next(k for k, status in enumerate(found.status) if status in failures)
        lines.append(f"first failure: {found.status[first]}: {found.reason[first]}")
    lines += ["", f"{'iteration':>10s}{'evaluations':>13s}{'violation':>12s}  best (smaller is better)"]
    step = max(1, len(rows) // 20)
    for row in [*rows[:-1:step], *rows[-1:]]:
        values = ", ".join(f"{value:.6g}" for value in row.objectives.min(axis=0))
        lines.append(f"{row.iteration:10d}{row.evaluations:13d}{row.violation.min():12.3g}  {values}")
    return "\n".join(lines)


def export(store: Store, path: Path) -> int:
    """Write every design: variables, objectives and constraints (in the study's units), status, reason.

    Parameters
    ----------
    path : Path
        A ``.csv``, whose numbers read back exactly, or a ``.parquet`` file; written whole or not at all.

    Returns
    -------
    int
        The number of designs.

    Raises
    ------
    InputError
        If the file's kind is unknown, or Parquet needs a package that is not there.
    RunError
        If it cannot be written.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import optim
    >>> study = optim.load_study(optim.find_study("sevenbar_force"))
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> few = {"name": "ga", "population": 4, "generations": 1}
    >>> result = optim.optimise(study, folder / "study.sqlite", algorithm=few)
    >>> with optim.read_store(folder / "study.sqlite") as store:
    ...     optim.export(store, folder / "designs.csv") == result["evaluations"]
    True
    """
    if path.suffix not in (".csv", ".parquet"):
        raise InputError("--out", str(path), "write a name that ends with .csv or .parquet")
    designs, found = store.evaluations()
    numbers = np.column_stack([designs, found.objectives, found.constraints])
    kinds = {"variable": store.variables, "objective": store.objectives, "constraint": store.constraints}
    names = [f"{kind}:{name}" for kind, those in kinds.items() for name in those]
    columns = dict(zip(names, numbers.T, strict=True))
    columns |= {"status": np.array(found.status, dtype=object), "reason": np.array(found.reason, dtype=object)}
    write = write_csv if path.suffix == ".csv" else write_parquet
    with whole(path) as partial:
        write(partial, columns, {}, {})
    return len(designs)
