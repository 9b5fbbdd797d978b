"""Bad input and failed runs: two exceptions, one list of named statuses."""

from __future__ import annotations

import difflib
import enum
from collections.abc import Iterable
from pathlib import Path


class InputError(ValueError):
    """Input that cannot be used; its text is one line that says where and what.

    Parameters
    ----------
    source : str or Path
        The file (or "command line", "argument") that holds the input.
    where : str
        The element or key, as the user wrote it: ``<joint name="A">`` or ``joints.A.clearance``.
    problem : str
        What is wrong, and what would be right.

    Attributes
    ----------
    source, where, problem
        As given.
    """

    def __init__(self, source: str | Path, where: str, problem: str) -> None:
        name = source.name or str(source) if isinstance(source, Path) else source
        self.source, self.where, self.problem = source, where, problem
        parts = [part for part in (str(name), where, problem) if part]
        super().__init__(" ".join(": ".join(parts).split()))


class UnknownNameError(InputError, KeyError):
    """A name that a table of results does not have; its text says which names are near."""

    __str__ = Exception.__str__  # a KeyError's is that of a key in quotes


class RunError(RuntimeError):
    """A run that cannot start; its text is one line that says why and what to try."""


class AssemblyError(RunError):
    """The linkage cannot be assembled; `status` says how it failed."""

    def __init__(self, status: Status, detail: str) -> None:
        super().__init__(f"{status.value}: {detail}; {status.remedy}")
        self.status = status


def nearest(name: str, known: Iterable[str]) -> str:
    """Say which of `known` was probably meant by `name`, as the end of a sentence."""
    known = sorted(known)
    close = difflib.get_close_matches(name, known, n=1, cutoff=0.5)
    if close:
        return f'did you mean "{close[0]}"?'
    return f"known are: {', '.join(known)}" if known else "none are known here"


def nearest_names(name: str, known: Iterable[str], most: int = 3) -> str:
    """Say which of many names were probably meant, as the end of a sentence; else which owners there are.

    Parameters
    ----------
    name : str
        ``OWNER.quantity``, misspelt.
    known : iterable of str
    most : int
        Names to suggest.

    Examples
    --------
    >>> nearest_names("A.forc", ["A.force", "A.ex", "O.torque"])
    'did you mean "A.force"?'
    """
    known = sorted(known)
    close = difflib.get_close_matches(name, known, n=most, cutoff=0.7)
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


def unreadable(path: Path, problem: OSError, others: Iterable[Path] = ()) -> InputError:
    """Make the error of a file that cannot be read; of one that is not there, with the name that was probably meant.

    Parameters
    ----------
    path : Path
    problem : OSError
    others : iterable of Path
        Files that could have been meant, beside those in the same folder with the same suffix.
    """
    reason = f"cannot be read ({problem.strerror})"
    if isinstance(problem, FileNotFoundError) and "\0" not in str(path):  # which no folder can be asked for
        beside = (other for other in path.parent.glob("*") if other.suffix == path.suffix)
        known = {other.name for other in (*beside, *others)}
        close = difflib.get_close_matches(path.name, sorted(known), n=1, cutoff=0.7)
        reason += f'; did you mean "{close[0]}"?' if close else ""
    return InputError(path, "", reason)


class Status(enum.Enum):
    """How a run ended; the value is the name used in files, `remedy` is what to try."""

    OK = "ok"
    NO_ASSEMBLY = "no-assembly"
    SINGULAR = "singular"
    LOCKED = "locked"
    LOOP_OPEN = "loop-open"
    JOURNAL_LEFT_BEARING = "journal-left-bearing"
    STEP_SIZE_COLLAPSE = "step-size-collapse"
    TOO_MANY_STEPS = "too-many-steps"
    NOT_FINITE = "not-finite"
    WORN_OUT = "worn-out"
    INTERRUPTED = "interrupted"
    BAD_INPUT = "bad-input"

    @property
    def remedy(self) -> str:
        """What the user can try, in one sentence."""
        return _REMEDY[self]


_REMEDY = {
    Status.OK: "nothing: the run reached its end",
    Status.NO_ASSEMBLY: "the loops cannot be closed at this position of the drives: check the link lengths,"
    " the drives' start angles and the initial poses in the SDF file",
    Status.SINGULAR: "the linkage starts in a singular position: drive another joint, or start elsewhere",
    Status.LOCKED: "the linkage is at a dead point, beyond which its loops cannot be closed: shorten"
    " the motion of the drives, change the lengths, or drive another joint",
    Status.LOOP_OPEN: "a loop of ideal joints came apart by more than a millionth of the linkage's size: tighten"
    " solver.accuracy; near a dead point change the lengths, or drive another joint",
    Status.JOURNAL_LEFT_BEARING: "the film is thinner than a ten-thousandth of the clearance (finite film: than"
    " a thousandth, where its map ends) and cannot carry the load: raise the viscosity,"
    ' lower the clearance or the speed, or allow contact with model = "mixed"',
    Status.STEP_SIZE_COLLAPSE: "the integrator cannot meet its tolerance: loosen the accuracy, or check the"
    " parameters for values that make the system extremely stiff",
    Status.TOO_MANY_STEPS: "the end is out of reach at this pace: check the units (SI: metres, kilograms, radians per"
    " second), give a shorter duration, or loosen the accuracy",
    Status.NOT_FINITE: "the numbers of the run became too large: look for parameters far beyond those of a machine",
    Status.WORN_OUT: "a profile is deeper than a fifth of the bearing's radius, where the model of the contact ends:"
    " ask for fewer cycles, or check the wear coefficient and its unit, m2/N",
    Status.BAD_INPUT: "the values of this run are not valid: see its reason",
    Status.INTERRUPTED: "the run was stopped by the user; what was computed up to then is kept",
}
