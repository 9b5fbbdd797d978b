"""The page of replicated results agrees with the code, and its comparison finds differences."""

from pathlib import Path

import make_replication
import pytest
from replication import press_paper
from replication.claims import change, differences

from optim import find_study, load_study

ROOT = Path(__file__).parents[2]


@pytest.mark.slow
def test_page_is_fresh():
    """Regenerate with ``python docs/make_replication.py``. One unit of the last digit for the rounding of each page."""
    for file, new in (
        (make_replication.PAGE, make_replication.page()),
        (make_replication.DETAILS, make_replication.details()),
    ):
        assert differences(file.read_text(encoding="utf-8"), new) == []


def test_change():
    assert change(5.434, 4.290) == pytest.approx(-21.05, abs=0.005)


def test_differences_of_pages():
    assert differences("a 1.23 b 4e-05", "a 1.25 b 5e-05") == []
    assert differences("a 1.23", "a 1.26") == ["1.23 -> 1.26"]
    assert differences("a 3 of 4", "a 3 of 5") == ["4 -> 5"]
    assert differences("same\na 1.0 reproduced", "same\na 1.0 trend only") == ["a # reproduced -> a # trend only"]
    assert differences("a", "a\nb") == ["one page is longer"]


def test_the_papers_designs_are_within_table_1():
    study = load_study(find_study("sevenbar_force"))
    for name in ("paper 1", "paper 2"):
        values = [press_paper.DESIGNS[name][path] for path in study.paths]
        assert (study.lower <= values).all()
        assert (values <= study.upper).all()
