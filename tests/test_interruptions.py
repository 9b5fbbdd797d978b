import importlib
import json
import os
import random
import re
import shutil
import signal
import sqlite3
import subprocess
import sys
import threading
from contextlib import suppress
from pathlib import Path
from typing import cast

import numpy as np
import pytest
from machines import LUBRICATED, four_bar, written
from processes import finish, start
from strikes import ANY_CALL, Strike, calls_in, registered_film

import linkages
from linkages import load_trajectory
from linkages.base import signals
from linkages.base.errors import InputError
from linkages.base.kernel.block import Block
from linkages.base.signals import deferred, interruptible
from linkages.cli.main import exit_status, main
from linkages.engines.budget import WINDOW
from linkages.engines.compiled.run.binding import integrate
from linkages.engines.compiled.run.job import Job, make_given, make_job
from linkages.mechanics.integrate.driver import PAUSED
from linkages.results.outputs.registry import pack

pytestmark = pytest.mark.processes

EXPERIMENT = "duration = 0.05\n" + LUBRICATED
STUDY = """experiment = "experiment.toml"
[variables.clearance]
path = "joints.A.clearance"
lower = 5e-5
upper = 2e-4
[objectives.force]
terms = [{ functional = "peak", output = "A.force" }]
[algorithm]
name = "ga"
population = 6
generations = 4
"""
QUICK = ("--engine", "compiled", "--no-plots", "--no-animation")


def made(folder: Path) -> dict[str, bytes]:
    """Visible files of a folder, times and versions aside."""
    found = {}
    for path in folder.iterdir() if folder.exists() else ():
        if path.name[0] == "." or path.suffix == ".lock":
            continue
        data = path.read_bytes()
        if path.suffix == ".json":
            data = json.loads(data)
            data.pop("wall_time", None)
            data.get("provenance", {}).pop("wall_time", None)
        if path.name == "record.json":
            data["table"] = re.sub(r"[\d.]+ s$", "", data["table"], flags=re.MULTILINE)
        if path.suffix == ".npz":
            data = load_trajectory(path)["time"].tolist()
        if path.suffix in (".sqlite", ".sqlite-wal", ".sqlite-shm"):
            continue
        found[path.name] = data
    return found


def evaluations(store: Path) -> list:
    with sqlite3.connect(store) as db:
        return db.execute("SELECT * FROM evaluations ORDER BY id").fetchall()


@pytest.fixture(scope="module")
def commands(tmp_path_factory):
    """A folder with inputs, and the arguments of each command."""
    folder = tmp_path_factory.mktemp("work")
    file = written(folder, four_bar(), EXPERIMENT)
    (folder / "study.toml").write_text(STUDY)
    vary = ("--vary", "joints.A.clearance=5e-5:2e-4:6", "--revolutions", "1", "--output", "A.force")
    assert main(["simulate", str(file), *QUICK, "--out", str(folder / "results")]) == 0
    return folder, {
        "simulate": ("simulate", file, *QUICK),
        "sweep": ("sweep", file, *vary, "--no-plots"),
        "optimise": ("optimise", folder / "study.toml", "--no-plots"),
        "report": ("report", folder / "results"),
    }


@pytest.fixture(scope="module")
def work(commands):
    """A folder with inputs; and the arguments, files and number of calls of each command."""
    (folder, words), known = commands, {}
    for name, these in words.items():
        status, errors = finish(start(*these, "--out", place(folder / "whole", name), struck=(ANY_CALL, 0, 0)))
        assert status == 0
        known[name] = (these, made(folder / "whole" / name), calls_in(errors))
    return folder, known


def place(folder: Path, name: str) -> Path:
    """Arguments of a command with --out."""
    (folder / name).mkdir(parents=True, exist_ok=True)
    return folder / name / "report.html" if name == "report" else folder / name


def in_a_class():
    """Ctrl-C strikes where Python makes another exception of it."""

    class Struck:
        def __set_name__(self, owner, name):
            signal.raise_signal(signal.SIGINT)

    type("Owner", (), {"attribute": Struck()})
    return 0


