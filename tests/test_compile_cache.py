"""Compiled code on disk: several processes at once, no place for it, a disk that is full, files that are damaged."""

import os
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from linkages.laws.friction import cubic

SCRIPT = """
import sys
import numpy as np
from linkages.kernel import kernel

@kernel
def double(x):
    return x + x

VALUES = [1, 2.5, 1j, np.float32(3), np.int8(4), np.ones(2), np.ones((2, 2)), np.ones(2, dtype=np.int8)]
for k in map(int, sys.argv[1].split(",")):
    assert np.all(double(VALUES[k]) == VALUES[k] + VALUES[k]), VALUES[k]
    assert np.asarray(double(VALUES[k])).dtype.kind == np.asarray(VALUES[k]).dtype.kind, VALUES[k]
print(sum(double.stats.cache_hits.values()))
"""
ORDERS = "0,1,2,3,4,5,6,7", "7,6,5,4,3,2,1,0", "3,2,1,0,7,6,5,4", "4,5,6,7,0,1,2,3"


@pytest.fixture
def start(tmp_path):
    """Start a process that compiles a function for some types of argument; its cache is in a folder of its own."""
    (tmp_path / "script.py").write_text(SCRIPT)

    def start(order: str, **changed: Path) -> subprocess.Popen:
        environment = (
            os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "cache")} | {k: str(v) for k, v in changed.items()}
        )
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
        return subprocess.Popen([sys.executable, "script.py", order], cwd=tmp_path, env=environment, **pipes)

    return start


@pytest.mark.slow
def test_processes_that_fill_an_empty_cache_at_once_get_their_own_code(start):
    """Each compiles for the same types in another order; then everything is there, and right."""
    for process in [start(order) for order in ORDERS]:
        _, errors = process.communicate()
        assert (process.returncode, errors) == (0, "")
    found, errors = start(ORDERS[0]).communicate()
    assert (found, errors) == ("8\n", "")


def test_code_saved_at_the_same_moment_is_not_mixed_up(tmp_path, monkeypatch):
    """Eight that do not know of each other, as processes do not."""
    monkeypatch.setattr("numba.config.CACHE_DIR", str(tmp_path))
    together = threading.Barrier(8)

    def save(k):
        file = type(cubic._cache)(cubic.py_func)._cache_file
        together.wait()
        file.save((k,), [k] * 1000)

    with ThreadPoolExecutor(8) as pool:
        list(pool.map(save, range(8)))
    file = type(cubic._cache)(cubic.py_func)._cache_file
    assert [file.load((k,)) for k in range(8)] == [[k] * 1000 for k in range(8)]


@pytest.fixture
def no_place(tmp_path):
    """Neither beside the script nor in the user's cache: a file stands where the folder would be; root or not."""
    (tmp_path / "__pycache__").write_text("")
    (tmp_path / "file").write_text("")
    (tmp_path / "temporary").mkdir()
    names = ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME", "HOME", "LOCALAPPDATA")
    return dict.fromkeys(names, tmp_path / "file") | {"TMPDIR": tmp_path / "temporary"}


def test_code_without_a_place_is_kept_in_a_temporary_folder_of_the_users_own(start, no_place, tmp_path):
    kept = tmp_path / "temporary" / f"linkages-{os.getuid()}"
    for hits in "01":
        found, errors = start("1", **no_place).communicate()
        assert found == f"{hits}\n"
        assert errors == (
            f"warning: compiled code is kept in {kept}; set NUMBA_CACHE_DIR to a folder that can be written\n"
        )
    kept.chmod(0o777)  # anybody could put code there
    found, errors = start("1", **no_place).communicate()
    assert found == "0\n"
    assert errors.startswith("warning: compiled code is not kept")
    assert len(errors.splitlines()) == 1


def test_damaged_code_is_compiled_again(start, tmp_path):
    assert start("1").communicate() == ("0\n", "")
    (file,) = (tmp_path / "cache").rglob("*.nbc")
    sound = file.read_bytes()
    for damaged in (sound[:-1], b"", sound[:100] + bytes([sound[100] ^ 1]) + sound[101:]):
        file.write_bytes(damaged)
        assert start("1").communicate() == ("0\n", "")
        assert start("1").communicate() == ("1\n", "")
