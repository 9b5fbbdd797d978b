"""Tables that name a law and give values to its declared parameters.

Such a table accepts the parameters of the named law. It also accepts, and ignores, parameters of the other built-in
laws of this kind, so that a law can be replaced by its path without removing the keys of the previous law.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any, ClassVar

from pydantic import ConfigDict, Field, SerializerFunctionWrapHandler, create_model, model_serializer, model_validator
from pydantic.fields import FieldInfo
from pydantic_core.core_schema import SerializationInfo

from linkages.input.files.toml import Table
from linkages.laws.declared import BUILT_IN_PARAMETERS, REGISTRIES, merged, users
from linkages.laws.parameters import Parameter

_FEW = 3  # most laws that a list of keys names


class LawTable(Table):
    """A table with one key that names a law, and the law's parameters as further keys."""

    model_config = ConfigDict(extra="allow")  # `_of_law` refuses others
    law_kind: ClassVar[str]
    law_key: ClassVar[str] = "law"

    @classmethod
    def added_keys(cls, data: Mapping[str, Any]) -> Mapping[str, FieldInfo]:
        """Return the keys of the parameters that a table with these values accepts."""
        return _parameters_of(cls, data).model_fields

    @classmethod
    def declared_keys(cls) -> Iterator[tuple[str, FieldInfo]]:
        """Yield every key that a law of this kind declares, repeatedly if laws declare it differently."""
        for parameter, laws in users(REGISTRIES[cls.law_kind]).items():
            ((name, info),) = _table((parameter,), required=True).model_fields.items()
            said = FieldInfo.merge_field_infos(info)
            if len(laws) <= _FEW:
                said.description = f"{', '.join(laws)}: {info.description}"
            yield name, said

    @classmethod
    def unknown(cls, key: str, data: Mapping[str, Any]) -> str:
        """Describe the error of a key: it belongs to another law, or is unknown."""
        registry, law = REGISTRIES[cls.law_kind], _named(cls, data)
        owners = [name for name, other in registry.items() if key in {p.name for p in other.parameters}]
        if not owners or law is None:
            return super().unknown(key, data)
        own = ", ".join(parameter.name for parameter in registry[law].parameters) or "none"
        return f"is a parameter of {', '.join(owners)}; {law} has: {own}"

    @model_validator(mode="before")
    @classmethod
    def _of_law(cls, data: Any) -> Any:
        if not isinstance(data, Mapping):
            return data
        law = _named(cls, data)
        for parameter in REGISTRIES[cls.law_kind][law].parameters if law is not None else ():
            if parameter.name in cls.model_fields or hasattr(cls, parameter.name):
                taken = f'{law} has a parameter "{parameter.name}", which already has another meaning here'
                raise ValueError(f"{taken}; rename it")
        own = {key: value for key, value in data.items() if key not in cls.model_fields}
        return {**data, **_parameters_of(cls, data).model_validate(own).model_dump(exclude_unset=True)}

    def _complete(self) -> None:
        """Set absent parameters to their defaults, which are not dumped as given values."""
        given = self.model_extra or {}
        self.__dict__.update({name: value for name, value in self._defaults.items() if name not in given})
        values = self.parameters
        for parameter in REGISTRIES[self.law_kind][getattr(self, self.law_key)].parameters:
            least = values.get(parameter.above)
            if least is not None and values[parameter.name] <= least:
                default = "" if parameter.above in given else f", the default; give {parameter.above} as well"
                unit = "" if parameter.unit == "1" else f" {parameter.unit}"
                problem = f"must be above {parameter.above}, which is {least:g}{unit}{default}"
                raise ValueError(f"{parameter.name} {problem}")

    @model_serializer(mode="wrap")
    def _all(self, handler: SerializerFunctionWrapHandler, info: SerializationInfo) -> dict[str, Any]:
        """Dump the parameters' defaults with the other keys' defaults."""
        dumped: dict[str, Any] = handler(self)
        return dumped if info.exclude_unset else self._defaults | dumped

    @property
    def _defaults(self) -> dict[str, Any]:
        keys = self.added_keys({self.law_key: getattr(self, self.law_key)})
        return {name: info.default for name, info in keys.items() if not info.is_required()}

    @property
    def parameters(self) -> dict[str, float]:
        """Return the values of the parameters by name."""
        known = dict(self)
        return {name: known[name] for name in self._defaults | (self.model_extra or {})}


def _named(table: type[LawTable], data: Mapping[str, Any]) -> str | None:
    """Find the law that a table with these values names; None if it does not exist."""
    field = table.model_fields[table.law_key]
    name = data.get(table.law_key, None if field.is_required() else field.default)
    return name if isinstance(name, str) and name in REGISTRIES[table.law_kind] else None


def _parameters_of(table: type[LawTable], data: Mapping[str, Any]) -> type[Table]:
    """Make the table of accepted parameters: the named law's, or all laws' if the law is unknown."""
    registry, law = REGISTRIES[table.law_kind], _named(table, data)
    if law is None:
        return _table(merged(registry.values()), required=False)
    own = registry[law].parameters
    names = {parameter.name for parameter in own}
    rest = (parameter for parameter in BUILT_IN_PARAMETERS[table.law_kind] if parameter.name not in names)
    return _table((*own, *rest), required=True)


@cache
def _table(parameters: tuple[Parameter, ...], required: bool) -> type[Table]:
    """Make a table of parameters; `required` makes parameters without a default mandatory."""
    fields: dict[str, Any] = {}
    for parameter in parameters:
        if hasattr(Table, parameter.name):  # `LawTable` rejects the law
            continue
        default = parameter.default if parameter.default is not None or not required else ...
        fields[parameter.name] = (float, parameter_field(parameter, default))
    return create_model("Parameters", __base__=Table, **fields)


def parameter_field(parameter: Parameter, default: Any = ...) -> Any:
    """Make the field of a table from a declared parameter."""
    bounds: dict[str, Any] = {**parameter.bounds, "allow_inf_nan": False}
    return Field(default, description=f"{parameter.meaning} [{parameter.unit}]", **bounds)
