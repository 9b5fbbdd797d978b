"""Which outputs of a run a functional can look at."""

from __future__ import annotations

import numpy as np

from linkages.errors import nearest
from linkages.model.experiment import Experiment
from linkages.model.mechanism import Mechanism
from linkages.outputs.columns import columns_from_states
from linkages.planar.contacts import WIDTH
from linkages.system.assembly import tree_of

JITTER = ".jitter"
#: Of the linkage without clearance, see `optim.evaluate.ideal_runs`.
IDEAL, TURNING = "ideal.", "turning_rate"
_REAL = ("film_thickness", "power", "eccentricity_ratio", "ex", "ey", "penetration", "closing", "sliding")


def known_outputs(mechanism: Mechanism, experiment: Experiment) -> set[str]:
    """Columns of a run (see `linkages.outputs.columns`), film thicknesses and drive powers; `JITTER` may follow a column."""
    tree = tree_of(mechanism, experiment)
    still = np.zeros((1, tree.size))
    contacts = np.zeros((1, len(tree.contacts), WIDTH))
    columns = columns_from_states(  # of the drawn pose at rest: for their names
        tree, experiment, np.zeros(1), still, still, still, contacts, np.zeros((1, len(tree.driven)))
    )
    known = set(columns) - {"time"}
    known |= {
        f"{name}.film_thickness" for name in experiment.play if mechanism.joint[name].bearing is not None
    }
    return known | {f"{name}.power" for name in experiment.drives}


def check_output(output: str, known: set[str]) -> None:
    """Check that there is such an output.

    Raises
    ------
    ValueError
        One sentence.
    """
    if output.startswith(IDEAL):
        _check_ideal(output, known)
        return
    column = output.removesuffix(JITTER)
    if column not in known:
        owner = output.partition(".")[0]
        same = {name for name in known if name.startswith(owner + ".")}
        raise ValueError(f'"{output}" is no output; {nearest(output, same or known)}')
    if column != output and column.rpartition(".")[2] in _REAL:
        raise ValueError(f'"{output}": the ideal linkage has no such value to be compared with')


def _check_ideal(output: str, known: set[str]) -> None:
    column = output.removeprefix(IDEAL)
    owner, _, what = column.rpartition(".")
    if what in _REAL or column.endswith(JITTER):
        raise ValueError(f'"{output}": the ideal linkage has no such value')
    there = known | {name.removesuffix("fx") + TURNING for name in known if name.endswith(".fx")}
    if column not in there:
        same = {IDEAL + name for name in there if name.startswith(owner + ".")}
        raise ValueError(f'"{output}" is no output; {nearest(output, same or there)}')
