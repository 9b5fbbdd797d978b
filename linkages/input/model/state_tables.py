"""additional states, motors and controllers: tables, and the quantities that they define.

Motors and controllers are no further mechanisms: they are formulas and states. A quantity is a state, continuous with a
formula of its rate or sampled with one of its next value, or a formula alone. Other formulas have its name.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Literal

from pydantic import Field

from linkages.base.errors import nearest
from linkages.input.files.formula import parse
from linkages.input.files.toml import Finite, NonNegative, Positive, Table, TwoOf, check_increasing
from linkages.input.functions.definitions import Call, Definition, Quantity, constant, formula, named
from linkages.laws.control import CONTROLLERS

#: Feedforward of controllers that is computed.
IDEAL_TORQUE = "ideal-torque"


class State(Table):
    """An additional state z: dz/dt = rate, or at each sampling instant z = next.

    Formulas have the time t, positions and speeds, and the names of states. Sampled states keep their values between
    the instants 0, T, 2 T, ...; all that are due change at once, from the values before.
    """

    rate: str | None = Field(None, description="its rate: a formula of t, positions, speeds and states, in SI units")
    next: str | None = Field(None, description="instead: its next value at each sampling instant, the same")
    sample_time: Positive | None = Field(None, description="time between two sampling instants of `next` [s]")
    start: Finite = Field(0.0, description="value at t = 0, before the first sampling instant, in SI units")
    scale: Positive = Field(1.0, description="magnitude in parts of which its error is controlled, in SI units")
    unit: str = Field("", description="its unit, for tables and figures")

    def _complete(self) -> None:
        if (self.rate is None) == (self.next is None):
            raise ValueError("give either rate, or next with sample_time")
        if (self.next is None) != (self.sample_time is None):
            raise ValueError("next and sample_time belong together")
        formula(self.rate or self.next or "")

    def quantities(self, name: str) -> dict[str, Quantity]:
        """Return the state by its name."""
        given = Definition(formula(self.rate or self.next or ""))
        return {name: Quantity(given, True, self.start, self.scale, self.sample_time or 0.0)}


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

    def quantities(self, name: str) -> dict[str, Quantity]:
        """Return the motor's quantities by name."""
        numbers = {key: value for key, value in dict(self).items() if isinstance(value, float)}
        numbers["back_emf"] = self.torque_constant or 0.0 if self.back_emf is None else self.back_emf
        own = _Own(name, {**numbers, "rate": f"{self.joint}.rate"})
        own.add("speed", "ratio*rate")
        if self.kind == "dc":
            if self.formula is not None:
                own.found[f"{name}.voltage"] = Quantity(Definition(formula(self.formula)))
            else:
                own.add("voltage", "applied", applied=self.voltage)
            if self.inductance is not None:
                change = "(own_voltage - resistance*own_current - back_emf*own_speed)/inductance"
                own.state("current", change, self.current)
            else:
                own.add("current", "(own_voltage - back_emf*own_speed)/resistance")
            own.add("electrical_power", "own_voltage*own_current")
            own.add("shaft_torque", "torque_constant*own_current - viscous*own_speed")
            lost = "resistance*own_current**2"
            if self.heated:
                change = f"({lost} - (own_temperature - surroundings)/thermal_resistance)/thermal_capacity"
                own.state("temperature", change, self.surroundings)
        elif self.kind == "induction":
            own.add("slip", "1 - own_speed/synchronous_speed")
            kloss = "2*breakdown_torque*own_slip*breakdown_slip/(own_slip**2 + breakdown_slip**2)"
            own.add("electrical_power", f"{kloss}*synchronous_speed")
            own.add("shaft_torque", "own_electrical_power/synchronous_speed - viscous*own_speed")
            lost = "own_electrical_power*own_slip"
        else:
            own.add("drawn_torque", "own_speed", table=(self.speeds or [], self.torques or []))
            own.add("electrical_power", "own_drawn_torque*own_speed")
            own.add("shaft_torque", "own_drawn_torque - viscous*own_speed")
            lost = "0"
        own.add("gear_torque", "(1 - efficiency)*abs(own_shaft_torque)*tanh(own_speed/efficiency_speed)")
        own.add("torque", "ratio*(own_shaft_torque - own_gear_torque)")
        own.add("losses", f"{lost} + viscous*own_speed**2 + own_gear_torque*own_speed")
        own.state("energy", "own_electrical_power", 0.0)
        return own.found


