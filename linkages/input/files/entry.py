"""Objects of files of results: typed attributes in a program, keys in the file, and nothing between the two."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, ClassVar

from pydantic import BeforeValidator, ConfigDict

from linkages.input.files.toml import Table
from linkages.input.files.writing import content_of

Keys = tuple[tuple[str, str], ...]


def _known(value: Any) -> Any:
    """Return None instead of a number that is not finite, as a file does."""
    return None if isinstance(value, float) and not math.isfinite(value) else value


#: A number, None (null in the file) if it is meaningless.
Number = Annotated[float | None, BeforeValidator(_known)]


class Entry(Table):
    """An object of a file of results.

    Its keys are attributes, and can be asked as a mapping, ``entry["key"]``: an entry has the keys that its maker gave,
    in the order of their declaration. `content` turns it into the dict that becomes JSON. A file may have more keys.
    """

    model_config = ConfigDict(extra="ignore", populate_by_name=True)
    _order: ClassVar[Keys]

    @classmethod
    def __pydantic_init_subclass__(cls, **options: Any) -> None:
        """Note the key of each attribute: the same word, unless Python reserves it."""
        super().__pydantic_init_subclass__(**options)
        cls._order = tuple((field.alias or name, name) for name, field in cls.model_fields.items())

    def __getitem__(self, key: str) -> Any:
        for known, name in self._order:
            if known == key and name in self.model_fields_set:
                return getattr(self, name)
        raise KeyError(key)

    def __contains__(self, key: object) -> bool:
        return any(key == known for known in self.keys())

    def __len__(self) -> int:
        return len(self.model_fields_set)

    def __iter__(self) -> Iterator[str]:  # type: ignore[override]  # of a mapping: its keys
        return iter(self.keys())

    def __eq__(self, other: object) -> bool:
        same = isinstance(other, Entry) or not isinstance(other, Mapping)
        return super().__eq__(other) if same else self.content == content_of(other)

    def __or__(self, other: Mapping[str, Any]) -> dict[str, Any]:
        """Return the content with further or other keys."""
        return self.content | content_of(other)

    __hash__ = None  # type: ignore[assignment]  # as of a dict

    def keys(self) -> list[str]:
        """Return the keys that the entry has."""
        return [key for key, name in self._order if name in self.model_fields_set]

    def values(self) -> list[Any]:
        """Return the values of the keys."""
        return [value for _, value in self.items()]

    def items(self) -> list[tuple[str, Any]]:
        """Return keys and values."""
        return [(key, getattr(self, name)) for key, name in self._order if name in self.model_fields_set]

    def get(self, key: str, default: Any = None) -> Any:
        """Return the value of a key, or a default if the entry does not have it."""
        try:
            return self[key]
        except KeyError:
            return default

    @property
    def content(self) -> dict[str, Any]:
        """Return what the file has: dicts, lists, numbers and texts."""
        return {key: content_of(value) for key, value in self.items()}


Mapping.register(Entry)
