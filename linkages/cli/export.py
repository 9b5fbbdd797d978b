"""``linkages export``: the trajectory of a run, or the loads of its links, for other programs."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from linkages.base.errors import InputError
from linkages.cli.options import add_names, add_units, possible_folder, seconds, stored_run, written
from linkages.cli.printing import show
from linkages.input.files.table_formats import FORMATS

if TYPE_CHECKING:
    from linkages.results.load_files import Case
    from linkages.results.trajectory import Trajectory
    from linkages.system import System

HELP = "write a run's trajectory (csv, mat, parquet, netcdf) or the loads of its links for finite elements"

EXAMPLES = """examples:
  linkages export results/seven_bar --to csv
  linkages export results/seven_bar --to mat --out press.mat
  linkages export results/seven_bar --loads
  linkages export results/seven_bar --loads --link link6 --at peak:B.force --at 0.35
"""

_PEAK = "peak:"
_SAME = 1e-6  # relative difference between a run and its repetition


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.add_argument("folder", type=Path, metavar="DIR", help="folder that `linkages simulate` wrote")
    group = parser.add_mutually_exclusive_group(required=True)
    group.add_argument("--to", choices=tuple(FORMATS), help="format of the trajectory")
    group.add_argument("--loads", action="store_true", help="balanced loads of each link: loads.csv, LINK.inp")
    add_units(parser)
    add_names(parser, "--link", "link with --loads; may be repeated; default: all")
    default = "the largest force of each joint of the links"
    meaning = f"time, or peak:OUTPUT for the time of an output's largest magnitude; may be repeated; default: {default}"
    parser.add_argument("--at", action="append", metavar="TIME", help=meaning)
    meaning = "default: DIR/trajectory.csv, .mat, .parquet or .nc; with --loads a folder, default: DIR"
    parser.add_argument("--out", type=Path, metavar="PATH", help=meaning)


def run(options: argparse.Namespace) -> int:
    """Write the files; return the exit status."""
    if options.loads:
        return _export_loads(options)
    for name in ("link", "at"):
        if getattr(options, name):
            raise InputError(f"--{name}", "", "goes with --loads; leave it out")
    from linkages.input.files.writing import whole
    from linkages.show.plots.presentation import shown

    run = stored_run(options.folder)
    count = len(run.columns)
    for name, column in run.columns.items():
        column *= shown(run.units.get(name, ""))[1]  # in place: copies would double the memory
    units = {name: shown(si)[0] for name, si in run.units.items()}
    write, end = FORMATS[options.to]
    path = options.out or options.folder / f"trajectory{end}"
    with whole(path) as partial:
        write(partial, run.columns, units, run.about)
    print(f"written: {path}, {count} columns of {len(run.time)} steps, {path.stat().st_size / 1e6:.1f} MB")
    return 0


# -- loads -------------------------------------------------------------------------------------------------------------


def _export_loads(options: argparse.Namespace) -> int:
    from linkages.input.files.writing import errors_of_writing
    from linkages.results.load_files import write_loads

    out = possible_folder(options.out or options.folder) if options.out else options.folder
    system, run, part = _repeated(options.folder)
    links = _links(options.link, system)
    times = _times(options.at, system, run, part, links)
    cases = _cases(system, run, times, links)
    with errors_of_writing(out):
        out.mkdir(parents=True, exist_ok=True)
        names = write_loads(out, cases)
    lines = [f"{'case':>4} {'time [s]':>12}  {'link':16} {'loads':>6} {'largest [N]':>12} {'sum / largest':>14}"]
    for k, case in enumerate(cases):
        lines.append(f"{k + 1:>4} {case.time:12.6g}  {case.name}")
        for link, of_link in case.links.items():
            count = len(of_link.loads)
            lines.append(f"{'':18} {link:16} {count:>6} {of_link.largest:12.4g} {of_link.imbalance:14.1e}")
    show("\n".join([*lines, "", written(out, names)]))
    return 0


def _repeated(folder: Path) -> tuple[System, Trajectory, Trajectory]:
    """Repeat the run of a folder from its record; return it and the part that its tables are about."""
    from linkages.engines.assessment import assess
    from linkages.show.report.result_folder import load_results, recorded_system

    results = load_results(folder)
    found = assess(recorded_system(results), results.summary["engine"], False)
    _compare(folder, found.run, stored_run(folder))
    if not found.run.evaluate or any(name in found.run for name in _segments(found.system, found.run)):
        raise InputError(str(folder), "summary.json", "has a run that gives no loads; repeat it with --engine compiled")
    return found.system, found.run, found.run.within(*found.reported_span)


def _segments(system: System, run: Trajectory) -> list[str]:
    """List the coordinates of a run with rigid segments, which the system's own tree does not have."""
    own = {f"q.{name}" for name in system.tree.coordinates}
    return [name for name in run if name.startswith("q.") and name not in own]


def _compare(folder: Path, run: Trajectory, stored: Trajectory) -> None:
    """Warn if a repeated run differs from the stored one."""
    import numpy as np

    names = [name for name in stored if name.startswith("q.") and name in run]
    ends = np.array([(run[name][-1], stored[name][-1]) for name in names])
    if run.time[-1] != stored.time[-1] or not np.allclose(ends[:, 0], ends[:, 1], rtol=_SAME, atol=_SAME):
        show(
            f"warning: the repeated run differs from the one in {folder}: its files have changed, or the motion is"
            " chaotic and this machine rounds otherwise; the loads belong to the repeated run"
        )


def _links(asked: list[str] | None, system: System) -> list[str]:
    from linkages.base.errors import nearest

    moving = [name for name in system.links if name != "world"]
    for name in asked or ():
        if name not in moving:
            raise InputError("--link", name, f"is unknown; {nearest(name, moving)}")
    return asked or moving


def _times(
    asked: list[str] | None, system: System, run: Trajectory, part: Trajectory, links: list[str]
) -> dict[str, float]:
    """Return the times of the cases, by the words of the option; peaks are those of a part of the run."""
    from linkages.base.errors import nearest
    from linkages.results.extremes import extremes

    of_links = [joint.name for joint in system.joints.values() if {joint.parent, joint.child} & set(links)]
    words = asked or [f"{_PEAK}{name}.force" for name in of_links]
    names = [word.removeprefix(_PEAK) for word in words if word.startswith(_PEAK)]
    for name in names:
        if name not in run:
            raise InputError("--at", f"{_PEAK}{name}", f"is unknown; {nearest(name, [*run])}")
    found: dict[str, Any] = {f"{_PEAK}{name}": extreme.time for name, extreme in extremes(part, names).items()}
    return {word: found[word] if word in found else _time(word, run) for word in words}


def _time(word: str, run: Trajectory) -> float:
    try:
        time = seconds(word)
    except ValueError:
        raise InputError("--at", word, "write a time [s], or peak:OUTPUT, such as peak:B.force") from None
    if not run.time[0] <= time <= run.time[-1]:
        raise InputError("--at", word, f"lies outside the run, {run.time[0]:g} to {run.time[-1]:g} s")
    return time


def _cases(system: System, run: Trajectory, times: dict[str, float], links: list[str]) -> list[Case]:
    import numpy as np

    from linkages.results.link_loads import link_loads
    from linkages.results.load_files import Case

    states = run.evaluate.function.states_at(np.array([*times.values()]))  # type: ignore[union-attr]
    cases = []
    for k, (name, time) in enumerate(times.items()):
        found = link_loads(system, time, tuple(part[k] for part in states))
        cases.append(Case(name, time, {link: found[link] for link in links}))
    return cases
