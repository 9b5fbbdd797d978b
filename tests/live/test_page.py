"""The live page in a browser: controls, numbers, keeping a run, keys."""

import json
import subprocess
from urllib.parse import unquote

import numpy as np
import pytest
from browser import find_browser
from live_page import Page
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

import linkages

pytestmark = pytest.mark.skipif(find_browser() is None, reason="needs Chromium and its driver")

CLEARANCE = "joints.A.clearance"


@pytest.fixture
def page(browser, serve):
    return Page(browser, serve())


def test_the_numbers_of_the_page_are_those_of_simulate(page, tmp_path):
    """Change, save, run the file: the same digits in the table."""
    page.type(CLEARANCE, "0.2 mm")
    page.type("joints.B.viscosity", "0.2")
    page.button("save")
    page.one(".panel input").send_keys(Keys.CONTROL + "a")
    page.one(".panel input").send_keys("thin")
    page.browser.find_element(By.XPATH, "//section[@class='panel']//button[.='save']").click()
    page.wait(lambda: page.state.startswith("written"))
    system = linkages.load(tmp_path / "thin.toml")
    assert (system.value(CLEARANCE), system.value("joints.B.viscosity")) == (2e-4, 0.2)
    summary = linkages.summarize(linkages.assess(system, "compiled", error_estimate=False))
    shown, table = summary["windows"]["steady"], page.table()
    for name, entry in shown["outputs"].items():
        assert float(table[name]["now"]) == float(f"{entry['peak']:.4g}")
    for name, entry in shown["joints"].items():
        assert float(table[f"{name}.force"]["now"]) == float(f"{entry['force']['peak']:.4g}")


@pytest.mark.parametrize("kind", ["save", "export"])
def test_enter_writes_the_file_and_escape_does_not(page, tmp_path, monkeypatch, kind):
    done = subprocess.CompletedProcess([], 0, "", "")
    monkeypatch.setattr(
        "linkages.show.live.keeping.subprocess.run", lambda *_, **__: done
    )  # the run of an export is slow
    page.button(kind)
    page.one(".panel input").send_keys("not", Keys.ESCAPE)
    page.wait(lambda: not page.one(".panel").is_displayed())
    page.button(kind)
    page.one(".panel input").send_keys(Keys.CONTROL + "a")
    page.one(".panel input").send_keys("mine", Keys.ENTER)
    page.wait(lambda: page.state.startswith("written"))
    assert [path.name for path in tmp_path.iterdir()] == ["mine.toml"]
    page.button(kind)
    page.one(".panel input").send_keys(Keys.CONTROL + "a")
    page.one(".panel input").send_keys("mine", Keys.ENTER)
    page.wait(lambda: "exists" in page.error)
    assert page.opacity(".numbers table") == 1.0


def test_two_tabs_have_their_own_tables(page):
    """Both change a value at the same time; each table is that of its own value."""
    browser, first, tables = page.browser, page.browser.current_window_handle, {}
    browser.switch_to.new_window("tab")
    try:
        second = Page(browser, page.server)
        for handle, value in ((first, "2e-4"), (browser.current_window_handle, "6e-4")):
            browser.switch_to.window(handle)
            field = second.field(CLEARANCE)
            field.send_keys(Keys.CONTROL + "a")
            field.send_keys(value, Keys.ENTER)
        for handle in browser.window_handles:
            browser.switch_to.window(handle)
            second.settle()
            tables[second.field(CLEARANCE).get_attribute("value")] = second.table()
    finally:
        if len(browser.window_handles) > 1:
            browser.close()
        browser.switch_to.window(first)
    for value, table in tables.items():
        page.type(CLEARANCE, "3e-4")
        page.type(CLEARANCE, value)
        alone = page.table()["A.eccentricity_ratio"]["now"]
        assert float(table["A.eccentricity_ratio"]["now"]) == pytest.approx(float(alone), rel=2e-3)
    assert len(tables) == 2


def test_old_numbers_are_pale_and_newer_values_do_not_wait(browser, serve):
    """A run that lasts minutes gives way as soon as another value is typed."""
    page = Page(browser, serve(linkages.load(linkages.find_file("slider_crank_dry.toml"), {"duration": 0.01})))
    page.server.answers.session.limit = 600.0
    before = page.table()
    page.search("duration")
    field = page.field("duration")
    for text in ("1000", "0.02"):
        field.send_keys(Keys.CONTROL + "a")
        field.send_keys(text, Keys.ENTER)
        if text == "1000":
            page.wait(lambda: page.opacity(".numbers table") < 0.5 and page.opacity(".plots") < 0.5)
            assert page.state == "computing ..."
            assert page.table() == before
    page.settle()
    assert page.opacity(".numbers table") == 1.0
    assert "computed in" in page.state
    assert page.browser.execute_script("return document.querySelector('.phase').value !== null")


def test_a_pinned_run_is_compared(page):
    before = page.table()["A.eccentricity_ratio"]["now"]
    page.button("pin")
    page.type(CLEARANCE, "5e-4")
    row = page.table()["A.eccentricity_ratio"]
    assert row["other"] == before
    change = float(row["change"].removesuffix(" %").replace("−", "-"))
    assert change == pytest.approx(100.0 * (float(row["now"]) / float(before) - 1.0), abs=0.5)  # three digits are shown
    assert len(page.browser.find_elements(By.CSS_SELECTOR, ".orbit.pinned")) == 2
    page.one(".pins .pin button:last-child").click()
    assert not page.browser.find_elements(By.CSS_SELECTOR, ".orbit.pinned")


