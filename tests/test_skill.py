"""SKILL.md, for assistant programs: its tasks are those of the page, its example and its words are true."""

import re
import shutil
from importlib import import_module
from pathlib import Path

import pytest

import linkages
from linkages.cli.main import main

TEXT = (Path(__file__).parents[1] / "SKILL.md").read_text(encoding="utf-8")


def test_the_tasks_are_those_of_the_page():
    """Their commands run in `test_tasks`."""
    assert import_module("make_skill").page(TEXT) == TEXT
    assert TEXT.count("\n| ") > 40


def test_it_begins_with_a_name_and_a_description():
    head = re.match(r"---\nname: linkages\ndescription: (.{100,1000})\n---\n", TEXT)
    assert head is not None


@pytest.fixture
def example(tmp_path):
    """The experiment of the page, beside its machine."""
    shutil.copy(linkages.find_file("slider_crank.sdf"), tmp_path)
    (tmp_path / "my.toml").write_text(re.search(r"```toml\n(.*?)```", TEXT, re.DOTALL)[1], encoding="utf-8")
    return tmp_path / "my.toml"


def test_the_example_runs_and_has_what_the_page_reads(example, tmp_path):
    words = ["simulate", str(example), "--no-plots", "--no-animation", "--quiet", "--out", str(tmp_path / "out")]
    assert main(words) == 0
    summary = linkages.summarize(linkages.assess(linkages.load(example)))
    assert {"status", "warnings", "error", "outputs"} <= set(summary)
    assert summary["status"] == "ok"


def test_the_paths_of_the_pitfalls_have_an_effect(example):
    """Each dotted path that the page gives for --set changes the system."""
    system = linkages.load(example)
    paths = re.search(r"take dotted paths: (.*?)\. A path", TEXT)[1]
    found = re.findall(r"`([\w.]+)`", paths)
    assert len(found) == 4
    for path in found:
        system.replaced({path: 1.01 * system.value(path)})


@pytest.mark.parametrize("words", sorted(set(re.findall(r"`linkages keys (\w+)`", TEXT)) - {"WORD"}))
def test_keys_are_found_by_the_words_of_the_page(words, capsys):
    assert main(["keys", words]) == 0
    assert capsys.readouterr().out.count("\n") > 0
