"""Named tuples by reference, for compiled code that hands many arrays from function to function.

Numba hands a named tuple over by value, every array as seven words or more, and counts references to each array with
atomic operations. For the small kernels here that costs more than their arithmetic, and most of the compiler's time. A
reference is one pointer; its attributes are the fields of the named tuple, loaded where they are used, nested named
tuples as references again.
"""

from __future__ import annotations

import hashlib
import struct
from collections.abc import Callable
from ctypes import addressof, c_char
from typing import Any, NamedTuple, TypeVar, cast

import numpy as np
from llvmlite import ir
from numba import typeof, types
from numba.extending import (
    NativeValue,
    infer_getattr,
    intrinsic,
    lower_getattr_generic,
    models,
    register_model,
    unbox,
)  # fmt: skip

from linkages.base.arrays import Indices
from linkages.base.kernel.fingerprint import full_name
from linkages.base.kernel.private import ARRAY_DATA, OFF, AttributeTemplate, array_words, without_owner
from linkages.base.kernel.simd import LaneArray

T = TypeVar("T")

_MANY = 1000  # layouts that are kept
_OWNER = 4  # flag of an array that owns its memory, which numba's types do not have


class Reference(types.Type):
    """Type of a reference to a named tuple."""

    def __init__(self, target: Any) -> None:
        self.target = target
        super().__init__(name=f"Reference({full_name(target)})")

    @property
    def mangling_args(self) -> tuple[str, tuple[()]]:
        """Name of the type within the names of functions: short."""
        return f"Reference_{hashlib.sha256(self.name.encode()).hexdigest()[:16]}", ()


@register_model(Reference)
class _ReferenceModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Reference) -> None:
        super().__init__(manager, kind, manager.lookup(kind.target).get_value_type().as_pointer())


@infer_getattr
class _ReferenceAttributes(AttributeTemplate):
    key = Reference

    def generic_resolve(self, kind: Reference, name: str) -> Any:  # type: ignore[override]
        """Return the type of a field."""
        if name not in kind.target.fields:
            return None
        field = tuple(kind.target)[kind.target.fields.index(name)]
        return Reference(field) if isinstance(field, types.BaseNamedTuple) else field


@lower_getattr_generic(Reference)
def _load_field(context: Any, builder: Any, kind: Reference, value: Any, name: str) -> Any:
    index = kind.target.fields.index(name)
    field = tuple(kind.target)[index]
    pointer = builder.gep(value, [ir.IntType(32)(0), ir.IntType(32)(index)], inbounds=True)
    if isinstance(field, types.BaseNamedTuple):
        return pointer
    loaded = builder.load(pointer)
    return without_owner(builder, loaded) if isinstance(field, types.Array) else loaded  # nothing is counted


@intrinsic
def _reference(typing: Any, value: Any) -> Any:
    """Return a reference to a named tuple, valid in the calling function and in those it calls.

    The caller keeps the arrays alive: the named tuple is made of its own arguments, or of variables used later.
    """
    if isinstance(value, Reference):  # from Python
        return value(value), lambda context, builder, signature, arguments: arguments[0]
    if not isinstance(value, types.BaseNamedTuple):
        return None

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        with builder.goto_entry_block():
            place = builder.alloca(arguments[0].type)
        builder.store(arguments[0], place)
        return place

    return Reference(value)(value), code


class Packed:
    """A named tuple laid out in memory, for compiled code that takes a reference to it.

    Numba would take it apart array by array in each function that Python calls, which costs seconds of compilation.

    Parameters
    ----------
    value : named tuple
        Of arrays, numbers, named tuples and packed ones. The arrays' contents are shared; attributes are the tuple's.
    """

    def __init__(self, value: Any) -> None:
        items: list[Any] = []
        key = _key(value, items)
        layout = _layouts.get(key) or _add_layout(key, value)
        self.unpacked = value
        self._numba_type_, self._words = layout.kind, layout.words.copy()
        self._words[layout.places] = [_word(item) for item in items]
        self.place = _address(self._words)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.unpacked, name)


class _Layout(NamedTuple):
    """Words of packed values that have the same types and shapes of arrays."""

    kind: Reference
    words: Indices
    places: Indices  # of the words that differ: numbers, addresses of arrays and of packed values


_layouts: dict[Any, _Layout] = {}


