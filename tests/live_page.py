"""A live page in a browser, as tests operate it."""

import json
from urllib.parse import quote

from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import WebDriverWait

_PATIENCE = 60.0  # [s]


class Page:
    """A live page in a browser."""

    def __init__(self, browser, server, units="SI units"):
        self.browser, self.server = browser, server
        browser.get(f"{server.address}live.css")  # of the same host, whose cookies keep choices
        browser.delete_all_cookies()
        browser.add_cookie({"name": "linkages-units", "value": quote(json.dumps(units))})
        browser.get(server.address)
        self.settle()

    def one(self, selector):
        return self.browser.find_element(By.CSS_SELECTOR, selector)

    def all(self, selector):
        return self.browser.find_elements(By.CSS_SELECTOR, selector)

    def wait(self, found):
        return WebDriverWait(self.browser, _PATIENCE, 0.05).until(lambda _: found())

    def settle(self):
        """Wait until the page shows the steady motion of its values."""
        self.wait(lambda: self.one("main").get_attribute("aria-busy") == "false")

    @property
    def state(self):
        return self.one(".state").text

    @property
    def error(self):
        return self.one(".error").text

    def button(self, name):
        self.browser.find_element(By.XPATH, f"//header//button[.='{name}']").click()

    def opacity(self, selector):
        return float(self.one(selector).value_of_css_property("opacity"))

    def field(self, path):
        return self.one(f'[data-path="{path}"] .typed')

    def type(self, path, text):
        """Type a value, and wait until the page shows its run."""
        field = self.field(path)
        field.send_keys(Keys.CONTROL + "a")
        field.send_keys(text, Keys.ENTER)
        self.settle()

    def table(self):
        """Return the texts of the table by name: now, of the compared run, change."""
        script = """return Object.fromEntries([...document.querySelectorAll(".numbers tbody tr")].map((row) =>
            [row.dataset.name, Object.fromEntries(["now", "other", "change"].map((kind) =>
                [kind, row.querySelector(`.${kind}`).firstChild.textContent]))]));"""
        return self.browser.execute_script(script)

    def search(self, text):
        """Search a value, and show the first hit."""
        self.one(".search input").send_keys(text, Keys.ENTER)
