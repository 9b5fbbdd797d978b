"""A motor that turns a revolute joint: direct current, induction, or a torque-speed curve.

A motor is formulas and states: its torque is a formula of its quantities, which are formulas of its numbers, of the
rate of its joint, and of its states.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from linkages.elements import torque
from linkages.elements.element import Checks, Element, Quantities, Rotor
from linkages.input.files.toml import Finite, NonNegative, Positive, Table, check_increasing
from linkages.input.functions.definitions import Definition, Quantity, formula, named
from linkages.input.functions.own_quantities import OwnQuantities

_NEEDS = {
    "dc": ("resistance", "torque_constant"),
    "induction": ("breakdown_torque", "breakdown_slip", "synchronous_speed"),
    "curve": ("speeds", "torques"),
}
_OF_DC = ("voltage", "formula", "inductance", "back_emf", "thermal_resistance", "thermal_capacity")


class Motor(Table):
    """A motor that turns a revolute joint: its shaft turns by `ratio` times the joint's coordinate.

    Direct current: U = R i + L di/dt + k_e w with the shaft's speed w, and the torque k_t i; without an inductance the
    current follows at once. Induction: Kloss' formula 2 T_k s s_k / (s^2 + s_k^2) with the slip s. Curve: a table of
    the torque over the shaft's speed. The gearbox loses (1 - efficiency) |T| tanh(w/efficiency_speed) of the torque T,
    against the motion.
    """

    joint: str = Field(description="revolute joint that it turns, from the joint's parent")
    kind: Literal["dc", "induction", "curve"] = Field(description="direct current, induction, or a torque-speed curve")
    ratio: Finite = Field(1.0, description="angle of the shaft per angle of the joint; not 0 [1]")
    voltage: Finite | None = Field(None, description="dc: constant voltage [V]")
    formula: str | None = Field(None, description="dc: voltage as a formula of t, positions, speeds and states, in V")
    resistance: Positive | None = Field(None, description="dc: resistance of the winding [ohm]")
    inductance: Positive | None = Field(None, description="dc: inductance of the winding; default: none [H]")
    torque_constant: Positive | None = Field(None, description="dc: torque per current [N m/A]")
    back_emf: NonNegative | None = Field(
        None, description="dc: voltage per speed of the shaft; default: the torque constant [V s/rad]"
    )
    current: Finite = Field(0.0, description="dc with an inductance: current at t = 0 [A]")
    breakdown_torque: Positive | None = Field(None, description="induction: largest torque [N m]")
    breakdown_slip: Positive | None = Field(None, description="induction: slip at which it acts [1]")
    synchronous_speed: Positive | None = Field(None, description="induction: speed of the shaft without slip [rad/s]")
    speeds: list[Finite] | None = Field(None, description="curve: speeds of the shaft, increasing [rad/s]")
    torques: list[Finite] | None = Field(None, description="curve: torques at `speeds`: monotone cubics [N m]")
    viscous: NonNegative = Field(0.0, description="viscous friction of the shaft [N m s/rad]")
    rotor_inertia: NonNegative = Field(
        0.0, description="moment of inertia of rotor and shaft; only for a joint of the world [kg m2]"
    )
    efficiency: Annotated[float, Field(gt=0, le=1)] = Field(1.0, description="efficiency of the gearbox [1]")
    efficiency_speed: Positive = Field(1.0, description="speed of the shaft below which its losses fade [rad/s]")
    thermal_resistance: Positive | None = Field(
        None, description="dc: from the winding to the surroundings, with thermal_capacity [K/W]"
    )
    thermal_capacity: Positive | None = Field(None, description="dc: heat capacity of the winding [J/K]")
    surroundings: Finite = Field(20.0, description="dc: temperature of the surroundings, and at t = 0 [degC]")

    def _complete(self) -> None:
        if self.ratio == 0.0:
            raise ValueError("ratio is 0; the shaft would not turn")
        own = _NEEDS[self.kind]
        for kind, keys in _NEEDS.items():
            for key in keys:
                if kind == self.kind and getattr(self, key) is None:
                    raise ValueError(f'{key} is missing: kind "{kind}" needs {", ".join(own)}')
                if kind != self.kind and getattr(self, key) is not None:
                    raise ValueError(f'{key} belongs to kind "{kind}"; remove it')
        if (self.voltage is None) == (self.formula is None) and self.kind == "dc":
            raise ValueError("give either voltage or formula")
        if self.kind != "dc" and (others := [key for key in _OF_DC if getattr(self, key) is not None]):
            raise ValueError(f'{others[0]} belongs to kind "dc"; remove it')
        if (self.thermal_resistance is None) != (self.thermal_capacity is None):
            raise ValueError("thermal_resistance and thermal_capacity belong together")
        if self.formula is not None:
            formula(self.formula)
        if self.speeds is not None:
            check_increasing("speeds", self.speeds, "torques", self.torques or [])

    @property
    def heated(self) -> bool:
        """Check whether the temperature of the winding is a state."""
        return self.thermal_resistance is not None


def check(motor: Motor, checks: Checks) -> None:
    """Refuse a joint that is not revolute or has a gearbox, and a rotor that is on a link beside the world."""
    checks.name_for_formulas()
    ends = checks.ends_of(checks.revolute("joint", motor.joint))
    if checks.has_gearbox(motor.joint):
        problem = "has a drive with backlash: give the motor a joint of its own, and a gear with backlash"
        checks.refuse("joint", f'"{motor.joint}" {problem}')
    if motor.rotor_inertia:
        if "world" not in ends:
            problem = f'needs a joint of the world, and "{motor.joint}" joins two links; add the rotor as a link'
            checks.refuse("rotor_inertia", f"{problem}, with a gear")
        if checks.has_beam(link := next(one for one in ends if one != "world")):
            checks.refuse("rotor_inertia", f'needs a link without a beam, and "{link}" has one')


def quantities(motor: Motor, name: str) -> dict[str, Quantity]:
    """Return the motor's quantities by name."""
    numbers = {key: value for key, value in dict(motor).items() if isinstance(value, float)}
    numbers["back_emf"] = motor.torque_constant or 0.0 if motor.back_emf is None else motor.back_emf
    own = OwnQuantities(name, {**numbers, "rate": f"{motor.joint}.rate"})
    own.add("speed", "ratio*rate")
    if motor.kind == "dc":
        if motor.formula is not None:
            own.found[f"{name}.voltage"] = Quantity(Definition(formula(motor.formula)))
        else:
            own.add("voltage", "applied", applied=motor.voltage)
        if motor.inductance is not None:
            change = "(own_voltage - resistance*own_current - back_emf*own_speed)/inductance"
            own.state("current", change, motor.current)
        else:
            own.add("current", "(own_voltage - back_emf*own_speed)/resistance")
        own.add("electrical_power", "own_voltage*own_current")
        own.add("shaft_torque", "torque_constant*own_current - viscous*own_speed")
        lost = "resistance*own_current**2"
        if motor.heated:
            change = f"({lost} - (own_temperature - surroundings)/thermal_resistance)/thermal_capacity"
            own.state("temperature", change, motor.surroundings)
    elif motor.kind == "induction":
        own.add("slip", "1 - own_speed/synchronous_speed")
        kloss = "2*breakdown_torque*own_slip*breakdown_slip/(own_slip**2 + breakdown_slip**2)"
        own.add("electrical_power", f"{kloss}*synchronous_speed")
        own.add("shaft_torque", "own_electrical_power/synchronous_speed - viscous*own_speed")
        lost = "own_electrical_power*own_slip"
    else:
        own.add("drawn_torque", "own_speed", table=(motor.speeds or [], motor.torques or []))
        own.add("electrical_power", "own_drawn_torque*own_speed")
        own.add("shaft_torque", "own_drawn_torque - viscous*own_speed")
        lost = "0"
    own.add("gear_torque", "(1 - efficiency)*abs(own_shaft_torque)*tanh(own_speed/efficiency_speed)")
    own.add("torque", "ratio*(own_shaft_torque - own_gear_torque)")
    own.add("losses", f"{lost} + viscous*own_speed**2 + own_gear_torque*own_speed")
    own.state("energy", "own_electrical_power", 0.0)
    return own.found


MOTOR = Element(
    table="motors",
    keys=Motor,
    check=check,
    quantities=quantities,
    own={
        "current": "current of the winding [A]",
        "voltage": "voltage at the winding [V]",
        "slip": "slip: difference of synchronous speed and speed over the first [1]",
        "speed": "speed of the shaft [rad/s]",
        "electrical_power": "electrical power; induction: in the air gap; curve: torque times speed [W]",
        "losses": "losses of the winding, of friction and of the gearbox [W]",
        "energy": "electrical energy since t = 0 [J]",
        "temperature": "temperature of the winding [degC]",
    },
    rotor=lambda motor: Rotor(motor.joint, motor.ratio**2 * motor.rotor_inertia),
    record=torque.RECORD,
    pack=lambda motor, places: torque.along(places.coordinate_of(motor.joint, ())),
    functions=lambda motor, name: {"value": [named(f"{name}.torque")]},
    act=torque.act,
    tell=torque.tell,
    outputs=(
        Quantities("MOTOR", {"torque": "torque of a motor on the joint's child, along the joint's coordinate [N m]"}),
    ),
)
