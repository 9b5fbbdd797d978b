"""Files that users write, read whole."""

from __future__ import annotations

from pathlib import Path

from linkages.errors import InputError, unreadable

_MOST = 10_000_000  # largest file size [bytes]; typical files have thousands


def read_whole(path: Path) -> bytes:
    """Read a file.

    Raises
    ------
    InputError
        If the file cannot be read, or is too large (`/dev/zero`).
    """
    try:
        with open(path, "rb") as file:
            data = file.read(_MOST + 1)
    except OSError as problem:
        raise unreadable(path, problem) from None
    except ValueError as problem:  # a name with a null character
        raise InputError(path, "", f"cannot be read ({problem})") from None
    if len(data) > _MOST:
        raise InputError(path, "", f"is larger than {_MOST // 1_000_000} MB; give a mechanism or an experiment")
    return data
