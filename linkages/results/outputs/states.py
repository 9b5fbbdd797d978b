"""Outputs of additional states, of motors and of controllers: the values of their quantities."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from linkages.results.outputs.joints import load_value
from linkages.results.outputs.quantity import OutputPlace, Owner, quantities
from linkages.system import System


def _at(key: str) -> Callable[[System, str], OutputPlace]:
    """Return a function that gives the place of a quantity, ``NAME.key`` or the state's own."""

    def place(system: System, name: str) -> OutputPlace:
        known = list(system.quantities)
        return OutputPlace(len(system.named_loads) + known.index(f"{name}.{key}" if key else name))

    return place


def _having(table: str, key: str) -> Callable[[System], Iterable[str]]:
    """List the motors or controllers that have a quantity."""
    return lambda system: [name for name in system.parts[table] if f"{name}.{key}" in system.quantities]


def _owners(label: str, table: str, **texts: str) -> list[Owner]:
    """Make the owners of some quantities, one for each."""
    return [
        Owner(label, _having(table, key), _at(key), quantities(load_value, **{key: text}))
        for key, text in texts.items()
    ]


STATES = Owner("STATE", lambda system: system.parts["states"], _at(""), quantities(load_value, value="its value []"))

#: States; quantities of motors and controllers in addition to those as loads.
OWN = (
    STATES,
    *_owners(
        "MOTOR",
        "motors",
        current="current of the winding [A]",
        voltage="voltage at the winding [V]",
        slip="slip: difference of synchronous speed and speed over the first [1]",
        speed="speed of the shaft [rad/s]",
        electrical_power="electrical power; induction: in the air gap; curve: torque times speed [W]",
        losses="losses of the winding, of friction and of the gearbox [W]",
        energy="electrical energy since t = 0 [J]",
        temperature="temperature of the winding [degC]",
    ),
    *_owners(
        "CONTROLLER",
        "controllers",
        error="reference less signal []",
        output="output, within its limits []",
        integral="integral part of the output []",
    ),
)
