"""Dual numbers: a number with its derivatives along `DIRECTIONS` directions, its slopes.

A kernel that is called with duals, or arrays of them, is compiled for them: its result is the number that it computes
from floats, to the last bit, with the exact derivatives of the same operations. So no function has a twin that
differentiates it. In memory a dual is a number and its slopes, without gaps; in the processor the slopes are a vector.

A comparison looks at the number alone, so that a dual follows the branch that the number follows. Where a slope is
infinite, of a root or a distance at zero, it is zero.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Sequence
from itertools import product
from operator import methodcaller
from typing import Any, NamedTuple, cast

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import (
    intrinsic,
    lower_builtin,
    lower_cast,
    models,
    overload,
    register_model,
    type_callable,
    typeof_impl,
)  # fmt: skip

from linkages.base.kernel import simd
from linkages.base.kernel.private import OFF
from linkages.base.kernel.simd import WIDTH, LaneArray

DIRECTIONS = 8
_FLOAT, _INDEX, _WORD = ir.DoubleType(), ir.IntType(32), ir.IntType(64)
_ALIKE = ir.Constant(ir.VectorType(_INDEX, DIRECTIONS), [0] * DIRECTIONS)
_SLOPES = ir.VectorType(_FLOAT, DIRECTIONS)
PAIR = ir.LiteralStructType([_FLOAT, _SLOPES])
_IN_MEMORY = ir.LiteralStructType([_FLOAT, _SLOPES], packed=True)
_FAST = ("contract",)  # slopes may be rounded once less; numbers may not
_NUMBERS = types.Float, types.Integer


class _Dual(types.Type):
    """Type of a dual."""

    def __init__(self) -> None:
        super().__init__(name="Dual")

    def can_convert_from(self, typing: Any, other: Any) -> Any:
        """Convert a number to a dual without slopes."""
        return typing.can_convert(other, types.complex128) if isinstance(other, _NUMBERS) else None


class _Lanes(types.Type):
    """Type of duals side by side, see `linkages.base.kernel.simd`."""

    def __init__(self) -> None:
        super().__init__(name="DualLanes")

    def can_convert_from(self, typing: Any, other: Any) -> Any:
        """Convert a number, a dual, or numbers side by side."""
        if isinstance(other, _Dual | simd.Lanes):
            return typing.can_convert(types.int64, types.float64)
        return typing.can_convert(other, types.complex128) if isinstance(other, _NUMBERS) else None


DUAL, LANES = _Dual(), _Lanes()


@register_model(_Dual)
class _DualModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, PAIR)

    def get_data_type(self) -> Any:
        """Return LLVM's type of a dual in memory."""
        return _IN_MEMORY

    def as_data(self, builder: Any, value: Any) -> Any:
        """Turn a dual into its stored form."""
        return _rebuilt(builder, value, _IN_MEMORY)

    def from_data(self, builder: Any, value: Any) -> Any:
        """Turn the stored form into a dual."""
        return _rebuilt(builder, value, PAIR)

    def load_from_data_pointer(self, builder: Any, place: Any, align: Any = None) -> Any:
        """Load a dual."""
        where = (builder.gep(place, [_INDEX(0), _INDEX(k)], inbounds=True) for k in range(2))
        return packed(builder, Parts(*(builder.load(part, align=8) for part in where)))


@register_model(_Lanes)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, ir.ArrayType(PAIR, WIDTH))

    def get_data_type(self) -> Any:
        """Return LLVM's type of duals side by side in memory."""
        return ir.ArrayType(_IN_MEMORY, WIDTH)

    def load_from_data_pointer(self, builder: Any, place: Any, align: Any = None) -> Any:
        """Load duals side by side."""
        load, zero = self._dmm[DUAL].load_from_data_pointer, _INDEX(0)
        array = ir.Constant(ir.ArrayType(PAIR, WIDTH), ir.Undefined)
        for k in range(WIDTH):
            array = builder.insert_value(array, load(builder, builder.gep(place, [zero, _INDEX(k)], inbounds=True)), k)
        return array


