"""Write the list of outputs in docs/outputs.md: ``python docs/make_outputs.py``."""

from collections.abc import Iterable
from pathlib import Path

from linkages.results.outputs.registry import table

PAGE = Path(__file__).with_name("outputs.md")
START, END = "<!-- outputs: docs/make_outputs.py -->\n", "<!-- outputs end -->\n"


def paired(rows: Iterable[tuple[str, str, str]]) -> list[tuple[str, str, str]]:
    """Join the components along x_P and y_P."""
    found: list[tuple[str, str, str]] = []
    for name, meaning, unit in rows:
        if meaning.endswith("y_P") and found[-1][1].endswith("x_P"):
            first, along, _ = found.pop()
            found.append((f"{first}, `.{name.rpartition('.')[2]}`", f"{along}, y_P", unit))
        else:
            found.append((f"`{name}`", meaning, unit))
    return found


def page(text: str) -> str:
    """Return the page with the list as the registry has it."""
    before, after = text.partition(START)[0], text.partition(END)[2]
    names: dict[tuple[str, str], list[str]] = {}
    for name, meaning, unit in paired(table()):
        names.setdefault((meaning, unit), []).append(name)
    lines = [f"- {', '.join(same)}: {meaning} [{unit}]\n" for (meaning, unit), same in names.items()]
    return "".join([before, START, "\n", *lines, "\n", END, after])


if __name__ == "__main__":
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
