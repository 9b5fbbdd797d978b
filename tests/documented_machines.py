"""Descriptions of machines in the documentation: blocks of its page, and the files that it links."""

import re
from pathlib import Path

_DOCS = Path(__file__).resolve().parents[1] / "docs"
PAGE = (_DOCS / "describe.md").read_text(encoding="utf-8")
#: Texts of all machines by title.
MACHINES = {
    found[1]: text
    for text in (
        *re.findall("```toml\n(.*?)```", PAGE, re.DOTALL),
        *(path.read_text(encoding="utf-8") for path in sorted(_DOCS.glob("machines/*.machine.toml"))),
    )
    if "[points]" in text and (found := re.match('title += "(.*?)"', text))
}


def documented(title: str) -> str:
    """Return the description of a machine by the start of its title."""
    return next(text for name, text in MACHINES.items() if name.startswith(title))