def in_a_handler():
    """Ctrl-C strikes what reads a file, and takes any failure for a fault of the file."""
    try:
        signal.raise_signal(signal.SIGINT)
    except BaseException as problem:
        raise InputError("file.sdf", "", "cannot be read") from problem
    return 0


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_waits_for_the_end_of_a_deferred_block(number):
    after = []

    @deferred()
    def struck():
        signal.raise_signal(number)
        after.append("here")

    with interruptible() as received, pytest.raises(KeyboardInterrupt):
        struck()
    assert after == ["here"]
    assert received == [number]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


@pytest.mark.parametrize("run", [in_a_class, in_a_handler])
def test_an_interrupt_that_other_code_turns_into_another_exception_ends_the_command(run, capsys):
    assert exit_status(run) == 130
    assert capsys.readouterr().err == "interrupted\n"


def test_the_exit_status_is_kept_where_a_signal_arrives_in_text_that_is_executed(tmp_path):
    """Python ends by SIGINT itself where KeyboardInterrupt, but no subclass of it, leaves such text."""
    (tmp_path / "struck.py").write_text(
        "import sys\n"
        "from linkages.cli.main import exit_status\n"
        "sys.exit(exit_status(lambda: exec('import signal; signal.raise_signal(signal.SIGTERM)')))\n"
    )
    words = [sys.executable, "-m", "struck"]
    ended = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stderr) == (143, "interrupted\n")


@pytest.mark.parametrize("rod", ["flexible", "rigid"])
def test_a_run_ends_after_the_present_step_and_keeps_its_steps(rod, own_registries):
    """Not after 20,000 steps, which take half a minute for some machines; the signal comes within the 240th or so.

    The steps of the flexible machine cost more than those of the rigid one.
    """
    registered_film("striking", strike := Strike())
    values = {"duration": 1e3, "joints.B.film": "striking", "links.rod.model": rod}
    system = linkages.load(linkages.find_file("slider_crank_flexible.toml"), values)
    linkages.simulate(system.replaced({"duration": 1e-4}), "compiled", outputs=["B.force"])  # loads the kernels
    strike.arm(3000)
    run = linkages.simulate(system, "compiled", outputs=["B.force"])
    assert run.status is linkages.Status.INTERRUPTED
    assert 1 < len(run.time) < WINDOW // 10
    assert run.time[-1] < 1.0


def test_a_row_of_a_batch_ends_after_the_present_step():
    given = make_given(
        system := linkages.load(linkages.find_file("slider_crank_dry.toml")), pack(system, ()), np.zeros((0, 2))
    )
    record = integrate(cast(Job, Block(make_job(given))), np.ones(1, np.int64), np.zeros(1))
    assert (record.status, record.steps) == (PAUSED, 0)


STRUCK = """
import ctypes, signal, sys
from numba import njit
from linkages.cli.main import exit_status

strike, sleep = ctypes.CDLL(None)["raise"], ctypes.CDLL(None)["sleep"]
for function in (strike, sleep):
    function.argtypes, function.restype = [ctypes.c_int], ctypes.c_int


@njit(nogil=True)
def endless(number):
    while number:
        strike(number)
        sleep(3600)


endless(0)
sys.exit(exit_status(lambda: endless(int(signal.{name})), alone=True))
"""


@pytest.mark.parametrize(("name", "status"), [("SIGINT", 130), ("SIGTERM", 143)])
def test_a_command_ends_soon_even_if_compiled_code_does_not_return(name, status):
    """The code itself sends the signal; Python's handler would wait for the hour of this call."""
    words = [sys.executable, "-c", STRUCK.format(name=name)]
    ended = subprocess.run(words, capture_output=True, text=True, check=False, timeout=600)
    assert (ended.returncode, ended.stderr) == (status, "interrupted\n")


LATE = """
import signal, sys, time
from linkages.cli.main import exit_status


def run():
    try:
        signal.raise_signal(signal.SIGINT)
    except KeyboardInterrupt:
        while True:
            time.sleep(0.01)


sys.exit(exit_status(run, alone=True))
"""


def test_a_command_that_writes_its_results_says_so_and_ends_at_the_second_ctrl_c():
    late = subprocess.Popen([sys.executable, "-c", LATE], stderr=subprocess.PIPE, text=True)
    assert late.stderr.readline() == "interrupted; writing what was computed, Ctrl-C again ends at once\n"
    late.send_signal(signal.SIGINT)
    assert late.communicate(timeout=600)[1] == "interrupted\n"
    assert late.returncode == 130


