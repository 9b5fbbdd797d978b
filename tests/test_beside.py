import gc
import os
import signal
import sys
import time

import pytest

from linkages.cli.beside import beside
from linkages.errors import InputError

needs_fork = pytest.mark.skipif(sys.platform != "linux", reason="processes are not split here")


def test_work_is_done_when_the_context_ends(tmp_path):
    with beside([(tmp_path / name).touch for name in ("one", "two")]):
        pass
    assert {path.name for path in tmp_path.iterdir()} == {"one", "two"}


@needs_fork
def test_it_goes_on_while_the_context_does(tmp_path):
    """The context waits for what the work writes."""
    with beside([lambda: (tmp_path / "process").write_text(str(os.getpid()))]):
        deadline = time.monotonic() + 30.0
        while not (tmp_path / "process").exists() and time.monotonic() < deadline:
            time.sleep(0.01)
        assert (tmp_path / "process").exists()
    assert int((tmp_path / "process").read_text()) != os.getpid()


@pytest.mark.parametrize(
    "problem", [InputError("--exaggerate", "9", "is too much"), MemoryError()], ids=["ours", "other"]
)
def test_what_goes_wrong_is_raised_here_and_said_once(problem, capfd):
    def fail():
        raise problem

    with pytest.raises(type(problem)) as met, beside([fail]):
        pass
    assert met.value is problem
    assert capfd.readouterr() == ("", "")


@needs_fork
def test_work_whose_process_is_killed_is_done_here(tmp_path):
    def work():
        if os.getpid() != here:
            os.kill(os.getpid(), signal.SIGKILL)
        (tmp_path / "done").touch()

    here = os.getpid()
    with beside([work]):
        pass
    assert (tmp_path / "done").exists()


@needs_fork
def test_work_whose_process_does_not_end_is_done_here(tmp_path, monkeypatch):
    def work():
        if os.getpid() != here:
            time.sleep(60.0)
        (tmp_path / "done").touch()

    here = os.getpid()
    monkeypatch.setattr("linkages.cli.beside._PATIENCE", 0.2)
    with beside([work]):
        pass
    assert (tmp_path / "done").exists()


@needs_fork
def test_where_no_process_can_be_made_the_work_is_done_here(tmp_path, monkeypatch):
    def refuse():
        raise OSError("no more processes")

    monkeypatch.setattr("os.fork", refuse)
    with beside([(tmp_path / "done").touch]):
        assert not (tmp_path / "done").exists()
    assert (tmp_path / "done").exists()


@needs_fork
def test_a_context_that_fails_ends_the_work(tmp_path):
    def work():
        (tmp_path / "begun").touch()
        time.sleep(2.0)
        (tmp_path / "done").touch()

    def struck():
        while not (tmp_path / "begun").exists():
            time.sleep(0.01)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt), beside([work]):
        struck()
    assert [path.name for path in tmp_path.iterdir()] == ["begun"]


@needs_fork
def test_nothing_of_the_first_process_is_collected_in_the_other(tmp_path):
    """Destructors of Drake's objects wait for threads, which are not there."""

    class Waiting:
        def __del__(self):
            (tmp_path / f"collected in {os.getpid()}").touch()

    def work():
        gc.collect()
        (tmp_path / "done").touch()

    waiting = Waiting()
    waiting.itself = waiting
    del waiting
    with beside([work]):
        pass
    assert {path.name for path in tmp_path.iterdir()} <= {"done", f"collected in {os.getpid()}"}
    assert gc.isenabled()
    gc.collect()
    assert (tmp_path / f"collected in {os.getpid()}").exists()


@needs_fork
def test_ctrl_c_is_left_to_the_first_process(tmp_path):
    def work():
        os.kill(os.getpid(), signal.SIGINT)
        (tmp_path / f"{os.getpid() == here}").touch()

    here = os.getpid()
    with beside([work]):
        pass
    assert [path.name for path in tmp_path.iterdir()] == ["False"]
