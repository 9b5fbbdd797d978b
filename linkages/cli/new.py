"""``linkages new``: templates of a mechanism and an experiment."""

from __future__ import annotations

import argparse
import os
import re
from importlib.resources import files
from pathlib import Path

from linkages.base.brief import counted
from linkages.base.errors import InputError, nearest
from linkages.cli.printing import show
from linkages.input.files.writing import errors_of_writing, whole

HELP = "write a commented mechanism (.sdf) and experiment (.toml) to start with"

EXAMPLES = """examples:
  linkages new press && linkages simulate press.toml
  linkages new press --model dry --out machines
  linkages new saw --flexible              a slider-crank with a flexible rod
  linkages new jansen --from leg.toml      from points, links and parameters
"""

_NAME = re.compile(r"(?!world$)[A-Za-z][A-Za-z0-9_-]{0,63}")  # SDFormat reserves "world"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    name = "name of both files and of the mechanism; default: the description's name"
    parser.add_argument("name", nargs="?", metavar="NAME", help=name)
    source = "description of the mechanism: points, links, parameters"
    parser.add_argument("--from", dest="source", type=Path, metavar="FILE", help=source)
    kind = parser.add_mutually_exclusive_group()
    model = "model of the clearance joint; default: %(default)s"
    kind.add_argument("--model", choices=("lubricated", "dry"), default="lubricated", help=model)
    rod = "a slider-crank with a flexible rod, instead of a four-bar with clearance"
    kind.add_argument("--flexible", dest="model", action="store_const", const="flexible", help=rod)
    parser.add_argument("--out", type=Path, default=Path(), metavar="DIR", help="default: the current folder")


def run(options: argparse.Namespace) -> int:
    """Write the files; return the exit status."""
    source: Path | None = options.source
    name: str | None = source.name.partition(".")[0] if source and options.name is None else options.name
    if name is None:
        raise InputError("NAME", "", "is missing; write linkages new NAME, or linkages new --from FILE")
    if not _NAME.fullmatch(name):
        problem = "must begin with a letter, contain at most 64 letters (a to z), digits, - and _, and not be world"
        raise InputError("NAME" if options.name is not None else f"--from: {source}: the file's name", name, problem)
    texts, facts = described_files(name, source) if source else (template_files(name, options.model), "")
    machine, experiment = write_files(name, texts, options.out)
    show(f"written: {machine}, {experiment}{facts}")
    show(f"draw it: linkages draw {experiment}")
    show(f"run it: linkages simulate {experiment}")
    return 0


def template_files(name: str, model: str) -> tuple[str, str]:
    """Return the texts of a mechanism and an experiment from templates, in which ``@NAME@`` is replaced.

    The model "lubricated" or "dry" gives a four-bar with clearance, "flexible" a slider-crank with a flexible rod.
    """
    mechanism = "slider_crank.sdf" if model == "flexible" else "four_bar.sdf"
    templates = files("linkages.cli") / "templates"
    texts = ((templates / file).read_text(encoding="utf-8") for file in (mechanism, f"{model}.toml"))
    machine, experiment = (text.replace("@NAME@", name) for text in texts)
    return machine, experiment


def described_files(name: str, source: Path) -> tuple[tuple[str, str], str]:
    """Return the texts of a described mechanism and its experiment, and their main facts."""
    import tomlkit

    from linkages.input.files.described_model import KEYS
    from linkages.input.files.description import described
    from linkages.input.files.reading import read_whole
    from linkages.input.files.sdf_text import sdf_text
    from linkages.input.files.toml import read_toml
    from linkages.input.model.experiment import Experiment, experiment_of
    from linkages.input.model.mechanism import mechanism_of_text
    from linkages.system import System

    data, sources = read_toml(source)
    if "mechanism" in data:
        raise InputError(source, "mechanism", "names an SDFormat file; a description has points and links instead")
    known = (*KEYS, *Experiment.model_fields)
    for key in data:
        if key not in known:
            raise InputError(source, key, f"unknown key; {nearest(key, known)}")
    drawn = described(source, name, {key: value for key, value in data.items() if key in KEYS})
    rest = {key: value for key, value in data.items() if key not in KEYS}
    flexible = {link.name: {"model": "flexible"} for link in drawn.model.links if link.beam is not None}
    if flexible:
        rest["links"] = flexible
    machine = sdf_text(drawn.model, [f"made by `linkages new --from {source.name}`"], drawn.text)
    mechanism = mechanism_of_text(source, machine.encode())
    system = System(mechanism, experiment_of(source, {"mechanism": f"{name}.sdf"} | rest, sources))
    document = tomlkit.parse(read_whole(source).decode())
    for key in KEYS:
        if key in document:
            document.remove(key)
    experiment = f'mechanism = "{name}.sdf"\n{tomlkit.dumps(document)}'
    if flexible:
        experiment = f"{experiment.rstrip()}\n\n{tomlkit.dumps({'links': flexible})}"
    counts = f"{len(mechanism.links)} links, {len(mechanism.joints)} joints"
    freedoms = f"{counted(system.assembly.mobility, 'degree')} of freedom"
    named = ", ".join(f"sdf.{key} = {value:.6g}" for key, value in drawn.parameters.items())
    facts = f"\n{counts}, {freedoms}" + (f"\nparameters, SI: {named}" if named else "")
    return (machine, experiment), facts


def write_files(name: str, content: tuple[str, str], folder: Path) -> tuple[Path, Path]:
    """Write the two texts to NAME.sdf and NAME.toml, both or neither; return their paths.

    InputError if one of the files exists, or the folder is not writable.
    """
    machine, experiment = (folder / f"{name}{end}" for end in (".sdf", ".toml"))
    for path in (machine, experiment):
        if os.path.lexists(path):  # a link that leads nowhere would be replaced
            raise InputError(str(path), "", "already exists; choose another name, or remove it")
    with errors_of_writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
    with whole(machine) as first, whole(experiment) as second:
        first.write_text(content[0], encoding="utf-8")
        second.write_text(content[1], encoding="utf-8")
    return machine, experiment