def test_changes_are_undone_and_done_again(page):
    page.type(CLEARANCE, "5e-4")
    page.type(CLEARANCE, "6e-4")
    page.button("undo")
    assert page.field(CLEARANCE).get_attribute("value") == "0.0005"
    page.button("redo")
    assert page.field(CLEARANCE).get_attribute("value") == "0.0006"
    ActionChains(page.browser).key_down(Keys.CONTROL).send_keys("z").send_keys("z").key_up(Keys.CONTROL).perform()
    assert page.field(CLEARANCE).get_attribute("value") == "0.0003"
    page.type(CLEARANCE, "7e-4")
    page.button("reset")
    assert page.field(CLEARANCE).get_attribute("value") == "0.0003"


def test_a_link_restores_all_values(page):
    page.type(CLEARANCE, "5e-4")
    page.button("link")
    page.wait(lambda: "#" in page.browser.current_url)
    address = page.browser.current_url
    assert json.loads(unquote(address.partition("#")[2])) == {CLEARANCE: 5e-4}
    page.browser.get("about:blank")
    page.browser.get(address)
    page.settle()
    assert page.field(CLEARANCE).get_attribute("value") == "0.0005"


def test_sliders_and_choices_move_with_keys(page):
    before, slider = page.table(), page.one(f'[data-path="{CLEARANCE}"] [type=range]')
    slider.send_keys(Keys.ARROW_RIGHT * 40)
    page.settle()
    assert page.table() != before
    assert float(page.field(CLEARANCE).get_attribute("value")) > 3.3e-4
    page.one('[data-path="joints.A.model"] select').send_keys("i")
    page.wait(lambda: "A.eccentricity_ratio" not in page.table())


def test_play_and_pause(page):
    body, clock = page.one("body"), page.one(".clock")
    first = clock.text
    page.wait(lambda: clock.text != first)
    body.send_keys(" ")
    assert page.one(".playback button").text == "play"
    held = clock.text
    page.one(".phase").send_keys(Keys.ARROW_RIGHT * 3)
    assert clock.text != held
    body.send_keys("p")
    assert "pin 1" in page.one(".numbers thead").text


def test_any_value_is_found(page):
    page.search("link2.mass")
    page.type("sdf.links.link2.mass", "400 g")
    assert page.one('[data-path="sdf.links.link2.mass"] .unit').text == "kg"
    page.search("no such value")
    assert "no value has" in page.error
    assert page.opacity(".numbers table") == 1.0  # they are still those of the values
    assert "computed in" in page.state


def test_faults_are_reported_and_the_last_picture_remains(page):
    before = page.table()
    page.type(CLEARANCE, "-1")
    assert page.error.startswith("Clearance of A: is -1; it should be greater than 0")
    assert page.table() == before
    page.type(CLEARANCE, "3 kg")
    assert "kg" in page.error
    page.search("frames.link2_C.pose.x")
    page.type(CLEARANCE, "3e-4")
    page.type("sdf.frames.link2_C.pose.x", "2")
    assert "do not close" in page.error
    assert page.browser.find_elements(By.CSS_SELECTOR, ".picture svg")
    page.server.shutdown()
    page.server.socket.close()
    page.one(".search input")  # the page itself is still there
    page.type("joints.B.clearance", "4e-4")
    assert "the server does not answer" in page.error


def test_warnings_follow_when_nothing_is_changed(browser, serve):
    page = Page(browser, serve(linkages.load(linkages.find_file("seven_bar_paper.toml"))))
    page.wait(lambda: page.browser.find_elements(By.CSS_SELECTOR, ".said .warning"))
    assert "film" in page.one(".said .warning").text


def test_the_picture_moves(page):
    def places():
        return np.array(page.browser.execute_script(
            "return [...document.querySelectorAll('.picture circle')].map((c) => [c.cx.baseVal.value, c.cy.baseVal.value])"
        ))  # fmt: skip

    before = places()
    page.wait(lambda: np.abs(places() - before).max() > 5.0)


def test_a_design_that_locks_shows_where(page):
    page.search("frames.link2_C.pose.x")
    page.type("sdf.frames.link2_C.pose.x", "0.13")
    assert page.state.startswith("locks at 1.5")
    assert page.one(".phase").get_attribute("value") == "1000"
    assert page.table() == {}
    page.button("undo")
    page.settle()
    assert "computed in" in page.state
    assert page.table()


def test_a_slow_run_has_a_preview(browser, serve):
    server = serve(linkages.load(linkages.find_file("slider_crank_dry.toml")))
    server.answers.session.preview = 0.0
    browser.execute_cdp_cmd(
        "Page.addScriptToEvaluateOnNewDocument",
        {
            "source": """window.said = [];
        new MutationObserver(() => said.push(document.querySelector(".state")?.textContent)).observe(document, {subtree: true, childList: true});"""
        },
    )
    page = Page(browser, server)
    said = page.browser.execute_script("return said")
    assert any(text and text.startswith("preview; computed in") for text in said)
    assert page.state.startswith("not periodic; computed in")