def test_ctrl_c_gives_no_traceback_while_the_command_is_imported(tmp_path):
    """The interrupt arrives at the first import after the package's own name."""
    (tmp_path / "lazy_loader.py").write_text("import os, signal\nos.kill(os.getpid(), signal.SIGINT)\n")
    words = [sys.executable, "-m", "linkages.cli.main", "keys"]
    changed = os.environ | {"PYTHONPATH": os.pathsep.join([str(tmp_path), *sys.path])}
    ended = subprocess.run(words, env=changed, capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stderr) == (-signal.SIGINT, "")


def until_sent_again():
    """Wait for the signal that is sent again because its exception was dropped; 0 if none comes within minutes."""
    threading.Event().wait(300.0)
    return 0


def dropped():
    """Ctrl-C strikes where C code calls Python and drops exceptions."""

    class Struck:
        def __del__(self):
            signal.raise_signal(signal.SIGINT)

    Struck()
    return until_sent_again()


def swallowed():
    """Ctrl-C strikes where code of others takes any exception for a failure of its own."""
    with suppress(BaseException):
        signal.raise_signal(signal.SIGINT)
    return 0


def imported():
    """Ctrl-C strikes where a package takes any failure of an import for a missing module."""
    with suppress(BaseException):
        importlib.import_module("struck_at_import")
    return until_sent_again()


@pytest.fixture(autouse=True)
def _module(tmp_path, monkeypatch):
    (tmp_path / "struck_at_import.py").write_text("import signal\nsignal.raise_signal(signal.SIGINT)\n")
    monkeypatch.syspath_prepend(tmp_path)


def printed():
    """Ctrl-C strikes where C code calls Python, prints exceptions and drops them."""
    try:
        signal.raise_signal(signal.SIGINT)
    except BaseException:
        sys.excepthook(*sys.exc_info())
    return until_sent_again()


@pytest.mark.parametrize("run", [dropped, swallowed, imported, printed])
def test_the_status_is_never_0_after_ctrl_c(run, capsys):
    hooks = sys.unraisablehook, sys.excepthook
    assert exit_status(run) == 130
    assert capsys.readouterr().err == "interrupted\n"
    assert (sys.unraisablehook, sys.excepthook) == hooks


def test_a_signal_that_is_sent_again_never_arrives_after_the_command(monkeypatch, capsys):
    """The command ends while the signal is on its way: it waits for it, since afterwards it would strike the caller."""
    on_its_way, ended, late = threading.Event(), threading.Event(), []

    def sent(*_):
        on_its_way.set()
        late.append(ended.wait(0.5))

    for place, name in ((signals.os, "kill"), (signals.signal, "pthread_kill")):
        monkeypatch.setattr(place, name, sent)

    def run():
        try:
            signal.raise_signal(signal.SIGINT)
        except BaseException:
            sys.excepthook(*sys.exc_info())
        on_its_way.wait()
        return 0

    assert exit_status(run) == 130
    ended.set()
    assert late == [False]
    assert capsys.readouterr().err == "interrupted\n"


@pytest.mark.parametrize("step", ["flush", "pthread_sigmask", "signal"])
def test_a_signal_at_the_end_of_a_command_is_counted_and_leaves_the_handlers_as_they_were(step, monkeypatch, capsys):
    """At none of the command's last steps does a signal pass as an exception to the caller."""
    strike, owner = Strike(), sys.stdout if step == "flush" else signals.signal

    def run():
        strike.arm(1)
        return 0

    with monkeypatch.context() as patch:
        patch.setattr(owner, step, strike.before(getattr(owner, step)))
        status = exit_status(run)
    assert (status, strike.calls > 0) == (130, True)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    assert capsys.readouterr().err == "interrupted\n"