class _DualRecord(types.Record):
    """Type of a record that has duals."""

    @property
    def dtype(self) -> Any:
        """Type of NumPy of the same size."""
        return np.dtype((np.void, self.size))


register_model(_DualRecord)(models.RecordModel)


class DualArray(LaneArray):
    """An array of duals: a number and its slopes in the last axis; compiled code sees the axes before it."""


def dual_array(*shape: int) -> DualArray:
    """Make an array of duals, all zero."""
    return np.zeros((*shape, 1 + DIRECTIONS)).view(DualArray)


@typeof_impl.register(DualArray)
def _type_of(value: DualArray, context: Any) -> Any:
    return types.Array(DUAL, value.ndim - 1, "C", aligned=False)


def has_duals(kind: Any) -> bool:
    """Whether a type of numba is a dual, an array of them, or a record or a plain tuple with one."""
    if isinstance(kind, types.Array):
        kind = kind.dtype
    return kind in (DUAL, LANES) or any(map(has_duals, _members(kind)))


def with_duals(kind: Any) -> Any:
    """Return the type with duals in the place of floats; records and arrays keep their types."""
    if isinstance(kind, types.BaseTuple):
        return types.Tuple([with_duals(part) for part in cast(Any, kind)])
    return DUAL if kind == types.float64 else kind


def with_dual_records(kind: Any) -> Any:
    """Return the type with duals in the place of floats, of records and arrays too."""
    if isinstance(kind, types.Record):
        return dual_record(kind, 1 + DIRECTIONS)
    if isinstance(kind, types.Array):
        return types.Array(with_dual_records(kind.dtype), kind.ndim, kind.layout, aligned=False)
    return with_duals(kind)


def dual_record(kind: Any, apart: int = 1) -> Any:
    """Return the type of a record with duals in the place of floats, and its words so many times as far apart."""
    fields: Any = [
        (name, {"type": _in_record(field.type, apart), "offset": apart * field.offset})
        for name, field in kind.fields.items()
    ]
    return _DualRecord(fields, apart * kind.size, False)


def _in_record(kind: Any, apart: int) -> Any:
    return dual_record(kind, apart) if isinstance(kind, types.Record) else with_duals(kind)


def _members(kind: Any) -> tuple[Any, ...]:
    """Types of the parts of a record or a plain tuple."""
    if isinstance(kind, types.Record):
        return tuple(field.type for field in kind.fields.values())
    plain = isinstance(kind, types.BaseTuple) and not isinstance(kind, types.BaseNamedTuple)
    return tuple(kind) if plain else ()


class Parts(NamedTuple):
    """The number of a dual and its slopes, None where they are zero: of a float."""

    number: Any
    slopes: Any = None


def parts(builder: Any, kind: Any, value: Any) -> Parts:
    """Take a dual or a float apart."""
    if kind != DUAL:
        return Parts(value)
    return Parts(builder.extract_value(value, 0), builder.extract_value(value, 1))


def packed(builder: Any, parts: Parts) -> Any:
    """Make a dual of its parts."""
    slopes = ir.Constant(_SLOPES, [0.0] * DIRECTIONS) if parts.slopes is None else parts.slopes
    pair = builder.insert_value(ir.Constant(PAIR, ir.Undefined), parts.number, 0)
    return builder.insert_value(pair, slopes, 1)


def spot_of(builder: Any, value: Any) -> Any:
    """Put a value into memory of the function that is written."""
    with builder.goto_entry_block():
        spot = builder.alloca(value.type)
    builder.store(value, spot)
    return spot


def _rebuilt(builder: Any, value: Any, kind: Any) -> Any:
    pair = ir.Constant(kind, ir.Undefined)
    for k in range(2):
        pair = builder.insert_value(pair, builder.extract_value(value, k), k)
    return pair


