"""Changed values of the live page: a list with a way back for each, steps that the browser's back undoes, words of the server."""

import pytest
from browser import find_browser
from live_page import Page
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

from linkages.show.live.answers import front_end
from linkages.show.naming import output_in_words, value_in_words
from linkages.show.plots.quantities import number

pytestmark = pytest.mark.skipif(find_browser() is None, reason="needs Chromium and its driver")

CLEARANCE, VISCOSITY = "joints.A.clearance", "joints.B.viscosity"
NUMBERS = [
    0.0,
    1.0,
    -1.0,
    796.8312,
    0.0123456,
    -0.0123456,
    1234567.0,
    99999.0,
    123456.0,
    13134.2,
    1e-4,
    9.87654e-5,
    -3.3e-12,
    6.02e23,
    0.1,
    1e5,
    1e6,
]


@pytest.fixture
def page(browser, serve):
    return Page(browser, serve(), "mm, r/min, °, mPa s")


def changes(page):
    return {row.find_elements(By.CSS_SELECTOR, "*")[0].text: row for row in page.all(".changes li")}


def test_each_changed_value_is_listed_and_undone_alone(page):
    page.type(CLEARANCE, "0.6")
    page.type(VISCOSITY, "200")
    listed = changes(page)
    assert list(listed) == ["Clearance of A", "Viscosity of B"]
    assert "0.3 mm → 0.6 mm" in listed["Clearance of A"].text
    page.one('[aria-label="undo Clearance of A"]').click()
    page.settle()
    assert list(changes(page)) == ["Viscosity of B"]
    assert page.field(CLEARANCE).get_attribute("value") == "0.3"
    page.button("undo")  # of the undo
    page.settle()
    assert page.field(CLEARANCE).get_attribute("value") == "0.6"


def test_back_is_undo_and_forward_is_redo(page):
    for value in ("0.6", "0.7"):
        page.type(CLEARANCE, value)

    def shown():
        return page.field(CLEARANCE).get_attribute("value")

    for step, value in ((page.browser.back, "0.6"), (page.browser.back, "0.3"), (page.browser.forward, "0.6")):
        step()
        page.wait(lambda value=value: shown() == value)
    page.button("undo")
    page.settle()
    assert shown() == "0.3"
    page.wait(lambda: "#" not in page.browser.current_url)  # the address goes with it
    page.browser.forward()
    page.wait(lambda: shown() == "0.6")


def test_a_panel_covers_no_number_and_gives_the_focus_back(page):
    page.button("tolerances")
    boxes = page.browser.execute_script(
        """return [".panel", ".numbers", ".picture", ".curves", ".controls"].map((name) => document.querySelector(name).getBoundingClientRect())
            .map(({left, top, right, bottom}) => [left, top, right, bottom]);"""
    )
    panel, *others = boxes
    for box in others:
        assert panel[2] <= box[0] or box[2] <= panel[0] or panel[3] <= box[1] or box[3] <= panel[1]
    page.browser.switch_to.active_element.send_keys(Keys.ESCAPE)
    assert not page.one(".panel").is_displayed()
    assert page.browser.switch_to.active_element.text == "tolerances"


def test_the_page_has_names_and_numbers_of_the_reports(page):
    found = page.browser.execute_script(
        """return [[...document.querySelectorAll(".row")].map((row) => [row.dataset.path, row.querySelector("label").textContent]),
            [...document.querySelectorAll(".numbers tbody tr")].map((row) => [row.dataset.name, row.querySelector("th span").firstChild.data])];"""
    )
    assert all(label == value_in_words(path) for path, label in found[0])
    assert all(label == output_in_words(name) for name, label in found[1])
    text = front_end("curves.js").split("export {")[0]
    digits = "return arguments[0].map((value) => number(value));"
    assert page.browser.execute_script(f"{text}\n{digits}", NUMBERS) == [number(value) for value in NUMBERS]


def test_an_orbit_is_whole_and_has_a_scale(page):
    """Nothing of the drawn bearing, journal or orbit lies beyond its picture; the bar is as long as the clearance."""
    outside, bar, ring = page.browser.execute_script(
        """const svg = document.querySelector(".orbits svg"), frame = svg.getBoundingClientRect(), box = (one) => one.getBoundingClientRect();
        const out = [...svg.querySelectorAll(":scope > circle, :scope > path, :scope > text")].map(box)
            .filter(({left, right, top, bottom}) => left < frame.left - 2 || right > frame.right + 2 || top < frame.top - 2 || bottom > frame.bottom + 2);
        return [out.length, box(svg.querySelector(".scale")).width, box(svg.querySelector(".clearance")).width];"""
    )
    assert outside == 0
    assert bar == pytest.approx(ring / 2.0, rel=0.05)
    assert page.one(".orbits text").text == "0.3 mm"


def test_all_curves_of_a_small_screen_are_seen_with_their_legend(page):
    size = {"width": 1280, "height": 800, "deviceScaleFactor": 1, "mobile": False}
    page.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    ends = (
        """return [...document.querySelectorAll(".curves figure")].map((one) => one.getBoundingClientRect().bottom);"""
    )
    page.wait(lambda: max(page.browser.execute_script(ends)) < 800)
    page.browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
    assert [one.text.strip() for one in page.all(".curves .legend span")] == ["run", "ideal joints"]


def test_requests_for_reports_are_checked(page):
    ask = page.server.answers.answer
    for runs in (None, [], [1], [{"peaks": [1]}], [{"peaks": {"A.force": "x"}}], [{"peaks": {"nothing": 1.0}}]):
        assert "error" in ask("report", {"runs": runs, "notes": "", "units": "SI units"}), runs
    good = {
        "runs": [{"name": "<b>", "values": {CLEARANCE: 2e-4}, "peaks": {"A.force": 7.0}}],
        "notes": "n",
        "units": "SI units",
    }
    text = ask("report", good)["page"]
    assert "&lt;b&gt;" in text
    assert "linkages simulate seven_bar.toml --set joints.A.clearance=0.0002" in text
