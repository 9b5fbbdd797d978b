"""TOML files as typed tables: reading, comments as sources, replacement by dotted path, errors in one line."""

from __future__ import annotations

import io
import re
import tomllib
from collections.abc import Iterator, Mapping, Sized
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, Literal, TypeVar, Union, get_args, get_origin

import tomlkit
from pydantic import BaseModel, ConfigDict, Field, GetCoreSchemaHandler, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import CoreSchema
from pydantic_core.core_schema import no_info_after_validator_function
from tomlkit.exceptions import TOMLKitError

from linkages.errors import InputError, nearest
from linkages.files.numbers import implausible
from linkages.files.reading import read_whole

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NonNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Finite = Annotated[float, Field(allow_inf_nan=False)]

_DEEPEST = 20  # levels of nesting: reading recurses
_LONGEST = 80  # characters of a wrong value that are shown


class Table(BaseModel):
    """A table of a TOML file: unknown keys are errors, values keep their types and do not change."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


AnyTable = TypeVar("AnyTable", bound=Table)


def read_toml(path: Path) -> tuple[dict[str, Any], dict[str, str]]:
    """Read a file: its values, and by dotted path the comment beside each value.

    Raises
    ------
    InputError
        If the file cannot be read or is not TOML.
    """
    if path.suffix == ".sdf":
        raise InputError(path, "", "is a machine; give the file (.toml) that says what is done with it")
    data = io.BytesIO(read_whole(path))
    try:
        document = tomlkit.parse(io.TextIOWrapper(data, "utf-8").read())
        return document.unwrap(), dict(_comments(document))
    except RecursionError:
        raise InputError(path, "", "is nested too deeply") from None
    except (TOMLKitError, ValueError) as problem:  # ValueError: not UTF-8, or a number with too many digits
        raise InputError(path, "", f"is not valid TOML: {problem}") from None


def replace_values(data: dict[str, Any], overrides: Mapping[str, Any], origin: str) -> None:
    """Replace values in nested tables by dotted path, in place; strings are read as TOML values."""
    for path, value in overrides.items():
        parts = path.split(".")
        if not all(parts):
            problem = "is not a path; write keys with dots between them, such as joints.A.clearance"
            raise InputError(origin, f'"{path}"', problem)
        table = data
        for part in parts[:-1]:
            table = table.setdefault(part, {})
            if not isinstance(table, dict):
                raise InputError(origin, path, f'"{part}" is a value, not a table')
        table[parts[-1]] = parse_value(value) if isinstance(value, str) else value


def value_at(table: Table, path: str, source: Path) -> float:
    """Return the number at a dotted path of a table; InputError if there is none."""
    here: Any = table
    for part in path.split("."):
        known = dict(here) if isinstance(here, BaseModel | Mapping) else {}
        if part not in known:
            raise InputError(source, path, f'has no "{part}"; {nearest(part, known)}')
        here = known[part]
    if here is None:
        raise InputError(source, path, "has no value in the experiment; give one there, or nominal")
    if isinstance(here, bool) or not isinstance(here, int | float):
        raise InputError(source, path, "is not a number, and cannot be a design variable")
    return float(here)


def validate(
    model: type[AnyTable], data: Mapping[str, Any], source: Path, origins: Mapping[str, str] | None = None
) -> AnyTable:
    """Build a table from its values; `origins` has by dotted path where those not of the file came from.

    Raises
    ------
    InputError
        For the first value that is wrong: file (or origin), dotted path, what is wrong and what would be right.
    """
    for where, problem in _implausible(data):
        raise InputError((origins or {}).get(where, source), where, problem)
    try:
        return model.model_validate(dict(data))
    except ValidationError as problem:
        # a misspelt key often leaves another one missing: name the misspelt one
        first = min(problem.errors(), key=lambda error: error["type"] != "extra_forbidden")
        where = ".".join(str(part) for part in first["loc"])
        raise InputError((origins or {}).get(where, source), where, _explain(model, first)) from None


def check_history(times: list[float] | None, values: Sized | None, name: str) -> None:
    """Check a table over time: equally many times and values; times increase, from 0 or before."""
    if (values is None) != (times is None):
        raise ValueError(f"times go with {name}")
    if values is None or times is None:
        return
    if len(values) != len(times) or len(values) < 2:
        raise ValueError(f"{len(times)} times and {len(values)} values; two or more of each, equally many")
    if any(b <= a for a, b in pairwise(times)):
        raise ValueError("times must increase")
    if times[0] > 0.0:
        raise ValueError("times must start at 0 or before")


@dataclass(frozen=True)
class OneOf:
    """Validates a name against those of a registry, as it is then: what is registered later can be named too."""

    registry: Mapping[str, object]

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return no_info_after_validator_function(self._check, handler(source))

    def _check(self, name: str) -> str:
        if name not in self.registry:
            raise ValueError(f'"{name}" is unknown; {nearest(name, self.registry)}')
        return name


def table_keys(model: type[BaseModel], prefix: str = "") -> Iterator[tuple[str, str]]:
    """Every key of a table and of the tables in it, by dotted path, with its meaning and unit."""
    return ((path, info.description or "") for path, info in _fields(model, prefix))


def described_keys(model: type[BaseModel]) -> Iterator[tuple[str, str]]:
    """Every key with its meaning, whether it is required, its default, and the values that it takes."""
    for path, info in _fields(model):
        yield path, "; ".join(filter(None, [info.description, *_rules(info)]))


def _fields(model: type[BaseModel], prefix: str = "") -> Iterator[tuple[str, FieldInfo]]:
    """Fields of a table and of the tables in it by dotted path."""
    for name, info in model.model_fields.items():
        inner = _inner(info)
        named = str(info.annotation).startswith("dict") and inner is not None
        path = f"{prefix}{name}" + (".NAME" if named else "")
        yield path, info
        if inner is not None:
            yield from _fields(inner, path + ".")


def _rules(info: FieldInfo) -> Iterator[str]:
    """Say what a key takes."""
    if choices := _choices(info):
        yield f"one of {', '.join(choices)}"
    signs = {"gt": ">", "ge": ">=", "lt": "<", "le": "<="}
    limits = [
        f"{sign} {getattr(rule, key):g}"
        for rule in _metadata(info)
        for key, sign in signs.items()
        if isinstance(getattr(rule, key, None), int | float)
    ]
    if limits:
        yield " and ".join(dict.fromkeys(limits))
    if info.is_required():
        yield "required"
    elif isinstance(info.default, bool | int | float) or (info.default and isinstance(info.default, str)):
        shown = info.default if isinstance(info.default, str) else tomlkit.item(info.default).as_string()
        yield f"default {shown}"


def _choices(info: FieldInfo) -> list[str]:
    """Names that a key takes; none if it takes others too."""
    kinds, found = [info.annotation], []
    while kinds:
        kind = kinds.pop(0)
        found += [str(name) for name in get_args(kind) if get_origin(kind) is Literal]
        kinds += [] if get_origin(kind) is Literal else get_args(kind)
    return found + [name for rule in _metadata(info) if isinstance(rule, OneOf) for name in sorted(rule.registry)]


def _metadata(info: FieldInfo) -> Iterator[Any]:
    """Find what is asked of a key's values, of one among other kinds too."""
    kinds: list[Any] = [*info.metadata, info.annotation]
    for kind in kinds:  # which becomes longer meanwhile
        if isinstance(kind, FieldInfo):
            kinds += kind.metadata
        elif get_origin(kind) is Annotated:
            kinds += kind.__metadata__
        elif get_origin(kind) in (Union, UnionType):
            kinds += get_args(kind)
        else:
            yield kind