def _scaled(builder: Any, slopes: Any, factor: _Number | float) -> Any:
    """Slopes times a number, or times 1 or -1."""
    if isinstance(factor, float):
        return slopes if factor == 1.0 else builder.fneg(slopes)
    return builder.fmul(slopes, _alike(builder, factor.value, _SLOPES), flags=_FAST)


def _alike(builder: Any, value: Any, kind: Any) -> Any:
    """Vector of equal entries."""
    first = builder.insert_element(ir.Constant(kind, ir.Undefined), value, _INDEX(0))
    return builder.shuffle_vector(first, first, _ALIKE)


def _sum(builder: Any, first: Any, second: Any) -> Any:
    """Sum of slopes."""
    if first is None or second is None:
        return second if first is None else first
    return builder.fadd(first, second, flags=_FAST)


def _writes(name: str, swapped: bool = False) -> Any:
    """Make the method of an operator that writes an operation of two floats."""

    def method(self: _Number, other: _Number | float) -> _Number:
        pair = (_value(other), self.value) if swapped else (self.value, _value(other))
        return self.another(getattr(self.builder, name)(*pair))

    return method


class _Number:
    """A float, or an integer exponent, of the code that is written: its operators write operations."""

    __add__ = _writes("fadd")
    __mul__ = __rmul__ = _writes("fmul")
    __sub__, __rsub__ = _writes("fsub"), _writes("fsub", True)
    __truediv__, __rtruediv__ = _writes("fdiv"), _writes("fdiv", True)

    def __init__(self, context: Any, builder: Any, value: Any) -> None:
        self.context, self.builder, self.value = context, builder, value

    def another(self, value: Any) -> _Number:
        """Return another value of the same code."""
        return _Number(self.context, self.builder, value)

    def __neg__(self) -> _Number:
        return self.another(self.builder.fneg(self.value))

    def of(self, function: Any, *others: _Number) -> _Number:
        """Write a call of numba's function of floats, and of an integer exponent."""
        values = [self.value, *(other.value for other in others)]
        kinds = [types.float64 if value.type == _FLOAT else types.int64 for value in values]
        typing = self.context.typing_context
        own = typing.resolve_value_type(function)
        own.get_call_type(typing, kinds, {})
        return self.another(self.context.get_function(own, types.float64(*kinds))(self.builder, values))

    def where(self, other: _Number | float, then: float, otherwise: _Number | float) -> _Number:
        """Write one number where this one is equal to another one, and a second one elsewhere."""
        equal = self.builder.fcmp_ordered("==", self.value, _value(other))
        return self.another(self.builder.select(equal, _value(then), _value(otherwise)))

    def inverse(self) -> _Number:
        """Write the reciprocal, zero of zero."""
        return self.where(0.0, 0.0, 1.0 / self)


def _value(number: _Number | float) -> Any:
    """LLVM's value of a number."""
    return number.value if isinstance(number, _Number) else _FLOAT(number)


@lower_cast(types.Float, _Dual)
@lower_cast(types.Integer, _Dual)
def _without_slopes(context: Any, builder: Any, given: Any, wanted: Any, value: Any) -> Any:
    return packed(builder, Parts(context.cast(builder, value, given, types.float64)))


Operation = Callable[..., Parts]  # of what writes the code, and of one or two duals or floats


def _rule(value: Callable[..., _Number], *partials: Callable[..., _Number | float]) -> Operation:
    """Make an operation of its number, and of its partial derivatives from the arguments' numbers and its own."""

    def operation(context: Any, builder: Any, *given: Parts) -> Parts:
        numbers = [_Number(context, builder, each.number) for each in given]
        result, slopes = value(*numbers), None
        for each, partial in zip(given, partials, strict=False):
            if each.slopes is not None:
                slopes = _sum(builder, slopes, _scaled(builder, each.slopes, partial(*numbers, result)))
        return Parts(result.value, slopes)

    return operation


