"""User-defined laws, registered from a script or a notebook in addition to the built-in ones.

A registered law is an ordinary entry of `CONTACTS`, `FILMS`, `FRICTIONS` or `CONTROLLERS`: experiments can name it and
set its parameters, and both engines call it by its address. A name can be registered again, for example when a notebook
cell is repeated; existing systems keep their law. Built-in laws cannot be replaced.

A contact or friction law without declared parameters has the parameters of all built-in laws of its kind.

Registries belong to a process. To transfer laws to another process, send the result of `registered`, and pass it to
`restore` there.
"""

from __future__ import annotations

import inspect
import math
import re
import time
from collections.abc import Callable, Iterable, Mapping, Sequence, Set
from types import FunctionType
from typing import Any, NamedTuple

from numba import NumbaError, types

from linkages.base.kernel import address
from linkages.laws.contact.contact_forces import power_law
from linkages.laws.contact.contact_laws import ContactLaw
from linkages.laws.control import ControlLaw
from linkages.laws.declared import REGISTRIES, check_parameters, declared
from linkages.laws.film.films import Film
from linkages.laws.friction import MOST_KINKS, FrictionLaw
from linkages.laws.parameters import Parameter, named_record
from linkages.laws.states import State, check_states

_BUILT_IN = {kind: frozenset(registry) for kind, registry in REGISTRIES.items()}

_registered: dict[tuple[str, str], Registered] = {}


class Registered(NamedTuple):
    """A registered law as plain data; made by `registered`.

    Attributes
    ----------
    kind : str
        "contact", "friction", "film" or "controller".
    name : str
    arguments : dict
        Arguments of the registration; functions are not compiled.
    time : int
        Time of the registration [ns].
    """

    kind: str
    name: str
    arguments: dict[str, Any]
    time: int


def register_contact(
    name: str,
    force: Callable[..., float | tuple[float, ...]] | None = None,
    *,
    factor: Callable[[float], float] | None = None,
    parameters: Sequence[Parameter] | None = None,
    needs: Sequence[str] | None = None,
    states: Sequence[State] = (),
    conformal: bool = False,
    formula: str = "",
    valid: str = "",
    source: str = "",
) -> None:
    """Register a contact law under a name that an experiment can give as ``joints.NAME.contact.law``.

    Parameters
    ----------
    name : str
    force : callable, optional
        ``force(delta, ddelta, ddelta0, joint) -> F`` as described in `linkages.laws.contact`: a Python function that
        numba can compile, plain or compiled already. Called with delta > 0 only; a negative F is taken as zero.
        Default K*delta^n, damped by `factor`.
    factor : callable, optional
        Hysteresis factor chi(e), any Python function; a force reads it as ``joint.hysteresis``. Default 0.
    parameters : sequence of Parameter, optional
        Numbers that the force reads as ``joint.NAME``, and files give as ``joints.NAME.contact.NAME``. Default: the
        parameters of the built-in laws, ``exponent`` and ``damping``.
    needs : sequence of str, optional
        Common keys that files must give for this law: ``"restitution"``, read as ``joint.restitution``, and
        ``"stiffness"`` (or a material), read as ``joint.stiffness``. Default: both; none if `parameters` are given.
    states : sequence of State, optional
        Continuous states of the contact. The force takes their values before ``joint``, and returns a tuple: F, then
        their rates. Without contact it is called with delta = ddelta = 0, for the rates alone.
    conformal : bool
        Whether a stiffness from the material is the one of conformal cylinders, pi E' L, instead of Hertz's.
    formula, valid, source : str
        Texts for the tables of the laws.

    Raises
    ------
    ValueError
        If the name belongs to a built-in law, or a function has wrong arguments or does not compile.

    Examples
    --------
    >>> from linkages import laws
    >>> laws.register_contact("small-loss", factor=lambda e: 1.5 * (1.0 - e * e) / (1.0 + e**3))
    >>> "small-loss" in laws.CONTACTS
    True
    """
    own: dict[str, Any] = {"force": force, "factor": factor, "conformal": conformal, "states": states}
    own |= {"parameters": parameters, "needs": needs}
    _register("contact", name, **own, formula=formula, valid=valid, source=source)


