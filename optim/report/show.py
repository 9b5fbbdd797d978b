"""The store of a study as a few lines of text."""

from __future__ import annotations

from optim.evaluate.evaluations import INFEASIBLE
from optim.store.store import Store


def format_store(store: Store) -> str:
    """Format what a store holds: the study, how far it has come, what failed."""
    task = store.meta("task")
    count, failures = store.count()
    unrun = failures.pop(INFEASIBLE, 0)
    rows = store.iterations()
    lines = [
        f"{store.path}: {task['algorithm']['name']}, seed {task['seed']}",
        f"variables:   {', '.join(store.variables)}",
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
