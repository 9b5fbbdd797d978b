"""Write the list of outputs in docs/outputs.md: ``python docs/make_outputs.py``."""

from pathlib import Path

from linkages.results.outputs.registry import table

PAGE = Path(__file__).with_name("outputs.md")
START, END = "<!-- outputs: docs/make_outputs.py -->\n", "<!-- outputs end -->\n"


def page(text: str) -> str:
    """Return the page with the list as the registry has it."""
    before, after = text.partition(START)[0], text.partition(END)[2]
    names: dict[tuple[str, str], list[str]] = {}
    for name, meaning, unit in table():
        names.setdefault((meaning, unit), []).append(f"`{name}`")
    lines = [f"- {', '.join(same)}: {meaning} [{unit}]\n" for (meaning, unit), same in names.items()]
    return "".join([before, START, "\n", *lines, "\n", END, after])


if __name__ == "__main__":
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
