"""``linkages doctor``: checks of the installation, each with a result and its remedy."""

from __future__ import annotations

import argparse
import importlib.metadata
import io
import platform
import re
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from functools import partial
from math import sqrt
from pathlib import Path
from typing import NamedTuple

from linkages.base.errors import Status
from linkages.base.packages import installed
from linkages.cli.printing import show_pairs
from linkages.engines import ENGINES, PACKAGES
from linkages.input.files.shipped import data_folder

HELP = "check the installation: versions, caches, data, a self-check"

EXAMPLES = """examples:
  linkages doctor
  linkages doctor > installation.txt   to send with a bug report
  linkages doctor --compile            no command waits for the compiler
"""
_NAMES = 27  # widest check [columns]
_PLACE = "set NUMBA_CACHE_DIR to a writable folder"
#: Capabilities that are missing without a package that not every system has.
_WITHOUT = {"drake": "without: the drake engine, compare, --verify, SNOPT, magnified joints in animations"}
_MINUTES = 8  # time to compile the code of all commands
_TOLERANCE = 1e-6  # relative tolerance of the self-check; the runs of both engines are ten times more accurate


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    text = "compile the code of all commands now, in the background, instead of at the first use of each"
    parser.add_argument("--compile", action="store_true", help=text)


def run(options: argparse.Namespace) -> int:
    """Print the results, or compile; return 1 if a check fails."""
    from linkages.cli.progress import announce_compilation

    if options.compile:
        return _compile()
    announce_compilation()
    wrong = 0
    for result in examine():
        wrong += bool(result.remedy)
        rows = [(f"{'WRONG' if result.remedy else 'ok   '} {result.name}", result.text)]
        show_pairs(rows + [("", result.remedy)] * bool(result.remedy), _NAMES)
    print(f"\n{wrong} of these need{'s' * (wrong == 1)} a remedy" if wrong else "\nall is well")
    return int(bool(wrong))


def _compile() -> int:
    """Begin to compile the code of all commands; return 1 if there is no cache to keep it in."""
    from linkages.cli.preparation import prepare_beside, short_runs

    if (cache := compile_cache()).remedy:
        print(f"WRONG {cache.name:22s} {cache.text}\n{'':28s} {cache.remedy}")
        return 1
    prepare_beside()
    print(
        f"compiling in the background: {len(short_runs())} short runs, for about {_MINUTES} minutes on two free cores;"
        " commands work meanwhile"
    )
    print(f"{cache.text}; `linkages doctor` counts its files")
    return 0


class CheckResult(NamedTuple):
    """A check, its result and, if it fails, the remedy."""

    name: str
    text: str
    remedy: str = ""


def examine() -> Iterator[CheckResult]:
    """Perform all checks, quick ones first; a crash of a check is a result too."""
    text = f"{platform.python_version()} at {sys.executable}"
    yield CheckResult("Python", text, "" if sys.version_info >= (3, 11) else "install Python 3.11 or newer")
    yield from packages()
    checks: dict[str, Callable[[], CheckResult]] = {
        "data": data,
        "compile cache": compile_cache,
        "film maps": film_maps,
        "threads": threads,
        "figures": figures,
    }
    for engine in ENGINES:
        if engine not in PACKAGES or installed(PACKAGES[engine]):
            checks[f"self-check, {engine}"] = partial(self_check, engine)
    for name, check in checks.items():
        try:
            yield check()
        except Exception as problem:  # any defect of the installation must be reported to the user
            text = " ".join(f"{type(problem).__name__}: {problem}".split())
            yield CheckResult(name, text, "install linkages and its packages in a new environment")


def packages() -> Iterator[CheckResult]:
    """Find the version of every package that linkages needs."""
    try:
        needed = importlib.metadata.requires("linkages") or []
        yield CheckResult("linkages", f"{importlib.metadata.version('linkages')} at {Path(__file__).parents[1]}")
    except importlib.metadata.PackageNotFoundError:
        yield CheckResult("linkages", "not installed", "run `pip install .` in the checkout")
        return
    for requirement in needed:
        line, _, marker = (part.strip() for part in requirement.partition(";"))
        if "extra" in marker:
            continue
        name, least = re.match(r"([\w.-]+)(?:.*>=([\d.]+))?", line).groups("")  # type: ignore[union-attr]
        try:
            version = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            if marker:  # not for all systems: the package does without
                yield CheckResult(name, f"not on this system, and not needed by most commands; {_WITHOUT[name]}")
            else:
                yield CheckResult(name, "not installed", f'run `pip install "{line}"`')
            continue
        old = _numbers(version) < _numbers(least)
        yield CheckResult(name, version, f'is too old: run `pip install -U "{line}"`' if old else "")


