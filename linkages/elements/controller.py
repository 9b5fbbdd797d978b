"""A controller: PID, or a registered function in Python; its output is for formulas of other elements."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal

from pydantic import Field

from linkages.base.errors import nearest
from linkages.elements.analysis import SAMPLED, Analysis, Refusal
from linkages.elements.element import Checks, Element, IdealEffort
from linkages.input.files.toml import Finite, NonNegative, Positive, Table, TwoOf
from linkages.input.functions.definitions import Call, Definition, Quantity, constant, formula, named
from linkages.input.functions.own_quantities import OwnQuantities
from linkages.laws.control import CONTROLLERS

#: Feedforward of controllers that is computed.
IDEAL_TORQUE = "ideal-torque"

_NEEDED = {"pid": ("signal", "reference"), "python": ("function", "sample_time")}
_OF_PYTHON = ("function", "inputs", "parameters", "memory")


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


def check(controller: Controller, checks: Checks) -> None:
    """Refuse a name that formulas cannot have, and a computed feedforward in a joint that is not free."""
    checks.name_for_formulas()
    if controller.joint is not None:
        checks.over_time("reference", controller.reference)
        if not checks.is_free(checks.moving(controller.joint)):
            checks.refuse("joint", f'"{controller.joint}" must be ideal, without a prescribed motion')


def quantities(controller: Controller, name: str) -> dict[str, Quantity]:
    """Return the controller's quantities by name."""
    function = controller.function
    return _calls(controller, name, function) if function is not None else _pid(controller, name)


def _calls(controller: Controller, name: str, function: str) -> dict[str, Quantity]:
    """Return the inputs and parameters of a function, its output and its memory."""
    found = {key: Quantity(Definition(formula(text))) for key, text in controller.inputs.items()}
    found |= {key: constant(key, one) for key, one in controller.parameters.items()}
    names = CONTROLLERS[function].names
    starts = {"output": 0.0} | {key: controller.memory[key] for key in names if key in controller.memory}
    call = Call(function, tuple(f"{name}.{key}" for key in names), len(starts))
    for key, start in starts.items():
        own = call._replace(results=len(starts) if key == "output" else 0)
        found[key] = Quantity(named(f"{name}.{key}"), True, start, 1.0, controller.sample_time or 0.0, own)
    return {f"{name}.{key}": one for key, one in found.items()}


def _pid(controller: Controller, name: str) -> dict[str, Quantity]:
    numbers = {key: getattr(controller, key) for key in ("proportional", "integral", "derivative", "filter_time")}
    low, high = controller.limits or (0.0, 0.0)
    period, tracking = controller.sample_time or 0.0, controller.tracking or 1.0
    own = OwnQuantities(name, {**numbers, "low": low, "high": high, "T": period, "tracking": tracking})
    base = (controller.feedforward or "0").replace(IDEAL_TORQUE, "0")  # a table replaces it
    for key, text in (("signal", controller.signal or ""), ("reference", controller.reference or ""), ("base", base)):
        own.found[f"{name}.{key}"] = Quantity(Definition(formula(text)))
    own.add("error", "own_reference - own_signal")
    terms = ["proportional*own_error", "own_base"]
    held = "min(max(own_wanted, low), high)" if controller.limits else "own_wanted"
    if controller.integral:
        change = "integral*own_error" + (f" + ({held} - own_wanted)/tracking" if controller.limits else "")
        terms.append("own_integral")
        own.state("integral", f"own_integral + T*({change})" if period else change, 0.0, period)
    if controller.derivative and period:
        change = "own_sampled*(own_error - own_error_before)"  # no error is known before the first sample
        own.add("slope", f"(filter_time*own_slope_before + {change})/(filter_time + T)")
        own.state("sampled", "1", 0.0, period)
        own.state("slope_before", "own_slope", 0.0, period)
        own.state("error_before", "own_error", 0.0, period)
        terms.append("derivative*own_slope")
    elif controller.derivative:
        own.add("slope", "(own_error - own_lag)/filter_time")
        own.state("lag", "own_slope", 0.0)
        terms.append("derivative*own_slope")
    own.add("wanted", " + ".join(terms))
    if period:
        own.state("output", held, 0.0, period)
    else:
        own.add("output", held)
    return own.found


def ideal_efforts(controller: Controller, name: str) -> Iterable[IdealEffort]:
    """Yield the computed feedforward."""
    if controller.feedforward == IDEAL_TORQUE:
        yield IdealEffort(f"{name}.base", "feedforward", controller.joint or "", controller.reference or "")


CONTROLLER = Element(
    table="controllers",
    keys=Controller,
    check=check,
    quantities=quantities,
    own={
        "error": "reference less signal []",
        "output": "output, within its limits []",
        "integral": "integral part of the output []",
    },
    ideal_efforts=ideal_efforts,
    unsupported=(
        SAMPLED,
        Refusal(
            "function",
            lambda controller: controller.function is not None,
            {Analysis.DERIVATIVES: "is in Python, which has no derivatives; give the controller by formulas of states"},
        ),
    ),
)
