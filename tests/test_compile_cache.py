"""Compiled code on disk: several processes at once, no place for it, a disk that is full, files that are damaged."""

import importlib
import math
import os
import pickle
import pkgutil
import subprocess
import sys
import threading
from collections import namedtuple
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numba
import numpy as np
import pytest

import linkages
from linkages.base.disk import keep, kept
from linkages.base.kernel import cache, folder, kernel, shipped
from linkages.base.kernel.by_reference import packed
from linkages.base.kernel.cache import pack
from linkages.base.kernel.compile import Kernel
from linkages.base.kernel.fingerprint import fingerprint, names_of, processor, toolchain
from linkages.base.kernel.private import Stored

SCRIPT = """
import sys
import numpy as np
from linkages.base.kernel import kernel, precompiled

@kernel
def double(x):
    return x + x

VALUES = [1, 2.5, 1j, np.float32(3), np.int8(4), np.ones(2), np.ones((2, 2)), np.ones(2, dtype=np.int8)]
for k in map(int, sys.argv[1].split(",")):
    assert np.all(double(VALUES[k]) == VALUES[k] + VALUES[k]), VALUES[k]
    assert np.asarray(double(VALUES[k])).dtype.kind == np.asarray(VALUES[k]).dtype.kind, VALUES[k]
compiled, loaded = precompiled.counts()
print(loaded, *["compiled"] * compiled)
"""
ORDERS = "0,1,2,3,4,5,6,7", "7,6,5,4,3,2,1,0", "3,2,1,0,7,6,5,4", "4,5,6,7,0,1,2,3"


@pytest.fixture
def start(tmp_path):
    """Start a process that compiles a function for some types of argument; its cache is in a separate folder."""
    (tmp_path / "script.py").write_text(SCRIPT)

    def start(order: str, **changed: Path) -> subprocess.Popen:
        environment = (
            os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "cache")} | {k: str(v) for k, v in changed.items()}
        )
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
        return subprocess.Popen([sys.executable, "script.py", order], cwd=tmp_path, env=environment, **pipes)

    return start


@pytest.mark.slow
@pytest.mark.processes
def test_processes_that_fill_an_empty_cache_at_once_compile_once_between_them(start):
    """Each needs code for the same types in another order; then everything is there, and right."""
    compiled = 0
    for process in [start(order) for order in ORDERS]:
        found, errors = process.communicate()
        assert (process.returncode, errors) == (0, "")
        compiled += found.count("compiled")
    assert compiled == 8
    found, errors = start(ORDERS[0]).communicate()
    assert (found, errors) == ("8\n", "")


RECORDS = """
import sys
import numpy as np
from linkages.base.kernel import kernel, precompiled, record_type

@kernel
def last(record):
    return record.a

records = {
    "short": np.zeros(1, record_type(a="f8"))[0],
    "long": np.zeros(1, record_type(b="f8", a="f8"))[0],
}
for k, name in enumerate(sys.argv[1:]):
    records[name].a = k + 1.0
    assert last(records[name]) == k + 1.0
print(*precompiled.counts())
"""


@pytest.mark.slow
def test_code_for_records_is_told_apart_whatever_a_process_has_met_before(tmp_path):
    """Numba numbers the types of records as it meets them: each is the first one of a process, then one loads both."""
    (tmp_path / "script.py").write_text(RECORDS)

    def counts(*order):
        environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}
        command = [sys.executable, "script.py", *order]
        return subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=True).stdout

    assert [counts("short"), counts("long"), counts("short", "long"), counts("long", "short")] == [
        "1 0\n", "1 0\n", "0 2\n", "0 2\n",
    ]  # fmt: skip


Whole = namedtuple("Whole", "pair")


