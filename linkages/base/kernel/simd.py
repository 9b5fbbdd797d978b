"""Numbers side by side: one operation of the processor for several of them.

An entry of a `LaneArray` is `WIDTH` numbers, which compiled code adds, subtracts, multiplies and divides at once, with
each other or each with the same number. So what is linear in a direction is found for several directions in hardly more
time than for one, by code that reads as if it were for one.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any, cast

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import (
    intrinsic,
    lower_builtin,
    lower_cast,
    models,
    register_model,
    type_callable,
    typeof_impl,
)  # fmt: skip

from linkages.base.kernel.private import array_field

WIDTH = 4  #: of the registers of present processors, or twice it


class LaneArray(np.ndarray[Any, np.dtype[np.float64]]):
    """An array of `WIDTH` numbers side by side, the last axis; compiled code sees the axes before it."""

    axes = 1  #: of an entry


def lane_array(*shape: int) -> LaneArray:
    """Make an array of lanes, all zero."""
    return np.zeros((*shape, WIDTH)).view(LaneArray)


class Lanes(types.Type):
    """Type of numbers side by side."""

    def __init__(self) -> None:
        super().__init__(name="Lanes")

    def can_convert_from(self, typing: Any, other: Any) -> Any:
        """Convert a number to lanes that are all the same."""
        return typing.can_convert(other, types.complex128) if isinstance(other, types.Float) else None


_lanes = Lanes()


@register_model(Lanes)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Lanes) -> None:
        super().__init__(manager, kind, ir.VectorType(ir.DoubleType(), WIDTH))


@typeof_impl.register(LaneArray)
def _type_of(value: LaneArray, context: Any) -> Any:
    return types.Array(_lanes, value.ndim - 1, "C", aligned=False)


@lower_cast(types.Float, Lanes)
def _alike(context: Any, builder: Any, given: Any, wanted: Any, value: Any) -> Any:
    """Put a number into all lanes."""
    number = context.cast(builder, value, given, types.float64)
    vector = ir.VectorType(ir.DoubleType(), WIDTH)
    first = builder.insert_element(ir.Constant(vector, ir.Undefined), number, ir.IntType(32)(0))
    return builder.shuffle_vector(first, first, ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), [0] * WIDTH))


def _register(function: Any, name: str) -> None:
    def type_call(first: Any, second: Any) -> Any:
        kinds = [each if each == _lanes else types.float64 for each in (first, second)]
        numbers = all(isinstance(each, Lanes | types.Float | types.Integer) for each in (first, second))
        return _lanes(*kinds) if numbers and _lanes in kinds else None

    type_callable(function)(lambda context: type_call)

    def code(context: Any, builder: Any, typed: Any, values: Any) -> Any:
        first, second = (context.cast(builder, *each, _lanes) for each in zip(values, typed.args, strict=True))
        return getattr(builder, name)(first, second)

    for pair in (_lanes, _lanes), (_lanes, types.float64), (types.float64, _lanes):
        lower_builtin(function, *pair)(code)


for _function, _inplace, _name in (
    (operator.add, operator.iadd, "fadd"),
    (operator.sub, operator.isub, "fsub"),
    (operator.mul, operator.imul, "fmul"),
    (operator.truediv, operator.itruediv, "fdiv"),
):
    _register(_function, _name)
    _register(_inplace, _name)


@type_callable(operator.neg)
def _type_negative(context: Any) -> Callable[[Any], Any]:
    return lambda lanes: lanes if lanes == _lanes else None


@lower_builtin(operator.neg, _lanes)
def _negative(context: Any, builder: Any, typed: Any, values: Any) -> Any:
    return builder.fneg(values[0])


#: The same for duals side by side, by the names below: ``code(kinds)`` as an intrinsic returns it.
codes_of_duals: dict[str, Callable[[Any], Any]] = {}


def _code_of(name: str, which: Any, kinds: Any) -> Any:
    """Return the code for duals if a type is not that of numbers, else None."""
    numbers = types.Float, types.Integer, Lanes
    return None if all(isinstance(kind, numbers) for kind in which) else codes_of_duals[name](kinds)


@intrinsic
def _lane(typing: Any, lanes: Any, place: Any) -> Any:
    def code(context: Any, builder: Any, typed: Any, values: Any) -> Any:
        return builder.extract_element(values[0], builder.trunc(values[1], ir.IntType(32)))

    return _code_of("lane", [lanes], [lanes]) or (types.float64(_lanes, types.int64), code)


@intrinsic
def _with_lane(typing: Any, lanes: Any, place: Any, value: Any) -> Any:
    def code(context: Any, builder: Any, typed: Any, values: Any) -> Any:
        return builder.insert_element(values[0], values[2], builder.trunc(values[1], ir.IntType(32)))

    own = _lanes(_lanes, types.int64, types.float64), code
    return _code_of("with_lane", [lanes, value], [lanes, place, value]) or own


@intrinsic
def _side_by_side(typing: Any, first: Any, second: Any, third: Any, fourth: Any) -> Any:
    def code(context: Any, builder: Any, typed: Any, values: Any) -> Any:
        vector = ir.Constant(ir.VectorType(ir.DoubleType(), WIDTH), ir.Undefined)
        for place, value in enumerate(values):
            vector = builder.insert_element(vector, value, ir.IntType(32)(place))
        return vector

    kinds = first, second, third, fourth
    return _code_of("side_by_side", kinds, kinds) or (_lanes(*[types.float64] * WIDTH), code)


def place_in(builder: Any, array: Any, indices: Any, kind: Any) -> Any:
    """Find the place at these indices."""
    data, strides = (array_field(builder, array, name) for name in ("data", "strides"))
    data = builder.ptrtoint(data, ir.IntType(64))
    for k, index in enumerate(indices):
        data = builder.add(data, builder.mul(index, builder.extract_value(strides, k)))
    return builder.inttoptr(data, kind.as_pointer())


@intrinsic
def _lanes_at(typing: Any, array: Any, i: Any, k: Any) -> Any:
    def code(context: Any, builder: Any, typed: Any, values: Any) -> Any:
        vector = ir.VectorType(ir.DoubleType(), WIDTH)
        return builder.load(place_in(builder, values[0], values[1:], vector), align=8)

    own = _lanes(array, types.int64, types.int64), code
    return _code_of("lanes_at", [array.dtype], [array, i, k]) or own


@intrinsic
def _put_lanes(typing: Any, array: Any, i: Any, k: Any, lanes: Any) -> Any:
    def code(context: Any, builder: Any, typed: Any, values: Any) -> Any:
        vector = ir.VectorType(ir.DoubleType(), WIDTH)
        builder.store(values[3], place_in(builder, values[0], values[1:3], vector), align=8)
        return context.get_dummy_value()

    own = types.void(array, types.int64, types.int64, _lanes), code
    return _code_of("put_lanes", [array.dtype], [array, i, k, lanes]) or own


#: ``lanes(a, b, c, d)``: these numbers, side by side.
lanes: Callable[[float, float, float, float], Any] = cast(Any, _side_by_side)
#: ``lane(lanes, place)``: the number in a lane.
lane: Callable[[Any, int], float] = cast(Any, _lane)
#: ``with_lane(lanes, place, number)``: lanes with a number in one of them, the others as given.
with_lane: Callable[[Any, int, float], Any] = cast(Any, _with_lane)
#: ``lanes_at(array, i, k)``: as lanes, the numbers of an array (n, m) from [i, k] on.
lanes_at: Callable[[Any, int, int], Any] = cast(Any, _lanes_at)
#: ``put_lanes(array, i, k, lanes)``: put lanes there.
put_lanes: Callable[[Any, int, int, Any], None] = cast(Any, _put_lanes)