def _divide(context: Any, builder: Any, x: Parts, y: Parts) -> Parts:
    """Write a ratio; its slopes have one division."""
    top, bottom = (_Number(context, builder, each.number) for each in (x, y))
    ratio, slopes = top / bottom, x.slopes
    if y.slopes is not None:
        slopes = _sum(builder, slopes, _scaled(builder, y.slopes, -ratio))
    return Parts(ratio.value, None if slopes is None else _scaled(builder, slopes, 1.0 / bottom))


def _minimum(context: Any, builder: Any, x: Parts, y: Parts) -> Parts:
    return _chosen(builder, "<=", x, y)


def _maximum(context: Any, builder: Any, x: Parts, y: Parts) -> Parts:
    return _chosen(builder, ">=", x, y)


def _chosen(b: Any, sign: str, x: Parts, y: Parts) -> Parts:
    first = b.or_(b.fcmp_ordered(sign, x.number, y.number), b.fcmp_unordered("uno", x.number, x.number))
    return parts(b, DUAL, b.select(first, packed(b, x), packed(b, y)))  # no number stays none


def _magnitude(context: Any, builder: Any, x: Parts) -> Parts:
    return _chosen(builder, ">=", x, _NEGATIVE(context, builder, x))


def _power_slope(x: _Number, y: _Number, result: _Number) -> _Number:
    """Write the derivative y x^(y - 1), zero where it is infinite."""
    if y.value.type == _FLOAT:
        exponent, less = y, y - 1.0
    else:
        exponent = y.another(y.builder.sitofp(y.value, _FLOAT))
        less = y.another(y.builder.sub(y.value, y.value.type(1)))
    slope = exponent * x.of(operator.pow, less)
    return slope.where(math.inf, 0.0, slope)


def _exponent_slope(x: _Number, y: _Number, result: _Number) -> _Number:
    """Write the derivative x^y log x with respect to y; zero unless x is positive: the exponent is constant there."""
    positive = x.builder.fcmp_ordered(">", x.value, _FLOAT(0.0))
    return result * x.another(x.builder.select(positive, x.of(math.log).value, _FLOAT(0.0)))


_KINDS = _Dual, types.Float, _Lanes, simd.Lanes
_WITH_DUALS, _SIDE_BY_SIDE = (_Dual, _Lanes), (_Lanes, simd.Lanes)


def _typed(kinds: tuple[Any, Any], result: Any, whole: bool) -> Any:
    """Type an operation on two numbers; None unless one is a dual. Integers become floats, a whole one does not."""
    known = all(isinstance(kind, (*_KINDS, types.Integer)) for kind in kinds)
    if not known or not any(isinstance(kind, _WITH_DUALS) for kind in kinds):
        return None
    if any(isinstance(kind, _SIDE_BY_SIDE) for kind in kinds):
        result = LANES
    first, second = (types.float64 if isinstance(kind, _NUMBERS) else kind for kind in kinds)
    return result(first, types.int64 if whole and isinstance(kinds[1], types.Integer) else second)


def _register(function: Any, operation: Operation, lanes: bool = False, whole: bool = False) -> None:
    """Teach numba an operation on two numbers, side by side too; ``whole``: an integer may be in the second place."""
    type_callable(function)(lambda context: lambda first, second: _typed((first, second), DUAL, whole))

    def code(context: Any, builder: Any, typed: Any, values: Any) -> Any:
        given = list(zip(typed.args, values, strict=True))
        if typed.return_type == DUAL:
            return packed(builder, operation(context, builder, *(parts(builder, *each) for each in given)))
        lanes = ([lane_parts(builder, *each, k) for each in given] for k in range(WIDTH))
        return together(builder, [operation(context, builder, *each) for each in lanes])

    for pair in product(_KINDS if lanes else _KINDS[:2], repeat=2):
        if not set(_WITH_DUALS).isdisjoint(pair):
            lower_builtin(function, *pair)(code)
    if whole:
        lower_builtin(function, _Dual, types.Integer)(code)