def test_code_for_named_tuples_is_told_apart_by_the_order_of_their_fields():
    """It reads fields by their places: of the tuple itself, by reference, of one within another one."""
    pairs = [namedtuple("Pair", fields)(1.0, 2.0) for fields in ("a b", "b a")]
    reads, within = (made(f"def f(x):\n    return x.{field}") for field in ("a", "pair.a"))
    assert [kernel(reads)(packed(pair)) for pair in pairs] == [1.0, 2.0]
    for function, wrapped in ((reads, lambda pair: pair), (reads, packed), (within, lambda pair: packed(Whole(pair)))):
        names = [names_of(function, (numba.typeof(wrapped(pair)),)) for pair in pairs]
        assert names[0] != names[1]


THREADS = """
import threading
from concurrent.futures import ThreadPoolExecutor
import numba
from linkages.base.kernel import kernel, stored

@kernel
def called(x: float) -> float:
    return 2.0 * x

@kernel
def first(x: float) -> float:
    return called(x) + 1.0

@kernel
def second(x: float) -> float:
    return called(x) + 2.0

numba.njit(lambda x: x)(1.0)  # imports what code needs: later there is no time between two kernels
loading, done = threading.Event(), threading.Event()
link = stored.binding.add_symbol

def linked_late(symbol, address):
    loading.set()
    done.wait(0.5)
    link(symbol, address)

def call_second():
    loading.wait()
    found = second(1.0)
    done.set()
    return found

stored.binding.add_symbol = linked_late
with ThreadPoolExecutor(2) as pool:
    print(*[job.result() for job in (pool.submit(first, 1.0), pool.submit(call_second))])
"""


@pytest.mark.slow
@pytest.mark.processes
def test_threads_that_load_callers_of_one_kernel_at_once_find_it(tmp_path):
    """The second caller is loaded while LLVM does not know the kernel yet, and would call address 0."""
    (tmp_path / "script.py").write_text(THREADS)
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    for _ in ("compiled", "loaded"):
        done = subprocess.run(
            [sys.executable, "script.py"], cwd=tmp_path, env=environment, capture_output=True, text=True
        )
        assert (done.returncode, done.stdout, done.stderr) == (0, "3.0 4.0\n", "")


@pytest.mark.processes
def test_code_saved_at_the_same_moment_is_not_mixed_up(tmp_path, monkeypatch):
    """Eight that do not know of each other, as processes do not."""
    together = threading.Barrier(8)

    def save(k):
        together.wait()
        keep(tmp_path / "code.nbc", b"code", bytes([k]) * 10_000)

    with ThreadPoolExecutor(8) as pool:
        list(pool.map(save, range(8)))
    found = kept(tmp_path / "code.nbc", b"code")
    assert found == found[:1] * 10_000


@pytest.fixture
def no_place(tmp_path):
    """Neither in the script's folder nor in the user's cache: a file blocks the folder; root or not."""
    (tmp_path / "__pycache__").write_text("")
    (tmp_path / "file").write_text("")
    (tmp_path / "temporary").mkdir()
    names = ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME", "HOME", "LOCALAPPDATA")
    return dict.fromkeys(names, tmp_path / "file") | {"TMPDIR": tmp_path / "temporary"}


@pytest.mark.slow
def test_code_without_a_place_is_kept_in_a_temporary_folder_of_the_users_own(start, no_place, tmp_path):
    kept = tmp_path / "temporary" / f"linkages-{os.getuid()}"
    why = f"because {tmp_path / 'file'} cannot be written; set NUMBA_CACHE_DIR to a folder that only you can write to\n"
    for hits in "01":
        found, errors = start("1", **no_place).communicate()
        assert found.split()[0] == hits
        assert errors == f"warning: compiled code is kept in {kept}, {why}"
    kept.chmod(0o777)  # anybody could put code there
    assert start("1", **no_place).communicate() == ("0 compiled\n", f"warning: compiled code is not kept, {why}")
    kept.rename(tmp_path / "elsewhere")
    (tmp_path / "elsewhere").chmod(0o700)
    kept.symlink_to(tmp_path / "elsewhere")  # as anybody can make in a temporary folder
    assert start("1", **no_place).communicate() == ("0 compiled\n", f"warning: compiled code is not kept, {why}")


