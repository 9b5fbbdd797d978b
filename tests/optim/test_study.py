"""The store rejects unreliable content with one line, and loses nothing."""

import sqlite3
import subprocess
import sys

import numpy as np
import pytest
import toy_optimisation as toy
from toy_optimisation import run

from linkages import InputError, RunError
from linkages.base import disk
from linkages.input.files.writing import locked
from optim import ALGORITHMS, Stopped, find_study, load_study, optimise
from optim.evaluate.evaluations import Evaluations
from optim.search.task import identity_of, settings_of
from optim.store import store as study
from optim.store.sqlite import SCHEMA, UNSEALED


@pytest.fixture
def begun(tmp_path):
    """A study stopped after ten iterations."""
    path, seen = tmp_path / "study.sqlite", []
    with pytest.raises(Stopped):
        run(toy.make_task(), path, observe=lambda row: seen.append(row), stop=lambda: len(seen) == 10)
    return path


def refused(task, path, kind=InputError):
    """Return the line that rejects a store; the file is unchanged."""
    before = path.read_bytes()
    with pytest.raises(kind) as problem:
        run(task, path, resume=True)
    assert path.read_bytes() == before
    assert "\n" not in str(problem.value)
    return str(problem.value)


def test_an_algorithm_is_named_by_a_text_too():
    with pytest.raises(InputError, match=r'algorithm\.name: "nsga3" is unknown; did you mean "nsga2"'):
        optimise(load_study(find_study("sevenbar_force")), algorithm="nsga3")


def test_values_come_back_to_the_last_bit(tmp_path):
    rng = np.random.default_rng(0)
    designs = rng.standard_normal((50, 3)) * 10.0 ** rng.integers(-300, 300, (50, 3))
    objectives = np.where(rng.random((50, 2)) < 0.1, np.nan, rng.standard_normal((50, 2)))
    objectives[0] = np.inf, -0.0
    found = Evaluations(objectives, np.empty((50, 0)), ("ok",) * 49 + ("singular",), ("",) * 49 + ('"so", they\nsay',))
    meta = {"variables": ["a", "b", "c"], "objectives": ["f", "g"], "constraints": []}
    with study.create(tmp_path / "study.sqlite", meta) as store:
        store.add(designs, found, 1.5)
    with study.read_store(tmp_path / "study.sqlite") as store:
        again, back = store.evaluations()
        assert store.count() == (50, {"singular": 1})
        assert store.meta("elapsed") == 1.5
    assert again.tobytes() == designs.tobytes()
    assert back.objectives.tobytes() == found.objectives.tobytes()
    assert (back.status, back.reason) == (found.status, found.reason)
    assert back.constraints.shape == (50, 0)


def test_a_population_is_kept_whole_or_not_at_all(tmp_path):
    meta = {"variables": ["a"], "objectives": ["f"], "constraints": []}
    twice = np.array([[1.0], [2.0], [1.0]])
    found = Evaluations(np.zeros((3, 1)), np.empty((3, 0)), ("ok",) * 3, ("",) * 3)
    with study.create(tmp_path / "study.sqlite", meta) as store:
        with pytest.raises(InputError):
            store.add(twice, found, 0.0)
        assert store.count() == (0, {})


def test_begun_studies_are_not_overwritten(begun):
    before = begun.read_bytes()
    with pytest.raises(InputError, match=r"study\.sqlite: holds 61 evaluations of this study; continue with --resume"):
        run(toy.make_task(), begun)
    assert begun.read_bytes() == before


def test_leftovers_of_a_killed_creation_do_not_matter(tmp_path):
    (tmp_path / ".study.sqlite.partial").write_bytes(b"half a file")
    assert run(toy.make_task(), tmp_path / "study.sqlite", resume=True).evaluations > 100


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        (
            {"task": {"algorithm": {"name": "evolve"}, "seed": 2, "problem": {"name": "Rosenbrock"}}},
            "seed: belongs to another study: there 1, here 2",
        ),
        (
            {"task": {"algorithm": {"name": "evolve"}, "seed": 1}},
            'problem.name: belongs to another study: there "Rosenbrock", here nothing',
        ),
        ({"versions": {"numpy": "1.0"}}, "was written with numpy .*, this is 1.0, and the numbers would be mixed"),
        ({"versions": {"numpy": np.__version__, "numba": "0.60"}}, "was written with numba not there, this is 0.60"),
    ],
)
def test_other_problems_and_versions_are_refused(begun, changed, message):
    with pytest.raises(InputError, match=message):
        run(toy.make_task(**changed), begun, resume=True)
    assert run(toy.make_task(), begun, resume=True).evaluations > 100


