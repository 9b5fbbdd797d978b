"""Every evaluation of a study as a table: CSV or Parquet."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np

from linkages import InputError
from linkages.files.writing import whole
from optim.store.store import Store


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
    names = [
        *(f"variable:{name}" for name in store.variables),
        *(f"objective:{name}" for name in store.objectives),
        *(f"constraint:{name}" for name in store.constraints),
    ]
    columns: dict[str, list[Any]] = {
        name: column.tolist() for name, column in zip(names, numbers.T, strict=True)
    }
    columns |= {"status": list(found.status), "reason": list(found.reason)}
    with whole(path) as partial:
        _write_csv(columns, partial) if path.suffix == ".csv" else _write_parquet(columns, partial)
    return len(designs)


def _write_csv(columns: dict[str, list[Any]], path: Path) -> None:
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        writer.writerows(zip(*columns.values(), strict=True))  # floats by repr: exact


def _write_parquet(columns: dict[str, list[Any]], path: Path) -> None:
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        raise InputError(
            "--out", path.suffix, 'needs pyarrow: pip install "linkages[parquet]"; or write .csv'
        ) from None
    parquet.write_table(pyarrow.table(columns), path)
