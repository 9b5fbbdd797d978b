"""Messages and exit status for runs that did not reach their end."""

from __future__ import annotations

import sys
from collections.abc import Mapping

from linkages.errors import Status
from linkages.results.trajectory import Trajectory


def report_failures(runs: Mapping[str, Trajectory]) -> int:
    """Print a line on standard error for each run that did not reach its end.

    Parameters
    ----------
    runs : mapping of str to Trajectory
        Runs by their names in the messages.

    Returns
    -------
    int
        Exit status: 0 if all succeeded, 130 if one was interrupted, otherwise 1.
    """
    failed = {name: run for name, run in runs.items() if run.status is not Status.OK}
    for name, run in failed.items():
        text = f"{run.status.value}; {run.status.remedy}"
        print(f"{name} ended at t = {run.time[-1]:.6g} s{_drives(run)}: {text}", file=sys.stderr)
    if any(run.status is Status.INTERRUPTED for run in failed.values()):
        return 130
    return int(bool(failed))


def _drives(run: Trajectory) -> str:
    """Describe the positions of the drives for a run whose loops can no longer be closed."""
    if run.status not in (Status.NO_ASSEMBLY, Status.LOCKED):
        return ""
    drives = [name.removesuffix(".rate") for name in run.columns if name.endswith(".rate")]
    places = [f"{name} = {run[f'q.{name}'][-1]:.4g} {run.units.get(f'q.{name}', '')}".rstrip() for name in drives]
    return "".join(f", {place}" for place in places)