def leaves(data: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Values of nested tables by dotted path."""
    for key, value in data.items():
        if isinstance(value, Mapping):
            yield from leaves(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


def parse_value(text: str) -> Any:
    """Read one value as TOML would; what is not TOML, or too long or too deep for its reader, is a string."""
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except (ValueError, RecursionError):
        return text


def _implausible(data: Any, path: tuple[str, ...] = ()) -> Iterator[tuple[str, str]]:
    """Find by dotted path what no table can use, whatever it is for: nesting, and numbers out of all proportion."""
    if len(path) > _DEEPEST:
        yield ".".join(path), f"is nested more than {_DEEPEST} levels deep"
    elif isinstance(data, Mapping):
        for key, value in data.items():
            yield from _implausible(value, (*path, str(key)))
    elif isinstance(data, list):
        for index, value in enumerate(data):
            yield from _implausible(value, (*path, str(index)))
    elif isinstance(data, int | float) and (problem := implausible(data)):
        yield ".".join(path), problem


def _comments(table: Any, prefix: str = "") -> Iterator[tuple[str, str]]:
    """Find the comment beside each value of a TOML document."""
    for key in table:
        # indexing would unwrap booleans, and lose their comment; tables written in several places have no item()
        item = table.item(key) if hasattr(table, "item") else table[key]
        path = f"{prefix}{key}"
        if isinstance(item, Mapping):
            yield from _comments(getattr(item, "value", item), path + ".")
        elif hasattr(item, "trivia") and item.trivia.comment:
            yield path, item.trivia.comment.lstrip("# ").strip()


def _explain(model: type[BaseModel], error: Any) -> str:
    """One sentence for a validation error."""
    loc, kind, value = error["loc"], error["type"], error["input"]
    table = _table_at(model, loc[:-1])
    if kind == "extra_forbidden":
        return f"unknown key; {nearest(str(loc[-1]), table.model_fields)}"
    field = table.model_fields.get(str(loc[-1])) if loc else None
    meaning = f" ({field.description})" if field is not None and field.description else ""
    if kind == "missing":
        choices = _choices(field) if field is not None else []
        return f"is missing{meaning}" + (f"; give one of {', '.join(choices)}" if choices else "")
    if kind == "value_error":
        return str(error["ctx"]["error"])
    # what pydantic says, in the words of TOML
    message = re.sub(r"^(Input|List) should", "it should", error["msg"])
    message = re.sub(r"a valid dictionary( or instance of \w+)?", "a table", message)
    message = message.replace("be a valid ", "be a ").replace(" after validation", "")
    shown = repr(value)
    return f"is {shown if len(shown) <= _LONGEST else shown[:_LONGEST] + '...'}; {message}{meaning}"


def _table_at(model: type[BaseModel], loc: tuple[Any, ...]) -> type[BaseModel]:
    """Find the table that a validation error's location lies in."""
    for part in loc:
        info = model.model_fields.get(str(part))
        if info is not None:  # else a name in a table of names
            model = _inner(info) or model
    return model


def _inner(info: Any) -> type[BaseModel] | None:
    """Find the table that a key holds, or holds a list or table of, if it does."""
    kinds = [info.annotation]
    while kinds:
        kind = kinds.pop(0)
        if isinstance(kind, type) and issubclass(kind, BaseModel):
            return kind
        kinds += get_args(kind)
    return None
