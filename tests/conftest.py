import os
import signal
from functools import partial
from pathlib import Path
from threading import Semaphore, current_thread, main_thread

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before NumPy is imported: tests use the cores, one worker each

import pytest
from drake_missing import pytest_make_collect_report, pytest_runtest_call, pytest_runtest_setup, skip_without_drake  # noqa: F401 - hooks and a fixture
from hypothesis import settings
from machines import written
from own_registries import own_registries, registries_of_module  # noqa: F401 - fixtures
from shipped import shipped

import linkages
from linkages.base.kernel import stored
from linkages.cli import progress
from linkages.cli.main import main

# Compiled functions are compiled at their first call: no deadline. The same examples in every run: a failure is one
# that can be repeated; searching for new ones is `pytest --hypothesis-profile=default`.
settings.register_profile("repeatable", deadline=None, derandomize=True)
settings.load_profile("repeatable")

# Ctrl-C is ignored in a script's background job and in all that it starts; tests that press it need it.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_collection_modifyitems(items):
    """Run the long tests first."""
    items.sort(key=lambda item: item.get_closest_marker("long") is None)


@pytest.fixture(autouse=True)
def no_signs_of_life(monkeypatch):
    """Keep the standard error of commands free of lines that depend on how busy the machine is."""
    monkeypatch.setattr(progress, "_FIRST", 1e6)
    monkeypatch.setattr(progress, "_LATER", 1e6)


@pytest.fixture
def heartbeats(monkeypatch):
    """Return a function that waits until the heartbeat of a command has judged its silence again, from the beginning."""
    looks, rest = Semaphore(0), progress._Silence.rest

    def looked(silence):
        if current_thread() is not main_thread():
            looks.release()
        return rest(silence)

    def wait():
        while looks.acquire(blocking=False):
            pass
        for _ in range(4):  # it looks up to twice for a judgement, the first of which may have begun
            assert looks.acquire(timeout=300.0)

    monkeypatch.setattr(progress._Silence, "rest", looked)
    return wait


@pytest.fixture(autouse=True)
def declared_arrays():
    """Refuse kernels of the package that make arrays without declaring it: they are compiled twice."""
    yield
    found = {name for name in stored.undeclared if name.startswith(("linkages.", "optim."))}
    stored.undeclared.clear()
    assert not found, f"declare makes_arrays=True: {found}"


@pytest.fixture(scope="session")
def seven_bar():
    """The shipped seven-bar."""
    return shipped("seven_bar")


@pytest.fixture(scope="session")
def fast_press():
    """The press of the benchmarks."""
    return shipped("seven_bar_fast")


@pytest.fixture
def experiment_file(tmp_path):
    """Write an SDF text and a TOML text into a folder; returns the path of the TOML file."""
    return partial(written, tmp_path)


@pytest.fixture
def system_of(experiment_file):
    """Make the system of an SDF text and a TOML text."""
    return lambda sdf, toml, overrides=None: linkages.load(experiment_file(sdf, toml), overrides)


@pytest.fixture
def mechanism_of(tmp_path):
    """Load a mechanism from its text."""

    def load(text: str, overrides: dict[str, float] | None = None) -> linkages.Mechanism:
        path = tmp_path / "m.sdf"
        path.write_text(text)
        return linkages.load_mechanism(path, overrides)

    return load


@pytest.fixture
def imported(tmp_path, capsys):
    """Import a text; returns the path of the machine's file and the lines that were printed."""

    def imported(text: str) -> tuple[Path, str]:
        source, out = tmp_path / ("theirs.urdf" if "<robot" in text else "theirs.sdf"), tmp_path / "ours.sdf"
        source.write_text(text)
        assert main(["import", str(source), "--out", str(out)]) == 0, capsys.readouterr().err
        return out, capsys.readouterr().out

    return imported


@pytest.fixture
def refusal(tmp_path, capsys):
    """Simulate a file with a value that is refused: status 2, nothing written, and one line, which is returned."""

    def refuse(path: Path, given: str) -> str:
        assert main(["simulate", str(path), "--set", given, "--out", str(tmp_path / "run")]) == 2
        said = capsys.readouterr().err.strip()
        assert len(said.splitlines()) == 1
        assert not (tmp_path / "run").exists()
        return said

    return refuse


@pytest.fixture
def drawn(monkeypatch):
    """Figures by the name of their file."""
    from matplotlib import image
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    found, last = {}, []
    draw, save = FigureCanvasAgg.draw, image.imsave

    def note(canvas):
        last[:] = [canvas.figure]
        draw(canvas)

    def keep(path, pixels, **options):
        found[str(path).rpartition("/")[2]] = last[0]
        return save(path, pixels, **options)

    monkeypatch.setattr(FigureCanvasAgg, "draw", note)
    monkeypatch.setattr(image, "imsave", keep)
    return found
