"""`start_of`: the answer of another study as a start, so that a cheap study can precede an expensive one."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from linkages import InputError
from linkages.base.errors import nearest
from optim.problem.study import Array, Study


def start_of(study: Study, path: Path, source: str = "--start") -> Array:
    """Read the best design of a finished study as a start for this one.

    Parameters
    ----------
    study : Study
        The study that will be solved.
    path : Path
        A ``result.json`` of ``linkages optimise``, or the folder that holds it.
    source : str
        What errors name.

    Returns
    -------
    (n,) array
        Values of this study's variables, SI units; variables that only this study has are nominal.

    Raises
    ------
    InputError
        If there is no such result, it varies what this study does not, or its design is outside the bounds here.

    Examples
    --------
    >>> import json, pathlib, tempfile
    >>> import optim
    >>> study = optim.load_study(optim.find_study("sevenbar_force"))
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "result.json"
    >>> _ = file.write_text(json.dumps({"best": {"variables": {"joints.A.viscosity": 0.3}}}))
    >>> float(optim.start_of(study, file)[-1])
    0.3
    """
    file = path / "result.json" if path.is_dir() else path
    found = _variables(file, source)
    for key in found:
        if key not in study.paths:
            near = nearest(key, study.paths)
            raise InputError(source, str(file), f"varies {key}, {study.source.name} does not; {near}")
    start = np.array([found.get(key, x) for key, x in zip(study.paths, study.nominal, strict=True)])
    for key, x, lower, upper in zip(study.paths, start, study.lower, study.upper, strict=True):
        if not lower <= x <= upper:
            here = f"in {study.source.name} between {lower:g} and {upper:g}"
            raise InputError(source, str(file), f"{key} is {x:g}, {here}")
    return start


def _variables(file: Path, source: str) -> dict[str, float]:
    """Read the best design's variables by dotted path."""
    try:
        best: Any = json.loads(file.read_text(encoding="utf-8"))["best"]
        found = {key: float(value) for key, value in best["variables"].items()}
    except OSError:
        problem = "cannot be read; give the output folder of a finished linkages optimise"
        raise InputError(source, str(file), problem) from None
    except (ValueError, KeyError, TypeError, AttributeError):
        raise InputError(source, str(file), "is not a result.json of linkages optimise") from None
    if not all(map(math.isfinite, found.values())):
        raise InputError(source, str(file), "has a value that is not finite")
    return found
