"""Options of several commands, the numbers in them, the experiment that they define, the folder of the results."""

from __future__ import annotations

import argparse
import math
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

from linkages.base.errors import InputError
from linkages.cli import commands
from linkages.cli.printing import show
from linkages.input.files.unit_conversion import decimal_comma, is_quantity, read, si, si_unit
from linkages.input.files.writing import OutputFolder, write_json
from linkages.show.plots.presentation import FORMATS, STYLES, presented, show_in

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from linkages.results.trajectory import Trajectory
    from linkages.show.report.tables import PageTable
    from linkages.system import System


def add_file(parser: argparse.ArgumentParser) -> None:
    """Add the experiment's file."""
    parser.add_argument("file", help="experiment: a path, or the name of a shipped file; .toml is optional")


def add_set(parser: argparse.ArgumentParser, lasting: bool = False) -> None:
    """Add ``--set``, and ``--duration`` to a command whose runs have one."""
    meaning = "replace a value; may be repeated"
    parser.add_argument("--set", action="append", default=[], metavar="PATH=VALUE", help=meaning)
    if lasting:
        parser.add_argument("--duration", type=seconds, metavar="SECONDS", help="replace the experiment's duration")


def add_settings(parser: argparse.ArgumentParser, lasting: bool = True) -> None:
    """Add the options of `add_set` and `add_out`, ``--quiet`` and ``--verbose``."""
    add_set(parser, lasting)
    add_out(parser)
    group = parser.add_mutually_exclusive_group()
    group.add_argument("--quiet", "-q", action="store_true", help="print nothing but errors")
    group.add_argument("--verbose", "-v", action="store_true", help="print the stages, the methods and the times")


def add_out(parser: argparse.ArgumentParser) -> None:
    """Add ``--out`` and ``--force``."""
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder of the results; default: results/NAME")
    parser.add_argument("--force", action="store_true", help="replace another command's files in the folder")


def add_experiment(
    parser: argparse.ArgumentParser, lasting: bool = True, pictures: bool = True, animation: bool = False
) -> None:
    """Add an experiment's file, `add_settings`, and `add_pictures` to a command that draws."""
    add_file(parser)
    add_settings(parser, lasting)
    if pictures:
        add_pictures(parser, animation)


def add_data(parser: argparse.ArgumentParser) -> None:
    """Add ``--data``."""
    meaning = "measured curves for comparison with the run; [data] in the experiment maps their columns"
    parser.add_argument("--data", type=Path, metavar="FILE", help=meaning)


def add_outputs(parser: argparse.ArgumentParser) -> None:
    """Add ``--output``."""
    default = "the experiment's outputs and the forces in clearance joints"
    add_names(parser, "--output", f"recorded output, see `linkages keys`; may be repeated; default: {default}")


def add_names(parser: argparse.ArgumentParser, option: str, meaning: str) -> None:
    """Add an option that gives a name and may be repeated."""
    parser.add_argument(option, action="append", metavar="NAME", help=meaning)


def add_units(parser: argparse.ArgumentParser) -> None:
    """Add ``--units``."""
    meaning = "units of tables, figures and pages instead of SI units, such as mm,deg,r/min; JSON and NPZ keep SI units"
    parser.add_argument("--units", metavar="UNITS", help=meaning)


def add_number(parser: argparse.ArgumentParser, option: str, default: float, metavar: str, meaning: str) -> None:
    """Add an option with a number of the type of its default."""
    text = f"{meaning}; default: %(default)s"
    parser.add_argument(option, type=type(default), default=default, metavar=metavar, help=text)


def add_drive(parser: argparse.ArgumentParser, defined: str) -> None:
    """Add ``--drive``: the drive that defines a revolution or a cycle."""
    default = "the first with constant speed, otherwise the first periodic one"
    parser.add_argument("--drive", metavar="JOINT", help=f"drive that defines {defined}; default: {default}")


