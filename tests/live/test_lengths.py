"""Lengths on the live page in a browser: links at their joints, changed values as fields, old numbers pale."""

import threading

import numpy as np
import pytest
from browser import find_browser
from live_page import Page
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.keys import Keys

import linkages
from linkages.cli.main import main
from linkages.input.files.sdf import read_sdf
from linkages.input.files.sdf_text import sdf_text

pytestmark = pytest.mark.skipif(find_browser() is None, reason="needs Chromium and its driver")

RIG = """title = "Rig"
duration = 0.2
outputs = ["slider.ax"]
section = [0.02, 0.01]
density = 7850
points = { O = [0, 0], A = ["O", 0.05, "40 deg"], B = ["A", 0.15, "-12 deg"] }
links = { ground = "O", crank = "O A", rod = "A B", slider = "B along ground" }
drives.O.speed = "600 r/min"
joints.B = { model = "lubricated", clearance = 1e-4, viscosity = 0.1 }
"""
CRANK = "sdf.frames.crank_A.pose.x"
NEAR = 0.6  # pixels: the journal of B moves within its clearance of 0.4
#: Ends of bars as drawn and pins as drawn, in plane axes [m].
DRAWN = """
const svg = document.querySelector(".picture svg"), text = (one) => one.textContent;
const bars = [...svg.querySelectorAll("[data-at]")].filter((one) => one.points && one.dataset.at.split(" ").length === 2)
  .filter((one) => Number(one.getAttribute("stroke-width")) > 10)
  .map((one) => one.getAttribute("points").split(" ").map((point) => point.split(",").map(Number)));
const pins = [...svg.querySelectorAll("circle[data-at]")].map((one) => [one.cx.baseVal.value, one.cy.baseVal.value]);
return [bars, pins];
"""


@pytest.fixture
def rig(tmp_path):
    """Write the rig as this version does, or as earlier ones did; return its system."""

    def make(at_frames=True):
        (tmp_path / "rig.machine.toml").write_text(RIG)
        assert main(["new", "--from", str(tmp_path / "rig.machine.toml"), "--out", str(tmp_path)]) == 0
        if not at_frames:
            machine = tmp_path / "rig.sdf"
            machine.write_text(sdf_text(read_sdf(machine), at_frames=False))
        return linkages.load(tmp_path / "rig.toml")

    return make


def hold(page):
    page.browser.execute_script(
        "const f = document.querySelector('.phase'); f.value = 300; f.dispatchEvent(new Event('input'))"
    )


def gaps(page):
    """Distance of each end of a bar from the nearest pin, in units of the picture."""
    hold(page)
    bars, pins = page.browser.execute_script(DRAWN)
    assert len(bars) >= 2
    return [min(np.hypot(*(np.array(end) - pin)) for pin in pins) for bar in bars for end in bar]


@pytest.mark.parametrize("length", ["60", "30"])
def test_links_end_at_their_joints_after_a_length_is_typed(browser, serve, rig, length):
    page = Page(browser, serve(rig()), "mm, r/min, °, mPa s")
    page.search(CRANK)
    page.type(CRANK, length)
    assert max(gaps(page)) < NEAR


@pytest.mark.parametrize("at_frames", [True, False])
def test_a_dragged_pin_lists_what_it_changes_and_links_end_at_their_joints(browser, serve, rig, at_frames):
    page = Page(browser, serve(rig(at_frames)))
    hold(page)
    before = {row.get_attribute("data-path") for row in page.all(".row")}
    pin = page.browser.execute_script(
        "const b = [...document.querySelectorAll('.picture text')].find((t) => t.textContent === 'A');"
        "const c = [...document.querySelectorAll('.picture circle[data-at]')], r = b.getBoundingClientRect();"
        "const near = (o) => { const q = o.getBoundingClientRect();"
        " return Math.hypot(q.x + q.width / 2 - r.x - r.width / 2, q.y + q.height / 2 - r.y - r.height / 2); };"
        "const q = c.sort((m, n) => near(m) - near(n))[0].getBoundingClientRect();"
        "return [q.x + q.width / 2, q.y + q.height / 2];"
    )
    actions = ActionChains(browser)
    actions.w3c_actions.pointer_action.move_to_location(*map(round, pin))
    actions.click_and_hold().move_by_offset(8, 4).pause(0.1).move_by_offset(8, 4).pause(0.1).release().perform()
    page.settle()
    changed = browser.execute_script("return Object.keys(JSON.parse(decodeURIComponent(location.hash.slice(1))))")
    shown = {row.get_attribute("data-path") for row in page.all(".row.changed")}
    assert set(changed) == shown
    assert shown - before
    assert max(gaps(page)) < NEAR


def test_a_value_without_effect_is_said_at_its_field(browser, serve, rig):
    page = Page(browser, serve(rig(at_frames=False)), "mm, r/min, °, mPa s")
    page.search(CRANK)
    page.type(CRANK, "60")
    assert page.error == (
        "Position x of crank_A: changes no number of the model: only the drawing uses it; "
        "the place of joint A is sdf.joints.A.pose.x"
    )
    assert page.field(CRANK).get_attribute("aria-invalid") == "true"
    page.one(".error button").click()  # the path that acts
    assert page.field("sdf.joints.A.pose.x").is_displayed()
    page.button("undo")
    page.settle()
    assert not page.error
    assert page.field(CRANK).get_attribute("aria-invalid") is None


def test_a_decimal_comma_is_said_in_the_words_of_the_field(browser, serve, rig):
    page = Page(browser, serve(rig()))
    page.type("joints.B.clearance", "0,2 mm")
    assert page.error.startswith("Clearance of B: is '0,2 mm'; it has a decimal comma: write 0.2 mm")
    assert [row.get_attribute("data-path") for row in page.all(".row.wrong")] == ["joints.B.clearance"]


@pytest.mark.parametrize("kind", ["compute", "picture"])
def test_what_is_shown_is_pale_while_a_long_answer_for_new_values_is_awaited(browser, serve, rig, monkeypatch, kind):
    """Numbers, curves and picture of the values before; a picture alone, if only it takes long."""
    server = serve(rig())
    page = Page(browser, server)
    page.search(CRANK)
    of = next(one for name, one in server.answers._pages.items() if name)
    own, go = getattr(of, kind), threading.Event()

    def late(*arguments):
        assert go.wait(60.0)
        return own(*arguments)

    monkeypatch.setattr(of, kind, late)
    field = page.field(CRANK)
    field.send_keys(Keys.CONTROL + "a")
    field.send_keys("0.055", Keys.ENTER)
    parts = {"compute": (".numbers table", ".plots", ".stage"), "picture": (".stage",)}[kind]
    page.wait(lambda: all(page.opacity(part) < 0.5 for part in parts))
    go.set()
    page.settle()
    assert [page.opacity(part) for part in parts] == [1.0] * len(parts)
