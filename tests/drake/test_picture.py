"""A diagram in a notebook: drawn where Graphviz is installed, a table of connections elsewhere."""

import pytest

from linkages.engines.drake import build_diagram, picture


@pytest.fixture
def diagram(seven_bar):
    return build_diagram(seven_bar)[0]


def test_without_graphviz_the_connections_are_listed(diagram, monkeypatch):
    monkeypatch.setenv("PATH", "")
    shown = picture(diagram)
    assert shown.svg is None
    assert ("plant.state", "clearance_joints.state") in shown.connections
    assert ("drives.generalized_force", "plant.applied_generalized_force") in shown.connections
    assert len(shown.connections) == len(diagram.connection_map())
    table = shown._repr_mimebundle_()["text/markdown"]
    assert table.count("\n| `") == len(shown.connections)
    assert "Graphviz" in table
    assert str(shown).count("->") == len(shown.connections)


def test_with_graphviz_drakes_own_drawing_is_shown(diagram, monkeypatch, tmp_path):
    """A replacement of ``dot`` that returns its input."""
    dot = tmp_path / "dot"
    dot.write_text('#!/bin/sh\ntest "$1" = -Tsvg && exec /bin/cat\n')
    dot.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    bundle = picture(diagram)._repr_mimebundle_()
    assert bundle["image/svg+xml"] == diagram.GetGraphvizString(max_depth=1)
    assert "text/markdown" not in bundle
