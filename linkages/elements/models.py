"""What models of joints and links have beside other elements: choices of the live page, substitutes on Drake."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from linkages.base.arrays import Array
from linkages.elements.validity import Warned


@dataclass(frozen=True)
class Substitute:
    """What the Drake engine runs instead of elements that it does not have.

    Attributes
    ----------
    key : str
        Key of the number that makes it finer.
    refined : callable
        ``refined(keys)`` are values by key that make it about twice as fine.
    warns : callable
        ``warns(named)`` are warnings about a run with it, for elements by name.
    compared : callable
        ``compared(named)`` are lines that explain a comparison of both engines.
    """

    key: str
    refined: Callable[[Any], Mapping[str, float]]
    warns: Callable[[Mapping[str, Any]], Iterable[Warned]]
    compared: Callable[[Mapping[str, Any]], Sequence[str]]


class Modelled(NamedTuple):
    """A joint or link that can have a model, for the live page."""

    name: str
    part: Any  # `linkages.input.model.mechanism.Link`
    ends: Sequence[Array]  # different places of joints on a link, (2,) [m]


@dataclass(frozen=True)
class Choice:
    """Models of a joint or link that the live page offers.

    Attributes
    ----------
    chosen : callable
        ``chosen(keys)`` is the present model; the keys are None for a part without a table.
    offered : callable
        ``offered(modelled)`` are the models that the part can have.
    values : callable
        ``values(modelled, model)`` are the values by path that give it a model, data that it lacks included; ValueError
        for an unknown one, and a part that cannot have it.
    determines : callable
        ``determines(name, values)`` are the beginnings of paths that such values make meaningless.
    """

    chosen: Callable[[Any], str]
    offered: Callable[[Modelled], Sequence[str]]
    values: Callable[[Modelled, str], dict[str, Any]]
    determines: Callable[[str, Mapping[str, Any]], tuple[str, ...]]
