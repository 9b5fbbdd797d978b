"""Writes the gallery, a tile for each command that draws: ``python docs/make_gallery.py``; it runs the commands.

With names of tiles it runs only theirs: ``python docs/make_gallery.py sweep map``.
"""

import contextlib
import io
import json
import re
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from PIL import Image

from linkages.cli.main import main
from linkages.show.report.answer import answer

DOCS = Path(__file__).resolve().parent
PAGE = DOCS / "gallery.md"
_WIDTH = 640  # of the pictures [px]


def measured_press() -> None:
    """Write the files of the tutorial on identification, with all its sensors, into the working folder."""
    page = (DOCS / "tutorial_identification.md").read_text(encoding="utf-8")
    Path("press_fit.toml").write_text("".join(re.findall(r"```toml\n(.*?)```", page, re.DOTALL)), encoding="utf-8")
    exec(re.search(r"```python\n(.*?)```", page, re.DOTALL)[1], {})


class Tile(NamedTuple):
    """A question, the commands that answer it, the figure of the last one, and a page about it."""

    question: str
    commands: str  # one a line
    figure: str  # in the folder of its results; or a picture of docs/figures, with `said`
    page: str
    said: str = ""  # answer, if the command states none
    before: Callable[[], None] | None = None


TILES = {
    "simulate": Tile("Does my joint rattle?", "simulate slider_crank_dry.toml", "joint_forces.png", "clearance.md"),
    "orbit": Tile("Does the oil carry the joint?", "simulate seven_bar.toml", "orbits.png", "laws.md"),
    "play": Tile(
        "What changes when I move a value?", "play seven_bar.toml", "live_page.png", "tutorial_live.md",
        "Motion, orbits, forces and peaks follow a slider within a fraction of a second.",
    ),
    "draw": Tile("How can my machine move?", "draw six_bar_dry.toml", "drawing.png", "drawings.md"),
    "animate": Tile(
        "How do I show it on a slide?", "simulate seven_bar.toml --out results/press\nanimate results/press --format gif",
        "seven_bar.gif", "reports.md", "The press, moved by its run.",
    ),
    "overlay": Tile(
        "How do two runs differ?",
        "simulate slider_crank_dry.toml --out results/dry\nsimulate slider_crank_lubricated.toml --out results/oil\n"
        "overlay results/dry results/oil --output B.force",
        "overlay.png", "plot_results.md",
    ),
    "sweep": Tile(
        "What if the clearance grows?",
        "sweep slider_crank_lubricated.toml --vary joints.B.clearance=0.05mm:0.2mm:7 --output B.force --revolutions 1",
        "sweep.png", "nonlinear.md",
    ),
    "map": Tile(
        "Which clearance and which speed are safe?",
        "sweep seven_bar.toml --vary joints.A.clearance=0.1mm:0.5mm:5 --vary drives.O1.speed=2:6:4 --output A.force"
        " --limit A.force=10N --revolutions 1 --transient 1",
        "map_A.force.png", "maps.md",
    ),
    "continue": Tile(
        "Is the motion stable at every speed?",
        "continue slider_crank_lubricated.toml --vary drives.O.speed=450:550 --transient 5 --output B.force",
        "branches.png", "periodic.md",
    ),
    "bearing": Tile(
        "How thick is the film of a bearing?",
        "bearing --diameter 0.1 --length 0.05 --clearance 1e-4 --viscosity 0.03 --speed 100 --load 1000",
        "bearing_pressure.png", "bearing.md",
    ),
    "modes": Tile("At which frequencies does it vibrate?", "modes slider_crank_flexible.toml --count 3", "mode_shapes.png", "modes.md"),
    "linearise": Tile(
        "How does it answer a controller?",
        "linearise slider_crank_flywheel.toml --time 0.1 --input O.torque --output O.rate --frequencies 0.1:100:200",
        "bode.png", "linearise.md",
    ),
    "sensitivity": Tile(
        "Which value matters most?",
        "sensitivity slider_crank_lubricated.toml --output B.force --wrt joints.B.clearance joints.B.viscosity",
        "matrix.png", "sensitivity.md",
    ),
    "wear": Tile("How does the joint wear?", "wear slider_crank_wear.toml --cycles 2000 --no-animation", "wear_B.png", "wear.md"),
    "identify": Tile(
        "Which clearance explains my measurement?", "identify press_fit.toml", "fit.png", "tutorial_identification.md",
        before=measured_press,
    ),
    "optimise": Tile("Which design has the smallest force?", "optimise sevenbar_force.toml", "convergence.png", "optimisation.md"),
    "study": Tile(
        "Which variables of a design matter?", "study sensitivity sevenbar_force.toml --samples 64", "sobol.png",
        "check_optimum.md#which-variables-matter",
    ),
    "tolerances": Tile(
        "Which tolerance costs most?", "tolerances slidercrank_tolerances.toml", "influence.png", "tolerances.md"
    ),
}  # fmt: skip
#: Commands that draw nothing of their own.
OTHERS = """## Commands without a picture

| question | command |
|---|---|
| how do I begin? | `linkages new my` ([four ways](new_machine.md)) |
| can I take a machine of another program? | `linkages import robot.urdf` ([guide](import.md)) |
| do both engines agree? | `linkages compare my.toml` ([guide](compare_engines.md)) |
| how do I send it to a colleague? | `linkages report results/my` ([guide](reports.md)) |
| how do I read it in another program? | `linkages export results/my --to csv` ([guide](export.md)) |
| what is this key called? | `linkages keys clearance` ([list](experiment.md)) |
| is the installation complete? | `linkages doctor` |
| can my shell complete commands? | `linkages completion bash` ([where](command_line.md#completion)) |
"""


