"""Flexible and rigid as models of a link that the live page offers; a link without a beam gets a steel bar."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from linkages.base.brief import counted
from linkages.elements.element import Choice, Modelled
from linkages.elements.flexible import numerics

_STEEL_BAR = {"youngs_modulus": 2.1e11, "density": 7850.0}
_MODELS = ("rigid", "flexible")


def _offered(link: Modelled) -> tuple[str, ...]:
    """Return both models for a link with a beam, or with two joints, between which one can lie."""
    return _MODELS if link.part.beam or len(link.ends) == 2 else _MODELS[:1]


def _values(link: Modelled, model: str) -> dict[str, Any]:
    """Return the values that make a link flexible or rigid."""
    if model not in _MODELS:
        raise ValueError(f'cannot be "{model}"; one of {", ".join(_MODELS)}')
    own = _bar(link) if model == "flexible" and not link.part.beam else {}
    return own | {f"links.{link.name}.model": model}


def _bar(link: Modelled) -> dict[str, float]:
    """Return a steel beam of a square section with the link's mass; ValueError for a link without two ends."""
    if len(link.ends) != 2:
        raise ValueError(f"has {counted(len(link.ends), 'pin')}; a beam needs two ends")
    length, mass = float(np.hypot(*(link.ends[1] - link.ends[0]))), link.part.mass
    side = float(f"{np.sqrt(mass / (_STEEL_BAR['density'] * length)) if mass else length / numerics.SLENDERNESS:.4g}")
    sizes = {"width": side, "height": side, **_STEEL_BAR}
    return {f"sdf.links.{link.name}.beam.{key}": value for key, value in sizes.items()}


def _determines(name: str, values: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the paths of the link's mass, which a beam determines."""
    if f"sdf.links.{name}.beam.density" not in values:
        return ()
    return tuple(f"sdf.links.{name}.{key}" for key in ("mass", "inertia", "com."))


CHOICE = Choice(lambda link: _MODELS[link is not None and link.bends], _offered, _values, _determines)