@pytest.mark.slow
@pytest.mark.parametrize("name", ["simulate", "sweep", "optimise", "report"])
def test_a_command_struck_at_any_moment_leaves_whole_files_and_can_be_repeated(name, work, tmp_path):
    folder, known = work
    words, whole, calls = known[name]
    dice, out, left = random.Random(name), tmp_path / name, None
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGKILL):
        resume = ("--resume",) if name == "optimise" and (out / "study.sqlite").exists() else ()
        at = round(dice.uniform(0.2, 1.0) * calls)
        status, errors = finish(start(*words, *resume, "--out", place(tmp_path, name), struck=(ANY_CALL, at, number)))
        assert status in (0, 128 + number), errors
        assert "Traceback" not in errors
        before, left = left, made(out)
        parts = {"simulate": lambda: [left["summary.json"]], "sweep": lambda: left["sweep.json"]["points"]}
        interrupted = left and name in parts and any(one["status"] == "interrupted" for one in parts[name]())
        if interrupted and left == before:  # of an earlier strike: this one came before anything was written
            assert status in (130, 143, 137)
        elif interrupted and name == "simulate":
            assert status in (130, 143)
            assert left["summary.json"]["duration"] == left["trajectory.npz"][-1] < 0.05
        elif interrupted:
            assert status in (130, 143)
            pairs = zip(left["sweep.json"]["points"], whole["sweep.json"]["points"], strict=True)
            assert all(one["status"] == "interrupted" or one["outputs"] == other["outputs"] for one, other in pairs)
        elif left and name == "optimise":  # it keeps the design before its figures and its record
            assert left.items() <= whole.items()
        elif left:
            assert left == whole
        hidden = [path.name for path in out.iterdir() if "partial" in path.name]
        assert not hidden or number == signal.SIGKILL
        for path in hidden:
            shutil.rmtree(out / path, ignore_errors=True)
        if status == 0 and name == "optimise":
            shutil.rmtree(out)
    resume = ("--resume",) if name == "optimise" and (out / "study.sqlite").exists() else ()
    assert finish(start(*words, *resume, "--out", place(tmp_path, name)))[0] == 0
    assert made(out) == whole
    if name == "optimise":
        assert evaluations(out / "study.sqlite") == evaluations(folder / "whole" / name / "study.sqlite")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "room"), [("simulate", 512), ("sweep", 512), ("optimise", 512), ("optimise", 40960), ("report", 512)]
)
def test_a_full_disk_is_said_in_one_line_and_harms_nothing(name, room, work, tmp_path):
    words, whole, _ = work[1][name]
    out = tmp_path / name
    status, errors = finish(start(*words, "--out", place(tmp_path, name), room=room))
    assert status == 1
    assert errors.splitlines()[-1].startswith("failed: ")
    assert "Traceback" not in errors
    assert made(out) == {}
    assert not list(out.glob(".*partial*"))
    resume = ("--resume",) if (out / "study.sqlite").exists() else ()
    assert bool(resume) == (room == 40960)
    assert finish(start(*words, *resume, "--out", place(tmp_path, name)))[0] == 0
    assert made(out) == whole


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no device that is always full")
def test_standard_output_that_is_full_is_said():
    with open("/dev/full", "w") as full:
        status, errors = finish(start("keys", stdout=full))
    assert (status, errors) == (1, "failed: output: No space left on device\n")


@pytest.fixture
def read_only(tmp_path):
    """A folder that cannot be written: by its permissions; for root, who may write anywhere, by its mount."""
    folder = tmp_path / "read_only"
    folder.mkdir()
    if os.getuid() != 0:
        folder.chmod(0o555)
        yield folder
        folder.chmod(0o755)
        return
    mounts = (["mount", "--bind", folder, folder], ["mount", "-o", "remount,ro,bind", folder])
    if any(subprocess.run(words, capture_output=True, check=False).returncode for words in mounts):
        pytest.skip("root writes anywhere, and may not mount here")
    yield folder
    subprocess.run(["umount", folder], check=True)


@pytest.mark.parametrize("name", ["simulate", "sweep", "optimise", "report"])
def test_a_folder_that_cannot_be_written_is_refused(name, commands, read_only, capsys):
    words = commands[1][name]
    out = read_only / ("report.html" if name == "report" else "out")
    assert main([*map(str, words), "--out", str(out)]) == 2
    (line,) = capsys.readouterr().err.splitlines()[-1:]
    assert line.startswith("error: --out: ")
    assert re.search(r"cannot be written( \((Read-only file system|Permission denied)\)|; give another folder)$", line)
    assert not list(read_only.iterdir())
