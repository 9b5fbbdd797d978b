"""Editing parts with the mouse, exploring and keeping, on the page in a browser."""

import json
import re

import pytest
from browser import find_browser
from live_page import Page
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

pytestmark = pytest.mark.skipif(find_browser() is None, reason="needs Chromium and its driver")

#: Where a joint is on the screen, at the beginning of the shown part.
PLACE = """
const {low, high, scale, at: [body, x, y], pose: [px, py, angle]} = arguments[0];
const at = [px + Math.cos(angle) * x - Math.sin(angle) * y, py + Math.sin(angle) * x + Math.cos(angle) * y];
const point = new DOMPoint((at[0] - low) * scale, (high - at[1]) * scale);
const there = point.matrixTransform(document.querySelector(".picture svg").getScreenCTM());
return [there.x, there.y];
"""


@pytest.fixture
def page(browser, serve):
    return Page(browser, serve())


def press(page, name):
    page.browser.find_element(By.XPATH, f"//*[@class='panel' or self::header]//button[.='{name}']").click()


def hold(page):
    """Stop the moving picture at the beginning."""
    page.browser.execute_script(
        "const f = document.querySelector('.phase'); f.value = 0; f.dispatchEvent(new Event('input'))"
    )


def mouse_on(page, joint):
    """Return actions that begin on a joint of the picture, at the beginning of the shown part."""
    hold(page)
    of = next(one for name, one in page.server.answers._pages.items() if name and one._result is not None)
    picture = of.picture(of._shown[0])
    body, x, y = picture["joints"][joint]
    given = {key: picture[key] for key in ("low", "high", "scale")} | {"at": [body, x, y]}
    left, top = page.browser.execute_script(PLACE, given | {"pose": picture["poses"][0][int(body)]})
    actions = ActionChains(page.browser)
    actions.w3c_actions.pointer_action.move_to_location(round(left), round(top))
    return actions


def test_a_click_on_a_joint_makes_it_lubricated(page):
    """It gets a bearing of the size of the others, and rows for its values; undo takes all away."""
    mouse_on(page, "C2").click().perform()
    assert {legend.text for legend in page.browser.find_elements(By.CSS_SELECTOR, ".panel legend")} == {
        "joint C2",
        "joint C3",
    }  # both are there
    press(page, "mixed")
    page.wait(lambda: page.browser.find_elements(By.CSS_SELECTOR, '[data-path="joints.C2.clearance"]'))
    page.settle()
    assert float(page.field("joints.C2.clearance").get_attribute("value")) == pytest.approx(3e-5)
    assert "C2.eccentricity_ratio" in page.table()
    page.button("undo")
    page.settle()
    assert not page.one('[data-path="joints.C2.clearance"]').is_displayed()
    assert "C2.eccentricity_ratio" not in page.table()
    page.button("redo")
    page.settle()
    assert page.one('[data-path="joints.C2.clearance"]').is_displayed()


def test_the_model_of_a_row_brings_what_it_needs(page):
    """The file has no contact for A: the list of its models offers dry nevertheless."""
    field = page.one('[data-path="joints.A.model"] select')
    field.send_keys("dry")
    page.browser.execute_script("arguments[0].dispatchEvent(new Event('change', {bubbles: true}))", field)
    page.wait(lambda: page.browser.find_elements(By.CSS_SELECTOR, '[data-path="joints.A.contact.restitution"]'))
    page.settle()
    assert page.error == ""
    assert page.one('[data-path="joints.A.model"] select').get_attribute("value") == "dry"


def test_a_dragged_pin_changes_the_lengths_in_one_step_of_undo(page):
    before = page.server.answers.session.system.value("sdf.frames.link6_D.pose.x")
    actions = mouse_on(page, "D").click_and_hold()
    for _ in range(4):
        actions = actions.move_by_offset(5, 0).pause(0.1)
    actions.release().perform()
    page.wait(lambda: page.one("main").get_attribute("aria-busy") == "false")
    page.search("link6_D.pose.x")
    after = float(page.field("sdf.frames.link6_D.pose.x").get_attribute("value"))
    assert before + 0.03 < after < before + 0.05  # 20 pixels, also while the picture is drawn again
    page.button("undo")
    page.settle()
    assert float(page.field("sdf.frames.link6_D.pose.x").get_attribute("value")) == pytest.approx(before)


