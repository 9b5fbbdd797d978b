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
        """Turn a dual into what is stored."""
        return _rebuilt(builder, value, _IN_MEMORY)

    def from_data(self, builder: Any, value: Any) -> Any:
        """Turn what is stored into a dual."""
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
    """An array of duals: a number and its slopes in the last axis; compiled code sees what is before it."""


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


def _scaled(builder: Any, slopes: Any, factor: Any) -> Any:
    """Slopes times a number."""
    if slopes is None:
        return None
    return builder.fmul(slopes, _alike(builder, factor, _SLOPES), flags=_FAST)


def _alike(builder: Any, value: Any, kind: Any) -> Any:
    """Vector of equal entries."""
    first = builder.insert_element(ir.Constant(kind, ir.Undefined), value, _INDEX(0))
    return builder.shuffle_vector(first, first, _ALIKE)


def _sum(builder: Any, first: Any, second: Any) -> Any:
    """Sum of slopes."""
    if first is None or second is None:
        return second if first is None else first
    return builder.fadd(first, second, flags=_FAST)


def _less(builder: Any, slopes: Any) -> Any:
    return None if slopes is None else builder.fneg(slopes)


class _Writer(NamedTuple):
    """What writes the code of an operation."""

    context: Any
    builder: Any

    def call(self, function: Any, *values: Any) -> Any:
        """Write a call of numba's function of floats, and of an integer exponent."""
        kinds = [types.float64 if value.type == _FLOAT else types.int64 for value in values]
        typing = self.context.typing_context
        own = typing.resolve_value_type(function)
        own.get_call_type(typing, kinds, {})
        return self.context.get_function(own, types.float64(*kinds))(self.builder, values)

    def finite_ratio(self, top: Any, bottom: Any) -> Any:
        """Write a ratio of numbers that is zero where the lower one is zero."""
        ratio = self.builder.fdiv(top, bottom)
        return self.builder.select(self.builder.fcmp_ordered("==", bottom, _FLOAT(0.0)), _FLOAT(0.0), ratio)


@lower_cast(types.Float, _Dual)
@lower_cast(types.Integer, _Dual)
def _without_slopes(context: Any, builder: Any, given: Any, wanted: Any, value: Any) -> Any:
    return packed(builder, Parts(context.cast(builder, value, given, types.float64)))


Operation = Callable[[_Writer, Parts, Parts], Parts]


def _add(write: _Writer, x: Parts, y: Parts) -> Parts:
    return Parts(write.builder.fadd(x.number, y.number), _sum(write.builder, x.slopes, y.slopes))


def _subtract(write: _Writer, x: Parts, y: Parts) -> Parts:
    slopes = _sum(write.builder, x.slopes, _less(write.builder, y.slopes))
    return Parts(write.builder.fsub(x.number, y.number), slopes)


def _multiply(write: _Writer, x: Parts, y: Parts) -> Parts:
    b = write.builder
    return Parts(b.fmul(x.number, y.number), _sum(b, _scaled(b, x.slopes, y.number), _scaled(b, y.slopes, x.number)))


def _divide(write: _Writer, x: Parts, y: Parts) -> Parts:
    b = write.builder
    ratio = b.fdiv(x.number, y.number)
    top = _sum(b, x.slopes, _scaled(b, y.slopes, b.fneg(ratio)))
    return Parts(ratio, _scaled(b, top, b.fdiv(_FLOAT(1.0), y.number)))


def _minimum(write: _Writer, x: Parts, y: Parts) -> Parts:
    return _chosen(write.builder, "<=", x, y)


def _maximum(write: _Writer, x: Parts, y: Parts) -> Parts:
    return _chosen(write.builder, ">=", x, y)


def _chosen(b: Any, sign: str, x: Parts, y: Parts) -> Parts:
    first = b.or_(b.fcmp_ordered(sign, x.number, y.number), b.fcmp_unordered("uno", x.number, x.number))
    return parts(b, DUAL, b.select(first, packed(b, x), packed(b, y)))  # no number stays none


def _arc_tangent(write: _Writer, y: Parts, x: Parts) -> Parts:
    b = write.builder
    square = b.fadd(b.fmul(x.number, x.number), b.fmul(y.number, y.number))
    inverse = write.finite_ratio(_FLOAT(1.0), square)
    across = _scaled(b, y.slopes, b.fmul(x.number, inverse))
    along = _scaled(b, x.slopes, b.fneg(b.fmul(y.number, inverse)))
    return Parts(write.call(math.atan2, y.number, x.number), _sum(b, across, along))


def _hypotenuse(write: _Writer, x: Parts, y: Parts) -> Parts:
    b, result = write.builder, write.call(math.hypot, x.number, y.number)
    inverse = write.finite_ratio(_FLOAT(1.0), result)
    slopes = (_scaled(b, each.slopes, b.fmul(each.number, inverse)) for each in (x, y))
    return Parts(result, _sum(b, *slopes))


def _copy_sign(write: _Writer, x: Parts, y: Parts) -> Parts:
    b, result = write.builder, write.call(math.copysign, x.number, y.number)
    side = b.select(b.fcmp_ordered("==", result, x.number), _FLOAT(1.0), _FLOAT(-1.0))
    return Parts(result, _scaled(b, x.slopes, side))


