"""A picture of a Drake diagram for notebooks."""

from __future__ import annotations

import shutil
import subprocess
from dataclasses import dataclass

from pydrake.systems.framework import Diagram


@dataclass(frozen=True)
class DiagramPicture:
    """The Jupyter view of a diagram: drawn by Graphviz, or as a table of its connections.

    Attributes
    ----------
    svg : str or None
        Drake's Graphviz drawing; None if the program ``dot`` is not installed.
    connections : tuple of (str, str)
        Output and input ports that are connected, as ``system.port``.
    """

    svg: str | None
    connections: tuple[tuple[str, str], ...]

    def _repr_mimebundle_(self, **_: object) -> dict[str, str]:
        if self.svg is not None:
            return {"image/svg+xml": self.svg, "text/plain": str(self)}
        rows = "".join(f"| `{output}` | `{taker}` |\n" for output, taker in self.connections)
        note = "\n*Install Graphviz (`dot`) to see the diagram drawn.*\n"
        return {"text/markdown": f"| output | input |\n|---|---|\n{rows}{note}", "text/plain": str(self)}

    def __str__(self) -> str:
        width = max((len(output) for output, _ in self.connections), default=0)
        return "\n".join(f"{output:{width}s} -> {taker}" for output, taker in self.connections)


def picture(diagram: Diagram) -> DiagramPicture:
    """Draw a diagram's systems and the connections between them.

    Raises
    ------
    subprocess.CalledProcessError
        If ``dot`` is installed and fails.
    """
    connections = sorted(
        (
            f"{giver.get_name()}.{giver.get_output_port(output).get_name()}",
            f"{taker.get_name()}.{taker.get_input_port(entry).get_name()}",
        )
        for (taker, entry), (giver, output) in diagram.connection_map().items()
    )
    svg = None
    if dot := shutil.which("dot"):
        text = diagram.GetGraphvizString(max_depth=1)
        svg = subprocess.run([dot, "-Tsvg"], input=text, capture_output=True, text=True, check=True).stdout
    return DiagramPicture(svg, tuple(connections))
