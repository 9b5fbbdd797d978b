"""Numbers of the live page: units, pinned runs, limits, differences, the table of runs, remedies."""

import csv
import json
from urllib.parse import unquote

import pytest
from browser import find_browser
from live_page import Page
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

pytestmark = pytest.mark.skipif(find_browser() is None, reason="needs Chromium and its driver")

CLEARANCE = "joints.A.clearance"


@pytest.fixture
def page(browser, serve):
    return Page(browser, serve(), "mm, r/min, °, mPa s")


def values(page):
    """Values of the page, by its link."""
    page.button("link")
    page.wait(lambda: "#" in page.browser.current_url)
    return json.loads(unquote(page.browser.current_url.partition("#")[2]))


def numbers(text):
    """Numbers of a caption behind its time."""
    return [float(part.split()[-1].replace("−", "-")) for part in text.split(" s: ")[1].split(", ")]


def test_typed_numbers_have_the_shown_unit(page):
    page.type(CLEARANCE, "0.2")
    page.type("drives.O1.speed", "45 r/min")
    page.type("joints.A.viscosity", "0.3 Pa s")
    assert values(page)[CLEARANCE] == 2e-4
    assert page.field("drives.O1.speed").get_attribute("value") == "45"
    assert page.field("joints.A.viscosity").get_attribute("value") == "300"


def test_a_page_that_is_loaded_again_has_its_values_and_limits(page):
    page.type(CLEARANCE, "0.2")
    field = '[data-name="A.force"] .limit'
    page.one(field).send_keys("> 5", Keys.ENTER)
    page.browser.refresh()
    page.settle()
    assert page.field(CLEARANCE).get_attribute("value") == "0.2"
    assert page.one(field).get_attribute("value") == "> 5"
    assert page.one('[data-name="A.force"] .within').text.startswith("✓")
    page.one(field).clear()
    page.one(field).send_keys(Keys.ENTER)
    page.button("reset")
    page.settle()
    assert "#" not in page.browser.current_url


def test_labels_are_words_with_the_path_as_tooltip(page):
    label = page.one(f'[data-path="{CLEARANCE}"] label')
    assert (label.text, label.get_attribute("title")) == ("Clearance of A", CLEARANCE)
    row = page.one('.numbers [data-name="slider7.ax"] th')
    assert (row.text, row.get_attribute("title")) == ("Acceleration x of slider7m/s²", "slider7.ax")


def test_a_search_lists_all_hits_and_changes_nothing_without_one(page):
    field = page.one(".search input")
    field.send_keys("mass link2")
    hits = [hit.get_attribute("title") for hit in page.browser.find_elements(By.CSS_SELECTOR, ".hits button")]
    assert "sdf.links.link2.mass" in hits
    assert hits[-1] == "sdf.links.link2.com.z"  # out of the plane
    rows = len(page.browser.find_elements(By.CSS_SELECTOR, ".row"))
    field.send_keys(" nothing", Keys.ENTER)
    assert page.one(".hits").text == "no such value"
    assert len(page.browser.find_elements(By.CSS_SELECTOR, ".row")) == rows
    field.send_keys(Keys.CONTROL + "a")
    field.send_keys("link2 mass")
    page.one('.hits [title="sdf.links.link2.mass"]').click()
    assert page.field("sdf.links.link2.mass").is_displayed()


def test_pinned_runs_have_names_and_are_compared(page):
    first = page.table()["A.eccentricity_ratio"]["now"]
    page.button("pin")
    page.type(CLEARANCE, "0.5")
    second = page.table()["A.eccentricity_ratio"]["now"]
    page.button("pin")
    name = page.one(".pins input")
    name.send_keys(Keys.CONTROL + "a")
    name.send_keys("thin", Keys.TAB)
    page.type(CLEARANCE, "0.7")
    assert page.table()["A.eccentricity_ratio"]["other"] == second
    page.one(".numbers .head select").send_keys("thin")
    assert page.table()["A.eccentricity_ratio"]["other"] == first
    assert "thin" in page.one(".plots figcaption").text
    colors = {page.one(f".plots .pinned.{pin}").value_of_css_property("stroke") for pin in ("pin1", "pin2")} | {
        page.one(".plots .curve:not(.pinned, .ideal)").value_of_css_property("stroke")
    }
    assert len(colors) == 3
    page.one(".pins button").click()  # back to the values of the first run
    page.settle()
    assert page.field(CLEARANCE).get_attribute("value") == "0.3"


