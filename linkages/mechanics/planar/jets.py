"""Exact arithmetic with values and their first two derivatives along a line, for formulas.

At a kink (abs, min, max) the derivatives of one side are used; where a function is not differentiable (sqrt, hypot at
zero) the derivatives are infinite, not a number, or zero.
"""

from __future__ import annotations

import math

from linkages.base.kernel import inlined_kernel, kernel

#: A value, its first and its second derivative.
Jet = tuple[float, float, float]

_NAMES = (
    "neg", "abs", "sqrt", "exp", "log", "sin", "cos", "tan", "asin", "acos", "atan", "tanh",
    "add", "sub", "mul", "truediv", "pow", "atan2", "hypot", "min", "max",
)  # fmt: skip
#: Codes of functions by their names in formulas; functions of two arguments come last.
CODES = {name: code for code, name in enumerate(_NAMES, 3)}
FIRST_BINARY = CODES["add"]
_NEG, _ABS, _SQRT, _EXP, _LOG, _SIN, _COS, _TAN, _ASIN, _ACOS, _ATAN, _TANH = (CODES[name] for name in _NAMES[:12])
_ADD, _SUB, _MUL, _DIV, _POW, _ATAN2, _HYPOT, _MIN, _MAX = (CODES[name] for name in _NAMES[12:])


@kernel
def unary(code: int, x: Jet) -> Jet:
    """Apply a function of one argument."""
    u, u1, u2 = x
    if code == _NEG:
        return -u, -u1, -u2
    if code == _ABS:
        return (u, u1, u2) if u >= 0.0 else (-u, -u1, -u2)
    if code == _SQRT:
        f = math.sqrt(u)
        d, dd = 0.5 / f, -0.25 / (f * u)
    elif code == _EXP:
        f = math.exp(u)
        d, dd = f, f
    elif code == _LOG:
        f, d, dd = math.log(u), 1.0 / u, -1.0 / (u * u)
    elif code == _SIN:
        f, d = math.sin(u), math.cos(u)
        dd = -f
    elif code == _COS:
        f, d = math.cos(u), -math.sin(u)
        dd = -f
    elif code == _TAN:
        f = math.tan(u)
        d = 1.0 + f * f
        dd = 2.0 * f * d
    elif code == _TANH:
        f = math.tanh(u)
        d = 1.0 - f * f
        dd = -2.0 * f * d
    elif code == _ATAN:
        f, d = math.atan(u), 1.0 / (1.0 + u * u)
        dd = -2.0 * u * d * d
    else:
        f, d = math.asin(u), 1.0 / math.sqrt(1.0 - u * u)
        dd = u * d * d * d
        if code == _ACOS:
            f, d, dd = math.acos(u), -d, -dd
    return f, d * u1, d * u2 + dd * u1 * u1


@kernel
def binary(code: int, x: Jet, y: Jet) -> Jet:
    """Apply a function of two arguments."""
    a, a1, a2 = x
    b, b1, b2 = y
    if code == _ADD:
        return a + b, a1 + b1, a2 + b2
    if code == _SUB:
        return a - b, a1 - b1, a2 - b2
    if code == _MUL:
        return a * b, a1 * b + a * b1, a2 * b + 2.0 * a1 * b1 + a * b2
    if code == _DIV:
        f = a / b
        f1 = (a1 - f * b1) / b
        return f, f1, (a2 - 2.0 * f1 * b1 - f * b2) / b
    if code == _POW:
        return _power(x, y)
    if code == _ATAN2:
        square, slope = a * a + b * b, a1 * b - a * b1
        f1 = slope / square
        return math.atan2(a, b), f1, (a2 * b - a * b2 - 2.0 * f1 * (a * a1 + b * b1)) / square
    if code == _HYPOT:
        f = math.hypot(a, b)
        if f == 0.0:
            return 0.0, 0.0, 0.0
        f1 = (a * a1 + b * b1) / f
        return f, f1, (a1 * a1 + a * a2 + b1 * b1 + b * b2 - f1 * f1) / f
    if code == _MIN:
        return x if a <= b else y
    return x if a >= b else y


@inlined_kernel
def _power(x: Jet, y: Jet) -> Jet:
    """Power; of a base below zero only with an exponent that is constant and whole."""
    a, a1, a2 = x
    b, b1, b2 = y
    f = math.pow(a, b)
    if b1 == 0.0 and b2 == 0.0:  # a coefficient of zero counts more than an infinite power
        d = b * math.pow(a, b - 1.0) if b != 0.0 else 0.0
        dd = b * (b - 1.0) * math.pow(a, b - 2.0) if b != 0.0 and b != 1.0 else 0.0
        return f, d * a1, d * a2 + dd * a1 * a1
    log = math.log(a)
    e1 = b1 * log + b * a1 / a
    e2 = b2 * log + 2.0 * b1 * a1 / a + b * (a2 / a - (a1 / a) ** 2)
    return f, f * e1, f * (e2 + e1 * e1)
