"""Compute the patent's background in the four-bar: ``python docs/make_patent.py [SETTING...]``, some minutes.

Writes docs/replication/computed/patent_background.json: see `replication.patent_background`.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

from replication.computed import keep, read
from replication.patent_background import FILE, compute, settings


def main(names: Sequence[str]) -> None:
    """Compute the named settings, or all."""
    data, known = read(FILE), settings()
    for name in names or known:
        data[name] = compute(known[name])._asdict()
        keep(FILE, {key: data[key] for key in known if key in data})
        print(name, data[name], flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
