"""The seeds that a command line asks for."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from linkages import InputError

if TYPE_CHECKING:
    from optim.problem.study import Study


def seeds_of(options: argparse.Namespace, study: Study) -> range:
    """Return the seeds of the command line, or else the study's; InputError if one is out of its range."""
    first = last = study.file.seed if options.seed is None else options.seed
    if options.seeds is not None:
        a, colon, b = options.seeds.partition(":")
        if not (colon and a.isdecimal() and b.isdecimal() and int(a) <= int(b)):
            raise InputError("--seeds", options.seeds, "write A:B, for instance 1:10")
        first, last = int(a), int(b)
    if not 0 <= first <= last < 2**32:
        raise InputError("--seed", str(first), "must be between 0 and 2^32 - 1")
    return range(first, last + 1)
