"""Writes the gallery, a tile for each command: ``python docs/make_gallery.py``; it runs the commands."""

import contextlib
import io
import json
import shutil
import sys
import tempfile
from pathlib import Path

from PIL import Image

from linkages.cli.main import main
from linkages.show.report.answer import answer

DOCS = Path(__file__).parent
PAGE = DOCS / "gallery.md"
_WIDTH = 640  # of the pictures [px]
#: Of each tile: question, command, file of its figure, page about it.
TILES = {
    "simulate": ("Does my joint rattle?", "simulate slider_crank_dry.toml", "joint_forces.png", "first_run.md"),
    "orbit": ("Does the oil carry the joint?", "simulate seven_bar.toml", "orbits.png", "laws.md"),
    "draw": ("How can my machine move?", "draw six_bar_dry.toml", "drawing.png", "command_line.md#drawings"),
    "sweep": (
        "What if the clearance grows?",
        "sweep slider_crank_lubricated.toml --vary joints.B.clearance=0.05mm:0.2mm:7 --output B.force --revolutions 1",
        "sweep.png", "nonlinear.md",
    ),
    "map": (
        "Which clearance and which speed are safe?",
        "sweep seven_bar.toml --vary joints.A.clearance=0.1mm:0.5mm:5 --vary drives.O1.speed=2:6:4 --output A.force"
        " --limit A.force=10N --revolutions 1 --transient 1",
        "map_A.force.png", "nonlinear.md",
    ),
    "bearing": (
        "How thick is the film of a bearing?",
        "bearing --diameter 0.1 --length 0.05 --clearance 1e-4 --viscosity 0.03 --speed 100 --load 1000",
        "bearing_pressure.png", "bearing.md",
    ),
    "modes": ("At which frequencies does it vibrate?", "modes slider_crank_flexible.toml --count 3", "mode_shapes.png", "modes.md"),
    "sensitivity": (
        "Which value matters most?",
        "sensitivity slider_crank_lubricated.toml --output B.force --wrt joints.B.clearance joints.B.viscosity",
        "tornado.png", "sensitivity.md",
    ),
    "wear": ("How does the joint wear?", "wear slider_crank_wear.toml --cycles 2000 --no-animation", "wear_B.png", "wear.md"),
    "optimise": ("Which design has the smallest force?", "optimise sevenbar_force.toml", "convergence.png", "optimisation.md"),
}  # fmt: skip


def made(name, words, figure, folder):
    """Run a command, keep its figure, and return the first sentence of its answer."""
    out = folder / name
    with contextlib.redirect_stdout(io.StringIO()):
        status = main([*words.split(), "--out", str(out)])
    if status:
        raise SystemExit(f"{words} failed")
    with Image.open(out / figure) as picture:
        picture.thumbnail((_WIDTH, _WIDTH))
        picture.convert("RGB").convert("P", palette=Image.Palette.ADAPTIVE).save(
            DOCS / "figures" / f"gallery_{name}.png", optimize=True
        )
    if (out / "record.json").is_file():
        return json.loads((out / "record.json").read_text(encoding="utf-8"))["answer"][0]
    summary = json.loads((out / "summary.json").read_text(encoding="utf-8"))
    return answer(summary, words.split()[1])[0]


def tile(name, question, words, page, said):
    """Write a tile: question, answer, picture, command."""
    return f"""## {question}

![{said}](figures/gallery_{name}.png)

{said}

```sh
linkages {words}
```

More: [{page.partition("#")[0].removesuffix(".md").replace("_", " ")}]({page}).
"""


def gallery(chosen):
    """Run the commands, and write the page with the tiles of all and the new sentences of the chosen ones."""
    folder = Path(tempfile.mkdtemp())
    told = json.loads((DOCS / "figures" / "gallery.json").read_text()) if chosen else {}
    for name, (_, words, figure, _) in TILES.items():
        if not chosen or name in chosen:
            told[name] = made(name, words, figure, folder)
    shutil.rmtree(folder)
    (DOCS / "figures" / "gallery.json").write_text(
        json.dumps(told, indent=1, ensure_ascii=False) + "\n", encoding="utf-8"
    )
    tiles = [tile(name, question, words, page, told[name]) for name, (question, words, _, page) in TILES.items()]
    head = "# Gallery\n\nFor engineers with a question: find the command that answers it by its picture; each command writes its own.\n"
    PAGE.write_text("\n".join([head, *tiles]), encoding="utf-8")


if __name__ == "__main__":
    gallery(sys.argv[1:])
