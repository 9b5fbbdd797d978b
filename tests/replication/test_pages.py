"""Pages with slow numbers agree with the stored results, and a row of each is computed again."""

import re
from pathlib import Path

import fourbar_methods
import make_press_films
import make_robust
import make_transient_film
import numpy as np
import pytest
import replicate
from replication import patent_searches
from replication.claims import differences
from replication.computed import read
from replication.recorded import load_record
from replication.verdicts import SOURCES

from optim import Evaluator, find_study, load_study

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("part", [patent_searches.methods, patent_searches.landscape], ids=["methods", "landscape"])
def test_the_appendix_has_the_stored_searches(part):
    """Regenerate with ``python docs/make_replication.py``."""
    assert part() in (ROOT / "docs" / "replication_details.md").read_text(encoding="utf-8")


@pytest.mark.slow
def test_a_row_of_the_methods_is_computed_again():
    """The recorded design at the page's three places, to the digits printed: objective, unseen starts, tighter tolerance."""
    record, study = load_record("fourbar_jitter"), load_study(find_study("fourbar_jitter"))
    row = read("fourbar_methods")["fourbar_jitter/grg, one start/1"]
    x = np.array(row["x"])
    assert np.array_equal(x, record.design(study))
    before, after = Evaluator(study)(np.array([study.nominal, x])).objectives[:, 0]
    unseen, tighter = fourbar_methods.score(study, x[None])
    again = {"value": after / before, "unseen": unseen[0], "tighter": tighter[0]}
    lengths = x / study.nominal
    assert patent_searches.cells(row | again, lengths) == patent_searches.cells(row, lengths)


@pytest.mark.slow
def test_a_row_of_the_landscape_is_computed_again():
    """The surrogate's answer by the patent's objective, to the digits printed."""
    part, study = read("fourbar_landscape")["surrogate"], load_study(find_study("fourbar_jitter"))
    before, after = Evaluator(study)(np.array([study.nominal, part["x"]])).objectives[:, 0]
    assert 1.0 - after / before == pytest.approx(part["fourbar_jitter"], abs=1e-3)


def test_table_of_the_robust_design_is_fresh():
    """Regenerate with ``python docs/make_robust.py``."""
    text = make_robust.PAGE.read_text(encoding="utf-8")
    assert differences(text, make_robust.page(text)) == []


def test_every_section_of_the_appendix_is_a_command(capsys):
    assert replicate.main([]) == 0
    listed = capsys.readouterr().out.split()
    text = (ROOT / "docs" / "replication_details.md").read_text(encoding="utf-8")
    assert re.findall(r"^### ([a-z]+\.[a-z]+)$", text, re.MULTILINE) == listed


def test_pages_of_results_are_short():
    """Four columns, a summary of at most 300 words for each source, and 4,000 words together."""
    texts = [(ROOT / "docs" / f"{name}.md").read_text(encoding="utf-8") for name in ("replication", "replication_3rrr")]
    assert sum(len(text.split()) for text in texts) <= 4000
    parts = [part for text in texts for part in text.split("\n## ")]
    tables = [part for part in parts if "| claim | printed | ours | verdict |" in part]
    assert len(tables) == len(SOURCES)
    for part in tables:
        summary = [line for line in part.splitlines() if not line.startswith(("|", "!["))]
        assert len(" ".join(summary).split()) <= 300
        assert part.count("![") == 1


def test_page_of_the_press_films_is_that_of_its_results():
    """Regenerate with ``python docs/make_press_films.py``."""
    assert make_press_films.PAGE.read_text(encoding="utf-8") == make_press_films.page(read("press_films"))


@pytest.mark.slow
@pytest.mark.parametrize("step", ["long film", "finite film", "groove, heat, sealed"])
def test_a_step_of_the_press_films_is_computed_again(step):
    """Forces to 1e-4, the others to 1 %: the printed digits but the last."""
    found, stored = make_press_films.row(step, 10.0), read("press_films")[f"{step}/10"]
    assert found["ideal"] == pytest.approx(stored["ideal"], rel=1e-6)
    for name, joint in found["joints"].items():
        assert joint["force"] == pytest.approx(stored["joints"][name]["force"], rel=1e-4)
        for key in ("ratio", "power", "temperature"):
            assert joint[key] == pytest.approx(stored["joints"][name][key], rel=0.01)


def test_page_of_films_with_history_is_that_of_its_results():
    """Regenerate with ``python docs/make_transient_film.py``; the rule is in the figure's range."""
    found = read("transient_film")
    assert make_transient_film.PAGE.read_text(encoding="utf-8") == make_transient_film.page(found)
    numbers = [row["number"] for rows in found["swings"].values() for row in rows]
    assert min(numbers) < make_transient_film.limit(found) < max(numbers)


@pytest.mark.slow
def test_an_error_of_the_quasi_static_map_is_computed_again():
    """Within a tenth of it; one oscillation."""
    from replication.transient_film_runs import SWINGS, MapCase, load_map, swing

    case = SWINGS[0]
    table = load_map(MapCase(case.slenderness, "mass-conserving", case.feed))
    stored = read("transient_film")["swings"][case.name]
    row = next(row for row in stored if row["frequency"] == 1.0)
    found = swing(case, 1.0, table)
    assert found["number"] == pytest.approx(row["number"], rel=1e-6)
    assert found["error"] == pytest.approx(row["error"], rel=0.01)