_NEEDS = {
    "dc": ("resistance", "torque_constant"),
    "induction": ("breakdown_torque", "breakdown_slip", "synchronous_speed"),
    "curve": ("speeds", "torques"),
}
_OF_DC = ("voltage", "formula", "inductance", "back_emf", "thermal_resistance", "thermal_capacity")


class Controller(Table):
    """A controller: PID, or a registered function in Python, `linkages.laws.register_controller`.

    PID: with the error e = reference - signal, u = K_p e + K_i integral(e) + K_d de/dt + feedforward.

    The output is u within its limits. Anti-windup is back-calculation: the integral part changes at the rate
    K_i e + (output - u)/tracking_time. The derivative acts on the error, filtered by a lag of filter_time. With a
    sampling time T the parts follow from the backward difference of the filtered derivative and the forward difference
    of the integral part, and the output is held between the instants 0, T, 2 T, ...

    At t = 0 the integral part is 0. A sampled controller knows no error before its first one, so its first difference
    is 0. The lag of a continuous one starts at 0: it takes the error at t = 0 as a step of this height.
    """

    kind: Literal["pid", "python"] = Field(description="kind of controller")
    signal: str | None = Field(
        None, description="pid: measured value: a formula of t, positions, speeds and states, such as O.rate"
    )
    reference: str | None = Field(None, description="pid: wanted value: a formula, the same")
    function: str | None = Field(
        None, description="python: name of a registered function of the time, inputs, parameters and memory"
    )
    inputs: dict[str, str] = Field({}, description="python: formulas by the names of the function's parameters")
    parameters: dict[str, Finite] = Field({}, description="python: numbers by the same, in SI units")
    memory: dict[str, Finite] = Field({}, description="python: its memory by the same: values at t = 0, in SI units")
    proportional: Finite = Field(0.0, description="K_p, output per error, in SI units")
    integral: Finite = Field(0.0, description="K_i, rate of the output per error, in SI units")
    derivative: Finite = Field(0.0, description="K_d, output per rate of the error, in SI units")
    filter_time: NonNegative = Field(
        0.0, description="time constant of the derivative's filter; needed with `derivative` without sampling [s]"
    )
    sample_time: Positive | None = Field(None, description="time between samples; pid: by default it is continuous [s]")
    limits: TwoOf[Finite] | None = Field(None, description="least and largest output, in SI units")
    tracking_time: Positive | None = Field(
        None, description="time constant of the anti-windup; default: K_p/K_i, or with K_p = 0 the sampling time [s]"
    )
    feedforward: str | None = Field(
        None,
        description='output without an error: a formula, or "ideal-torque": the torque (prismatic: force) that moves'
        " the machine with ideal joints along the reference; default: 0",
    )
    joint: str | None = Field(None, description="ideal-torque: joint whose coordinate the reference gives over time")

    def _complete(self) -> None:
        own = _NEEDED[self.kind]
        for key in own:
            if getattr(self, key) is None:
                raise ValueError(f'{key} is missing: kind "{self.kind}" needs {" and ".join(own)}')
        for key in sorted(self.model_fields_set - {"kind", "sample_time"}):
            if (kind := "python" if key in _OF_PYTHON else "pid") != self.kind:
                raise ValueError(f'{key} belongs to kind "{kind}"; remove it')
        if self.function is not None:
            self._check_names(self.function)
        for text in (self.signal, self.reference, self.feedforward, *self.inputs.values()):
            if text is not None and text != IDEAL_TORQUE:
                formula(text)
        if (self.feedforward == IDEAL_TORQUE) != (self.joint is not None):
            raise ValueError(f'feedforward = "{IDEAL_TORQUE}" and joint belong together')
        if self.joint is not None and self.reference is not None:
            formula(self.reference, of_state=False)
        if self.limits is not None and not self.limits[0] < self.limits[1]:
            raise ValueError("limits must increase: the least output, then the largest")
        if self.derivative and self.sample_time is None and not self.filter_time:
            raise ValueError("filter_time is missing: without sample_time the derivative needs a filter [s]")
        if self.limits is not None and self.integral and self.tracking is None:
            raise ValueError("tracking_time is missing: without proportional and sample_time it has no default [s]")

    def _check_names(self, function: str) -> None:
        if function not in CONTROLLERS:
            remedy = f"call linkages.laws.register_controller before; {nearest(function, CONTROLLERS)}"
            raise ValueError(f'function "{function}" is not registered in this process: {remedy}')
        wanted = CONTROLLERS[function].names
        given = [*self.inputs, *self.parameters, *self.memory]
        if sorted(given) != sorted(wanted) or "output" in wanted:
            found = f"inputs, parameters and memory give {', '.join(given) or 'nothing'}"
            problem = 'a name cannot be "output"' if "output" in wanted else "they must be the same"
            raise ValueError(
                f'function "{function}" takes (t{"".join(f", {one}" for one in wanted)}); {found}; {problem}'
            )

    @property
    def tracking(self) -> float | None:
        """Return the time constant of the anti-windup [s]; None without one."""
        if self.tracking_time is not None or not self.integral:
            return self.tracking_time
        return abs(self.proportional / self.integral) or self.sample_time

    def quantities(self, name: str) -> dict[str, Quantity]:
        """Return the controller's quantities by name."""
        return self._calls(name, self.function) if self.function is not None else self._pid(name)

    def _calls(self, name: str, function: str) -> dict[str, Quantity]:
        """Return the inputs and parameters of a function, its output and its memory."""
        found = {key: Quantity(Definition(formula(text))) for key, text in self.inputs.items()}
        found |= {key: constant(key, one) for key, one in self.parameters.items()}
        names = CONTROLLERS[function].names
        starts = {"output": 0.0} | {key: self.memory[key] for key in names if key in self.memory}
        call = Call(function, tuple(f"{name}.{key}" for key in names), len(starts))
        for key, start in starts.items():
            own = call._replace(results=len(starts) if key == "output" else 0)
            found[key] = Quantity(named(f"{name}.{key}"), True, start, 1.0, self.sample_time or 0.0, own)
        return {f"{name}.{key}": one for key, one in found.items()}

    def _pid(self, name: str) -> dict[str, Quantity]:
        numbers = {key: getattr(self, key) for key in ("proportional", "integral", "derivative", "filter_time")}
        low, high = self.limits or (0.0, 0.0)
        period = self.sample_time or 0.0
        own = _Own(name, {**numbers, "low": low, "high": high, "T": period, "tracking": self.tracking or 1.0})
        base = (self.feedforward or "0").replace(IDEAL_TORQUE, "0")  # a table replaces it
        for key, text in (("signal", self.signal or ""), ("reference", self.reference or ""), ("base", base)):
            own.found[f"{name}.{key}"] = Quantity(Definition(formula(text)))
        own.add("error", "own_reference - own_signal")
        terms = ["proportional*own_error", "own_base"]
        held = "min(max(own_wanted, low), high)" if self.limits else "own_wanted"
        if self.integral:
            change = "integral*own_error" + (f" + ({held} - own_wanted)/tracking" if self.limits else "")
            terms.append("own_integral")
            own.state("integral", f"own_integral + T*({change})" if period else change, 0.0, period)
        if self.derivative and period:
            change = "own_sampled*(own_error - own_error_before)"  # no error is known before the first sample
            own.add("slope", f"(filter_time*own_slope_before + {change})/(filter_time + T)")
            own.state("sampled", "1", 0.0, period)
            own.state("slope_before", "own_slope", 0.0, period)
            own.state("error_before", "own_error", 0.0, period)
            terms.append("derivative*own_slope")
        elif self.derivative:
            own.add("slope", "(own_error - own_lag)/filter_time")
            own.state("lag", "own_slope", 0.0)
            terms.append("derivative*own_slope")
        own.add("wanted", " + ".join(terms))
        if period:
            own.state("output", held, 0.0, period)
        else:
            own.add("output", held)
        return own.found


_NEEDED = {"pid": ("signal", "reference"), "python": ("function", "sample_time")}
_OF_PYTHON = ("function", "inputs", "parameters", "memory")


class _Own:
    """Collects the quantities of an element: formulas of its numbers, its signals, and its quantities ``own_NAME``."""

    def __init__(self, name: str, names: Mapping[str, float | str]) -> None:
        self.name, self.names = name, names
        self.found: dict[str, Quantity] = {}

    def _definition(self, text: str, **more: float | None) -> Definition:
        given = parse(text)
        own = {one: f"{self.name}.{one.removeprefix('own_')}" for one in given.names if one.startswith("own_")}
        added = {key: value for key, value in more.items() if value is not None}
        return Definition(given, {**self.names, **own, **added})

    def add(
        self, key: str, text: str, table: tuple[list[float], list[float]] | None = None, **more: float | None
    ) -> None:
        """Add a formula, or a table over its value."""
        self.found[f"{self.name}.{key}"] = Quantity(self._definition(text, **more)._replace(table=table))

    def state(self, key: str, text: str, start: float, period: float = 0.0) -> None:
        """Add a state with the formula of its rate, or of its next value."""
        self.found[f"{self.name}.{key}"] = Quantity(self._definition(text), True, start, 1.0, period)