def test_limits_have_margins(page):
    def set_limit(text):
        field = page.one('[data-name="A.force"] .limit')
        field.send_keys(Keys.CONTROL + "a")
        field.send_keys(text, Keys.ENTER)
        return page.one('[data-name="A.force"] td:last-child')

    force = float(page.table()["A.force"]["now"])
    cell = set_limit("8")
    assert float(cell.text.removeprefix("✓ ").removesuffix(" %")) == pytest.approx(100 * (1 - force / 8), rel=5e-3)
    cell = set_limit("> 8")
    assert cell.text.startswith("✗ −")
    cell = set_limit("nonsense")
    assert "is no limit of A.force" in page.error
    set_limit(Keys.BACKSPACE)
    assert not page.browser.find_elements(By.CSS_SELECTOR, ".within, .beyond")


def test_a_difference_is_the_run_minus_the_pinned_one(page):
    page.one(".playback button").click()
    page.button("pin")
    page.type(CLEARANCE, "0.9")
    page.one(".plots svg").send_keys(Keys.ARROW_RIGHT * 7)
    captions = page.browser.find_elements(By.CSS_SELECTOR, ".plots figcaption")
    before = [numbers(caption.text) for caption in captions]
    page.browser.find_element(By.XPATH, "//button[.='difference']").click()
    for (now, _, pinned), caption in zip(before, captions, strict=True):
        assert "minus pin 1" in caption.text
        (difference,) = numbers(caption.text)
        assert difference == pytest.approx(now - pinned, abs=1e-3 * max(abs(now), abs(pinned)))


def test_the_mark_of_a_curve_is_its_peak(page):
    titles = page.browser.execute_script(
        "return [...document.querySelectorAll('.peak title')].map((one) => one.textContent)"
    )
    named = page.browser.execute_script(
        "return [...document.querySelectorAll('.plots figcaption')].map((one) => one.title)"
    )
    table = page.table()
    for name, title in zip(named, titles, strict=True):
        assert abs(float(title.split()[1].replace("−", "-"))) == pytest.approx(float(table[name]["now"]), rel=1e-3)


def test_the_table_of_runs_is_sorted_written_and_goes_back(page):
    for value in ("0.5", "0.2"):
        page.type(CLEARANCE, value)
    page.wait(lambda: page.browser.find_elements(By.XPATH, "//button[.='runs (3)']"))
    page.button("runs (3)")

    def clearances():
        return [
            row.find_elements(By.TAG_NAME, "td")[1].text
            for row in page.browser.find_elements(By.CSS_SELECTOR, ".runs tbody tr")
        ]

    assert clearances() == ["0.3", "0.5", "0.2"]
    for ordered in (["0.2", "0.3", "0.5"], ["0.5", "0.3", "0.2"]):
        page.browser.find_element(By.XPATH, "//button[.='Clearance of A [mm]']").click()
        assert clearances() == ordered
    text = page.browser.execute_async_script(
        """const done = arguments[0];
        URL.createObjectURL = (blob) => { blob.text().then(done); return "data:,"; };
        [...document.querySelectorAll(".panel button")].find((one) => one.textContent === "CSV").click();"""
    )
    heads, *rows = csv.reader(text.splitlines())
    assert heads[:3] == ["run", "change", f"{CLEARANCE} [mm]"]
    assert [row[1] for row in rows] == ["", "Clearance of A 0.5 mm", "Clearance of A 0.2 mm"]
    assert [float(row[2]) for row in rows] == pytest.approx([0.3, 0.5, 0.2])
    page.browser.find_element(By.XPATH, "//table[@class='runs']//th/button[.='2']").click()
    page.settle()
    assert page.field(CLEARANCE).get_attribute("value") == "0.5"


def test_a_remedy_is_one_click(browser, serve):
    server = serve()
    remedy = {"label": "use 0.5 mm", "values": {CLEARANCE: 5e-4}}
    server.answers.session.warnings = lambda: [{"text": "the clearance is too small", "remedies": [remedy]}]
    page = Page(browser, server)
    page.wait(lambda: page.browser.find_elements(By.CSS_SELECTOR, ".warning button"))
    page.one(".warning button").click()
    page.settle()
    assert page.field(CLEARANCE).get_attribute("value") == "0.0005"
    page.button("undo")
    assert page.field(CLEARANCE).get_attribute("value") == "0.0003"
