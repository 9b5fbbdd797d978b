"""The live page in a notebook gives the answers of the page in a browser."""

import re

import anywidget
import pytest
from browser import find_browser, open_page

import linkages
from linkages.show.live.answers import front_end
from linkages.show.plots.pages import embedded

# A cell of a notebook whose kernel has the replies ready.
CELL = """<!DOCTYPE html><style>{css}</style><div id="cell" style="width: 1000px"></div><script type="module">{module}
const replies = {replies};
let hear;
widget.render({{el: document.querySelector("#cell"), model: {{
  on: (_, listener) => {{ hear = listener; }},
  send: ({{n, kind}}) => setTimeout(() => hear({{n, reply: replies[kind]}})),
}}}});
</script>"""

LOOK = """
const root = document.querySelector(".linkages-live"), count = (selector) => root.querySelectorAll(selector).length;
while (root.getAttribute("aria-busy") !== "false") await frames(1);
return {counts: [".picture svg", ".row", ".numbers tbody tr", ".orbits figure", ".plots figure"].map(count),
  error: root.querySelector(".error").textContent, over: root.scrollWidth - root.clientWidth};"""


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


@pytest.mark.skipif(find_browser() is None, reason="needs Chromium and its driver")
def test_a_cell_shows_the_page(answers, settled, tmp_path):
    of = answers("seven_bar")
    run = settled(of, {})
    replies = {kind: of.answer(kind, {}) for kind in ("start", "picture", "numbers", "warnings")} | {"run": run}
    module = front_end("widget.js").replace("export default {", "const widget = {")
    cell = CELL.format(css=front_end("live.css"), module=module, replies=embedded(replies))
    (tmp_path / "cell.html").write_text(cell, encoding="utf-8")
    seen = open_page(tmp_path / "cell.html", tmp_path, LOOK).seen
    assert seen["counts"] == [1, 8, 15, 2, 7]
    assert not seen["error"]
    assert seen["over"] <= 0