def _register_comparison(function: Any, sign: str) -> None:
    type_callable(function)(lambda context: lambda first, second: _typed((first, second), types.boolean, False))

    def code(context: Any, builder: Any, typed: Any, values: Any) -> Any:
        first, second = (parts(builder, *each).number for each in zip(typed.args, values, strict=True))
        compare = builder.fcmp_unordered if sign == "!=" else builder.fcmp_ordered
        return compare(sign, first, second)

    for pair in (_Dual, _Dual), (_Dual, types.Float), (types.Float, _Dual):
        lower_builtin(function, *pair)(code)


def _register_unary(function: Any, operation: Operation) -> None:
    type_callable(function)(lambda context: lambda x: DUAL if x == DUAL else None)

    def code(context: Any, builder: Any, typed: Any, values: Any) -> Any:
        return packed(builder, operation(context, builder, parts(builder, DUAL, values[0])))

    lower_builtin(function, _Dual)(code)


_ADD = _rule(lambda x, y: x + y, lambda x, y, r: 1.0, lambda x, y, r: 1.0)
_SUBTRACT = _rule(lambda x, y: x - y, lambda x, y, r: 1.0, lambda x, y, r: -1.0)
_MULTIPLY = _rule(lambda x, y: x * y, lambda x, y, r: y, lambda x, y, r: x)
_NEGATIVE = _rule(lambda x: -x, lambda x, r: -1.0)
_POWER = _rule(lambda x, y: x.of(operator.pow, y), _power_slope, _exponent_slope)
_ARITHMETIC = {
    operator.add: _ADD, operator.iadd: _ADD, operator.sub: _SUBTRACT, operator.isub: _SUBTRACT,
    operator.mul: _MULTIPLY, operator.imul: _MULTIPLY, operator.truediv: _divide, operator.itruediv: _divide,
}  # fmt: skip
_OF_TWO: dict[Any, Operation] = {
    min: _minimum,
    max: _maximum,
    math.atan2: _rule(
        lambda y, x: y.of(math.atan2, x),
        lambda y, x, r: x * (x * x + y * y).inverse(),
        lambda y, x, r: -(y * (x * x + y * y).inverse()),
    ),
    math.hypot: _rule(
        lambda x, y: x.of(math.hypot, y), lambda x, y, r: x * r.inverse(), lambda x, y, r: y * r.inverse()
    ),
    math.copysign: _rule(lambda x, y: x.of(math.copysign, y), lambda x, y, r: r.where(x, 1.0, -1.0)),
}
#: The derivative of each function of one number, from its argument and its value.
_OF_ONE: dict[Any, Callable[[Any, Any], _Number]] = {
    math.sqrt: lambda x, r: 0.5 * r.inverse(),
    math.exp: lambda x, r: r,
    math.expm1: lambda x, r: r + 1.0,
    math.log: lambda x, r: 1.0 / x,
    math.log10: lambda x, r: 1.0 / math.log(10.0) / x,
    math.log1p: lambda x, r: 1.0 / (x + 1.0),
    math.sin: lambda x, r: x.of(math.cos),
    math.cos: lambda x, r: -x.of(math.sin),
    math.tan: lambda x, r: r * r + 1.0,
    math.asin: lambda x, r: 1.0 / (1.0 - x * x).of(math.sqrt),
    math.acos: lambda x, r: -(1.0 / (1.0 - x * x).of(math.sqrt)),
    math.atan: lambda x, r: 1.0 / (x * x + 1.0),
    math.sinh: lambda x, r: x.of(math.cosh),
    math.cosh: lambda x, r: x.of(math.sinh),
    math.tanh: lambda x, r: 1.0 - r * r,
}
for _function, _operation in (*_ARITHMETIC.items(), *_OF_TWO.items()):
    _register(_function, _operation, lanes=_function in _ARITHMETIC)