def test_other_python_is_no_other_version(begun):
    assert run(toy.make_task(versions={"numpy": np.__version__, "python": "4.0"}), begun, resume=True)


def test_foreign_files_are_refused(tmp_path):
    path = tmp_path / "study.sqlite"
    path.write_text("A list of things to do, longer than a hundred characters. " * 10)
    assert "is not the file of a study" in refused(toy.make_task(), path)
    path.write_bytes(b"")
    assert "is not the file of a study" in refused(toy.make_task(), path)
    path.unlink()
    with sqlite3.connect(path) as db:
        db.execute("CREATE TABLE evaluations (id INTEGER)")
    db.close()
    assert "is an SQLite file, but not that of a study" in refused(toy.make_task(), path)


def test_other_format_versions_are_refused(begun):
    db = sqlite3.connect(begun)
    db.execute(f"PRAGMA user_version = {SCHEMA + 1}")
    db.close()
    assert f"version {SCHEMA + 1} of the file format; this program reads version {SCHEMA}" in refused(
        toy.make_task(), begun
    )


def test_a_file_of_the_version_before_is_read_and_continued(begun, tmp_path):
    expected = run(toy.make_task(), tmp_path / "whole.sqlite")
    with study.read_store(begun) as store:
        designs, _ = store.evaluations()
    with sqlite3.connect(begun) as db:
        for table in study.COLUMNS:
            db.execute(f"ALTER TABLE {table} DROP COLUMN seal")
        db.execute(f"PRAGMA user_version = {UNSEALED}")
    db.close()
    with study.read_store(begun) as store:
        assert store.evaluations()[0].tobytes() == designs.tobytes()
    outcome = run(toy.make_task(), begun, resume=True)
    assert outcome.result.x.tobytes() == expected.result.x.tobytes()
    with sqlite3.connect(begun) as db:  # its rows, the old ones too, are sealed now
        assert db.execute("PRAGMA user_version").fetchone()[0] == SCHEMA
        assert db.execute("UPDATE evaluations SET reason = 'other' WHERE id = 1").rowcount == 1
    db.close()
    assert "a row of evaluations is not as it was stored" in refused(toy.make_task(), begun)


@pytest.mark.parametrize("damage", ["page", "truncated", "table", "row", "meta"])
def test_damaged_files_are_refused(begun, damage):
    if damage in ("page", "truncated"):
        content = bytearray(begun.read_bytes())
        if damage == "page":
            content[4096 : 2 * 4096] = bytes(range(256)) * 16
        begun.write_bytes(content if damage == "page" else content[: 3 * 4096 + 17])
    else:
        db = sqlite3.connect(begun)
        db.execute(
            {
                "table": "DROP TABLE iterations",
                "row": "UPDATE evaluations SET objectives = x'00' WHERE id = 3",
                "meta": "DELETE FROM meta WHERE key = 'task'",
            }[damage]
        )
        db.commit()
        db.close()
    message = refused(toy.make_task(), begun, (InputError, RunError))
    assert message.startswith("study.sqlite: ")
    assert "damaged" in message


def test_full_disk(begun, monkeypatch):
    """The file cannot grow: one line; committed data are kept, and the study can continue with more space."""
    rows = toy_count(begun)
    connect = study._connect

    def small(path):
        db = connect(path)
        pages = db.execute("PRAGMA page_count").fetchone()[0]
        db.execute(f"PRAGMA max_page_count = {pages}")
        return db

    monkeypatch.setattr(study, "_connect", small)
    with pytest.raises(RunError, match=r"study\.sqlite: database or disk is full; what it holds is kept"):
        run(toy.make_task(generations=toy.GENERATIONS), begun, resume=True)
    monkeypatch.undo()
    assert toy_count(begun) >= rows
    fresh = begun.with_name("fresh.sqlite")
    assert run(toy.make_task(), begun, resume=True).result.x.tobytes() == run(toy.make_task(), fresh).result.x.tobytes()


