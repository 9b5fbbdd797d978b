"""Write the lists of ports in docs/drake_engine.md from the code: ``python docs/make_drake.py``."""

import inspect
import re
from pathlib import Path

from linkages.engines.drake.clearance import JOINT_OUTPUTS, ClearanceJoints
from linkages.engines.drake.drives import Drives
from linkages.results.outputs.registry import table

PAGE = Path(__file__).with_name("drake_engine.md")
START, END = "<!-- ports: docs/make_drake.py -->\n", "<!-- ports end -->\n"


def ports(system: type) -> list[tuple[str, str, str]]:
    """Name, direction with size, and meaning of each port in a system's docstring."""
    text = (inspect.getdoc(system) or "").partition("Ports\n-----\n")[2].partition("\n\n")[0]
    found = re.findall(r"- ``([\w.]+)``: (.*?)\n((?:  .*\n?)+)", text + "\n")
    return [(name, kind.rstrip("."), " ".join(meaning.split())) for name, kind, meaning in found]


def page(text: str) -> str:
    """Return the page with the tables as the code has them."""
    before, after = text.partition(START)[0], text.partition(END)[2]
    rows = ["\n"]
    for label, system in (("clearance", ClearanceJoints), ("drives", Drives)):
        rows += [f"- `{label}`, `{name}` ({kind}): {meaning}\n" for name, kind, meaning in ports(system)]
    known = {name.rpartition(".")[2] for name, _, _ in table()}
    names = ", ".join(f"`{name}`" for name in JOINT_OUTPUTS)
    others = "; ".join(f"`{name}` is the {meaning}" for name, meaning in JOINT_OUTPUTS.items() if name not in known)
    rows.append(
        f"\n`JOINT_OUTPUTS`, a block for each contact: {names}. They are [outputs](outputs.md#outputs); {others}.\n"
    )
    return "".join([before, START, *rows, "\n", END, after])


if __name__ == "__main__":
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