@pytest.mark.skipif(os.name != "posix", reason="folders have other permissions here")
@pytest.mark.parametrize("mode", [0o777, pytest.param(0o775, marks=pytest.mark.slow)])
def test_a_cache_that_other_users_can_write_to_is_not_used(start, tmp_path, mode):
    """Its files are code: whoever can write them can do anything in the user's name."""
    cache, private = tmp_path / "cache", tmp_path / "temporary" / f"linkages-{os.getuid()}"
    (tmp_path / "temporary").mkdir()
    assert start("1", TMPDIR=tmp_path / "temporary").communicate() == ("0 compiled\n", "")
    assert cache.stat().st_mode & 0o777 == 0o700
    assert not private.exists()  # a folder that is not needed is not made
    cache.chmod(mode)
    assert start("1", TMPDIR=tmp_path / "temporary").communicate() == (
        "0 compiled\n",
        f"warning: compiled code is kept in {private}, because other users can write to {cache};"
        " set NUMBA_CACHE_DIR to a folder that only you can write to\n",
    )


@pytest.mark.skipif(os.name != "posix", reason="folders have other permissions here")
@pytest.mark.parametrize("of", ["subfolder", "file"])
def test_a_cache_with_a_part_that_other_users_can_write_to_is_not_used(tmp_path, of):
    """As long as they can enter the folder; a part of a private folder is out of their reach."""
    part = tmp_path / "cache" / "ab"
    part.mkdir(parents=True)
    if of == "file":
        part.chmod(0o755)
        part = part / "cd.nbc"
        part.touch()
    part.chmod(0o777)
    (tmp_path / "cache").chmod(0o755)
    assert folder._made(tmp_path / "cache") == f"other users can write to {part}"
    (tmp_path / "cache").chmod(0o700)
    assert folder._made(tmp_path / "cache") == ""
    (tmp_path / "cache").chmod(0o755)
    part.chmod(0o755)
    assert folder._made(tmp_path / "cache") == ""


@pytest.mark.skipif(os.name != "posix" or os.getuid() != 0, reason="only root can give a folder to another user")
def test_a_cache_with_a_part_of_another_user_is_not_used(tmp_path):
    part = tmp_path / "cache" / "ab"
    part.mkdir(parents=True)
    (tmp_path / "cache").chmod(0o755)
    os.chown(part, 12345, -1)
    assert folder._made(tmp_path / "cache") == f"other users can write to {part}"


