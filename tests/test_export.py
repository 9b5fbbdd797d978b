"""A trajectory read back by the program that each format is for."""

import csv
import json
import sys
import tracemalloc

import numpy as np
import pytest
from scipy.io import loadmat

from linkages import InputError, Status, Trajectory, load_trajectory
from linkages.cli.main import main
from linkages.engines.compiled.batch.batch import Batch
from linkages.engines.compiled.batch.statistics import STATISTICS

TIME = np.linspace(0.0, 1.0, 7)
UNITS = {
    "time": "s", "A.force": "N", "guide.corner1.force": "N", "guide.offset": "m", "a-b.x": "m", "a_b.x": "m",
    "kinetic_energy": "J", "2.angle": "rad",
}  # fmt: skip
COLUMNS = {"time": TIME} | {name: (k + 0.1) * np.sin(TIME + k) for k, name in enumerate(UNITS) if k}


@pytest.fixture
def run():
    return Trajectory(TIME, COLUMNS, Status.LOCKED, {"engine": "compiled", "steps": 6}, units=UNITS)


@pytest.fixture
def folder(run, tmp_path):
    run.save(tmp_path / "trajectory.npz")
    return tmp_path


def test_a_loaded_run_is_interpolated_between_its_samples(folder):
    """Linearly: half-way between two samples is their mean; a time outside the run is refused."""
    loaded = load_trajectory(folder / "trajectory.npz")
    middles = loaded.evaluate(0.5 * (TIME[1:] + TIME[:-1]))
    for name, column in COLUMNS.items():
        np.testing.assert_allclose(middles[name], 0.5 * (column[1:] + column[:-1]), rtol=1e-14)
    assert not loaded.evaluate  # no dense output
    part = loaded.within(0.25, 0.75)
    for run, time in ((loaded, 1.01), (part, 0.8)):
        with pytest.raises(InputError, match="times"):
            run.evaluate([time])


def export(folder, kind, name):
    assert main(["export", str(folder), "--to", kind]) == 0
    return folder / name


def test_units_are_kept_with_the_trajectory(run, folder):
    assert load_trajectory(folder / "trajectory.npz").units == UNITS


def test_csv_has_heads_with_units_and_reads_back_exactly(folder, capsys):
    with open(export(folder, "csv", "trajectory.csv"), newline="") as file:
        head, *rows = csv.reader(file)
    assert head == [f"{name} [{unit}]" for name, unit in UNITS.items()]
    np.testing.assert_array_equal(np.array(rows, dtype=float).T, list(COLUMNS.values()))
    assert "8 columns of 7 steps" in capsys.readouterr().out


@pytest.mark.parametrize(("kind", "name"), [("csv", "trajectory.csv"), ("netcdf", "trajectory.nc")])
def test_an_export_has_each_column_once_in_memory(kind, name, tmp_path):
    time = np.linspace(0.0, 1.0, 20_000)
    run = Trajectory(time, {"time": time} | {f"A{k}.force": k + time for k in range(20)}, Status.OK)
    run.save(tmp_path / "trajectory.npz")
    export(tmp_path, kind, name)  # imports
    tracemalloc.start()
    export(tmp_path, kind, name)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 1.5 * 21 * time.nbytes  # with those of Python, of one part of the rows


def test_mat_has_a_structure_for_each_owner(folder):
    found = loadmat(export(folder, "mat", "trajectory.mat"), simplify_cells=True)
    np.testing.assert_array_equal(found["A"]["force"], COLUMNS["A.force"])
    np.testing.assert_array_equal(found["guide"]["corner1"]["force"], COLUMNS["guide.corner1.force"])
    assert found["units"]["guide"]["offset"] == "m"
    np.testing.assert_array_equal(found["kinetic_energy"], COLUMNS["kinetic_energy"])
    np.testing.assert_array_equal(found["x2"]["angle"], COLUMNS["2.angle"])
    # MATLAB has no hyphens: two names that become one both stay
    np.testing.assert_array_equal(found["a_b"]["x"], COLUMNS["a-b.x"])
    np.testing.assert_array_equal(found["a_b"]["x_"], COLUMNS["a_b.x"])
    assert found["about"]["status"] == "locked"