def answered(name: str, tile: Tile) -> str:
    """Run the commands of a tile in the working folder, keep the figure, and return the first sentence of the answer."""
    if tile.said:
        return tile.said
    if tile.before:
        tile.before()
    for line in tile.commands.splitlines():
        words = line.split()
        words += [] if "--out" in words else ["--out", "out"]
        with contextlib.redirect_stdout(io.StringIO()):
            status = main(words)
        if status:
            raise SystemExit(f"{line} failed")
    out = Path("out")
    with Image.open(out / tile.figure) as picture:
        picture.thumbnail((_WIDTH, _WIDTH))
        small = picture.convert("RGB").convert("P", palette=Image.Palette.ADAPTIVE)
        small.save(DOCS / "figures" / f"gallery_{name}.png", optimize=True)
    if (out / "record.json").is_file():
        return json.loads((out / "record.json").read_text(encoding="utf-8"))["answer"][0]
    return answer(json.loads((out / "summary.json").read_text(encoding="utf-8")), words[1])[0]


def written(name: str, tile: Tile, said: str) -> str:
    """Write a tile: question, answer, picture, commands."""
    figure = tile.figure if tile.said else f"gallery_{name}.png"
    commands = "\n".join(f"linkages {line}" for line in tile.commands.splitlines())
    page = tile.page.partition("#")[0].removesuffix(".md").replace("_", " ")
    return f"""## {tile.question}

![{said}](figures/{figure})

{said}

```sh
{commands}
```

More: [{page}]({tile.page}).
"""


def gallery(chosen: list[str]) -> None:
    """Run the commands of all tiles or of the chosen ones, and write the page."""
    store = DOCS / "figures" / "gallery.json"
    told = json.loads(store.read_text(encoding="utf-8"))
    for name, tile in TILES.items():
        if not chosen or name in chosen:
            with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
                told[name] = answered(name, tile)
    told = {name: told[name] for name in TILES}
    store.write_text(json.dumps(told, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    head = "# Gallery\n\nFor engineers with a question: find the command that answers it by its picture.\n"
    tiles = [written(name, tile, told[name]) for name, tile in TILES.items()]
    PAGE.write_text("\n".join([head, *tiles, OTHERS]), encoding="utf-8")


if __name__ == "__main__":
    gallery(sys.argv[1:])