def test_a_link_of_the_list_shows_its_values(page):
    page.one('[aria-label="joint or link"]').send_keys("link link2")
    page.button("edit")
    assert page.one(".panel h2").text == "link link2"
    press(page, "its values")
    values = [hit.get_attribute("title") for hit in page.browser.find_elements(By.CSS_SELECTOR, ".hits button")]
    assert "sdf.links.link2.mass" in values
    assert "sdf.frames.link2_C.pose.x" in values
    page.button("edit")
    assert page.browser.switch_to.active_element.text == "link link2"
    page.browser.switch_to.active_element.send_keys(Keys.ESCAPE)
    assert not page.one(".panel").is_displayed()
    assert page.browser.switch_to.active_element.text == "edit"


def test_a_sweep_is_drawn(page):
    page.one('[data-path="joints.A.viscosity"] .slider button').click()
    page.wait(lambda: page.browser.find_elements(By.CSS_SELECTOR, ".panel .plots svg"))
    assert len(page.browser.find_elements(By.CSS_SELECTOR, ".panel .point")) == 21
    titles = [dot.get_attribute("textContent") for dot in page.browser.find_elements(By.CSS_SELECTOR, ".panel .point")]
    middle = float(titles[10].split(": ")[1])
    assert middle == pytest.approx(float(page.table()["A.force"]["now"]), rel=1e-4)


def test_tolerances_are_bands(page):
    page.button("tolerances")
    press(page, "close")
    page.button("tolerances")
    fields = page.browser.find_elements(By.CSS_SELECTOR, ".panel input")
    fields[1].send_keys(Keys.CONTROL + "a")
    fields[1].send_keys("8")
    press(page, "run")
    page.wait(lambda: page.browser.find_elements(By.CSS_SELECTOR, ".panel table"))
    assert "8 runs" in page.one(".panel p").text
    assert page.browser.find_elements(By.CSS_SELECTOR, ".curves .band")


@pytest.mark.slow  # derivatives
def test_sensitivities_are_bars(page):
    page.search("sdf.links.link2.mass")
    page.button("sensitivities")
    page.wait(lambda: page.browser.find_elements(By.CSS_SELECTOR, ".panel .bars"))
    first = page.one(".panel .bars tbody button")
    assert first.get_attribute("title") == "sdf.links.link2.mass"  # of the force in A


def test_a_notebook_is_written(page, tmp_path):
    page.type("joints.A.clearance", "2e-4")
    page.button("notebook")
    press(page, "write")
    page.wait(lambda: page.state.startswith("written"))
    (file,) = tmp_path.iterdir()
    assert "'joints.A.clearance': 0.0002" in "".join(json.loads(file.read_text())["cells"][0]["source"])
    assert "linkages.load" in page.one(".panel pre").text


def test_a_report_has_pinned_runs_and_notes(page):
    """The page that is downloaded is complete: it loads nothing."""
    page.browser.execute_script(
        "window.written = []; const make = URL.createObjectURL;"
        "URL.createObjectURL = (blob) => { blob.text().then((text) => window.written.push(text)); return make(blob); };"
    )
    page.button("pin")
    page.type("joints.A.clearance", "2e-4")
    page.button("notes")
    page.one(".panel textarea").send_keys("thin & fast")
    press(page, "close")
    page.button("report")
    text = page.wait(lambda: page.browser.execute_script("return window.written[0]"))
    for part in ("thin &amp; fast", "pin 1", "now", "joints.A.clearance", "<svg", "Force in A", "linkages "):
        assert part in text
    assert not re.search(r'(?:src|href)="(?!data:|#)', text)
    assert "<curves" not in text
