"""Public names and types of the packages, as an editor and a type checker see them."""

import importlib
from pathlib import Path

import pytest

PACKAGES = ["linkages", "linkages.plots", "linkages.report", "linkages.engines.drake", "optim"]


@pytest.mark.parametrize("name", PACKAGES)
def test_public_names_are_listed_and_exist(name):
    package = importlib.import_module(name)
    assert package.__all__
    assert set(dir(package)) >= set(package.__all__)
    for public in package.__all__:
        assert getattr(package, public) is not None


def test_unknown_name_is_an_attribute_error():
    import linkages

    with pytest.raises(AttributeError, match="simulat_"):
        linkages.simulat_  # noqa: B018 - the access raises


@pytest.mark.slow
def test_type_checker_sees_the_types_of_public_functions(tmp_path, monkeypatch):
    from mypy import api

    monkeypatch.chdir(tmp_path)
    script = Path("script.py")
    script.write_text(
        'import linkages\n\nrun: int = linkages.simulate(linkages.load(linkages.find_file("seven_bar.toml")))\n'
    )
    found, problems, status = api.run([str(script), "--follow-imports=silent", "--ignore-missing-imports"])
    assert status == 1, problems
    assert 'expression has type "Trajectory", variable has type "int"' in found
