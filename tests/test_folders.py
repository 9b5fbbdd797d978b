"""Folders of results: one holds what one command wrote, of one run."""

import argparse

import pytest
from machines import four_bar

from linkages import InputError
from linkages.cli.main import main
from linkages.cli.options import output_folder

DRIVEN = "duration = 1.0\n[drives.O]\nspeed = 1.0\n"


def test_a_folder_holds_the_results_of_one_run(experiment_file, tmp_path, capsys):
    """Those of another command are refused, or replaced whole; of the same command nothing stays behind."""
    file, out = experiment_file(four_bar(), DRIVEN), tmp_path / "out"
    out.mkdir()
    for name in ("wear.json", "wear_B.png", "notes.txt"):
        (out / name).touch()
    assert main(["simulate", str(file), "--out", str(out)]) == 2
    assert "holds results of `linkages wear`; give another folder, or --force" in capsys.readouterr().err
    with output_folder(argparse.Namespace(out=out, force=True), "", "simulate") as folder:
        (folder / "summary.json").touch()
    assert sorted(path.name for path in out.iterdir()) == ["notes.txt", "summary.json"]
    (out / "trajectory.csv").touch()  # as `linkages export` leaves it there
    (out / "drawing.html").touch()
    with output_folder(argparse.Namespace(out=out, force=True), "", "simulate") as folder:
        (folder / "summary.json").touch()
    assert sorted(path.name for path in out.iterdir()) == ["notes.txt", "summary.json"]


def test_a_drawing_gives_way_to_a_run_and_not_a_run_to_a_drawing(tmp_path):
    (tmp_path / "drawing.html").touch()
    options = argparse.Namespace(out=tmp_path, force=False)
    assert output_folder(options, "", "simulate").path == tmp_path
    (tmp_path / "summary.json").touch()
    with pytest.raises(InputError, match="linkages simulate"):
        output_folder(options, "", "draw")


def test_a_wear_that_is_begun_again_keeps_its_blocks(tmp_path):
    (tmp_path / "blocks").mkdir()
    (tmp_path / "wear_B.png").touch()
    with output_folder(argparse.Namespace(out=tmp_path, force=True), "", "wear", ("blocks",)) as folder:
        (folder / "wear.json").touch()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["blocks", "wear.json"]
