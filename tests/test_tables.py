"""Tables for readers: every column of a quantity with a dimension names its unit, joints name their links."""

import re

import numpy as np
import pytest

import linkages
import optim
from linkages.cli.sweep import format_sweep
from linkages.cli.wear import format_life
from linkages.explore.wear.stages import content
from linkages.results.outputs.registry import unit
from optim.algorithms.nlp import Ending
from optim.report.result import format_table


def rows_of(text, heading):
    """Lines of the block of a table that begins with a heading, the heading aside."""
    lines = text.splitlines()
    first = next(k for k, line in enumerate(lines) if line.startswith(heading))
    end = next((k for k, line in enumerate(lines) if k > first and not line.strip()), len(lines))
    return lines[first + 1 : end]


@pytest.fixture(scope="module")
def text():
    system = linkages.load(linkages.find_file("slider_crank_dry.toml"), {"duration": 0.002})
    return linkages.format_summary(linkages.summarize(linkages.assess(system, "compiled")))


def test_each_joint_names_the_links_that_meet_in_it(text):
    found = {line.partition(":")[0]: line.partition(":")[2].split("  ")[0].strip() for line in rows_of(text, "joint")}
    assert found == {"O": "world, crank", "A": "crank, rod", "B (dry)": "slider, rod", "guide": "world, slider"}


def test_each_row_of_outputs_and_drives_has_its_unit(text):
    for line in rows_of(text, "output") + rows_of(text, "drive"):
        assert re.match(r"\S+( torque| force)? \[[^\]]+\] ", line), line


def test_a_sweep_names_the_unit_of_its_variable_and_of_each_output():
    system = linkages.load(linkages.find_file("slider_crank_dry.toml"))
    names = ["B.force", "B.ey", "slider.ax"]
    found = linkages.sweep(system, "drives.O.speed", [100.0, 200.0], names, 1)
    lines = format_sweep(found, {name: unit(system, name) for name in names}).splitlines()
    head = next(line for line in lines if line.startswith("drives.O.speed ["))
    assert re.findall(r"\[([^\]]+)\]", head) == ["rad/s", "N", "m", "m/s2"]


@pytest.fixture(scope="module")
def life():
    return content(linkages.wear_life(linkages.load(linkages.find_file("slider_crank_wear.toml")), 20))


def test_the_peaks_of_a_life_have_units(life):
    assert life["units"] == {"B.force": "N", "O.torque": "N m", "slider.x.jitter": "m"}
    for line in rows_of(format_life(life), "mean peak"):
        assert re.match(r"\S+ \[[^\]]+\] ", line), line


@pytest.fixture(scope="module")
def solved():
    study = optim.load_study(optim.find_study("sevenbar_force.toml"))
    return study, optim.optimise(study, algorithm={"name": "ga", "population": 4, "generations": 1})


def test_each_variable_of_an_optimisation_has_its_unit(solved):
    text = optim.format_result(*solved)
    found = {line.split(" [")[0]: re.search(r"\[([^\]]+)\]", line).group(1) for line in rows_of(text, "variable")}
    assert found == {
        "sdf.links.link2.mass": "kg", "sdf.links.link2.inertia": "kg m2", "sdf.links.crank4.mass": "kg",
        "sdf.links.crank4.inertia": "kg m2", "sdf.links.slider7.mass": "kg", "joints.A.viscosity": "Pa s",
    }  # fmt: skip
    assert "force [N]" in format_table([solved[1]] * 2)


@pytest.mark.parametrize("feasible", [True, False])
def test_a_nominal_design_that_is_not_feasible_is_named(solved, feasible):
    study, result = solved
    changed = result.model_copy(update={"nominal": result.nominal.model_copy(update={"feasible": feasible})})
    assert ("the nominal design is not feasible" in optim.format_result(study, changed)) != feasible


def test_the_ending_of_an_algorithm_is_told_in_words(solved):
    assert "budget-used" not in optim.format_result(*solved)
    assert "all iterations made: " in optim.format_result(*solved)
    for ending in Ending:
        assert "-" not in ending.words
    assert solved[1]["status"] == "budget-used"  # the key of the file is unchanged


def test_the_variables_of_shipped_studies_have_units_or_are_numbers():
    for path in ("sevenbar_geometry", "sevenbar_jitter", "fourbar_jitter", "slidercrank_flexible"):
        study = optim.load_study(optim.find_study(path))
        labels = [study.variable_label(one) for one in study.paths]
        assert all(re.search(r" \[[^\]]+\]$", label) for label in labels), labels
        assert np.all(study.lower <= study.upper)
