"""Formulas in files: arithmetic on named numbers, parsed and never executed as code."""

from __future__ import annotations

import ast
import math
import operator
import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import TypeVar

from linkages.base.errors import nearest

_LONGEST = 200_000  # most characters of a formula (controllers are often generated)
_DEEPEST = 60  # levels of nesting (reading recurses); a sum or product counts as one
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

#: A step of a formula: a number, a name, or a function (or operator) of some results before it, by their count.
_Step = float | str | tuple[str, int]


@dataclass(frozen=True)
class Formula:
    """A formula such as ``rho * L**2 / 12``.

    Attributes
    ----------
    text : str
        Its text in the file.
    names : frozenset of str
        Names in it, without `CONSTANTS`.
    """

    text: str
    names: frozenset[str]
    _steps: tuple[_Step, ...]

    def __call__(self, values: Mapping[str, float]) -> float:
        """Evaluate with these values of its names; NaN if the result is undefined or too large."""
        try:
            result = self.fold(float, values.__getitem__, lambda name, given: _COMPUTED[name](*given))
        except (ValueError, ZeroDivisionError, OverflowError):
            return math.nan
        return result if math.isfinite(result) else math.nan

    def fold(self, number: Callable[[float], T], name: Callable[[str], T], apply: Callable[[str, list[T]], T]) -> T:
        """Evaluate the formula from its innermost parts, by the results for a number, a name and a function.

        Operators have their names in `operator`.
        """
        stack: list[T] = []
        for step in self._steps:
            if isinstance(step, tuple):
                function, count = step
                stack[-count:] = [apply(function, stack[-count:])]
            else:
                stack.append(number(step) if isinstance(step, float) else name(step))
        return stack[0]


def parse(text: str, parts: Collection[str] = ("x", "y")) -> Formula:
    """Read a formula: numbers, names (``a``, ``A.x``), ``+ - * / **``, parentheses and `FUNCTIONS`.

    `parts` are the allowed names after a dot. A ValueError has one sentence with the error and the remedy.
    """
    if len(text) > _LONGEST:
        raise ValueError(f"is longer than {_LONGEST:,} characters; give a table instead, or several loads")
    if found := _UNDERSCORE.search(text):
        raise ValueError(f'has the number "{found[0]}"; write it without underscores')
    try:
        tree = ast.parse(text.strip(), mode="eval").body
    except (RecursionError, MemoryError):
        problem = "has too many terms, or is nested too deeply; put parts of a long sum in parentheses"
        raise ValueError(problem) from None
    except (SyntaxError, ValueError):
        raise ValueError(f'"{shown(text)}" is not a formula') from None
    steps: list[_Step] = []
    _translate(tree, steps, parts)
    return Formula(text, frozenset(step for step in steps if isinstance(step, str)), tuple(steps))


def _translate(node: ast.expr, steps: list[_Step], parts: Collection[str], depth: int = 0) -> None:
    """Append the steps that evaluate a part of a formula; reject everything that is not arithmetic."""
    if depth > _DEEPEST:
        raise ValueError("is nested too deeply")
    match node:
        case ast.Constant(value=value) if isinstance(value, int | float) and not isinstance(value, bool):
            try:
                steps.append(float(value))
            except OverflowError:
                raise ValueError("has a number that is too large") from None
        case ast.Name(id=name):
            steps.append(CONSTANTS.get(name, name))
        case ast.Attribute(value=ast.Name(id=owner), attr=part):
            if part not in parts:
                raise ValueError(f'"{owner}.{part}" is not arithmetic: after a dot, {nearest(part, parts)}')
            steps.append(f"{owner}.{part}")
        case ast.UnaryOp(op=op, operand=operand) if type(op) in _OPERATORS:
            _translate(operand, steps, parts, depth + 1)
            steps.append((_OPERATORS[type(op)].__name__, 1))
        case ast.BinOp(op=op) if type(op) in _OPERATORS:
            left: ast.expr = node
            others = []
            while isinstance(left, ast.BinOp) and type(left.op) in _OPERATORS:  # the left side of a sum nests deeply
                others.append((left.op, left.right))
                left = left.left
            _translate(left, steps, parts, depth + 1)
            for operation, other in reversed(others):
                _translate(other, steps, parts, depth + 1)
                steps.append((_OPERATORS[type(operation)].__name__, 2))
        case ast.Call(func=ast.Name(id=name), args=arguments, keywords=[]):
            if name not in FUNCTIONS:
                raise ValueError(f'has no function "{name}"; {nearest(name, FUNCTIONS)}')
            count = FUNCTIONS[name][1]
            if len(arguments) != count and (count is not None or len(arguments) < 2):
                raise ValueError(f"{name} takes {count or 'two or more'} argument{'s' * (count != 1)}")
            for argument in arguments:
                _translate(argument, steps, parts, depth + 1)
            steps.append((name, len(arguments)))
        case _:
            problem = "is not arithmetic: use numbers, names, + - * / ** and functions"
            try:
                found = f'"{shown(ast.unparse(node))}"'
            except RecursionError:
                found = "a deeply nested part"
            raise ValueError(f"{found} {problem}")


def shown(text: str) -> str:
    """Shorten a formula for an error."""
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}..."
