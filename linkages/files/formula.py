"""Formulas in files: arithmetic on named numbers, parsed and never executed as code."""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from linkages.errors import nearest

_LONGEST = 1000  # characters
_DEEPEST = 60  # levels of nesting: evaluation recurses

_OPERATORS: dict[type[ast.AST], Callable[..., float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: math.pow,  # unlike **, never complex
    ast.UAdd: operator.pos,
    ast.USub: operator.neg,
}

#: Functions and the number of their arguments (None: two or more).
FUNCTIONS: dict[str, tuple[Callable[..., float], int | None]] = {
    function.__name__: (function, count)
    for count, functions in (
        (1, (abs, math.sqrt, math.exp, math.log)),
        (1, (math.sin, math.cos, math.tan, math.asin, math.acos, math.atan)),
        (2, (math.atan2,)),
        (None, (math.hypot, min, max)),
    )
    for function in functions
}

CONSTANTS = {"pi": math.pi}


@dataclass(frozen=True)
class Formula:
    """A formula such as ``rho * L**2 / 12``.

    Attributes
    ----------
    text : str
        As written.
    names : frozenset of str
        The names it needs, `CONSTANTS` aside.
    """

    text: str
    names: frozenset[str]
    _tree: ast.expr

    def __call__(self, values: Mapping[str, float]) -> float:
        """Evaluate with these values of its names; NaN where it is undefined or too large."""
        try:
            result = _value(self._tree, CONSTANTS | dict(values))
        except (ValueError, ZeroDivisionError, OverflowError):
            return math.nan
        return result if math.isfinite(result) else math.nan


def parse(text: str) -> Formula:
    """Read a formula: numbers, names (``a``, ``A.x``), ``+ - * / **``, parentheses and `FUNCTIONS`.

    Raises
    ------
    ValueError
        One sentence: what is wrong, and what would be right.
    """
    if len(text) > _LONGEST:
        raise ValueError(f"is longer than {_LONGEST} characters")
    try:
        tree = ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise ValueError(f'"{text}" is not a formula') from None
    names: set[str] = set()
    _check(tree, names)
    return Formula(text, frozenset(names - set(CONSTANTS)), tree)


def _check(node: ast.expr, names: set[str], depth: int = 0) -> None:
    """Collect names; refuse whatever is not arithmetic."""
    if depth > _DEEPEST:
        raise ValueError("is nested too deeply")
    match node:
        case ast.Constant(value=value) if isinstance(value, int | float) and not isinstance(value, bool):
            try:
                float(value)
            except OverflowError:
                raise ValueError("has a number that is too large") from None
        case ast.Name(id=name):
            names.add(name)
        case ast.Attribute(value=ast.Name(id=owner), attr="x" | "y" as part):
            names.add(f"{owner}.{part}")
        case ast.UnaryOp(op=op, operand=operand) if type(op) in _OPERATORS:
            _check(operand, names, depth + 1)
        case ast.BinOp(left=left, op=op, right=right) if type(op) in _OPERATORS:
            _check(left, names, depth + 1)
            _check(right, names, depth + 1)
        case ast.Call(func=ast.Name(id=name), args=arguments, keywords=[]):
            if name not in FUNCTIONS:
                raise ValueError(f'has no function "{name}"; {nearest(name, FUNCTIONS)}')
            count = FUNCTIONS[name][1]
            if len(arguments) != count and (count is not None or len(arguments) < 2):
                raise ValueError(f"{name} takes {count or 'two or more'} argument{'s' * (count != 1)}")
            for argument in arguments:
                _check(argument, names, depth + 1)
        case _:
            raise ValueError(f'"{ast.unparse(node)}" is not arithmetic: use numbers, names, + - * / ** and functions')


def _value(node: ast.expr, values: Mapping[str, float]) -> float:
    match node:
        case ast.Constant(value=value):
            return float(value)  # type: ignore[arg-type]
        case ast.Name(id=name):
            return float(values[name])
        case ast.Attribute(value=ast.Name(id=owner), attr=part):
            return float(values[f"{owner}.{part}"])
        case ast.UnaryOp(op=op, operand=operand):
            return _OPERATORS[type(op)](_value(operand, values))
        case ast.BinOp(left=left, op=op, right=right):
            return _OPERATORS[type(op)](_value(left, values), _value(right, values))
        case ast.Call(func=ast.Name(id=name), args=arguments):
            return FUNCTIONS[name][0](*(_value(argument, values) for argument in arguments))
    raise AssertionError(ast.dump(node))  # `_check` let nothing else through