for _function in operator.pow, operator.ipow, math.pow:
    _register(_function, _POWER, whole=True)
for _function, _sign in (
    (operator.lt, "<"), (operator.le, "<="), (operator.gt, ">"),
    (operator.ge, ">="), (operator.eq, "=="), (operator.ne, "!="),
):  # fmt: skip
    _register_comparison(_function, _sign)
_register_unary(operator.neg, _NEGATIVE)
_register_unary(operator.pos, lambda context, builder, x: x)
_register_unary(abs, _magnitude)
for _function, _partial in _OF_ONE.items():
    _register_unary(_function, _rule(methodcaller("of", _function), _partial))


@intrinsic
def _number(typing: Any, x: Any) -> Any:
    if x != DUAL:
        return types.float64(types.float64), lambda context, builder, typed, values: values[0]
    return types.float64(x), lambda context, builder, typed, values: builder.extract_value(values[0], 0)


@intrinsic
def _slope(typing: Any, x: Any, place: Any) -> Any:
    if x != DUAL:
        return types.float64(x, types.int64), lambda context, builder, typed, values: _FLOAT(0.0)

    def code(context: Any, builder: Any, typed: Any, values: Any) -> Any:
        return builder.extract_element(builder.extract_value(values[0], 1), builder.trunc(values[1], _INDEX))

    return types.float64(DUAL, types.int64), code


@intrinsic
def _is_known(typing: Any, x: Any) -> Any:
    def code(context: Any, builder: Any, typed: Any, values: Any) -> Any:
        slopes = builder.extract_value(values[0], 1)
        byte = ir.IntType(DIRECTIONS)
        return builder.icmp_signed("==", builder.bitcast(builder.fcmp_ordered("ord", slopes, slopes), byte), byte(-1))

    return types.boolean(DUAL), code


@intrinsic
def _varies(typing: Any, x: Any) -> Any:
    if x != DUAL:
        return types.boolean(types.float64), lambda context, builder, typed, values: ir.Constant(ir.IntType(1), 0)

    def code(context: Any, builder: Any, typed: Any, values: Any) -> Any:
        slopes = builder.extract_value(values[0], 1)
        moved = builder.fcmp_unordered("!=", slopes, ir.Constant(_SLOPES, [0.0] * DIRECTIONS))
        byte = ir.IntType(DIRECTIONS)
        return builder.icmp_signed("!=", builder.bitcast(moved, byte), byte(0))

    return types.boolean(DUAL), code


@intrinsic
def _put_slopes(typing: Any, array: Any, i: Any, k: Any, x: Any) -> Any:
    def code(context: Any, builder: Any, typed: Any, values: Any) -> Any:
        place = simd.place_in(builder, values[0], values[1:3], _SLOPES)
        builder.store(builder.extract_value(values[3], 1), place, align=8)
        return context.get_dummy_value()

    return types.void(array, types.int64, types.int64, DUAL), code


@intrinsic
def _seeded(typing: Any, number: Any, place: Any) -> Any:
    def code(context: Any, builder: Any, typed: Any, values: Any) -> Any:
        words = ir.VectorType(_WORD, DIRECTIONS)
        places = ir.Constant(words, [*range(DIRECTIONS)])
        own = builder.icmp_signed("==", _alike(builder, values[1], words), places)
        return packed(builder, Parts(values[0], builder.uitofp(own, _SLOPES)))

    return DUAL(types.float64, types.int64), code


@intrinsic
def _with_number(typing: Any, x: Any, number: Any) -> Any:
    def code(context: Any, builder: Any, typed: Any, values: Any) -> Any:
        return builder.insert_value(values[0], values[1], 0)

    return DUAL(DUAL, types.float64), code


