"""Reports of studies: tables and tiles come from the record, with readable units, names in words, and the file's numbers."""

import json
import re

import pytest

from linkages.cli.main import main
from linkages.show.plots.quantities import number, quantity, share, uncertain

BEARING = "bearing --diameter 0.1 --length 0.05 --clearance 1e-4 --viscosity 0.03 --speed 100 --load 1000 --film short"


def reported(words, folder):
    """Run a command and write its report; return the record and the page."""
    assert main([*words.split(), "--out", str(folder)]) == 0
    assert main(["report", str(folder)]) == 0
    return json.loads((folder / "record.json").read_text()), (folder / "report.html").read_text()


def cells(page):
    """Return the texts of a page's cells, by the text of the first cell of their row; of equal ones the first row."""
    rows = re.findall(r"<tr><th scope=\"row\" class=\"text\">(.*?)</th>(.*?)</tr>", page)
    return {name: re.findall(r"<td[^>]*>(.*?)</td>", rest) for name, rest in reversed(rows)}


def test_the_report_of_sensitivities_has_the_matrix_as_a_table(tmp_path):
    words = "sensitivity slider_crank_lubricated.toml --duration 0.012 --no-error-estimate --no-plots --quiet"
    record, page = reported(
        f"{words} --output B.force --wrt joints.B.viscosity drives.O.speed sdf.links.rod.mass", tmp_path
    )
    rates = json.loads((tmp_path / "sensitivity.json").read_text())
    details = json.loads((tmp_path / "details.json").read_text())
    found = cells(page)
    for name, path in (("Speed of O", "drives.O.speed"), ("Mass of rod", "sdf.links.rod.mass")):
        share_of = rates[path]["B.force.peak"] * details["values"][path] / details["numbers"]["B.force.peak"]
        assert found[name][0] == f"{'+' if share_of > 0 else ''}{number(share_of, 2)}"
    assert "<pre>" not in page.partition("How to repeat")[0]
    assert record["question"].endswith("viscosity of B, speed of O and mass of rod?")
    assert record["answer"][0].startswith("1 % more ")


def test_the_report_of_a_bearing_begins_with_its_numbers(tmp_path):
    record, page = reported(f"{BEARING} --no-plots", tmp_path)
    content = json.loads((tmp_path / "bearing.json").read_text())
    assert record["tiles"][:2] == [
        [share(content["eccentricity_ratio"]), "of the clearance: the journal's eccentricity"],
        [quantity(content["least_film"], "m", 3), "thinnest oil film"],
    ]
    assert f"<dd>{record['tiles'][1][0]}</dd>" in page
    assert cells(page)["Least film"] == [quantity(content["least_film"], "m")]


def test_the_report_of_an_optimisation_has_both_designs(tmp_path, pytestconfig, monkeypatch):
    monkeypatch.chdir(pytestconfig.rootpath)
    _, page = reported("optimise .ci/small_study.toml --no-plots", tmp_path)
    result = json.loads((tmp_path / "result.json").read_text())
    nominal, best = (result[key]["variables"]["joints.A.viscosity"] for key in ("nominal", "best"))
    row = cells(page)["Viscosity of A"]
    assert row[:3] == ["joints.A.viscosity", quantity(nominal, "Pa s"), quantity(best, "Pa s")]
    assert cells(page)["force"][1] == quantity(result["best"]["objectives"]["force"], "N")


def test_the_report_of_an_identification_has_values_with_deviations(tmp_path, pytestconfig):
    file = pytestconfig.rootpath / "optim/identify/examples/slider_crank_fit.toml"
    record, page = reported(f"identify {file} --no-plots", tmp_path)
    found = json.loads((tmp_path / "result.json").read_text())["parameters"]["clearance"]
    value = uncertain(found["value"], found["deviation"], "m")
    assert re.fullmatch(r"4\d\d\.\d\d ± \d\.\d\d µm", value)
    assert cells(page)["Clearance of B"][1] == value
    assert record["tiles"][0] == [value, "Clearance of B"]


@pytest.mark.slow
def test_the_report_of_tolerances_begins_with_the_yield(tmp_path):
    record, page = reported("tolerances slidercrank_tolerances.toml --samples 64 --no-plots", tmp_path)
    found = json.loads((tmp_path / "tolerances.json").read_text())
    assert record["tiles"][0][0] == share(found["yield"]["value"])
    assert cells(page)["film_A"][0] == quantity(found["outputs"]["film_A"]["mean"], "m")
    assert len([one for one in record["tables"] if one["rows"]]) == 3
