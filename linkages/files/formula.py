"""Formulas in files: arithmetic on named numbers, parsed and never executed as code."""

from __future__ import annotations

import ast
import math
import operator
import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import TypeVar

from linkages.errors import nearest

_LONGEST = 200_000  # most characters of a formula (controllers are often generated)
_DEEPEST = 60  # levels of nesting (evaluation recurses); a sum or product counts as one
_UNDERSCORE = re.compile(r"(?<![\w.])[\d.]+(?:[eE][+-]?\d+)?_\w*")  # as in 2_0, which Python reads as 20
_SHOWN = 80  # most characters of a formula in an error

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
        (1, (math.sin, math.cos, math.tan, math.asin, math.acos, math.atan, math.tanh)),
        (2, (math.atan2,)),
        (None, (math.hypot, min, max)),
    )
    for function in functions
}

CONSTANTS = {"pi": math.pi}

_COMPUTED = {function.__name__: function for function in (*_OPERATORS.values(), *(f for f, _ in FUNCTIONS.values()))}

T = TypeVar("T")


@dataclass(frozen=True)
class Formula:
    """A formula such as ``rho * L**2 / 12``.

    Attributes
    ----------
    text : str
        Text of the file.
    names : frozenset of str
        Names in the formula, without `CONSTANTS`.
    """

    text: str
    names: frozenset[str]
    _tree: ast.expr

    def __call__(self, values: Mapping[str, float]) -> float:
        """Evaluate with these values of its names; NaN if the result is undefined or too large."""
        try:
            result = self.fold(float, values.__getitem__, lambda name, given: _COMPUTED[name](*given))
        except (ValueError, ZeroDivisionError, OverflowError):
            return math.nan
        return result if math.isfinite(result) else math.nan

    def fold(self, number: Callable[[float], T], name: Callable[[str], T], apply: Callable[[str, list[T]], T]) -> T:
        """Evaluate the formula recursively, from its innermost parts.

        Parameters
        ----------
        number, name : callable
            Results for a number, and for a name of `names`.
        apply : callable
            Result of a function for its arguments; operators have their names in `operator`.
        """

        def value(node: ast.expr) -> T:
            match node:
                case ast.Constant(value=found):
                    return number(float(found))  # type: ignore[arg-type]
                case ast.Name(id=found):
                    return number(CONSTANTS[found]) if found in CONSTANTS else name(found)
                case ast.Attribute(value=ast.Name(id=owner), attr=part):
                    return name(f"{owner}.{part}")
                case ast.UnaryOp(op=op, operand=operand):
                    return apply(_OPERATORS[type(op)].__name__, [value(operand)])
                case ast.BinOp():
                    first, others = _terms(node)
                    result = value(first)
                    for operation, other in others:
                        result = apply(_OPERATORS[type(operation)].__name__, [result, value(other)])
                    return result
                case ast.Call(func=ast.Name(id=function), args=arguments):
                    return apply(function, [value(argument) for argument in arguments])
            raise AssertionError(ast.dump(node))  # excluded by `_check`

        return value(self._tree)


def parse(text: str, parts: Collection[str] = ("x", "y")) -> Formula:
    """Read a formula: numbers, names (``a``, ``A.x``), ``+ - * / **``, parentheses and `FUNCTIONS`.

    Parameters
    ----------
    text : str
    parts : collection of str
        Allowed names after a dot.

    Raises
    ------
    ValueError
        If the formula is invalid: one sentence with the error and the remedy.
    """
    if len(text) > _LONGEST:
        raise ValueError(f"is longer than {_LONGEST:,} characters; give a table instead, or several loads")
    if found := _UNDERSCORE.search(text):
        raise ValueError(f'has the number "{found[0]}"; write it without underscores')
    try:
        tree = ast.parse(text.strip(), mode="eval").body
    except (RecursionError, MemoryError):
        raise ValueError(
            "has too many terms, or is nested too deeply; put parts of a long sum in parentheses"
        ) from None
    except (SyntaxError, ValueError):
        raise ValueError(f'"{shown(text)}" is not a formula') from None
    names: set[str] = set()
    _check(tree, names, parts)
    return Formula(text, frozenset(names - set(CONSTANTS)), tree)


def _check(node: ast.expr, names: set[str], parts: Collection[str], depth: int = 0) -> None:
    """Collect names; reject everything that is not arithmetic."""
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
        case ast.Attribute(value=ast.Name(id=owner), attr=part) if part in parts:
            names.add(f"{owner}.{part}")
        case ast.Attribute(value=ast.Name(id=owner), attr=part):
            raise ValueError(f'"{owner}.{part}" is not arithmetic: after a dot, {nearest(part, parts)}')
        case ast.UnaryOp(op=op, operand=operand) if type(op) in _OPERATORS:
            _check(operand, names, parts, depth + 1)
        case ast.BinOp(op=op) if type(op) in _OPERATORS:
            first, others = _terms(node)
            for term in (first, *(other for _, other in others)):
                _check(term, names, parts, depth + 1)
        case ast.Call(func=ast.Name(id=name), args=arguments, keywords=[]):
            if name not in FUNCTIONS:
                raise ValueError(f'has no function "{name}"; {nearest(name, FUNCTIONS)}')
            count = FUNCTIONS[name][1]
            if len(arguments) != count and (count is not None or len(arguments) < 2):
                raise ValueError(f"{name} takes {count or 'two or more'} argument{'s' * (count != 1)}")
            for argument in arguments:
                _check(argument, names, parts, depth + 1)
        case _:
            problem = "is not arithmetic: use numbers, names, + - * / ** and functions"
            try:
                found = f'"{shown(ast.unparse(node))}"'
            except RecursionError:
                found = "a deeply nested part"
            raise ValueError(f"{found} {problem}")


def _terms(node: ast.expr) -> tuple[ast.expr, list[tuple[ast.operator, ast.expr]]]:
    """Split ``a + b - c`` into its first term, and pairs of operator and term, because the left side nests deeply."""
    others: list[tuple[ast.operator, ast.expr]] = []
    while isinstance(node, ast.BinOp) and type(node.op) in _OPERATORS:
        others.append((node.op, node.right))
        node = node.left
    return node, others[::-1]


def shown(text: str) -> str:
    """Shorten a formula for an error."""
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}..."