def data() -> CheckResult:
    """Find the shipped machines and experiments."""
    folder = data_folder()
    machines, experiments = (_count(folder, f"*.{kind}") for kind in ("sdf", "toml"))
    text = f"{machines} machines, {experiments} experiments in {folder}"
    remedy = "" if machines and experiments else "install the package again: it came without sdf/"
    return CheckResult("data", text, remedy)


def compile_cache() -> CheckResult:
    """Check the cache of compiled code: without it each start compiles for up to a minute."""
    import numba

    from linkages.base.kernel import fingerprint, folder, shipped

    if getattr(numba.config, "DISABLE_JIT", False):
        return CheckResult("compile cache", "the compiler is off", "unset NUMBA_DISABLE_JIT")
    path = folder.folder()
    if path is None:
        return CheckResult("compile cache", "none", _PLACE)
    kept, packed, made_with = _count(path, "*/*.nbc"), len(shipped.names()), shipped.versions()
    text = f"{path}, {f'{kept} files' if kept else 'empty'}"
    if packed and made_with == fingerprint.versions():
        text += f"; the package has {packed} kernels for {shipped.LEVEL}"
    elif made_with:
        text += f"; the package's kernels are not used: they need {shipped.LEVEL}, {made_with}"
    if not kept and not (packed and made_with == fingerprint.versions()):
        text += ": the first run compiles for up to a minute"
    return CheckResult("compile cache", text, _PLACE if path.is_relative_to(folder.temporary_folder()) else "")


def film_maps() -> CheckResult:
    """Check the cache of finite-film maps: computing one takes seconds."""
    from linkages.base.disk import cache_directory

    path = cache_directory()
    remedy = "" if _writable(path) else "set LINKAGES_CACHE to a writable folder"
    return CheckResult("film maps", f"{path}, {_count(path, '*.map')} maps", remedy)


def threads() -> CheckResult:
    """Check the number of threads for batches of runs."""
    import numba

    from linkages.base.kernel.precompiled import processors

    available, used = processors(), numba.get_num_threads()
    remedy = f"set NUMBA_NUM_THREADS to {available} at most" if used > available else ""
    return CheckResult("threads", f"{used} of {available} cores", remedy)


def figures() -> CheckResult:
    """Draw a figure without a display."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(1.0, 1.0))
    figure.subplots().plot([0.0, 1.0])
    figure.savefig(io.BytesIO(), format="png")
    return CheckResult("figures", "drawn without a display")


def self_check(engine: str) -> CheckResult:
    """Drop a journal in its bearing, and compare its impact with closed forms; see `linkages.engines.drop`."""
    from linkages.engines.assessment import simulate
    from linkages.engines.drop import CLEARANCE, GRAVITY, deepest, drop
    from linkages.results.impacts import impacts

    begin = time.perf_counter()
    run = simulate(drop(), engine)
    if run.status is not Status.OK:
        raise RuntimeError(f"the run ended with the status {run.status.value}")
    (contact,) = impacts(run, ["J"])
    took = time.perf_counter() - begin
    found = contact.start, contact.approach_speed, contact.peak_penetration
    exact = (sqrt(2 * CLEARANCE / GRAVITY), sqrt(2 * CLEARANCE * GRAVITY), deepest())
    error = max(abs(value / known - 1.0) for value, known in zip(found, exact, strict=True))
    text = f"time, speed and depth of an impact agree with closed forms to {error:.1e}, in {took:.1f} s"
    remedy = f"more than {_TOLERANCE:g}: remove the compile cache, then try again"
    return CheckResult(f"self-check, {engine}", text, "" if error < _TOLERANCE else remedy)


def _writable(folder: Path) -> bool:
    """Check that a folder is writable; create it if necessary."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


def _count(folder: Path, pattern: str) -> int:
    return len(list(folder.glob(pattern))) if folder.is_dir() else 0


def _numbers(version: str) -> tuple[int, ...]:
    return tuple(int(part) for part in re.findall(r"\d+", version)[:3])
