"""HTML pages from templates next to the modules: each is one file that needs no network."""

from __future__ import annotations

from importlib.resources import files
from typing import Any

from jinja2 import Environment, StrictUndefined
from markupsafe import Markup

from linkages.input.files.writing import json_text


def own_text(package: str, name: str) -> str:
    """Read a file of a package."""
    return (files(package) / name).read_text(encoding="utf-8")


def filled(template: str, **values: Any) -> str:
    """Fill a template: texts are escaped unless they are `Markup`, and a missing value is an error."""
    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True
    )
    return environment.from_string(template).render(values)


def embedded(content: Any) -> Markup:
    """Write JSON for embedding in a page: its text cannot end the script element."""
    return Markup(json_text(content).strip().replace("<", "\\u003c"))