#: ``number(x)``: the number of a dual; a float itself.
number: Callable[[Any], float] = (lambda x: x) if OFF else cast(Any, _number)
#: ``slope(x, place)``: the derivative of a dual along a direction.
slope: Callable[[Any, int], float] = cast(Any, _slope)
#: ``is_known(x)``: whether all slopes of a dual are numbers.
is_known: Callable[[Any], bool] = cast(Any, _is_known)
#: ``varies(x)``: whether a dual has a slope; false for a float.
varies: Callable[[float], bool] = (lambda x: False) if OFF else cast(Any, _varies)
#: ``put_slopes(array, i, k, x)``: put all slopes of a dual into an array (n, m) of floats from [i, k] on.
put_slopes: Callable[[Any, int, int, Any], None] = cast(Any, _put_slopes)
#: ``seeded(number, place)``: a dual whose slope is 1 along a direction, and zero along the others; zero beyond all.
seeded: Callable[[float, int], Any] = cast(Any, _seeded)
#: ``with_number(x, number)``: a dual with another number.
with_number: Callable[[Any, float], Any] = cast(Any, _with_number)


def _register_of_number(function: Any, result: Any) -> None:
    """Teach numba a function that takes the number of a dual alone."""
    type_callable(function)(lambda context: lambda x: result if x == DUAL else None)

    def code(context: Any, builder: Any, typed: Any, values: Any) -> Any:
        typing, given = context.typing_context, builder.extract_value(values[0], 0)
        own = typing.resolve_value_type(function)
        made = own.get_call_type(typing, [types.float64], {})
        return context.cast(builder, context.get_function(own, made)(builder, [given]), made.return_type, result)

    lower_builtin(function, _Dual)(code)


for _function, _result in (
    (int, types.int64), (math.ceil, types.int64), (math.floor, types.int64),
    (math.isfinite, types.boolean), (math.isnan, types.boolean),
):  # fmt: skip
    _register_of_number(_function, _result)


def room(like: float, shape: Any) -> Any:
    """Make an array of zeros for numbers of the kind of ``like``: floats, or duals."""
    return np.zeros(shape)


@overload(room)
def _room(like, shape):  # type: ignore[no-untyped-def]
    if like == DUAL:
        return lambda like, shape: np.zeros(shape, DUAL)
    return lambda like, shape: np.zeros(shape)


def lane_parts(builder: Any, kind: Any, value: Any, k: int) -> Parts:
    """Lane k of duals or numbers side by side, or of one that is the same in all."""
    if kind == LANES:
        return parts(builder, DUAL, builder.extract_value(value, k))
    if isinstance(kind, simd.Lanes):
        return Parts(builder.extract_element(value, _INDEX(k)))
    return parts(builder, kind, value)


def together(builder: Any, duals: Sequence[Parts]) -> Any:
    """Put duals side by side."""
    array = ir.Constant(ir.ArrayType(PAIR, WIDTH), ir.Undefined)
    for k, dual in enumerate(duals):
        array = builder.insert_value(array, packed(builder, dual), k)
    return array


@lower_cast(types.Float, _Lanes)
@lower_cast(_Dual, _Lanes)
@lower_cast(simd.Lanes, _Lanes)
def _to_lanes(context: Any, builder: Any, given: Any, wanted: Any, value: Any) -> Any:
    return together(builder, [lane_parts(builder, given, value, k) for k in range(WIDTH)])


@type_callable(operator.neg)
def _type_negative(context: Any) -> Callable[[Any], Any]:
    return lambda x: LANES if x == LANES else None


@lower_builtin(operator.neg, _Lanes)
def _negative_lanes(context: Any, builder: Any, typed: Any, values: Any) -> Any:
    lanes = (lane_parts(builder, LANES, values[0], k) for k in range(WIDTH))
    return together(builder, [_NEGATIVE(context, builder, each) for each in lanes])
