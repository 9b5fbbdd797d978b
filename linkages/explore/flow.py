"""A run of the compiled engine that stops where it is told and goes on from there."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from linkages.engines.compiled.replay import Steps
from linkages.engines.compiled.runner import STATUS, Machine, join
from linkages.errors import InputError, Status, nearest
from linkages.integrate.driver import DONE, PAUSED
from linkages.model.experiment import Experiment
from linkages.model.mechanism import Mechanism
from linkages.outputs.columns import Columns, columns_from_states, point_columns
from linkages.planar.contacts import CLEARANCE_OUTPUTS
from linkages.planar.kinematics import spread
from linkages.system.assembly import Assembly, assemble

Array = NDArray[np.float64]

_MOST = 20_000  # steps between two looks at the keyboard
_OF_CONTACTS = ("ex", "ey", "penetration", "closing", "sliding")  # as `CLEARANCE_OUTPUTS` names them


class Flow:
    """A run that can be stopped, continued, and put elsewhere.

    Attributes
    ----------
    t : float
        Time reached [s].
    y : (ny,) array
        State: positions and rates of the free coordinates, then bristles; see `linkages.engines.compiled.model.Model`.
    scale : (ny,) array
        What an error of each entry is measured by.
    status : Status
        OK as long as the run can go on.

    Raises
    ------
    AssemblyError, InputError
        As `linkages.system.assembly.assemble`.
    """

    def __init__(
        self, mechanism: Mechanism, experiment: Experiment, assembly: Assembly | None = None
    ) -> None:
        self.mechanism, self.experiment = mechanism, experiment
        self.assembly = assembly or assemble(mechanism, experiment)
        self._machine = Machine(self.assembly, experiment)
        self.y = self._machine.start
        self.t, self.status = 0.0, Status.OK
        self._step = self._machine.first_step

    @property
    def scale(self) -> Array:
        """What an error of each entry of the state is measured by."""
        return self._machine.model.scale

    def advance(self, until: float) -> Steps:
        """Go on up to a time, or to where the run fails; returns the steps taken."""
        parts = []
        code = PAUSED
        while code == PAUSED:
            part = self._machine.run(self.t, self.y, self._step, _MOST, until)
            parts.append(part)
            self.t, self.y, self._step = float(part.times[-1]), part.states[-1].copy(), part.next_step
            code = part.status
        if code != DONE:
            self.status = STATUS[code]
        return join(parts)

    def put(self, y: Array, other: Flow) -> None:
        """Put the run at the time of another one, into a state close to the other's.

        What contacts remember is taken from the other as it is.
        """
        self.t, self.y, self._step = other.t, y, other._step
        machine = self._machine
        machine.memory[:] = other._machine.memory
        contacts = machine.evaluate(self.here(), np.array([self.t]))[3]
        depth = contacts[0, :, CLEARANCE_OUTPUTS.index("penetration")]
        machine.modes[:] = np.where((machine.model.touching == 1) & (depth > 0.0), 1, -1)

    def here(self) -> Steps:
        """Return the state reached as a piece without steps."""
        return Steps(np.array([self.t]), self.y[None, :].copy(), self._machine.memory[:, 0][None, :].copy())

    def columns(self, piece: Steps, times: Array, names: Sequence[str] | None = None) -> Columns:
        """Columns (see `linkages.outputs.columns`) at times within a piece: all of them, or at least those that are named.

        Contacts' and points' columns are cheap, others need the reactions of all joints.
        """
        tree = self.assembly.tree
        q, v, a, contacts = self._machine.evaluate(piece, times)
        found: Columns = {"time": times}
        for name in names or ():
            column, point = self._of_contact(name, contacts), name.rpartition(".")[0]
            if column is not None:
                found[name] = column
            elif point in self.mechanism.point and name not in found:
                found |= self._of_point(point, q, v, a)
        if names is None or any(name not in found for name in names):
            clearance = contacts if tree.contacts else None
            found = columns_from_states(tree, self.experiment, times, q, v, a, clearance)
        return found

    def check_names(self, names: Sequence[str]) -> None:
        """Check that columns of these names exist.

        Raises
        ------
        InputError
            If one does not.
        """
        known = self.columns(self.here(), np.array([self.t]))
        for name in names:
            if name not in known:
                raise InputError("output", name, f"is unknown; {nearest(name, known)}")

    def _of_contact(self, name: str, contacts: Array) -> Array | None:
        """Column of a contact; None if the name is not one."""
        label, _, quantity = name.rpartition(".")
        labels = [own for _, own in self.assembly.tree.contacts]
        if label not in labels:
            return None
        k = labels.index(label)
        if quantity == "force":
            return np.hypot(contacts[:, k, 2], contacts[:, k, 3])
        depth = contacts[:, k, CLEARANCE_OUTPUTS.index("penetration")]
        if quantity == "eccentricity_ratio":
            return 1.0 + depth / float(self._machine.model.laws["clearance"][k])
        return contacts[:, k, CLEARANCE_OUTPUTS.index(quantity)] if quantity in _OF_CONTACTS else None

    def _of_point(self, point: str, q: Array, v: Array, a: Array) -> Columns:
        tree = self.assembly.tree
        nt, nb = len(q), len(tree.bodies)
        pose, vel, acc = np.empty((nt, nb, 5)), np.empty((nt, nb, 3)), np.empty((nt, nb, 3))
        spread(tree.bodies, q, v, a, pose, vel, acc)
        return point_columns(tree, point, pose, vel, acc)


def period_of(experiment: Experiment, drive: str | None = None) -> float:
    """Time of a revolution of the named drive, or of the first one of constant speed [s].

    Raises
    ------
    InputError
        If there is no such drive, or none of constant speed.
    """
    turning = {name: d.speed for name, d in experiment.drives.items() if d.prescribed and d.speed}
    if drive is not None and drive not in turning:
        raise InputError("drive", drive, f"has no constant speed; {nearest(drive, turning)}")
    if not turning:
        raise InputError(experiment.source, "drives", "none has a constant speed: there is no revolution")
    speed = turning[drive] if drive is not None else next(iter(turning.values()))
    return float(2.0 * np.pi / abs(speed))


def lasting(experiment: Experiment, revolutions: float, drive: str | None = None) -> Experiment:
    """Return the same experiment with the duration of so many revolutions."""
    return experiment.replaced({"duration": revolutions * period_of(experiment, drive)})