def test_full_disk_at_the_very_beginning(tmp_path, monkeypatch):
    connect = study._connect

    def tiny(path):
        db = connect(path)
        db.execute("PRAGMA max_page_count = 2")
        return db

    monkeypatch.setattr(study, "_connect", tiny)
    with pytest.raises(RunError, match="disk is full"):
        run(toy.make_task(), tmp_path / "study.sqlite")
    assert not (tmp_path / "study.sqlite").exists()


def toy_count(path):
    with study.read_store(path) as store:
        return store.count()[0]


HOLDER = "import sys; from pathlib import Path; from linkages.input.files.writing import locked; p = Path(sys.argv[1]);\nwith locked(p.with_name(p.name + '.lock'), p): print('held', flush=True); sys.stdin.read()"


@pytest.mark.processes
def test_one_process_at_a_time(begun):
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    holder = subprocess.Popen([sys.executable, "-c", HOLDER, str(begun)], **pipes)
    try:
        assert holder.stdout.readline() == b"held\n"
        assert "study.sqlite: is in use by another process" in refused(toy.make_task(), begun)
        assert toy_count(begun) == 61  # looking is allowed
    finally:
        holder.kill()
        holder.communicate()
    assert run(toy.make_task(), begun, resume=True).evaluations > 100


def test_lock_is_free_again_after_use(tmp_path):
    path = tmp_path / "study.sqlite"
    for _ in range(2):
        with (
            locked(tmp_path / "lock", path),
            pytest.raises(InputError, match="in use by another process"),
            locked(tmp_path / "lock", path),
        ):
            pass


def test_a_store_on_a_network_file_system_needs_no_shared_memory(tmp_path, monkeypatch):
    """The write-ahead log does; the store is the same otherwise, also where it moves to a local disk."""
    mounts = tmp_path / "mounts"
    mounts.write_text(f"proc /proc proc rw 0 0\n/dev/sda / ext4 rw 0 0\nhome:/x {tmp_path / 'far'} nfs4 rw 0 0\n")
    (tmp_path / "far").mkdir()
    assert [disk.on_network(tmp_path / name, mounts) for name in ("far", "far/a/b", "near")] == [True, True, False]
    assert not disk.on_network(tmp_path, tmp_path / "no mounts")
    meta = {key: ["x"] for key in ("variables", "objectives", "constraints")}
    row = np.ones((1, 1)), Evaluations(np.ones((1, 1)), np.ones((1, 1)), ("ok",), ("",))
    for far, mode in ((True, "delete"), (False, "wal"), (True, "delete")):
        monkeypatch.setattr(study, "on_network", lambda path, far=far: far)
        path = tmp_path / "study.sqlite"
        with study.open_store(path) if path.exists() else study.create(path, meta) as store:
            if not store.count()[0]:
                store.add(*row, 1.0)
            assert store._rows("PRAGMA journal_mode") == [(mode,)]
            assert store.evaluations()[0].tolist() == [[1.0]]


def test_no_pickle(begun):
    """Nothing in the store is a pickle, and nothing here could load one."""
    import ast
    from pathlib import Path

    import optim

    for file in Path(optim.__file__).parent.rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text())):
            names = [a.name for a in node.names] if isinstance(node, ast.Import | ast.ImportFrom) else []
            assert not {"pickle", "cloudpickle", "dill", "shelve", "marshal", "joblib"} & {
                n.split(".")[0] for n in names
            }
            assert not (isinstance(node, ast.Name) and node.id in ("eval", "exec"))
    assert b"\x80\x04\x95" not in begun.read_bytes()


def test_a_store_of_an_earlier_revision_of_an_algorithm_is_refused(tmp_path, monkeypatch):
    path, press = tmp_path / "study.sqlite", load_study(find_study("sevenbar_force"))
    monkeypatch.setitem(ALGORITHMS, "ga", ALGORITHMS["ga"]._replace(revision=1))
    with pytest.raises(Stopped):
        optimise(press, path, stop=lambda: True)
    monkeypatch.undo()
    before = path.read_bytes()
    with pytest.raises(InputError, match="revision: belongs to another study: there nothing, here 2; give another"):
        optimise(press, path, resume=True)
    assert path.read_bytes() == before


def test_a_store_from_before_the_source_of_derivatives_was_a_setting_is_continued():
    """It has no such key; with sensitivities the numbers differ, and the key is there."""
    study = load_study(find_study("fourbar_jitter"))
    assert settings_of(study)[1].derivatives == "differences"
    assert "derivatives" not in identity_of(study, 1)["task"]["algorithm"]
