"""`Stepper`: the compiled engine in a closed loop of a user's own, such as a controller, an optimiser or a game."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from linkages.base.arguments import Names, validated
from linkages.base.arrays import Array, Indices
from linkages.base.errors import InputError, Status, nearest
from linkages.base.kernel.by_reference import packed
from linkages.elements.machine import KINDS, OF_ELEMENTS, record_of
from linkages.engines.compiled.run.job import MOST, make_given
from linkages.engines.compiled.run.replay import Steps
from linkages.engines.compiled.run.runner import STATUS, Runner
from linkages.engines.compiled.run.sampling import tabulate_run
from linkages.engines.numerics import STEPPING_EARLY
from linkages.mechanics.integrate.driver import PAUSED
from linkages.mechanics.planar.contact_memory import record_memory, recorded
from linkages.results.outputs.registry import default_outputs, pack
from linkages.system import System
from linkages.system.ideal_motion import cause

_KEYS = {"drives": ("torque", "force")} | {
    kind.table: (kind.applied.key,) for kind in KINDS if kind.applied is not None
}


@dataclass(frozen=True)
class StepperState:
    """A moment of a `Stepper`, to return to; it can be pickled.

    Attributes
    ----------
    time : float
        Time [s].
    state : (ny,) array
        Free coordinates, their rates, states of laws and of the experiment.
    memory, modes, sides : arrays
        Memory of the contacts.
    values : mapping
        Inputs.
    next_step : float
        Step that the engine tries next [s].
    status : Status
    """

    time: float
    state: Array
    memory: Array
    modes: Indices
    sides: Array
    values: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    next_step: float = 0.0
    status: Status = Status.OK


class _Places(NamedTuple):
    """The places of one number among the coefficients of functions: of a constant, or in formulas."""

    numbers: Array
    at: tuple[Any, ...]

    @property
    def number(self) -> float:
        """Return the number."""
        return float(self.numbers[self.at].flat[0])


class Stepper:
    """A system that runs in steps of any lengths, with inputs that are constant during a step.

    A copy, or a pickled one, continues from the same state with its own arrays.

    Parameters
    ----------
    system : System
    inputs : sequence of str
        Paths of constant torques and forces that a step may change: ``drives.A.torque``, ``drives.A.force``,
        ``torques.NAME.torque`` [N m], ``forces.NAME.force`` (two components) [N]; and of values that formulas of loads
        and states read: ``values.NAME``. They start at the file's values.
    outputs : sequence of str, optional
        Names of `outputs`; default: those of the experiment, forces and eccentricities of clearance joints, torques of
        drives.

    Attributes
    ----------
    names : tuple of str
        Names of the outputs.

    Raises
    ------
    InputError
        If an input is no constant torque, force or value of the experiment, or a value that a prescribed motion or a
        feedforward reads, or an output is unknown.

    Examples
    --------
    >>> import linkages
    >>> system = linkages.load(linkages.find_file("slider_crank_dry.toml"))
    >>> stepper = linkages.Stepper(system, outputs=["slider.x"])
    >>> start = stepper.state()
    >>> stepper.step(1e-3).value, round(stepper.outputs()["slider.x"], 3)
    ('ok', 0.161)
    >>> stepper.restore(start)
    >>> stepper.time
    0.0
    """

    @validated
    def __init__(self, system: System, inputs: Names = (), outputs: Names | None = None) -> None:
        self.system, self.inputs = system, tuple(inputs)
        self.names = default_outputs(system) if outputs is None else tuple(outputs)
        given = make_given(system, pack(system, self.names), np.zeros((0, 2)))
        own = {name: getattr(given.model, name).copy() for name in ("torque_c", "load_c")}
        self._runner = runner = Runner(system, given._replace(model=given.model._replace(**own)))
        self._places = {name: self._place(name, own) for name in self.inputs}
        self._values = {name: tuple(one.number for one in places) for name, places in self._places.items()}
        self._sides, self._found = runner.job.equations.work.kinked.sides, np.zeros((1, len(self.names)))
        moment = Steps(np.zeros(1), runner.start[None].copy(), np.zeros((1, recorded(runner.memory))))
        self._moment, self._packed = moment, packed(moment)
        self._solved, self._most = runner.job.equations.work.solved, int(given.limits[MOST])
        self._time, self._state, self._next = 0.0, runner.start.copy(), 0.0
        self._status = Status.OK

    def _place(self, path: str, own: Mapping[str, Array]) -> list[_Places]:
        """Return the places of the numbers that an input replaces."""
        system = self.system
        if path.removeprefix("values.") in system.values:
            return [_of_value(self.system, path, own["load_c"])]
        table, _, rest = path.partition(".")
        name, _, key = rest.rpartition(".")
        element = system.parts[table].get(name) if table in _KEYS else None
        if element is None or key not in _KEYS[table]:
            known = [f"{table}.{n}.{k}" for table, n, k in _constants(self.system)]
            known += [f"values.{n}" for n in system.values]
            raise InputError(system.description.source, f'input "{path}"', f"is unknown; {nearest(path, known)}")
        if getattr(element, key) is None:
            raise InputError(
                system.description.source, f'input "{path}"', f"is no constant; give {table}.{name} a {key}"
            )
        if table == "drives":
            return [_Places(own["torque_c"], (self.system.tree.powered.index(name), slice(None), -1))]
        applied = OF_ELEMENTS[table].applied
        assert applied is not None  # else it has no key
        first = int(record_of(self.system.elements, self.system.parts, table, name)[applied.field])
        return [_Places(own["load_c"], (first + i, slice(None), -1)) for i in range(len(applied.units))]

    def __reduce__(self) -> tuple[Any, ...]:
        """Copy and pickle the system, the names and the state; another stepper computes with its own arrays."""
        return _resumed, (self.system, self.inputs, self.names, self.state())

    @property
    def time(self) -> float:
        """Return the time [s]."""
        return self._time

    @property
    def status(self) -> Status:
        """Return the status of the last step."""
        return self._status

    def step(self, time: float, values: Mapping[str, float | Sequence[float]] | None = None) -> Status:
        """Run to a time [s], with new values of some inputs from the present time on.

        Where the motion ends earlier, `time` is its end and the status says why; further steps are refused.

        Raises
        ------
        InputError
            If the time is not after the present one or is after the experiment's duration, or an input is unknown or
            not finite, or the motion has ended.
        """
        if not self._time < time <= self.system.settings.duration * (1.0 + STEPPING_EARLY):
            last = self.system.settings.duration
            raise InputError("argument", "time", f"is {time:g} s; it must be after {self._time:g} s, up to {last:g} s")
        if self._status is not Status.OK:
            raise InputError("argument", "time", f"the motion ended with the status {self._status.value}; restore")
        if values:
            self._set(values)
        record = self._runner.run(self._time, self._state, self._next, self._most, time)
        self._time, self._state, self._next = float(record.times[-1]), record.states[-1], record.next_step
        status = Status.TOO_MANY_STEPS if record.status == PAUSED else STATUS[record.status]
        self._status, _ = cause(status, self.system, self._time)
        return self._status

    def _set(self, values: Mapping[str, float | Sequence[float]]) -> None:
        checked: dict[str, tuple[float, ...]] = {}
        for name, value in values.items():
            places = self._places.get(name)
            if places is None:
                raise InputError("argument", "values", f'"{name}" is no input; {nearest(name, self.inputs)}')
            numbers = np.ravel(value)
            if numbers.dtype.kind not in "fiu" or len(numbers) != len(places) or not np.isfinite(numbers).all():
                problem = f"needs {len(places)} finite number{'s'[: len(places) - 1]}; it is {value!r}"
                raise InputError("argument", f'values["{name}"]', problem)
            checked[name] = tuple(map(float, numbers.tolist()))
        for name, given in checked.items():
            for one, number in zip(self._places[name], given, strict=True):
                one.numbers[one.at] = number
        self._values |= checked
        self._solved[0] = math.nan

    def outputs(self) -> dict[str, float]:
        """Return the outputs at the present time, with the inputs of the last step, in SI units."""
        moment, runner = self._moment, self._runner
        moment.times[0], moment.states[0] = self._time, self._state
        record_memory(runner.memory, moment.memory[0])
        tabulate_run(runner.job, self._packed, moment.times, self._found)
        return dict(zip(self.names, self._found[0].tolist(), strict=True))

    def state(self) -> StepperState:
        """Return the present state; from it the same inputs give the same bits."""
        runner = self._runner
        memories = runner.memory.copy(), runner.modes.copy(), self._sides.copy()
        return StepperState(self._time, self._state.copy(), *memories, dict(self._values), self._next, self._status)

    def restore(self, state: StepperState) -> None:
        """Return to a state of this system; InputError for the state of another one."""
        runner = self._runner
        own = runner.start.shape, runner.memory.shape, self._places.keys()
        if (state.state.shape, state.memory.shape, state.values.keys()) != own:
            raise InputError("argument", "state", "is of another system, or of one with other inputs")
        self._set(state.values)
        self._solved[0] = math.nan
        runner.memory[:], runner.modes[:], self._sides[:] = state.memory, state.modes, state.sides
        self._time, self._state, self._next = state.time, state.state.copy(), state.next_step
        self._status = state.status


def _resumed(system: System, inputs: Names, outputs: Names, state: StepperState) -> Stepper:
    """Return a stepper in a state."""
    stepper = Stepper(system, inputs, outputs)
    stepper.restore(state)
    return stepper


def _of_value(system: System, path: str, numbers: Array) -> _Places:
    """Return the places of a value in formulas of loads and states: numbers that differ for the next larger value."""
    value = system.value(path)
    other = system.replaced({path: float(np.nextafter(value, math.inf))})
    index = np.nonzero(other.arrays.load_c != numbers)
    moves = any((a != b).any() for a, b in zip(system.motions.arrays, other.motions.arrays, strict=True))
    if moves or not len(index[0]) or (numbers[index] != value).any():
        problem = "is no number of a load's or state's formula alone: a motion or a feedforward reads it, or no formula"
        raise InputError(system.description.source, f'input "{path}"', problem)
    return _Places(numbers, index)


def _constants(system: System) -> list[tuple[str, str, str]]:
    """List table, name and key of the constant torques and forces of an experiment."""
    return [
        (table, name, key)
        for table, keys in _KEYS.items()
        for name, element in system.parts[table].items()
        for key in keys
        if getattr(element, key) is not None
    ]
