"""``linkages draw``: a labelled picture of a mechanism, and its properties before a run."""

from __future__ import annotations

import argparse
import sys

from linkages.cli.options import add_out, add_set, output_folder, print_results, record, set_values

HELP = "draw a mechanism: a labelled, movable picture, mobility, ranges of motion of the drives"
WRITES = {"draw": ("drawing.html", "drawing.png", "drawing.svg")}

EXAMPLES = """examples:
  linkages draw four_bar.sdf
  linkages draw my.toml --set sdf.links.crank.mass=0.4 --out results/my
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.add_argument("file", help="mechanism (.sdf) or experiment (.toml): a path, or the name of a shipped file")
    add_set(parser)
    add_out(parser)


def run(options: argparse.Namespace) -> int:
    """Draw; return the exit status."""
    from linkages.base.errors import COMMAND_LINE
    from linkages.input.files.shipped import find_file
    from linkages.input.model.experiment import nothing_done
    from linkages.input.model.mechanism import faults_of_values, load_mechanism
    from linkages.show.plots.drawing import draw, page, svg
    from linkages.show.plots.drawing.raster import picture
    from linkages.show.plots.style import write_figure
    from linkages.system import System, load

    file, values = find_file(options.file, ".toml", ".sdf"), set_values(options)
    if file.suffix == ".sdf":
        experiment = nothing_done(file, values, COMMAND_LINE)
        with faults_of_values(experiment):
            system = System(load_mechanism(file, experiment.sdf_overrides), experiment)
    else:
        system = load(file, values, COMMAND_LINE)
    drawing, out = draw(system), output_folder(options, f"{file.stem}_drawing", "draw")
    with out as folder:
        still = draw(system, spread=True)
        write_figure(picture(still), folder / "drawing")
        (folder / "drawing.svg").write_text(svg(still), encoding="utf-8")
        (folder / "drawing.html").write_text(page(drawing), encoding="utf-8")
        facts = [drawing.problem] * bool(drawing.problem) + [*drawing.facts, *drawing.doubts]
        table = "\n".join([drawing.title, *(f"  {text}" for text in (*drawing.facts, *drawing.doubts))])
        record(options, folder, drawing.title, "What can this mechanism do before it runs?", facts, table)
    print_results(options, table, out)
    if drawing.problem:
        print(f"failed: {drawing.problem}", file=sys.stderr)
        return 1
    return 0
