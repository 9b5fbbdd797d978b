"""Build hook: with LINKAGES_PACK_KERNELS=1 a wheel has compiled kernels, so that its first run does not compile.

They are those of all commands (`linkages.cli.preparation`), for the processors of `linkages.base.kernel.shipped`.
Another processor, or another version of Python, numba or numpy, compiles at its first run, as without them.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

ASKED = os.environ.get("LINKAGES_PACK_KERNELS") == "1"
PLACE = "linkages/base/kernel/kernels.zip"
PREPARE = "from linkages.cli.preparation import prepare; failed = prepare(); assert not failed, failed"
PACK = (
    "import sys; from pathlib import Path; from linkages.base.kernel.cache import pack; pack(*map(Path, sys.argv[1:]))"
)


class Kernels(BuildHookInterface):
    """Compile kernels, and put them into the wheel."""

    def dependencies(self) -> list[str]:
        """Name the packages that compiling needs: all those of the project."""
        return self.metadata.core.dependencies if ASKED else []

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Compile in a folder of its own."""
        if not ASKED:
            return
        folder = Path(tempfile.mkdtemp())
        code, archive = folder / "code", folder / "kernels.zip"
        self._describe(folder / f"linkages-{self.metadata.version}.dist-info")
        settings = {"NUMBA_CPU_NAME": "x86-64-v3", "NUMBA_CPU_FEATURES": "", "NUMBA_CACHE_DIR": str(code)}
        settings |= {"PYTHONPATH": os.pathsep.join([self.root, str(folder)]), "LINKAGES_CACHE": str(folder / "cache")}
        for words in ([PREPARE], [PACK, str(code), str(archive)]):
            subprocess.run([sys.executable, "-c", *words], env=os.environ | settings, check=True, stdout=sys.stderr)
        build_data["force_include"][str(archive)] = PLACE

    def _describe(self, place: Path) -> None:
        """Write what an installation would: version, and entry points, by which commands of `optim` are found."""
        place.mkdir()
        (place / "METADATA").write_text(f"Metadata-Version: 2.1\nName: linkages\nVersion: {self.metadata.version}\n")
        groups = self.metadata.core.entry_points.items()
        lines = [line for group, points in groups for line in (f"[{group}]", *(" = ".join(p) for p in points.items()))]
        (place / "entry_points.txt").write_text("\n".join(lines) + "\n")
