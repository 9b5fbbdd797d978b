"""Store of blocks on disk, by their input: an interrupted calculation continues from them."""

from __future__ import annotations

import hashlib
import io
from pathlib import Path
from typing import Any

import numpy as np

from linkages.base.disk import keep, kept
from linkages.base.errors import Status
from linkages.explore.wear.measure import BlockStart, CycleBlock, Removed, measure
from linkages.input.files.writing import errors_of_writing
from linkages.system import System
from linkages.system.identity import identity


class BlockStore:
    """Measures blocks, or reads blocks measured earlier from a folder, if one is given.

    A block depends on the system, the profiles, its start and the required accuracy; these, and the versions of the
    packages, determine its file name. A file is written atomically, with a digest: a damaged one is ignored.
    """

    def __init__(self, system: System, drive: str | None, folder: Path | None) -> None:
        self.system, self.drive, self.folder = system, drive, folder
        self.count = 0
        self._base = identity(system)

    def measure(self, removed: Removed, start: BlockStart | None, scatter: float, single: bool = False) -> CycleBlock:
        """Return the result of `linkages.explore.wear.measure.measure`, from the store if present."""
        if self.folder is None:
            return measure(self.system, removed, start, scatter, self.drive, single)
        digest = hashlib.sha256(self._base.encode())
        digest.update(repr((sorted(removed), scatter, self.drive, start is None, single)).encode())
        parts = [removed[name] for name in sorted(removed)]
        if start is not None:
            parts += [start.y, start.memory, np.array(start.step)]
        for part in parts:
            digest.update(np.ascontiguousarray(part).tobytes())
        self.count += 1
        path = self.folder / f"{self.count:04d}-{digest.hexdigest()[:16]}.block"
        content = kept(path, digest.digest())
        if content is not None:
            return _block(content)
        block = measure(self.system, removed, start, scatter, self.drive, single)
        written = io.BytesIO()
        np.savez(written, **_arrays(block))
        with errors_of_writing(path):
            keep(path, digest.digest(), written.getvalue())
        return block


def _arrays(block: CycleBlock) -> dict[str, Any]:
    found: dict[str, Any] = {f"loads {name}": lines for name, lines in block.loads.items()}
    found |= {f"work {name}": values for name, values in block.work.items()}
    found |= {f"peak {name}": np.array(value) for name, value in block.peaks.items()}
    end = {"y": block.end.y, "memory": block.end.memory, "step": np.array(block.end.step)}
    return found | end | {"cycles": np.array(block.cycles), "status": np.array(block.status.value)}


def _block(content: bytes) -> CycleBlock:
    with np.load(io.BytesIO(content)) as file:
        data = {name: file[name] for name in file.files}

    def of(kind: str) -> dict[str, Any]:
        return {name.removeprefix(kind): values for name, values in data.items() if name.startswith(kind)}

    end = BlockStart(data["y"], data["memory"], float(data["step"]))
    peaks = {name: float(value) for name, value in of("peak ").items()}
    return CycleBlock(of("loads "), of("work "), peaks, int(data["cycles"]), end, Status(str(data["status"])))