def add_cluster(parser: argparse.ArgumentParser) -> None:
    """Add ``--cluster`` and ``--wait``."""
    meaning = "run on a Dask cluster: tcp://host:8786, or the file (.json) that its scheduler writes"
    parser.add_argument("--cluster", metavar="ADDRESS", help=meaning)
    meaning = "with --cluster: time to wait for the scheduler and a first worker; default: 60 s"
    parser.add_argument("--wait", type=seconds, metavar="SECONDS", help=meaning)


@contextmanager
def workers(options: argparse.Namespace, remedy: str) -> Iterator[tuple[Executor | None, Callable[[], int]]]:
    """Provide the executor of ``--cluster`` and the number of its threads by now; without it None and 0."""
    if not options.cluster:
        if options.wait is not None:
            raise InputError("--wait", f"{options.wait:g}", "belongs to --cluster; give the address, or remove it")
        yield None, lambda: 0
        return
    from linkages.engines.cluster import WAIT, cluster

    if options.wait is not None and not options.wait >= 0.0:
        raise InputError("--wait", f"{options.wait:g}", "must be zero or positive")
    with cluster(options.cluster, remedy, WAIT if options.wait is None else options.wait) as found:
        yield found


def add_part(parser: argparse.ArgumentParser, default: str) -> None:
    """Add ``--from`` and ``--to``: a part of a run."""
    for name, what in (("--from", "before"), ("--to", "after")):
        meaning = f"without the times {what}; default: {default}"
        parser.add_argument(name, type=seconds, metavar="SECONDS", help=meaning)


def stored_run(folder: Path) -> Trajectory:
    """Read the run of a folder; InputError if it has none."""
    from linkages.results.trajectory import load_trajectory

    source = folder / "trajectory.npz"
    if not source.exists():
        problem = "has no trajectory.npz" if folder.is_dir() else "is not a folder"
        raise InputError(str(folder), "", f"{problem}; give the --out folder of `linkages simulate`")
    return load_trajectory(source)


def part_of(run: Trajectory, folder: Path, options: argparse.Namespace) -> Trajectory:
    """Return the part of a folder's run of `add_part`; InputError if nothing remains."""
    first, last = float(run.time[0]), float(run.time[-1])
    asked = getattr(options, "from"), options.to
    start, end = (at if given is None else given for given, at in zip(asked, (first, last), strict=True))
    if not max(start, first) < min(end, last):
        raise InputError("--from", f"{start:g}", f"and --to {end:g} leave nothing of {folder}, {first:g} to {last:g} s")
    return run.within(max(start, first), min(end, last))


def add_pictures(parser: argparse.ArgumentParser, animation: bool = False) -> None:
    """Add ``--no-plots``, the options of figures, and ``--no-animation`` to a command that writes one."""
    parser.add_argument("--no-plots", action="store_true", help="write no figures")
    group = parser.add_argument_group("figures")
    group.add_argument("--format", choices=FORMATS, help="default: png")
    group.add_argument(
        "--size", metavar="SIZE", help="width and height, such as 85x60mm, or the width alone; at least 40x30mm"
    )
    group.add_argument("--style", choices=STYLES, help="print has small text, thin lines, 300 dpi; default: screen")
    if animation:
        parser.add_argument("--no-animation", action="store_true", help="write no animation")


def output_names(options: argparse.Namespace, system: System) -> list[str]:
    """Return the names of `add_outputs`; InputError if there are none."""
    usual = dict.fromkeys([*system.settings.outputs, *(f"{name}.force" for name in system.play)])
    names = options.output or [*usual]
    if not names:
        raise InputError(system.description.source, "outputs", "are none; name one with --output")
    return names


def seconds(text: str) -> float:
    """Read a time, such as ``0.02`` or ``20 ms`` [s]; invalid text gives the ValueError that argparse expects."""
    return si(text, "s") if is_quantity(text) else float(text)