def test_parquet_has_units_as_metadata_of_the_fields(folder):
    parquet = pytest.importorskip("pyarrow.parquet")
    table = parquet.read_table(export(folder, "parquet", "trajectory.parquet"))
    assert table.column_names == list(COLUMNS)
    assert {field.name: field.metadata[b"units"].decode() for field in table.schema} == UNITS
    np.testing.assert_array_equal(table["guide.offset"].to_numpy(), COLUMNS["guide.offset"])
    assert json.loads(table.schema.metadata[b"provenance"])["steps"] == 6


def test_netcdf_has_variables_over_time_with_units(folder):
    xarray = pytest.importorskip("xarray")
    with xarray.open_dataset(export(folder, "netcdf", "trajectory.nc")) as found:
        assert found.attrs["status"] == "locked"
        assert {name: found[name].attrs["units"] for name in UNITS} == UNITS
        np.testing.assert_array_equal(found["A.force"].sel(time=TIME[3]), COLUMNS["A.force"][3])


def test_dataframe_and_dataset_of_a_trajectory(run):
    frame = pytest.importorskip("pandas") and run.to_dataframe()
    assert frame.index.name == "time"
    assert frame.attrs["units"] == UNITS
    assert frame["A.force"].loc[TIME[2]] == COLUMNS["A.force"][2]
    pytest.importorskip("xarray")
    assert run.to_xarray()["A.force"].attrs == {"units": "N"}


@pytest.fixture
def batch():
    shape = (3, 2, 2)  # runs, windows, outputs
    found = {name: np.arange(12.0).reshape(shape) + 100.0 * k for k, name in enumerate(STATISTICS)}
    found["minimum"] = -found["maximum"] - 1.0
    return Batch(
        ("joints.A.clearance",), np.array([[1e-4], [2e-4], [3e-4]]), ("A.force", "slider.ax"),
        np.array([[0.0, 1.0], [1.0, 2.0]]), found, [Status.OK, Status.LOCKED, Status.OK], ["", "stuck", ""],
        np.array([10, 20, 30]),
    )  # fmt: skip


def test_a_batch_is_a_row_for_each_run_and_window(batch):
    pytest.importorskip("pandas")
    frame = batch.to_dataframe()
    assert len(frame) == 6
    row = frame[(frame["run"] == 1) & (frame["start"] == 1.0)].iloc[0]
    assert row["joints.A.clearance"] == 2e-4
    assert (row["status"], row["reason"], row["steps"], row["end"]) == ("locked", "stuck", 20, 2.0)
    assert row["slider.ax.maximum"] == batch.maximum[1, 1, 1]
    assert row["A.force.peak"] == batch.peak[1, 1, 0] == batch.maximum[1, 1, 0] + 1.0


def test_a_batch_as_axes_of_runs_windows_and_outputs(batch):
    pytest.importorskip("xarray")
    found = batch.to_xarray()
    one = found["rms"].sel(output="slider.ax").isel(run=2, window=0)
    assert one.item() == batch.rms[2, 0, 1]
    assert found["joints.A.clearance"].values[2] == 3e-4
    assert found["status"].values.tolist() == ["ok", "locked", "ok"]
    assert found["end"].values.tolist() == [1.0, 2.0]


@pytest.mark.parametrize(("package", "method"), [("pandas", "to_dataframe"), ("xarray", "to_xarray")])
def test_a_method_names_the_extra_that_is_not_installed(package, method, run, batch, monkeypatch):
    monkeypatch.setitem(sys.modules, package, None)
    for thing in (run, batch):
        with pytest.raises(InputError, match=rf'needs {package}: pip install "linkages\[export\]"'):
            getattr(thing, method)()


def test_the_command_names_the_extra_that_is_not_installed(folder, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    assert main(["export", str(folder), "--to", "parquet"]) == 2
    error = capsys.readouterr().err
    assert 'needs pyarrow: pip install "linkages[export]"' in error
    assert error.count("\n") == 1
    assert [path.name for path in folder.iterdir()] == ["trajectory.npz"]


@pytest.mark.parametrize(("name", "problem"), [("", "has no trajectory.npz"), ("nodir", "is not a folder")])
def test_a_folder_without_a_run_is_bad_input(name, problem, tmp_path, capsys):
    given = tmp_path / name
    assert main(["export", str(given), "--to", "csv"]) == 2
    assert capsys.readouterr().err == f"error: {given}: {problem}; give the --out folder of `linkages simulate`\n"
    assert list(tmp_path.iterdir()) == []
