"""Files, ``--set`` values, results and command lines with something wrong in them, and commands that Ctrl-C strikes.

All end with one line of refusal or finite numbers, and soon.

Run as a script, it tries as many as one likes: ``python tests/test_mutations.py --count 10000 --seed 1``.
"""

from __future__ import annotations

import argparse
import faulthandler
import signal
import sys
import tempfile
import traceback
from collections import Counter
from contextlib import contextmanager
from pathlib import Path

import mutant_commands
import mutant_trials
import pytest
from mutant_trials import command
from mutants import EXPERIMENTS, Mutator

TRIALS = mutant_trials.TRIALS | {"line": mutant_commands.mutated, "struck": mutant_commands.struck}
#: Mutants of every run of the tests, and shares of the script's.
COUNTS = {"load": 200, "study": 50, "store": 30, "import": 100, "describe": 20, "report": 30, "compiled": 30}
COUNTS |= {"line": 200}
SHARES = {"load": 4, "study": 2, "store": 2, "import": 2, "describe": 4, "report": 4, "blocks": 1, "compiled": 11}
SHARES |= {"drake": 1, "line": 30, "struck": 4}
LONGEST = 20  # s of the processor for one mutant
STUCK = 1800  # s after which the script gives up

FAULT, HANG = "FAULT", "HANG"  # beginnings of the endings that must not be


@contextmanager
def at_most(seconds: float):
    """Press Ctrl-C if it takes the processor longer, and again: results of an interrupted run are kept.

    No signal is sent after the block, which the caller may leave at any moment by one of them.
    """
    under_way = [True]

    def press(*_: object) -> None:
        if under_way:
            signal.raise_signal(signal.SIGINT)

    before = signal.signal(signal.SIGPROF, press)
    signal.setitimer(signal.ITIMER_PROF, seconds, 2.0)
    try:
        yield
    finally:
        under_way.clear()
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


@pytest.fixture
def no_signs_of_life():
    """Let commands show them: their silence is measured."""


def ending(kind: str, number: int, seed: int, folder: Path) -> str:
    """Try a mutant; what hangs is tried twice: the first time it may have been the compiler."""
    for _ in range(2):
        try:
            with at_most(LONGEST):
                return TRIALS[kind](Mutator(f"{kind} {number} {seed}"), folder)
        except KeyboardInterrupt as pressed:
            found = "slow, and says so" if pressed.args == (True,) else HANG
        except BaseException as problem:
            frames = traceback.extract_tb(problem.__traceback__)
            ours = [frame for frame in frames if "site-packages" not in frame.filename] or frames
            said = f"{type(problem).__name__}: {' '.join(str(problem).split())[:400]}"
            return f"{FAULT} {Path(ours[-1].filename).name}:{ours[-1].lineno} {said}"
    return found


def faults(ends: Counter) -> list[str]:
    return [text for text in ends if text.startswith((FAULT, HANG))]


@pytest.mark.slow
@pytest.mark.parametrize("kind", COUNTS)
def test_mutants_are_refused_in_one_line_or_give_finite_numbers(kind, tmp_path):
    ends = Counter(ending(kind, k, 1, tmp_path) for k in range(COUNTS[kind]))
    assert not faults(ends), ends
    assert min(ends["refused"], COUNTS[kind] - ends["refused"]) > 0.1 * COUNTS[kind]


def script() -> int:
    """Try many mutants; prints how many of each kind ended how, and which did not end well."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=1000, help="default: %(default)s")
    parser.add_argument("--first", type=int, default=0, help="number of the first; default: %(default)s")
    parser.add_argument("--seed", type=int, default=1, help="default: %(default)s")
    parser.add_argument("--kinds", nargs="+", choices=TRIALS, default=list(TRIALS), help="default: all")
    options = parser.parse_args()
    signal.signal(signal.SIGINT, signal.default_int_handler)  # which a script in the background ignores
    order = [kind for kind in options.kinds for _ in range(SHARES[kind])]
    ends: Counter = Counter()
    with tempfile.TemporaryDirectory() as folder:
        for path in EXPERIMENTS if "compiled" in options.kinds else ():  # compiles their kernels
            command("simulate", path, "--engine", "compiled", "--duration", "0.01", "--out", Path(folder) / "out")
        for number in range(options.first, options.first + options.count):
            kind = order[number % len(order)]
            faulthandler.dump_traceback_later(STUCK, exit=True)
            found = ending(kind, number, options.seed, Path(folder))
            ends[f"{kind:10s}{found}"] += 1
            if faults(Counter([found])):
                print(f"{kind} {number}: {found}", flush=True)
            if sys.stderr.isatty() or number % 100 == 99:
                print(f"\r{number + 1 - options.first}", end="", file=sys.stderr, flush=True)
    faulthandler.cancel_dump_traceback_later()
    print(f"\n{options.count} mutants from number {options.first}, seed {options.seed}")
    for text, count in sorted(ends.items()):
        print(f"{count:7d}  {text}")
    return int(any(text[10:].startswith((FAULT, HANG)) for text in ends))


if __name__ == "__main__":
    sys.exit(script())
