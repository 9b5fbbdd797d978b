"""The live page in a notebook gives the answers of the page in a browser."""

import re

import anywidget
import pytest

import linkages
from linkages.show.live.answers import front_end


@pytest.fixture
def widget(monkeypatch, tmp_path):
    """Make a widget and the list of its messages to the front end."""
    sent = []
    monkeypatch.setattr(anywidget.AnyWidget, "send", lambda self, content, buffers=None: sent.append(content))
    return linkages.play(linkages.load(linkages.find_file("seven_bar.toml")), folder=tmp_path), sent


def test_requests_are_answered_by_number(widget, tmp_path):
    shown, sent = widget
    shown._handle_custom_msg({"n": 7, "kind": "run", "request": {"values": {"joints.A.clearance": "0.2 mm"}}}, [])
    shown._handle_custom_msg({"n": 8, "kind": "save", "request": {"values": {}, "name": "mine"}}, [])
    shown._handle_custom_msg({"n": 9, "kind": "run", "request": {"values": {"nothing": 1}}}, [])
    assert [message["n"] for message in sent] == [7, 8, 9]
    assert sent[0]["reply"]["numbers"] == {"joints.A.clearance": 2e-4}
    assert (tmp_path / "mine.toml").is_file()
    assert "nothing" in sent[2]["reply"]["error"]


def test_messages_of_another_form_are_left_alone(widget):
    shown, sent = widget
    for message in ({}, [], "run", {"n": 1}):
        shown._handle_custom_msg(message, [])
    assert not sent


def test_one_module_has_the_front_end_of_the_page():
    text = front_end("widget.js")
    assert re.findall(r"^(?:export|import).*", text, re.MULTILINE) == ["export default {"]
    assert all(f"function {name}(" in text for name in ("mount", "drawCurves", "joints", "explore"))