def _power(write: _Writer, x: Parts, y: Parts) -> Parts:
    b, whole = write.builder, y.number.type != _FLOAT
    result = write.call(operator.pow, x.number, y.number)
    less = b.sub(y.number, y.number.type(1)) if whole else b.fsub(y.number, _FLOAT(1.0))
    exponent = b.sitofp(y.number, _FLOAT) if whole else y.number
    slope = b.fmul(exponent, write.call(operator.pow, x.number, less))
    slope = b.select(b.fcmp_ordered("==", slope, _FLOAT(math.inf)), _FLOAT(0.0), slope)
    slopes = _scaled(b, x.slopes, slope)
    if y.slopes is not None:
        positive = b.fcmp_ordered(">", x.number, _FLOAT(0.0))  # else the exponent is constant
        log = b.select(positive, write.call(math.log, x.number), _FLOAT(0.0))
        slopes = _sum(b, slopes, _scaled(b, y.slopes, b.fmul(result, log)))
    return Parts(result, slopes)


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
        given, write = list(zip(typed.args, values, strict=True)), _Writer(context, builder)
        if typed.return_type == DUAL:
            return packed(builder, operation(write, *(parts(builder, *each) for each in given)))
        found = [operation(write, *(lane_parts(builder, *each, k) for each in given)) for k in range(WIDTH)]
        return together(builder, found)

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


def _register_unary(function: Any, operation: Callable[[_Writer, Parts], Parts]) -> None:
    type_callable(function)(lambda context: lambda x: DUAL if x == DUAL else None)

    def code(context: Any, builder: Any, typed: Any, values: Any) -> Any:
        return packed(builder, operation(_Writer(context, builder), parts(builder, DUAL, values[0])))

    lower_builtin(function, _Dual)(code)


def _register_function(function: Any, slope: Callable[[_Writer, Any, Any], Any]) -> None:
    """Teach numba a function of one number by its slope, from its argument and its value."""

    def operation(write: _Writer, x: Parts) -> Parts:
        result = write.call(function, x.number)
        return Parts(result, _scaled(write.builder, x.slopes, slope(write, x.number, result)))

    _register_unary(function, operation)


def _negative(write: _Writer, x: Parts) -> Parts:
    return Parts(write.builder.fneg(x.number), _less(write.builder, x.slopes))


def _magnitude(write: _Writer, x: Parts) -> Parts:
    return _chosen(write.builder, ">=", x, _negative(write, x))


def _inverse(write: _Writer, x: Any) -> Any:
    return write.builder.fdiv(_FLOAT(1.0), x)


def _one_and_square(write: _Writer, x: Any, sign: float) -> Any:
    b = write.builder
    return b.fadd(_FLOAT(1.0), b.fmul(_FLOAT(sign), b.fmul(x, x)))


def _inverse_root(write: _Writer, x: Any) -> Any:
    return _inverse(write, write.call(math.sqrt, _one_and_square(write, x, -1.0)))


_ARITHMETIC: dict[Any, Operation] = {
    operator.add: _add, operator.iadd: _add,
    operator.sub: _subtract, operator.isub: _subtract,
    operator.mul: _multiply, operator.imul: _multiply,
    operator.truediv: _divide, operator.itruediv: _divide,
}  # fmt: skip
_FUNCTIONS: dict[Any, Operation] = {
    min: _minimum,
    max: _maximum,
    math.atan2: _arc_tangent,
    math.hypot: _hypotenuse,
    math.copysign: _copy_sign,
}
for _function, _operation in (*_ARITHMETIC.items(), *_FUNCTIONS.items()):
    _register(_function, _operation, lanes=_function in _ARITHMETIC)
for _function in operator.pow, operator.ipow, math.pow:
    _register(_function, _power, whole=True)
for _function, _sign in (
    (operator.lt, "<"), (operator.le, "<="), (operator.gt, ">"),
    (operator.ge, ">="), (operator.eq, "=="), (operator.ne, "!="),
):  # fmt: skip
    _register_comparison(_function, _sign)
_register_unary(operator.neg, _negative)
_register_unary(operator.pos, lambda write, x: x)
_register_unary(abs, _magnitude)
for _function, _derivative in cast(
    dict[Any, Callable[[_Writer, Any, Any], Any]],
    {
        math.sqrt: lambda write, x, result: write.finite_ratio(_FLOAT(0.5), result),
        math.exp: lambda write, x, result: result,
        math.expm1: lambda write, x, result: write.builder.fadd(_FLOAT(1.0), result),
        math.log: lambda write, x, result: _inverse(write, x),
        math.log10: lambda write, x, result: write.builder.fdiv(_FLOAT(1.0 / math.log(10.0)), x),
        math.log1p: lambda write, x, result: _inverse(write, write.builder.fadd(_FLOAT(1.0), x)),
        math.sin: lambda write, x, result: write.call(math.cos, x),
        math.cos: lambda write, x, result: write.builder.fneg(write.call(math.sin, x)),
        math.tan: lambda write, x, result: _one_and_square(write, result, 1.0),
        math.asin: lambda write, x, result: _inverse_root(write, x),
        math.acos: lambda write, x, result: write.builder.fneg(_inverse_root(write, x)),
        math.atan: lambda write, x, result: _inverse(write, _one_and_square(write, x, 1.0)),
        math.sinh: lambda write, x, result: write.call(math.cosh, x),
        math.cosh: lambda write, x, result: write.call(math.sinh, x),
        math.tanh: lambda write, x, result: _one_and_square(write, result, -1.0),
    },
).items():
    _register_function(_function, _derivative)


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
    write = _Writer(context, builder)
    return together(builder, [_negative(write, lane_parts(builder, LANES, values[0], k)) for k in range(WIDTH)])
