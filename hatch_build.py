"""Build hook: with LINKAGES_PACK_KERNELS=1 a wheel has compiled kernels, so that its first run does not compile.

They are those of the commands below, for the processors of `linkages.base.kernel.shipped`. Another processor, or
another version of Python, numba or numpy, compiles at its first run, as without them.
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
MAIN = "import sys; from linkages.cli.main import main; sys.exit(main(sys.argv[1:]))"
PACK = (
    "import sys; from pathlib import Path; from linkages.base.kernel.cache import pack; pack(*map(Path, sys.argv[1:]))"
)
COMMANDS = [
    ["simulate", "seven_bar.toml"],
    ["simulate", "seven_bar.toml", "--duration", "0.002", "--engine", "drake"],
    ["simulate", "seven_bar_dry.toml", "--duration", "0.02"],
    ["simulate", "seven_bar_mixed.toml", "--duration", "0.02"],
    ["simulate", "slider_crank_dry.toml", "--duration", "0.002"],
    ["simulate", "slider_crank_dry.toml", "--duration", "0.0002", "--engine", "drake"],
    ["simulate", "slider_crank_lubricated.toml", "--duration", "0.002"],
    ["simulate", "slider_crank_flexible.toml", "--duration", "0.002"],
    ["simulate", "slider_crank_guide.toml", "--duration", "0.002"],
    ["simulate", "four_bar_dry.toml", "--duration", "0.002"],
    ["simulate", "three_rrr_clearance.toml", "--duration", "0.0005"],
    ["sensitivity", "seven_bar.toml", "--wrt", "joints.A.clearance", "--duration", "0.01"],
    ["sensitivity", "slider_crank_dry.toml", "--wrt", "joints.B.clearance", "--duration", "0.001"],
    ["sweep", "slider_crank_dry.toml", "--vary", "joints.B.clearance=1e-4:2e-4:2", "--revolutions", "1"],
    ["modes", "slider_crank_flexible.toml"],
    ["wear", "slider_crank_wear.toml", "--cycles", "2"],
]


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
        settings = {"NUMBA_CPU_NAME": "x86-64-v3", "NUMBA_CPU_FEATURES": "", "NUMBA_CACHE_DIR": str(code)}
        environment = os.environ | settings | {"PYTHONPATH": self.root, "LINKAGES_CACHE": str(folder / "cache")}
        for k, words in enumerate(COMMANDS):
            self.app.display_info(f"kernels of: linkages {' '.join(words)}")
            run([MAIN, *words, "--out", str(folder / str(k))], environment)
        run([PACK, str(code), str(archive)], environment)
        build_data["force_include"][str(archive)] = PLACE


def run(words: list[str], environment: dict[str, str]) -> None:
    """Run Python code with arguments."""
    subprocess.run([sys.executable, "-c", *words], env=environment, check=True, stdout=subprocess.DEVNULL)
