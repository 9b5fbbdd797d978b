"""`verify`: an optimum run again on Drake at a tighter tolerance and, with dry contact, from unseen starts."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from linkages import System
from linkages.base.arguments import Count, validated
from linkages.base.brief import cell
from linkages.engines import check_engine
from linkages.input.files.writing import finite
from optim.evaluate.evaluations import INFEASIBLE, OK
from optim.evaluate.evaluator import Evaluator
from optim.evaluate.limits import in_units
from optim.evaluate.requests import Request, Statistics
from optim.evaluate.single_runs import run_on_drake
from optim.problem.schema import LIFE
from optim.problem.study import Array, Study
from optim.search import numerics
from optim.search.result import Design

_GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0  # its multiples are spread evenly, and are no fractions of a turn


@validated
def verify(
    study: Study,
    best: Design | dict[str, Any],
    threads: Count | None = None,
    progress: Callable[[float], None] | None = None,
) -> dict[str, Any]:
    """Check an optimum at a ten times tighter tolerance: on Drake, and, with dry contact, from unseen starts.

    Parameters
    ----------
    study : Study
    best : Design or dict
        The optimum, or its entry in ``result.json``.
    threads : int, optional
        Threads of the compiled engine.
    progress : callable, optional
        Called with the part of Drake's simulated time that is done.

    Returns
    -------
    dict
        ``engine``; ``status``, "ok" or why there is nothing to compare; ``objectives`` and ``constraints`` by name:
        values of the ``study`` and of ``drake``, and ``difference``, study minus Drake relative to
        Drake's (None if that is zero). ``phases``: see `unseen_phases`, None if it does not apply.

    Examples
    --------
    >>> import optim
    >>> study = optim.load_study(optim.find_study("sevenbar_force"))
    >>> report = optim.verify(study, {"status": "no-assembly"})
    >>> report["status"]
    'the optimum failed: no-assembly'
    """
    check_engine("drake")
    report: dict[str, Any] = {"engine": "drake", "tolerance": f"{numerics.VERIFICATION_TIGHTER:g} of the study's"}
    if best["status"] != OK:
        why = "violates constraints" if best["status"] == INFEASIBLE else f"failed: {best['status']}"
        return report | {"status": f"the optimum {why}", "phases": None}
    if any(term.output.startswith(LIFE) for _, _, quantity in study.quantities for term in quantity.terms or ()):
        return report | {"status": "only the compiled engine computes a service life", "phases": None}
    tighter = numerics.VERIFICATION_TIGHTER
    tight = study.replaced(lambda system: {"solver.accuracy": tighter * system.settings.accuracy})
    design = np.array([[best["variables"][path] for path in study.paths]])
    relative = any(quantity.relative for _, _, quantity in study.quantities)
    total = (2 if relative else 1) * sum(point.system.settings.duration for point in study.points)
    done = 0.0

    def engine(request: Request) -> Statistics:
        nonlocal done
        found = run_on_drake(request, progress and (lambda time: progress((done + time) / total)))
        done += len(request.values) * request.point.system.settings.duration
        return found

    evaluate = Evaluator(tight, engine=engine)
    found = evaluate(design)
    nominal = evaluate(study.nominal[None]) if relative else found
    if progress is not None:
        progress(1.0)
    for name, evaluations in (("", found), ("nominal design: ", nominal)):
        if evaluations.failed[0]:
            return report | {"status": name + evaluations.reason[0], "phases": None}
    objectives, constraints = in_units(study, found, nominal)
    report |= {
        "status": OK,
        "objectives": _compared(study, best["objectives"], objectives[0]),
        "constraints": _compared(study, best["constraints"], constraints[0]),
    }
    return report | {"phases": unseen_phases(tight, design[0], threads)}


def unseen_phases(study: Study, design: Array, threads: int | None = None) -> dict[str, Any] | None:
    """Evaluate objectives from other starts of the drives than the study's; impacts depend on where they begin.

    All drives start as they are at a later time, so that the machine passes the same positions. Returns ``angles`` by
    which the first drive is turned [rad]; for each objective values of the ``best`` design (n,) and of the ``nominal``
    one at each (undivided, if relative; None where it failed), and ``change``, that of their mean over the phases where
    neither failed. None without dry contact, or where no drive has a speed and a start angle that the design leaves.
    """
    if not all(point.system.can_touch and _turns(point.system, point.paths) for point in study.points):
        return None
    angles = [2.0 * math.pi * math.modf(k * _GOLDEN)[0] for k in range(1, numerics.VERIFICATION_PHASES + 1)]
    turned = [study.replaced(partial(_turned, angle=angle)) for angle in angles]
    designs = np.vstack([design, study.nominal])
    values = np.array([Evaluator(one, threads=threads)(designs).objectives for one in turned])
    both = np.isfinite(values).all(axis=(1, 2))
    report: dict[str, Any] = {"angles": angles, "objectives": {}}
    for k, name in enumerate(study.file.objectives):
        best, nominal = values[both, :, k].mean(axis=0) if both.any() else (math.nan, math.nan)
        report["objectives"][name] = {
            "best": [finite(x) for x in values[:, 0, k]],
            "nominal": [finite(x) for x in values[:, 1, k]],
            "change": _relative(best, nominal),
        }
    return report


def format_verification(report: dict[str, Any]) -> str:
    """Format a verification as lines of text.

    Parameters
    ----------
    report : dict
        From `optim.verify`.

    Examples
    --------
    >>> import optim
    >>> optim.format_verification({"status": "the optimum violates constraints"})
    'not verified on Drake: the optimum violates constraints'
    """
    if report["status"] != OK:
        return f"not verified on Drake: {report['status']}"
    lines = [f"{'verified on Drake':34s}{'study':>13s}{'Drake':>18s}{'difference':>13s}"]
    for kind in ("objectives", "constraints"):
        for name, entry in report[kind].items():
            difference = cell(entry["difference"], 13, ".1e")
            lines.append(f"{entry.get('label', name):34s}{entry['study']:13.5g}{entry['drake']:18.5g}{difference}")
    if report["phases"] is not None:
        head = f"from {len(report['phases']['angles'])} unseen starts"
        lines += ["", f"{head:34s}{'change of the mean':>44s}"]
        for name, entry in report["phases"]["objectives"].items():
            change = entry["change"]
            lines.append(f"{name:34s}" + (f"{'-':>44s}" if change is None else f"{100.0 * change:+43.1f}%"))
    return "\n".join(lines)


def _turns(system: System, paths: tuple[str, ...]) -> bool:
    """Whether there are drives of constant speed, and no design sets where they start."""
    speeds = [drive.speed for drive in system.drives.values() if drive.prescribed]
    return bool(speeds) and all(speeds) and not any(path.startswith("drives.") for path in paths)


def _turned(system: System, angle: float) -> dict[str, Any]:
    """Start angles after the first drive has turned by an angle."""
    drives = {name: drive for name, drive in system.drives.items() if drive.prescribed}
    first = next(iter(drives.values())).speed or 0.0
    return {
        f"drives.{name}.angle": drive.angle + angle * (drive.speed or 0.0) / first for name, drive in drives.items()
    }


def _compared(study: Study, before: dict[str, float], drake: Array) -> dict[str, Any]:
    return {
        name: {"label": study.label(name), "study": value, "drake": float(x), "difference": _relative(value, float(x))}
        for (name, value), x in zip(before.items(), drake, strict=True)
    }


def _relative(value: float, reference: float) -> float | None:
    """Return (value - reference)/|reference|, or None where that is no number."""
    return finite((value - reference) / abs(reference)) if reference else None
