"""Keys of tables: allowed values and units; conversion of values with units to numbers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Literal, get_args, get_origin

import tomlkit
from pydantic import BaseModel, GetCoreSchemaHandler
from pydantic.fields import FieldInfo
from pydantic_core import CoreSchema
from pydantic_core.core_schema import no_info_after_validator_function

from linkages.base.errors import nearest


@dataclass(frozen=True)
class OneOf:
    """Validates a name against a registry at the time of use, so that later entries are valid too."""

    registry: Mapping[str, object]

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return no_info_after_validator_function(self._check, handler(source))

    def _check(self, name: str) -> str:
        if name not in self.registry:
            raise ValueError(f'"{name}" is unknown; {nearest(name, self.registry)}')
        return name


def table_keys(model: type[BaseModel]) -> Iterator[tuple[str, str]]:
    """Yield every key of a table and its inner tables, by dotted path, with meaning and unit."""
    return ((path, info.description or "") for path, info in _fields(model))


def described_keys(model: type[BaseModel]) -> Iterator[tuple[str, str]]:
    """Yield every key with its meaning, whether it is required, default, and allowed values."""
    for path, info in _fields(model):
        rules = [info.description]
        if choices := names_taken(info):
            rules.append(f"one of {', '.join(choices)}")
        signs = {"gt": ">", "ge": ">=", "lt": "<", "le": "<="}
        limits = [
            f"{sign} {getattr(rule, key):g}"
            for rule in _content(info)
            for key, sign in signs.items()
            if isinstance(getattr(rule, key, None), int | float)
        ]
        if limits:
            rules.append(" and ".join(dict.fromkeys(limits)))
        if info.is_required():
            rules.append("required")
        elif isinstance(info.default, bool | int | float) or (info.default and isinstance(info.default, str)):
            shown = info.default if isinstance(info.default, str) else tomlkit.item(info.default).as_string()
            rules.append(f"default {shown}")
        yield path, "; ".join(filter(None, rules))


def taken_keys(model: type[BaseModel], data: Any) -> Mapping[str, FieldInfo]:
    """Return the allowed keys of a table with these values: parameters, for example, depend on the law."""
    added = getattr(model, "added_keys", None)
    if added is None or not isinstance(data, Mapping):
        return model.model_fields
    return {**model.model_fields, **added(data)}


def _fields(model: type[BaseModel], prefix: str = "") -> Iterator[tuple[str, FieldInfo]]:
    """Yield the fields of a table and its inner tables by dotted path."""
    declared = getattr(model, "declared_keys", tuple)
    for name, info in (*model.model_fields.items(), *declared()):
        inner = inner_table(info)
        named = is_named(info) and inner is not None
        path = f"{prefix}{name}" + (".NAME" if named else "")
        yield path, info
        if inner is not None:
            yield from _fields(inner, path + ".")


def names_taken(info: FieldInfo) -> list[str]:
    """Return the allowed names of a key; empty if it also allows others."""
    content = _content(info)
    found = [str(name) for kind in content if get_origin(kind) is Literal for name in get_args(kind)]
    return found + [name for rule in content if isinstance(rule, OneOf) for name in sorted(rule.registry)]


def inner_table(info: FieldInfo) -> type[BaseModel] | None:
    """Find the table type of a key, of its list items or of its named tables; None without one."""
    return next((kind for kind in _content(info) if isinstance(kind, type) and issubclass(kind, BaseModel)), None)


def _content(info: FieldInfo) -> list[Any]:
    """List the types and constraints of a key, of its alternatives and of its items."""
    found: list[Any] = [*info.metadata, info.annotation]
    for kind in found:  # grows during the iteration
        if isinstance(kind, FieldInfo):
            found += kind.metadata
        elif get_origin(kind) is not Literal:
            found += get_args(kind)
    return found


def is_number(info: FieldInfo) -> bool:
    """Check whether a key allows numbers, or lists of numbers, and no text."""
    kinds = [kind for kind in _content(info) if isinstance(kind, type)]
    return (float in kinds or int in kinds) and str not in kinds


def is_named(info: FieldInfo) -> bool:
    """Check whether a key holds tables with user-defined names."""
    return str(info.annotation).startswith("dict")


def bracketed(meaning: str | None) -> str:
    """Return the bracketed unit in a key's meaning; empty without one.

    Examples
    --------
    >>> from linkages.input.files.table_keys import bracketed
    >>> bracketed("radial clearance c [m]")
    'm'
    """
    return (meaning or "").partition("[")[2].partition("]")[0]