def test_folders_of_code_are_for_their_user_alone_whatever_the_permissions_of_new_files(tmp_path, monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    before = os.umask(0)
    try:
        cache.write("abcd", Stored(b"code", ()))
    finally:
        os.umask(before)
    assert [path.stat().st_mode & 0o777 for path in (tmp_path / "cache", tmp_path / "cache" / "ab")] == [0o700, 0o700]
    assert cache.read("abcd").content == b"code"


@pytest.mark.slow
def test_code_that_cannot_be_unpickled_is_compiled_again(start, tmp_path):
    """Files that are sound and hold something else: whole, or in the part that numba reads."""

    def other_result(content):
        _, symbols = pickle.loads(content)
        return pickle.dumps((b"no pickle", symbols))

    assert start("1").communicate() == ("0 compiled\n", "")
    for change in (lambda _: b"no pickle", lambda _: pickle.dumps((1, 2)), lambda _: b"cos\ngone\n.", other_result):
        for file in (tmp_path / "cache").rglob("*.nbc"):
            name = (file.parent.name + file.stem).encode()
            keep(file, name, change(kept(file, name)))
        found, errors = start("1").communicate()
        assert (found, errors) == ("0 compiled\n", "")
        assert start("1").communicate() == ("1\n", "")


@pytest.mark.slow
def test_damaged_code_is_compiled_again(start, tmp_path):
    assert start("1").communicate() == ("0 compiled\n", "")
    (file,) = (tmp_path / "cache").rglob("*.nbc")
    for damage in (lambda x: x[:-1], lambda x: b"", lambda x: x[:100] + bytes([x[100] ^ 1]) + x[101:]):
        file.write_bytes(damage(file.read_bytes()))
        assert start("1").communicate() == ("0 compiled\n", "")
        assert start("1").communicate() == ("1\n", "")


def made(source: str, **scope):
    exec(source, scope := scope | {"__name__": __name__})
    return scope["f"]


def test_a_function_is_what_it_says_and_what_it_refers_to():
    """The same text and values anywhere: the same; another constant, another value, another callee: another."""
    callee, other = (kernel(made(f"def f(x):\n    return x + {k}")) for k in (1, 2))
    text = "def f(x):\n    return call(x) * scale"
    same = fingerprint(made(text, call=callee, scale=2.0))
    assert fingerprint(made("\n\n" + text, call=kernel(made("def f(x):\n    return x + 1")), scale=2.0)) == same
    changes = (
        made(text, call=other, scale=2.0),
        made(text, call=callee, scale=3.0),
        made(text + " + x", call=callee, scale=2.0),
    )
    assert len({same, *map(fingerprint, changes)}) == 4


@pytest.mark.parametrize("name", ["OPT", "CPU_NAME", "CPU_FEATURES", "LOOP_VECTORIZE", "BOUNDSCHECK"])
def test_a_setting_of_numba_that_changes_code_is_part_of_the_fingerprint(name, monkeypatch):
    before = toolchain.__wrapped__(*processor.__wrapped__())
    monkeypatch.setattr(numba.config, name, "another")
    assert toolchain.__wrapped__(*processor.__wrapped__()) != before


def test_where_a_module_is_does_not_change_the_fingerprint(monkeypatch):
    """Another environment has numpy elsewhere; its version is part of the toolchain."""
    function = made("def f(x):\n    return np.sqrt(x) + math.sqrt(x)", np=np, math=math)
    before = fingerprint(function)
    fingerprint.cache_clear()
    for module in (np, math):
        monkeypatch.setattr(module.__spec__, "origin", "/elsewhere/module.py")
    assert "/elsewhere" in repr(np)
    assert fingerprint(function) == before


def test_the_name_of_an_attribute_is_no_global():
    """A module may have a function with the name of an attribute that a kernel reads."""
    text = "def f(x):\n    return x.real"
    assert fingerprint(made(text)) == fingerprint(made(text, real=object()))


def test_every_kernel_of_the_package_has_a_fingerprint():
    """Without one it would be compiled again in every process."""
    found = 0
    for module in pkgutil.walk_packages(linkages.__path__, "linkages."):
        if ".drake" in module.name or ".cli" in module.name or module.name.endswith("widget"):
            continue
        for value in vars(importlib.import_module(module.name)).values():
            if isinstance(value, Kernel):
                fingerprint(value)
                found += 1
    assert found > 100


PACKED = """
import sys
from pathlib import Path
from linkages.base.kernel import shipped
shipped.ARCHIVE = Path(sys.argv.pop(2))
if sys.argv.pop(2) == "another processor":
    shipped._FEATURES = [*shipped._FEATURES, "a feature of the next decade"]
"""


@pytest.mark.slow
@pytest.mark.skipif(not shipped.fits(), reason="the processor is below the level of the package's kernels")
def test_code_in_the_package_is_loaded_on_processors_of_its_level_and_only_there(start, tmp_path):
    level = {"NUMBA_CPU_NAME": shipped.LEVEL, "NUMBA_CPU_FEATURES": "", "NUMBA_CACHE_DIR": tmp_path / "packed"}
    assert start("0,1,5", **level).communicate() == ("0 compiled compiled compiled\n", "")
    pack(tmp_path / "packed", tmp_path / "kernels.zip")
    (tmp_path / "script.py").write_text(PACKED + SCRIPT)

    def ran(name, processor, values):
        environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}
        command = [sys.executable, "script.py", values, tmp_path / name, processor]
        return subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True).stdout

    assert ran("kernels.zip", "this one", "0,1,5") == "3\n"
    assert not list((tmp_path / "cache").glob("??"))
    assert ran("kernels.zip", "another processor", "0,5") == "0 compiled compiled\n"
    assert ran("none.zip", "this one", "0,1,5") == "2 compiled\n"