def register_film(
    name: str,
    force: Callable[..., tuple[float, float, float]],
    *,
    parameters: Sequence[Parameter] = (),
    formula: str = "",
    valid: str = "",
    source: str = "",
) -> None:
    """Register a film under a name that an experiment can give as ``joints.NAME.film``.

    Parameters
    ----------
    name : str
    force : callable
        ``force(eps, deps, ew, slenderness) -> (f_n, f_t, extent)`` as described in `linkages.laws.film`: a Python
        function that numba can compile, plain or compiled already. Called with 0 <= eps <= 1 - 1e-6. With `parameters`
        it is ``force(eps, deps, ew, slenderness, joint)``.
    parameters : sequence of Parameter, optional
        Numbers that the force reads as ``joint.NAME``, and files give next to ``film``, as ``joints.NAME.NAME``.
    formula, valid, source : str
        Texts for the tables of the laws.

    Raises
    ------
    ValueError
        If the name belongs to a built-in film, or the function has wrong arguments or does not compile.

    Examples
    --------
    >>> from linkages import laws
    >>> laws.register_film("squeeze", lambda eps, deps, ew, slenderness: (-12.0 * deps, 0.0, 0.0))
    >>> "squeeze" in laws.FILMS
    True
    """
    _register("film", name, force=force, parameters=parameters, formula=formula, valid=valid, source=source)


def register_friction(
    name: str,
    coefficient: Callable[..., float | tuple[float, ...]],
    *,
    parameters: Sequence[Parameter] | None = None,
    needs: Sequence[str] | None = None,
    states: Sequence[State] = (),
    kinks: Sequence[str | float] = (),
    formula: str = "",
    valid: str = "",
    source: str = "",
) -> None:
    """Register a friction law under a name that an experiment can give as ``joints.NAME.friction.law``.

    Parameters
    ----------
    name : str
    coefficient : callable
        ``coefficient(v, joint) -> mu`` as described in `linkages.laws.friction`: a Python function that numba can
        compile, plain or compiled already. Odd in v and the states, and v*mu >= 0 if it is to dissipate.
    parameters : sequence of Parameter, optional
        Numbers that the law reads as ``joint.NAME``, and files give as ``joints.NAME.friction.NAME``. Default: those
        of the built-in laws, ``v_0``, ``v_1``, ``bristle_stiffness`` and ``bristle_damping``.
    needs : sequence of str, optional
        Common keys that files must give for this law: ``"coefficient"``, read as ``joint.mu_d`` and, the static one,
        ``joint.mu_s``. Default: it; none if `parameters` are given.
    states : sequence of State, optional
        Continuous states of the contact, such as the deflection of bristles. The coefficient takes their values before
        ``joint``, and returns a tuple: mu, then their rates. Without a normal load it is called with v = 0, for the
        rates alone.
    kinks : sequence of str or float, optional
        Sliding speeds at which the slope or the curvature of the coefficient jumps: names of parameters, or numbers
        [m/s]. The law has them on both sides of zero. Accurate runs and derivatives have steps that end there; without
        that a step across a kink has an error of the order of its size. Two at most, or zero and one more.
    formula, valid, source : str
        Texts for the tables of the laws.

    Raises
    ------
    ValueError
        If the name belongs to a built-in law, or the function has wrong arguments or does not compile.

    Examples
    --------
    >>> from linkages import laws
    >>> import math
    >>> def smooth(v, joint):
    ...     return joint.top * math.tanh(v / joint.pace)
    >>> top = laws.Parameter("top", "1", None, "largest coefficient", ge=0.0)
    >>> pace = laws.Parameter("pace", "m/s", 1e-3, "speed at which friction is tanh(1) of its largest value", gt=0.0)
    >>> laws.register_friction("smooth", smooth, parameters=[top, pace])
    >>> "smooth" in laws.FRICTIONS
    True
    """
    own = {"coefficient": coefficient, "states": states, "kinks": kinks, "parameters": parameters, "needs": needs}
    _register("friction", name, **own, formula=formula, valid=valid, source=source)


