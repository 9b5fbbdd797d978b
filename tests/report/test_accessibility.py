"""Reports, animations, drawings and the live page can be used by everybody: names, landmarks, contrast, keyboard."""

import base64
import re
import threading

import pytest
from accessible import axe_violations, faults, prefer
from browser import find_browser, started
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import WebDriverWait

import linkages
from linkages.cli.main import main
from linkages.show.live.answers import Answers
from linkages.show.live.controls import controls
from linkages.show.live.server import LiveServer
from linkages.show.live.session import Session
from linkages.show.plots.lines import wear_page
from linkages.show.report.page import write_report
from linkages.show.report.result_folder import load_results

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(find_browser() is None, reason="no Chromium with its chromedriver on the PATH"),
]

PAGES = ("report", "animation", "drawing", "wear", "live")
WORN = {"depth": 2e-5, "clearance": 1e-4, "radius": 0.01} | {
    "stages": [{side: [depth] * 24 for side in ("bearing", "journal")} for depth in (0.0, 2e-5)]
}


@pytest.fixture(scope="module")
def browser():
    with started("--window-size=1280,900") as found:
        yield found


@pytest.fixture(scope="module")
def addresses(results_folder, tmp_path_factory):
    folder = tmp_path_factory.mktemp("pages")
    write_report(load_results(results_folder), folder / "report.html")
    (folder / "wear.html").write_text(wear_page("Wear", {"cycles": [0, 10], "joints": {"B": WORN}}), encoding="utf-8")
    assert main(["draw", "seven_bar.toml", "--out", str(folder / "drawing")]) == 0
    system = linkages.load(linkages.find_file("seven_bar.toml"))
    server = LiveServer(Answers(Session(system, 60.0, 60.0), controls(system), folder))
    thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.02})
    thread.start()
    files = {"report": folder / "report.html", "animation": results_folder / "animation.html"}
    files |= {"drawing": folder / "drawing" / "drawing.html", "wear": folder / "wear.html"}
    yield {name: path.as_uri() for name, path in files.items()} | {"live": server.address}
    server.shutdown()
    server.server_close()
    thread.join()


def opened(browser, address):
    """Open a page, and wait until it shows a picture of its machine."""
    browser.get("about:blank")
    browser.get(address)
    ready = "return document.readyState === 'complete' && document.querySelector('[aria-busy=true]') === null && document.querySelector('img, canvas, svg') !== null"
    WebDriverWait(browser, 60.0).until(lambda page: page.execute_script(ready))


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("name", PAGES)
def test_a_page_has_names_landmarks_headings_and_contrast(browser, addresses, name, scheme):
    prefer(browser, "prefers-color-scheme", scheme)
    opened(browser, addresses[name])
    assert faults(browser) == []


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("name", PAGES)
def test_axe_finds_no_violation(browser, addresses, name, scheme):
    prefer(browser, "prefers-color-scheme", scheme)
    opened(browser, addresses[name])
    found = axe_violations(browser)
    if found is None:
        pytest.skip("the environment variable AXE_CORE is not the path of axe.min.js (npm pack axe-core)")
    assert found == []


def test_a_fault_would_be_found(browser, addresses):
    prefer(browser, "prefers-color-scheme", "light")
    opened(browser, addresses["drawing"])
    browser.execute_script(
        """document.documentElement.lang = ""; document.querySelector("main").append(document.createElement("button"));
        document.querySelector("h1").style.color = "#999"; document.body.append("outside", document.createElement("p"));"""
    )
    found = " ".join(faults(browser))
    for fault in ("no language", "no name: <button>", "text with a contrast of 2.8"):
        assert fault in found


def test_an_animation_is_played_by_keys_from_the_first_tab_on(browser, addresses):
    opened(browser, addresses["animation"])
    place = "return document.querySelector('#bar input').value"
    browser.switch_to.active_element.send_keys(Keys.TAB)
    first = browser.switch_to.active_element
    assert (first.tag_name, first.text) == ("button", "pause")
    browser.execute_script("document.activeElement.blur()")
    browser.find_element(By.TAG_NAME, "body").send_keys(" ")
    assert first.text == "play"
    held = int(browser.execute_script(place))
    browser.find_element(By.TAG_NAME, "body").send_keys(Keys.ARROW_RIGHT * 3)
    assert int(browser.execute_script(place)) == min(held + 3, 240)
    browser.find_element(By.TAG_NAME, "body").send_keys(" ")
    assert first.text == "pause"


def test_a_report_of_the_press_is_printed_on_four_pages(browser, tmp_path):
    out = tmp_path / "press"
    assert main(["simulate", "seven_bar.toml", "--out", str(out), "--no-animation", "--quiet"]) == 0
    write_report(load_results(out), tmp_path / "report.html")
    opened(browser, (tmp_path / "report.html").as_uri())
    printed = browser.execute_cdp_cmd("Page.printToPDF", {"preferCSSPageSize": True, "printBackground": True})
    assert len(re.findall(rb"/Type\s*/Page[^s]", base64.b64decode(printed["data"]))) <= 4
