"""Packages that an environment may lack: one line names the missing package and the command that installs it."""

from __future__ import annotations

import importlib
from importlib.util import find_spec
from typing import Any

from linkages.base.errors import InputError

#: What each module belongs to, and how it is installed.
_REMEDIES = {
    "anywidget": 'anywidget: pip install "linkages[play]"',
    "distributed": 'Dask: pip install "linkages[cluster]"',
    "emcee": 'emcee: pip install "linkages[posterior]"',
    "pandas": 'pandas: pip install "linkages[export]"',
    "pyarrow": 'pyarrow: pip install "linkages[export]"',
    "pydrake": "Drake, which is not installed: pip install drake (there is no Drake for Windows)",
    "xacro": 'the package of that name: pip install "linkages[import]"; or run `xacro FILE > NAME.urdf` elsewhere',
    "xarray": 'xarray: pip install "linkages[export]"',
}


def installed(module: str) -> bool:
    """Check whether a package can be imported, without importing it."""
    return find_spec(module) is not None


def check_installed(module: str, source: str, where: str = "") -> None:
    """Raise an InputError for what needs the package, the `source` and its part, if it is not installed."""
    if not installed(module.partition(".")[0]):
        raise _missing(module.partition(".")[0], source, where)


def needed(module: str, source: str, where: str = "") -> Any:
    """Import a module; InputError as by `check_installed`."""
    check_installed(module, source, where)
    return importlib.import_module(module)


def _missing(package: str, source: str, where: str) -> InputError:
    return InputError(source, where, f"needs {_REMEDIES[package]}")