def register_controller(name: str, function: Callable[..., float | Sequence[float]]) -> None:
    """Register a sampled controller under a name that an experiment can give as ``controllers.NAME.function``.

    Parameters
    ----------
    name : str
    function : callable
        ``function(t, ...) -> output``, any Python function or object that can be called; it is not compiled. After the
        time t [s] its parameters have the names of ``inputs``, ``parameters`` and ``memory`` of the experiment. With a
        memory it returns the output, then the new memory in the order of its parameters. The same arguments must give
        the same result: a run is repeated to estimate its errors.

    Raises
    ------
    ValueError
        If the function cannot be called, or has other than positional parameters.

    Examples
    --------
    >>> from linkages import laws
    >>> laws.register_controller("bang-bang", lambda t, speed: 1.0 if speed < 5.0 else 0.0)
    >>> laws.CONTROLLERS["bang-bang"].names
    ('speed',)
    """
    _register("controller", name, function=function)


def registered(names: Iterable[str] | None = None) -> tuple[Registered, ...]:
    """Give the records of the registered laws of these names, or of all; they pickle where their functions do.

    Parameters
    ----------
    names : iterable of str, optional

    Examples
    --------
    >>> from linkages import laws
    >>> laws.register_contact("undamped", factor=lambda e: 0.0)
    >>> [law.kind for law in laws.registered(["undamped"])]
    ['contact']
    """
    wanted = None if names is None else set(names)
    return tuple(law for law in _registered.values() if wanted is None or law.name in wanted)


def restore(records: Iterable[Registered]) -> None:
    """Register the laws of `registered`, of another process, that are missing in this one or older here.

    Parameters
    ----------
    records : iterable of Registered

    Examples
    --------
    >>> from linkages import laws
    >>> laws.register_contact("undamped", factor=lambda e: 0.0)
    >>> laws.restore(laws.registered())  # in a process that has them all: nothing to do
    """
    for record in records:
        here = _registered.get((record.kind, record.name))
        if here is None or here.time < record.time:
            _add(record)


def _register(kind: str, name: str, **arguments: Any) -> None:
    plain = {key: getattr(value, "py_func", value) for key, value in arguments.items()}
    for key in ("parameters", "needs", "states", "kinks"):
        if plain.get(key) is not None:
            plain[key] = tuple(plain[key])
    _add(Registered(kind, name, plain, time.time_ns()))


def _add(record: Registered) -> None:
    """Compile a law and enter it in its registry."""
    kind, name = record.kind, record.name
    if not (isinstance(name, str) and name):
        raise ValueError(f"{kind} law {name!r}: the name must be a text")
    if name in _BUILT_IN[kind]:
        raise ValueError(f'{kind} law "{name}" is built in: register yours under another name')
    try:
        law = _MAKERS[kind](**record.arguments)
        check_parameters(kind, name, law.parameters)
        if getattr(law, "states", ()):
            _compile_alone(kind, law)
        law.address  # noqa: B018 - compiles
    except Exception as error:
        raise ValueError(f'{kind} law "{name}": {_reason(error)}') from None
    REGISTRIES[kind][name] = law
    _registered[kind, name] = record


def _contact(force: Any, factor: Any, parameters: Any, needs: Any, states: Any = (), **texts: Any) -> ContactLaw:
    if force is None and factor is None:
        raise ValueError("give a force, a factor, or both")
    if force is None and (parameters is not None or states):
        raise ValueError(f"give a force, which reads the {'states' if states else 'parameters'}")
    own, needs = declared("contact", parameters, needs)
    if force is not None:
        _check(force, "delta", "ddelta", "ddelta0", *check_states(states), "joint")
    if factor is not None:
        _check(factor, "e")
        float(factor(0.5))
        texts["factor"], needs = factor, tuple(dict.fromkeys(("restitution", *needs)))
    return ContactLaw(force or power_law, parameters=own, needs=needs, states=states, **texts)