def load_system(options: argparse.Namespace, defaults: Mapping[str, float] | None = None) -> System:
    """Load the experiment and its mechanism with the values of ``--set`` and ``--duration``.

    `defaults` are values by dotted path that override the file, unless the command line does.
    """
    from linkages.base.errors import COMMAND_LINE
    from linkages.input.files.shipped import find_file
    from linkages.system import load

    worn = _worn_values(options.worn) if getattr(options, "worn", None) else {}
    values = {**(defaults or {}), **worn, **set_values(options)}
    file = find_file(options.file, ".toml")
    system = load(file, values, COMMAND_LINE)
    _check_set(system, file, values)
    if getattr(options, "units", None) is None:
        show_in(system.description.units, (system.description.source, "units"))
    if getattr(options, "ideal", False):
        ideal = {f"joints.{name}": {"model": "ideal"} for name in system.experiment.joints}
        return system.replaced(ideal, COMMAND_LINE)
    return system


def _check_set(system: System, file: Path, values: Mapping[str, Any]) -> None:
    """Refuse a number of the command line that changes nothing in a run, see `linkages.engines.compiled.effects`."""
    from linkages.base.errors import COMMAND_LINE
    from linkages.engines.compiled.effects import without_effect
    from linkages.system import load

    for path in values:
        try:
            before = load(file, {other: value for other, value in values.items() if other != path}, COMMAND_LINE)
        except InputError:  # the others need this value
            continue
        if problem := without_effect(system, before, path):
            raise InputError(COMMAND_LINE, path, problem)


def _worn_values(path: Path) -> dict[str, Any]:
    """Return the key `worn` of each joint of a ``wear.json``, by dotted path of the experiment."""
    from linkages.input.model.worn import read_worn

    try:
        return {f"joints.{name}.worn": repr(str(path.absolute())) for name in read_worn(path)}
    except InputError:
        raise
    except ValueError as problem:
        raise InputError("--worn", "", str(problem)) from None


def set_values(options: argparse.Namespace) -> dict[str, str | float]:
    """Return the values of ``--set`` and ``--duration`` by their dotted paths."""
    values: dict[str, str | float] = {}
    for item in options.set:
        path, equals, value = item.partition("=")
        if not equals or not path or not value:
            raise InputError("--set", item, "write PATH=VALUE, such as joints.A.clearance=2e-4")
        values[path.strip()] = value.strip()
    if getattr(options, "duration", None) is not None:
        values["duration"] = options.duration
    if getattr(options, "data", None) is not None:
        values["data.file"] = repr(str(options.data.absolute()))
    return values


def as_presented(options: argparse.Namespace) -> AbstractContextManager[None]:
    """Return the context of a command that shows its results as its options say."""
    return presented(**{name: getattr(options, name, None) for name in ("format", "size", "style", "units")})


def written(out: Path, names: Iterable[str]) -> str:
    """List the files written into the folder of results."""
    return f"written to {out}{os.sep}: {', '.join(names)}"


#: Options with a value that say where results go and where work is done: a repetition does not need them.
_OWN_PLACE = frozenset({"--out", "--cluster", "--wait"})


def record(
    options: argparse.Namespace,
    folder: Path,
    title: str,
    question: str,
    answer: list[str],
    table: str,
    tables: Iterable[PageTable] = (),
    tiles: Iterable[tuple[str, str]] = (),
) -> None:
    """Write ``record.json`` for ``linkages report``: question, answer, tables, command line without its folder.

    `table` is the text of the terminal, `tables` and `tiles`, the numbers of the first screen with their meanings, are
    the same for a page.
    """
    from linkages.input.files.versions import versions

    given: dict[str, Any] = {"title": title, "question": question, "answer": answer, "table": table}
    given |= {"tiles": [*tiles], "tables": [one.content for one in tables]}
    pairs = pairwise(["", *options.words])
    words = [word for before, word in pairs if _OWN_PLACE.isdisjoint((before, word.partition("=")[0]))]
    words = [word for word in words if word != "--resume"]  # the repetition begins anew
    write_json(folder / "record.json", given | {"words": words, "versions": versions()})


def print_results(options: argparse.Namespace, table: str, out: OutputFolder) -> None:
    """Print the table of a command and the names of its files, unless it is quiet."""
    if not getattr(options, "quiet", False):
        show(f"{table}\n\n{written(out.path, out.names)}")


# -- folders of results: each has the files of one command and one run -------------------------------------------------


