"""Exceptions for bad input and failed runs, and the named statuses of runs."""

from __future__ import annotations

import difflib
import enum
import sys
from collections.abc import Iterable, Sequence
from functools import cache
from pathlib import Path

#: Origins of values that no file has, shown as their source and in errors: Python, or the command line.
ARGUMENT, COMMAND_LINE = "argument", "command line"

_LONG = 200  # characters of the longest word that a message shows whole
_NAMED = 4  # most items of a brief list


class InputError(ValueError):
    """Invalid input; its text is one line with place and reason.

    Parameters
    ----------
    source : str or Path
        The file (or "command line", "argument") with the input.
    where : str
        The element or key, as the user wrote it: ``<joint name="A">`` or ``joints.A.clearance``.
    problem : str
        Error and remedy.

    Attributes
    ----------
    source, where, problem
        The arguments.
    """

    def __init__(self, source: str | Path, where: str, problem: str) -> None:
        name = source.name or str(source) if isinstance(source, Path) else source
        self.source, self.where, self.problem = source, where, problem
        parts = [part for part in (str(name), where, problem) if part]
        super().__init__(" ".join(map(shortened, ": ".join(parts).split())))


def shortened(word: str) -> str:
    """Return a word of a message; of a very long one its beginning and its end."""
    return word if len(word) <= _LONG else f"{word[: _LONG // 2]}...{word[-_LONG // 4 :]}"


class UnknownNameError(InputError, KeyError):
    """A name that a table of results does not have; its text lists similar names."""

    __str__ = Exception.__str__  # KeyError would print the key in quotes


class RunError(RuntimeError):
    """A run that cannot start, or does not reach its end; its text is one line with reason and remedy."""


class TimeOverError(Exception):
    """Raised by the progress function of a run that is to end: its steps so far are kept."""


class AssemblyError(RunError):
    """The linkage cannot be assembled.

    Attributes
    ----------
    status : Status
        The reason.
    """

    def __init__(self, status: Status, detail: str) -> None:
        super().__init__(f"{status.value}: {detail}; {status.remedy}")
        self.status = status


@cache
def notice(text: str) -> None:
    """Print a line on standard error, once in each process."""
    print(f"notice: {text}", file=sys.stderr)


#: Longest list of names in a message, and number of names in the place of a longer one.
_LONGEST, _CLOSEST = 300, 5


def nearest(name: str, known: Iterable[str], others: str = "", place: str = "") -> str:
    """Suggest the most similar name of `known`, as the end of a sentence; if none is, list all or say `others`.

    In the place of a long list are the closest names, their number, and what lists them all, the `place`.

    Examples
    --------
    >>> nearest("colour", ["mass", "x"])
    'known are: mass, x'
    >>> nearest("colour", [f"point{k}.x" for k in range(100)], place="`linkages keys` lists them")
    'the closest of 100 are point9.x, point8.x, point7.x, point6.x, point5.x; `linkages keys` lists them'
    """
    known = sorted(known)
    close = difflib.get_close_matches(name, known, n=1, cutoff=0.5)
    if close:
        return f'did you mean "{close[0]}"?'
    if others:
        return others
    every = ", ".join(known)
    if len(every) > _LONGEST:
        closest = difflib.get_close_matches(name, known, n=_CLOSEST, cutoff=0.0)
        return f"the closest of {len(known)} are {', '.join(closest)}{place and '; '}{place}"
    return f"known are: {every}" if known else "none are known here"


def nearest_names(name: str, known: Iterable[str]) -> str:
    """Suggest up to three names similar to ``OWNER.quantity``, or list all of the owner, as the end of a sentence.

    Examples
    --------
    >>> nearest_names("A.forc", ["A.force", "A.ex", "O.torque"])
    'did you mean "A.force"?'
    """
    known = sorted(known)
    close = difflib.get_close_matches(name, known, n=3, cutoff=0.7)
    if close:
        *first, last = (f'"{one}"' for one in close)
        return f"did you mean {', '.join(first)} or {last}?" if first else f"did you mean {last}?"
    owner = name.partition(".")[0]
    own = [one.partition(".")[2] for one in known if one.startswith(f"{owner}.")]
    if own:
        return f"{owner} has {', '.join(own)}"
    return f"there are quantities of {', '.join(dict.fromkeys(one.partition('.')[0] for one in known))}"