def _film(force: Any, parameters: Any, **texts: Any) -> Film:
    _check(force, "eps", "deps", "ew", "slenderness", *(["joint"] if parameters else []))
    return Film(force, parameters=parameters, **texts)


def _friction(coefficient: Any, states: Any, kinks: Any, parameters: Any, needs: Any, **texts: Any) -> FrictionLaw:
    _check(coefficient, "v", *check_states(states), "joint")
    own, needs = declared("friction", parameters, needs)
    _check_kinks(kinks, {parameter.name for parameter in own})

    def speeds(values: Mapping[str, float]) -> tuple[float, ...]:
        return tuple(values[kink] if isinstance(kink, str) else float(kink) for kink in kinks)

    return FrictionLaw(coefficient, states=states, parameters=own, needs=needs, kinks=speeds, **texts)


def _compile_alone(kind: str, law: Any) -> None:
    """Compile a law with states by itself, for a message about what it returns."""
    function, inputs = (law.force, 3) if kind == "contact" else (law.coefficient, 1)
    numbers = (inputs + len(law.states)) * [types.float64]
    result = types.UniTuple(types.float64, 1 + len(law.states))
    address(function, result(*numbers, named_record(kind, law.parameters, law.needs)))


def _check_kinks(kinks: Sequence[str | float], parameters: Set[str]) -> None:
    """Reject kinks that are neither parameters nor speeds, and more than a contact has room for."""
    for kink in kinks:
        if isinstance(kink, str) and kink not in parameters:
            raise ValueError(f'kinks: "{kink}" is no parameter of the law; there are {", ".join(sorted(parameters))}')
        if not isinstance(kink, str) and not 0.0 <= float(kink) < math.inf:
            raise ValueError(f"kinks: {kink!r} is not a speed of 0 or more [m/s]")
    if sum(1 if kink == 0 else 2 for kink in kinks) > MOST_KINKS:
        raise ValueError("kinks: there may be two speeds, or zero and one speed")


def _controller(function: Any) -> ControlLaw:
    if not callable(function):
        raise ValueError(f"{function!r} cannot be called")
    given = inspect.signature(function).parameters
    if not given or any(one.kind is not one.POSITIONAL_OR_KEYWORD for one in given.values()):
        raise ValueError("must take the time, then inputs, parameters and memory by name")
    return ControlLaw(function, tuple(given)[1:])


_MAKERS: dict[str, Callable[..., Any]] = {
    "contact": _contact, "film": _film, "friction": _friction, "controller": _controller,
}  # fmt: skip


def _check(function: Any, *arguments: str) -> Any:
    """Reject objects other than Python functions of these arguments."""
    if not isinstance(function, FunctionType):
        raise ValueError(f"{function!r} is not a Python function")
    try:
        inspect.signature(function).bind(*arguments)
    except TypeError:
        raise ValueError(f"{function.__name__} must take ({', '.join(arguments)})") from None
    return function


def _reason(error: Exception) -> str:
    """Shorten an error to one line; numba's errors begin with the stage of its compiler."""
    if isinstance(error, KeyError):  # the record that the compiler sees has the declared and needed numbers alone
        remedy = "declare a parameter of this name, or give the name in `needs`"
        return f"reads joint.{error.args[0]}, which it neither declares nor needs; {remedy}"
    lines = re.sub(r"\x1b\[\d*m", "", str(error)).splitlines()
    text = next((line.strip() for line in lines if line.strip() and not line.startswith("Failed in")), "")
    returns = re.match(r"No conversion from (.*) to (.*) for ", text)
    if returns:
        return f"returns {returns[1]}; must return {returns[2]}"
    return text if isinstance(error, NumbaError | ValueError) else f"{type(error).__name__}: {text}"