def _key(value: Any, items: list[Any]) -> Any:
    """Return the key of a value's layout; add its numbers, arrays with entries and packed values to the items."""
    if isinstance(value, np.ndarray):
        if value.size:
            items.append(value)
        return type(value), value.dtype, value.shape, value.strides, value.flags.num
    if isinstance(value, tuple):
        return type(value), *[_key(item, items) for item in value]
    if isinstance(value, bool | np.bool_):
        return bool, bool(value)
    items.append(value)
    return value._numba_type_ if isinstance(value, Packed) else type(value)


def _add_layout(key: Any, value: Any) -> _Layout:
    """Make the layout of values with this key, and keep it."""
    words, spots = bytearray(), list[tuple[int, Any]]()
    lay(value, words, spots)
    words.extend(bytes(-len(words) % 8))
    places = np.array([spot // 8 for spot, _ in spots], np.int64)
    if len(_layouts) >= _MANY:
        _layouts.clear()
    layout = _layouts[key] = _Layout(reference_to(value), np.frombuffer(words, np.int64), places)
    return layout


def _word(item: Any) -> int:
    """Return the word of a number, of an array's address, or of a packed value's."""
    if isinstance(item, np.ndarray):
        return _address(item)
    if isinstance(item, float):
        return int(np.float64(item).view(np.int64))
    return int(item.place if isinstance(item, Packed) else item)


_references: dict[Any, Reference] = {}  # by what `shape` gives: numba takes milliseconds to find a type


def reference_to(value: Any) -> Reference:
    """Return the type of a reference to a named tuple of arrays, numbers, named tuples and packed ones."""
    found = shape(value)
    if found not in _references:
        _references[found] = Reference(typeof(value))
    return _references[found]


def shape(value: Any) -> Any:
    """Return a key for the numba type of a value, which takes numba longer to find."""
    if isinstance(value, Packed):
        return Packed, value._numba_type_
    if isinstance(value, tuple):
        return type(value), *map(shape, value)
    if isinstance(value, np.ndarray):
        return type(value), value.dtype, value.ndim, value.flags.num & ~_OWNER
    return type(value), getattr(value, "dtype", None)


def reference_type(value: Any) -> Any:
    """Return the numba type of a packed named tuple."""
    return value._numba_type_


def packed(value: T) -> T:
    """Lay a named tuple out in memory; the result is a `Packed`."""
    return cast(T, Packed(value))


def lay(value: Any, words: bytearray, spots: list[tuple[int, Any]]) -> None:
    """Add a value as numba lays it out: arrays as structures without owners, each on a multiple of its size.

    ``spots`` gets the place of each number, of each packed value's address, and of the address of each array with
    entries; nobody reads the others.
    """
    if isinstance(value, bool | np.bool_):
        words.append(int(value))
        return
    words.extend(bytes(-len(words) % 8))
    if isinstance(value, tuple):
        for item in value:
            lay(item, words, spots)
        words.extend(bytes(-len(words) % 8))  # a structure that ends with a truth value
    elif isinstance(value, np.ndarray):
        lengths, strides = value.shape, value.strides
        if isinstance(value, LaneArray):
            lengths, strides = lengths[: -value.axes], strides[: -value.axes]
        if value.size:
            spots.append((len(words) + ARRAY_DATA, value))
        structure = array_words(value, _address(value) if value.size else 0, lengths, strides)
        words.extend(struct.pack(f"{len(structure)}q", *structure))
    else:
        spots.append((len(words), value))
        number = value.place if isinstance(value, Packed) else value
        words.extend(struct.pack("d" if isinstance(value, float) else "q", number))


def _address(array: Any) -> int:
    """Return the address of an array's contents; NumPy's own way takes five times as long, except for records."""
    try:
        return int(array.ctypes.data) if array.dtype.names else addressof(c_char.from_buffer(array))
    except (TypeError, ValueError, BufferError):  # read-only, or with gaps
        return int(array.ctypes.data)


@unbox(Reference)
def _unbox_reference(kind: Reference, value: Any, c: Any) -> NativeValue:
    place = c.pyapi.object_getattr_string(value, "place")
    pointer = c.builder.inttoptr(c.pyapi.long_as_longlong(place), c.context.get_value_type(kind))
    c.pyapi.decref(place)
    return NativeValue(pointer)


#: ``reference(value)`` within compiled code, see `_reference`; without a compiler, the value itself.
reference: Callable[[Any], Any] = (lambda value: value) if OFF else cast(Any, _reference)
