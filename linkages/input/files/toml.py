"""TOML files as typed tables: reading, comments as sources, replacement by dotted path, errors in one line."""

from __future__ import annotations

import io
import re
import tomllib
from collections.abc import Iterator, Mapping, Sized
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, ClassVar, Self, TypeVar, cast

import tomlkit
from pydantic import BaseModel, ConfigDict, Field, ValidationError, ValidationInfo, field_validator, model_validator
from tomlkit.exceptions import ParseError, TOMLKitError

from linkages.base.errors import InputError, nearest
from linkages.input.files.magnitudes import implausible
from linkages.input.files.reading import read_whole
from linkages.input.files.table_keys import bracketed, inner_table, is_number, names_taken, taken_keys
from linkages.input.files.unit_conversion import decimal_comma, read, read_either

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NonNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Finite = Annotated[float, Field(allow_inf_nan=False)]
T = TypeVar("T")
#: A list of two values of a type: ``TwoOf[Finite]``.
TwoOf = Annotated[list[T], Field(min_length=2, max_length=2)]

_DEEPEST = 20  # most levels of nesting (reading recurses)
_LONGEST = 80  # most characters of a wrong value in a message


class Table(BaseModel):
    """A table of a TOML file: unknown keys are errors, values are not coerced and are immutable.

    A number may be a quoted text with a unit if the key's description has a bracketed unit.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, defer_build=True)  # built when first used
    of_any_joint: ClassVar[bool] = False  # whether units with rad also allow m (prismatic joints)
    imperfections: ClassVar[tuple[str, ...]] = ()  # keys that the linkage with ideal joints lacks

    @field_validator("*", mode="before")
    @classmethod
    def _in_si(cls, value: Any, key: ValidationInfo) -> Any:
        field = cls.model_fields[key.field_name or ""]
        if isinstance(value, str | list) and is_number(field):
            return (read_either if cls.of_any_joint else read)(value, bracketed(field.description))
        return value

    @model_validator(mode="after")
    def _checked(self, _: ValidationInfo) -> Self:
        self._complete()
        return self

    def _complete(self) -> None:
        """Raise a ValueError, in one sentence, for values that do not go together; bases check first."""

    def number_at(self, path: str, source: Path) -> float:
        """Return the number at a dotted path; InputError if there is none."""
        here: Any = self
        for part in path.split("."):
            if isinstance(here, list):
                here = here[_place(here, part, path, source)]
                continue
            known = dict(here) if isinstance(here, Table | Mapping) else {}
            if part not in known:
                raise InputError(source, path, f'has no "{part}"; {nearest(part, known)}')
            here = known[part]
        if here is None:
            raise InputError(source, path, "has no value in the experiment; give one there, or a start (nominal)")
        if isinstance(here, bool) or not isinstance(here, int | float):
            raise InputError(source, path, "is not a number, and cannot be a design variable")
        return float(here)

    @classmethod
    def unknown(cls, key: str, data: Mapping[str, Any]) -> str:
        """Describe the error of an unknown key."""
        return f"unknown key; {nearest(key, taken_keys(cls, data))}"


AnyTable = TypeVar("AnyTable", bound=Table)


def read_toml(path: Path) -> tuple[dict[str, Any], dict[str, str]]:
    """Read a file: its values, and the comment after each value by dotted path."""
    if path.suffix == ".sdf":
        raise InputError(path, "", "is a mechanism; give the experiment file (.toml) that names it")
    data = read_whole(path)
    try:
        document = tomlkit.parse(io.TextIOWrapper(io.BytesIO(data), "utf-8").read())
        return document.unwrap(), dict(_comments(document))
    except RecursionError:
        raise InputError(path, "", "is nested too deeply") from None
    except (TOMLKitError, ValueError) as problem:  # ValueError: not UTF-8, or a number with too many digits
        raise InputError(path, "", f"is not valid TOML: {problem}{_comma_at(problem, data)}") from None


def _comma_at(problem: Exception, data: bytes) -> str:
    """Say that the value of the line that is not valid has a decimal comma."""
    if not isinstance(problem, ParseError):
        return ""
    line = data.decode("utf-8", "replace").splitlines()[problem.line - 1 : problem.line]
    value = "".join(line).partition("=")[2].partition("#")[0]
    return decimal_comma(value)


def replace_values(data: dict[str, Any], overrides: Mapping[str, Any], origin: str) -> None:
    """Replace values in nested tables by dotted path, in place; strings are read as TOML values.

    A number in a list has its place, from 0, as the last part of its path; a component of a vector its axis, as in
    ``gravity.y``.
    """
    for path, value in overrides.items():
        parts = path.split(".")
        if not all(parts):
            problem = "is not a path; write keys with dots between them, such as joints.A.clearance"
            raise InputError(origin, f'"{path}"', problem)
        table: Any = data
        for part in parts[:-1]:
            if isinstance(table.get(part), list):
                table[part] = list(table[part])  # the list may belong to another table
            table = table.setdefault(part, {})
            if not isinstance(table, dict | list) or (isinstance(table, list) and part != parts[-2]):
                raise InputError(origin, path, f'"{part}" is a value, not a table')
        key: str | int = _place(table, parts[-1], path, origin) if isinstance(table, list) else parts[-1]
        table[key] = parse_value(value) if isinstance(value, str) else value


def _place(values: list[Any], part: str, path: str, source: str | Path) -> int:
    """Return the index of a component: x, y, z of a vector; otherwise the places in the list, from 0."""
    known = {axis: k for k, axis in enumerate("xyz")} if len(values) == 3 else {str(k): k for k in range(len(values))}
    if part not in known:
        raise InputError(source, path, f'has no "{part}"; {nearest(part, known)}')
    return known[part]


def validate(
    model: type[AnyTable],
    data: Mapping[str, Any],
    source: Path,
    origins: Mapping[str, str] | None = None,
    folder: Path | None = None,
) -> AnyTable:
    """Build a table from its values; `origins` has the origin of overrides by dotted path.

    Data files that the table names are in `folder`, and are not read without it.

    InputError for the first invalid value: file (or origin), dotted path, error and remedy.
    """
    for where, problem in _implausible(data):
        raise InputError((origins or {}).get(where, source), where, problem)
    try:
        return model.model_validate(data, context=folder)
    except ValidationError as problem:
        # a misspelt key often causes a missing key: report the misspelt one
        first = min(problem.errors(), key=lambda error: error["type"] != "extra_forbidden")
        loc = _written(data, first["loc"])
        where = ".".join(part for part in map(str, loc) if part.strip())  # without tags of unions
        raise InputError((origins or {}).get(where, source), where, _explain(model, data, loc, first)) from None


def check_history(times: list[float] | None, values: Sized | None, name: str) -> None:
    """Check a table over time: equally many times and values; times increase, from 0 or before."""
    if (values is None) != (times is None):
        raise ValueError(f"times go with {name}")
    if values is not None and times is not None:
        check_increasing("times", times, "values", values)
        if times[0] > 0.0:
            raise ValueError("times must start at 0 or before")


def check_increasing(key: str, places: list[float], what: str, values: Sized) -> None:
    """Check a table: equally many places (times) and values, two or more; places increase."""
    if len(values) != len(places) or len(values) < 2:
        raise ValueError(f"{len(places)} {key} and {len(values)} {what}; two or more of each, equally many")
    if any(b <= a for a, b in pairwise(places)):
        raise ValueError(f"{key} must increase")


def leaves(data: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the values of nested tables by dotted path."""
    for key, value in data.items():
        if isinstance(value, Mapping):
            yield from leaves(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


def parse_value(text: str) -> Any:
    """Parse one TOML value; text that is not TOML, or too long or deep for the parser, is a string."""
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except (ValueError, RecursionError):
        return text


def _implausible(data: Any, path: tuple[str, ...] = ()) -> Iterator[tuple[str, str]]:
    """Yield values that no table allows, by dotted path: deep nesting and implausible numbers."""
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
    """Yield the comment after each value of a TOML document."""
    for key in table:
        # indexing would unwrap booleans, and lose their comment; tables written in several places have no item()
        item = table.item(key) if hasattr(table, "item") else table[key]
        path = f"{prefix}{key}"
        if isinstance(item, Mapping):
            yield from _comments(getattr(item, "value", item), path + ".")
        elif hasattr(item, "trivia") and item.trivia.comment:
            yield path, item.trivia.comment.lstrip("# ").strip()


def _written(data: Any, loc: tuple[Any, ...]) -> tuple[Any, ...]:
    """Return a location up to the value that stands in the file: pydantic adds the type that a number failed to be."""
    for count, part in enumerate(loc):
        if not isinstance(data, Mapping | list):
            return loc[:count]
        inside = isinstance(data, Mapping) or isinstance(part, int)
        data = (data.get(part, data) if isinstance(data, Mapping) else data[part]) if inside else data
    return loc


def _explain(model: type[Table], data: Mapping[str, Any], loc: tuple[Any, ...], error: Any) -> str:
    kind, value = error["type"], error["input"]
    table, values = _table_at(model, data, loc[:-1])
    if kind == "extra_forbidden":
        return table.unknown(str(loc[-1]), values)
    field = taken_keys(table, values).get(str(loc[-1])) if loc else None
    meaning = f" ({field.description})" if field is not None and field.description else ""
    if kind == "missing":
        choices = names_taken(field) if field is not None else []
        return f"is missing{meaning}" + (f"; give one of {', '.join(choices)}" if choices else "")
    if kind == "value_error":
        return str(error["ctx"]["error"])
    # pydantic's message in TOML terms
    message = re.sub(r"^(Input|List) should", "it should", error["msg"])
    message = re.sub(r"a valid dictionary( or instance of \w+)?", "a table", message)
    message = (
        message.replace("be a valid i", "be an i").replace("be a valid ", "be a ").replace(" after validation", "")
    )
    shown, comma = repr(value), decimal_comma(value) if isinstance(value, str) else ""
    return f"is {shown if len(shown) <= _LONGEST else shown[:_LONGEST] + '...'}{comma or f'; {message}'}{meaning}"


def _table_at(model: type[Table], data: Any, loc: tuple[Any, ...]) -> tuple[type[Table], Any]:
    """Find the table that a validation error's location lies in, and its values."""
    for part in loc:
        info = taken_keys(model, data).get(str(part))
        if info is not None:  # otherwise a name in a table of names
            model = cast(type[Table], inner_table(info) or model)
        if isinstance(data, Mapping):
            data = data.get(part, data)  # except tags of unions
        elif isinstance(data, list) and isinstance(part, int):
            data = data[part]
    return model, data
