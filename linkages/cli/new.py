"""``linkages new``: a machine and an experiment to begin with."""

from __future__ import annotations

import argparse
import re
from importlib.resources import files
from pathlib import Path

from linkages.errors import InputError

HELP = "write a commented machine (.sdf) and experiment (.toml) to begin with"

_EXAMPLES = """examples:
  linkages new press && linkages simulate press.toml
  linkages new press --model dry --out machines
"""

_NAME = re.compile(r"(?!world$)[A-Za-z][A-Za-z0-9_-]{0,63}")  # SDFormat keeps "world" for itself


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.epilog = _EXAMPLES
    parser.add_argument("name", metavar="NAME", help="name of both files and of the machine")
    parser.add_argument(
        "--model",
        choices=("lubricated", "dry"),
        default="lubricated",
        help="model of the joint with play; default: %(default)s",
    )
    parser.add_argument("--out", type=Path, default=Path(), metavar="DIR", help="default: the current folder")


def run(options: argparse.Namespace) -> int:
    """Write the files; returns the exit status."""
    name: str = options.name
    if not _NAME.fullmatch(name):
        raise InputError(
            "name", name, "must begin with a letter, contain only letters, digits, - and _, and not be world"
        )
    machine, experiment = write_files(name, options.model, options.out)
    print(f"written: {machine}, {experiment}\nrun it:  linkages simulate {experiment}")
    return 0


def write_files(name: str, model: str, folder: Path) -> tuple[Path, Path]:
    """Write NAME.sdf and NAME.toml, both or neither.

    Parameters
    ----------
    name : str
        Replaces ``@NAME@`` in the templates.
    model : str
        "lubricated" or "dry".
    folder : Path

    Returns
    -------
    (Path, Path)
        The machine and the experiment.

    Raises
    ------
    InputError
        If one of them exists, or the folder cannot be written.
    """
    templates = files("linkages") / "templates"
    texts = {
        folder / f"{name}.sdf": (templates / "four_bar.sdf").read_text(encoding="utf-8"),
        folder / f"{name}.toml": (templates / f"{model}.toml").read_text(encoding="utf-8"),
    }
    for path in texts:
        if path.exists():
            raise InputError(str(path), "", "already exists; choose another name, or remove it")
    begun: list[Path] = []
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for path, text in texts.items():
            with open(path, "x", encoding="utf-8") as file:
                begun.append(path)
                file.write(text.replace("@NAME@", name))
    except OSError as problem:
        for path in begun:
            path.unlink(missing_ok=True)
        raise InputError("--out", str(folder), f"cannot be written ({problem.strerror})") from None
    machine, experiment = texts
    return machine, experiment
