"""Duals side by side: what `linkages.base.kernel.simd` does with numbers, for `linkages.base.kernel.dual`."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types

from linkages.base.kernel import simd
from linkages.base.kernel.dual import DUAL, LANES, lane_parts, parts, spot_of, together
from linkages.base.kernel.simd import WIDTH

_INDEX, _WORD = ir.IntType(32), ir.IntType(64)


def _lane(kinds: Any) -> Any:
    def code(context: Any, builder: Any, typed: Any, values: Any) -> Any:
        place = spot_of(builder, values[0])
        return builder.load(builder.gep(place, [_WORD(0), values[1]]))

    return DUAL(LANES, types.int64), code


def _with_lane(kinds: Any) -> Any:
    def code(context: Any, builder: Any, typed: Any, values: Any) -> Any:
        place = spot_of(builder, context.cast(builder, values[0], typed.args[0], LANES))
        own = context.cast(builder, values[2], typed.args[2], DUAL)
        builder.store(own, builder.gep(place, [_WORD(0), values[1]]))
        return builder.load(place)

    return LANES(kinds[0], types.int64, DUAL if kinds[2] == DUAL else types.float64), code


def _side_by_side(kinds: Any) -> Any:
    def code(context: Any, builder: Any, typed: Any, values: Any) -> Any:
        return together(builder, [parts(builder, *each) for each in zip(typed.args, values, strict=True)])

    return LANES(*[kind if kind == DUAL else types.float64 for kind in kinds]), code


def _places(context: Any, builder: Any, array: Any, indices: Any) -> list[Any]:
    first = simd.place_in(builder, array, indices, context.get_data_type(DUAL))
    return [builder.gep(first, [_WORD(k)]) for k in range(WIDTH)]


def _lanes_at(kinds: Any) -> Any:
    def code(context: Any, builder: Any, typed: Any, values: Any) -> Any:
        load = context.data_model_manager[DUAL].load_from_data_pointer
        found = (load(builder, place) for place in _places(context, builder, values[0], values[1:]))
        return together(builder, [parts(builder, DUAL, each) for each in found])

    return LANES(kinds[0], types.int64, types.int64), code


def _put_lanes(kinds: Any) -> Any:
    def code(context: Any, builder: Any, typed: Any, values: Any) -> Any:
        lanes = context.cast(builder, values[3], typed.args[3], LANES)
        for k, place in enumerate(_places(context, builder, values[0], values[1:3])):
            for part, each in enumerate(lane_parts(builder, LANES, lanes, k)):
                builder.store(each, builder.gep(place, [_INDEX(0), _INDEX(part)]), align=8)
        return context.get_dummy_value()

    return types.void(kinds[0], types.int64, types.int64, kinds[3]), code


simd.codes_of_duals.update(
    lane=_lane, with_lane=_with_lane, side_by_side=_side_by_side, lanes_at=_lanes_at, put_lanes=_put_lanes
)
