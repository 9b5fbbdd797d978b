"""The live page on screens of all sizes, in both colours, by keyboard, without motion."""

import pytest
from accessible import CONTRASTS, prefer
from browser import find_browser
from live_page import Page
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

import linkages

pytestmark = pytest.mark.skipif(find_browser() is None, reason="needs Chromium and its driver")

BOXES = """return [".picture", ".orbits", ".controls", ".numbers", ".curves"].map((name) => {
    const box = document.querySelector(name).getBoundingClientRect();
    return [box.left, box.top, box.right, box.bottom]; });"""


def resize(page, width, height):
    page.browser.execute_cdp_cmd(
        "Emulation.setDeviceMetricsOverride",
        {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False},
    )
    page.settle()


@pytest.fixture
def page(browser, serve):
    yield Page(browser, serve(), "mm, r/min, °, mPa s")
    browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})


@pytest.mark.parametrize(("width", "height"), [(1280, 800), (1920, 1080)])
def test_machine_controls_peaks_and_a_curve_are_seen_without_scrolling(page, width, height):
    resize(page, width, height)
    page.button("pin")
    whole = page.browser.execute_script(
        """const page = document.documentElement, fits = (one) => one.scrollHeight <= one.clientHeight && one.scrollWidth <= one.clientWidth;
        return [page, ...document.querySelectorAll(".controls, .numbers, .orbits, .picture")].map(fits);"""
    )
    assert all(whole)
    seen = page.browser.execute_script(
        """return [...document.querySelectorAll(".picture svg, .controls .row, .numbers tr, .orbits figure, .plots figure:first-child")]
            .map((one) => one.getBoundingClientRect()).map((box) => [box.left, box.top, box.right, box.bottom]);"""
    )
    assert len(seen) == 1 + 8 + 16 + 2 + 1
    for left, top, right, bottom in seen:
        assert 0 <= left < right <= width
        assert 0 <= top < bottom <= height
    picture = page.one(".picture svg").size
    assert picture["width"] * picture["height"] > 0.15 * width * height


@pytest.mark.parametrize("machine", ["seven_bar", "slider_crank_dry"])  # seven and five curves
def test_all_curves_of_a_large_screen_are_seen(browser, serve, machine):
    page = Page(browser, serve(linkages.load(linkages.find_file(f"{machine}.toml"))))
    resize(page, 1920, 1080)
    fits = "const panel = document.querySelector('.curves'); return panel.scrollHeight <= panel.clientHeight;"
    page.wait(lambda: browser.execute_script(fits))
    browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


@pytest.mark.parametrize("width", [390, 800, 1280])
def test_panels_are_beside_or_below_each_other(page, width):
    resize(page, width, 900)
    assert page.browser.execute_script("return document.documentElement.scrollWidth") == width
    boxes = page.browser.execute_script(BOXES)
    for k, (left, top, right, bottom) in enumerate(boxes):
        assert 0 <= left < right <= width
        for other in boxes[k + 1 :]:
            assert right <= other[0] + 1 or other[2] <= left + 1 or bottom <= other[1] + 1 or other[3] <= top + 1


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_texts_and_lines_have_the_contrast_of_wcag_aa(page, scheme):
    prefer(page.browser, "prefers-color-scheme", scheme)
    for value in ("0.4", "0.5", "0.6", "0.7"):
        page.button("pin")
        page.type("joints.A.clearance", value)
    for k, limit in enumerate(("< 1", "> 1")):
        page.browser.find_elements(By.CSS_SELECTOR, ".limit")[k].send_keys(limit, Keys.ENTER)
    page.one(".search input").send_keys("mass")
    texts, edges = page.browser.execute_script(CONTRASTS)
    assert len(texts) > 100
    assert len(edges) > 50
    assert not [text for text in texts if text[0] < 4.5]
    assert not [edge for edge in edges if edge[0] < 3.0]


def test_every_control_is_reached_by_the_tab_key(page):
    count = page.browser.execute_script(
        """const all = [...document.querySelectorAll("button, input, select, [tabindex='0']")].filter((one) => one.checkVisibility() && !one.disabled);
        window.left = new Set(all);
        document.addEventListener("focusin", (event) => window.left.delete(event.target));
        return all.length;"""
    )
    page.browser.switch_to.active_element.send_keys(Keys.TAB)
    for _ in range(count + 5):
        page.browser.switch_to.active_element.send_keys(Keys.TAB)
    assert page.browser.execute_script("return [...window.left].map((one) => one.outerHTML)") == []


def test_borders_move_and_panels_hide_by_keys_and_stay_so(page):
    resize(page, 1280, 800)

    def width():
        return page.one(".controls").size["width"]

    before = width()
    page.one(".border.left").send_keys(Keys.ARROW_RIGHT * 3)
    assert width() == pytest.approx(before + 60, abs=2)
    page.browser.find_element(By.XPATH, "//button[.='curves']").send_keys(Keys.ENTER)
    assert not page.one(".curves").is_displayed()
    page.browser.refresh()
    page.settle()
    assert width() == pytest.approx(before + 60, abs=2)
    assert not page.one(".curves").is_displayed()


def test_a_curve_is_read_and_enlarged_by_keys(page):
    page.browser.find_element(By.XPATH, "//button[.='pause']").click()
    curve, clock = page.one(".plots svg"), page.one(".clock").text
    curve.send_keys(Keys.ARROW_RIGHT)
    assert page.one(".clock").text != clock

    def marks():
        return [text.text for text in page.browser.find_elements(By.CSS_SELECTOR, ".plots figure:first-child text")]

    whole = marks()
    curve.send_keys("++")
    assert marks() != whole
    curve.send_keys("0")
    assert marks() == whole


def test_nothing_moves_by_itself_if_the_reader_prefers_so(page):
    prefer(page.browser, "prefers-reduced-motion", "reduce")
    page.browser.refresh()
    page.settle()
    assert page.one(".playback button").text == "play"
    assert page.one(".clock").text == "0 s"


def test_chosen_units_and_colours_are_kept(page):
    assert page.field("joints.A.clearance").get_attribute("value") == "0.3"
    assert page.field("drives.O1.speed").get_attribute("value") == "30"
    assert page.field("joints.A.viscosity").get_attribute("value") == "400"
    millimetres = float(page.table()["slider7.x"]["now"])
    for label, choice in (("units", "SI units"), ("colours", "dark")):
        page.browser.find_element(By.XPATH, f"//select[@aria-label='{label}']").send_keys(choice)
    assert page.field("joints.A.clearance").get_attribute("value") == "0.0003"
    assert float(page.table()["slider7.x"]["now"]) == pytest.approx(millimetres / 1000.0, rel=1e-4)
    page.browser.refresh()
    page.settle()
    assert page.field("joints.A.clearance").get_attribute("value") == "0.0003"
    assert page.one("main").value_of_css_property("background-color") == "rgba(22, 24, 28, 1)"