def _files() -> dict[str, tuple[str, ...]]:
    """Collect the files of each command, its reports and exports; the first one identifies the command."""
    modules = commands().values()
    return {command: names for module in modules for command, names in getattr(module, "WRITES", {}).items()}


def output_folder(
    options: argparse.Namespace, name: str, command: str, continued: tuple[str, ...] = ()
) -> OutputFolder:
    """Return the folder of the results, ``results/NAME`` unless ``--out`` is given; it is written atomically.

    Files of another run, or with ``--force`` of other commands, are removed then. InputError if it is a file, cannot be
    made or written, or (without ``--force``) has results of another command. `continued` are files of an earlier run
    that this one continues.
    """
    out = possible_folder(options.out or Path("results") / name)
    if not out.exists() or not any(out.iterdir()):
        return OutputFolder(out, [])
    known = _files()
    others = [
        owner
        for owner, (key, *_) in known.items()  # drawings are compatible with all runs
        if owner != command and (out / key).exists() and not any(Path(key).match(own) for own in known[command])
    ]
    if others and not options.force:
        problem = f"holds results of `linkages {others[0]}`; give another folder, or --force to replace them"
        raise InputError("--out", str(out), problem)
    stale = {
        f"{name.removesuffix('.png')}.{kind}" if name.endswith(".png") else name
        for owner in (command, *others)
        for name in (*known[owner], "record.json", "report.html")
        for kind in FORMATS
    }
    return OutputFolder(out, sorted(stale - set(continued)))


def possible_folder(out: Path) -> Path:
    """Return a folder that exists or can be made; InputError if it is a file, or cannot be made or written."""
    place = next(place for place in (out, *out.absolute().parents) if place.exists())
    if not place.is_dir():
        raise InputError("--out", str(out), "is a file; give a folder" if place == out else f"{place.name} is a file")
    if not os.access(place, os.W_OK | os.X_OK):
        raise InputError("--out", str(out), "cannot be written; give another folder")
    return out


# -- numbers -----------------------------------------------------------------------------------------------------------


def path_and_range(text: str, system: System) -> tuple[str, float, float]:
    """Read ``PATH=LO:HI`` of ``--vary``; InputError if it is not of that form, or LO is not below HI.

    Examples
    --------
    >>> import linkages
    >>> from linkages.cli.options import path_and_range
    >>> path_and_range("joints.A.clearance=0.1mm:0.4mm", linkages.load(linkages.find_file("seven_bar.toml")))
    ('joints.A.clearance', 0.0001, 0.0004)
    """
    path, parts = path_and_parts(text, "PATH=LO:HI")
    low, high = (value_of("--vary", part, path, system) for part in parts)
    if not low < high:
        raise InputError("--vary", text, "needs LO < HI")
    return path, low, high


def path_and_parts(text: str, form: str) -> tuple[str, list[str]]:
    """Split the text of ``--vary`` into its path and its parts between colons, as many as in the form."""
    path, _, numbers = text.partition("=")
    parts = numbers.split(":")
    if not path.strip() or len(parts) != len(form.split(":")):
        raise InputError("--vary", text, f"write {form}; LO and HI may have units, as 0.1mm:0.4mm")
    return path.strip(), parts


def value_of(where: str, text: str, path: str, system: System) -> float:
    """Read a finite number in the SI unit of a path, or with its unit; `where` names it in an InputError."""
    unit = system.value_unit(path)
    of_any_kind = not unit and path.startswith(("sdf.parameters.", "values.")) and is_quantity(text)
    return number(where, text, si_unit(text) if of_any_kind else unit)


def number(where: str, text: str, unit: str) -> float:
    """Read a finite number in a unit (empty: a pure number), or with its own."""
    try:
        value = float(read(text, unit) if unit else text)
    except ValueError as problem:
        said = str(problem)
        remedy = decimal_comma(text) or "; give a number"
        raise InputError(where, "", said if said.startswith("is ") else f'is "{text}"{remedy}') from None
    if not math.isfinite(value):
        raise InputError(where, "", f'is "{text}"; give a finite number')
    return value