def listed(items: Iterable[str]) -> str:
    """Join words, at least one: ``A, B and C``."""
    *first, last = items
    return f"{', '.join(first)} and {last}" if first else last


def listed_briefly(items: Sequence[str]) -> str:
    """Join words, the first few of many: ``A, B, C, D and 3 more``."""
    more = len(items) - _NAMED
    return ", ".join(items[:_NAMED]) + (f" and {more} more" if more > 0 else "")


def unreadable(path: Path, problem: OSError, others: Iterable[Path] = ()) -> InputError:
    """Make the error of an unreadable file; for a missing file with the most similar name.

    Candidates are the files in the same folder with the same suffix, and `others`.
    """
    reason = f"cannot be read ({problem.strerror})"
    if isinstance(problem, FileNotFoundError) and "\0" not in str(path):  # a name with a null character is invalid
        beside = (other for other in path.parent.glob("*") if other.suffix == path.suffix)
        known = {other.name for other in (*beside, *others)}
        close = difflib.get_close_matches(path.name, sorted(known), n=1, cutoff=0.7)
        reason += f'; did you mean "{close[0]}"?' if close else ""
    return InputError(path, "", reason)


class Status(enum.Enum):
    """End of a run; the value is the name in files, `remedy` the advice to the user."""

    OK = "ok"
    NO_ASSEMBLY = "no-assembly"
    SINGULAR = "singular"
    LOCKED = "locked"
    LOOP_OPEN = "loop-open"
    JOURNAL_LEFT_BEARING = "journal-left-bearing"
    JAMMED = "jammed"
    FREE_OF_MASS = "free-of-mass"
    STEP_SIZE_COLLAPSE = "step-size-collapse"
    TOO_MANY_STEPS = "too-many-steps"
    NOT_FINITE = "not-finite"
    WORN_OUT = "worn-out"
    INTERRUPTED = "interrupted"
    TIME_OVER = "time-over"
    BAD_INPUT = "bad-input"

    @property
    def remedy(self) -> str:
        """Return the advice to the user in one sentence."""
        return _REMEDY[self]


_REMEDY = {
    Status.OK: "none: the run reached its end",
    Status.NO_ASSEMBLY: "the loops cannot be closed at this position of the drives: check the link lengths,"
    " the drives' start angles and the initial poses in the SDF file",
    Status.SINGULAR: "the linkage starts in a singular position: drive another joint, or start elsewhere",
    Status.LOCKED: "the loops cannot be closed beyond this position, such as a dead point: shorten"
    " the motion of the drives, change the lengths, or drive another joint",
    Status.LOOP_OPEN: "a loop of ideal joints opened by more than a millionth of the linkage's size: tighten"
    " solver.accuracy; near a dead point change the lengths, or drive another joint",
    Status.JOURNAL_LEFT_BEARING: "the film is thinner than a ten-thousandth of the clearance (finite film: than"
    " a thousandth, with grooves a hundredth, where its map ends; tilted: an end of the journal can touch) and cannot"
    " carry the load: raise the viscosity, lower the clearance or the speed, or allow contact with"
    ' model = "mixed"',
    Status.JAMMED: "no accelerations satisfy the friction of the joints, which grows with the joint forces (Painleve's"
    " paradox): lower a coefficient of friction, lengthen the slider, or use a dry joint with clearance",
    Status.FREE_OF_MASS: "a link without mass or moment of inertia can move here while all masses rest, so that its"
    " acceleration has no value: give its mass and inertia",
    Status.STEP_SIZE_COLLAPSE: "the integrator cannot meet its tolerance: loosen the accuracy, or check the"
    " parameters for values that make the system extremely stiff",
    Status.TOO_MANY_STEPS: "the steps are too short to reach the end: check the units (SI: metres, kilograms, radians"
    " per second), give a shorter duration, or loosen the accuracy",
    Status.NOT_FINITE: "the numbers of the run became too large: look for parameters with implausible magnitudes",
    Status.WORN_OUT: "a profile is deeper than a fifth of the bearing's radius, the limit of the contact model:"
    " use fewer cycles, or check the wear coefficient and its unit, m2/N",
    Status.BAD_INPUT: "the values of this run are not valid: see its reason",
    Status.INTERRUPTED: "the run was stopped by the user; the computed part is kept",
    Status.TIME_OVER: "the limit of time ended the run; the computed part is kept",
}
