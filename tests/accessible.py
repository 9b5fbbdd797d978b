"""What a page needs so that everybody can use it, as far as a script in the page can tell.

`faults` runs axe-core too, if the environment variable AXE_CORE is the path of its ``axe.min.js`` (``npm pack axe-core``).
"""

import os
from pathlib import Path

# Ratio of contrast by WCAG 2.1: of texts, and of lines and edges, to the colour behind them; with what they are.
CONTRASTS = """
const numbers = (color) => color.match(/[\\d.]+/g).map(Number);
const part = (value) => (value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4);
const luminance = (color) => numbers(color).slice(0, 3).reduce((sum, v, k) => sum + [0.2126, 0.7152, 0.0722][k] * part(v / 255), 0);
const behind = (element) => {
  if (!element) return "rgb(255, 255, 255)";
  const color = getComputedStyle(element).backgroundColor;
  return numbers(color)[3] === 0 ? behind(element.parentElement) : color;
};
const ratio = (color, back) => {
  const [low, high] = [luminance(color), luminance(back)].sort((a, b) => a - b);
  return (high + 0.05) / (low + 0.05);
};
const seen = (element) => element.checkVisibility() && !element.closest(":disabled, title, option, canvas, [aria-hidden]");
const texts = [], edges = [];
for (const element of document.querySelectorAll("main *, header *")) {
  if (!seen(element)) continue;
  const style = getComputedStyle(element), name = `${element.tagName} ${element.getAttribute("class")} ${element.textContent.slice(0, 20)}`;
  if ([...element.childNodes].some((node) => node.nodeType === 3 && node.data.trim()) || element.matches("input, select"))
    texts.push([ratio(element instanceof SVGElement ? style.fill : style.color, behind(element)), name]);
  if (element.placeholder) texts.push([ratio(getComputedStyle(element, "::placeholder").color, behind(element)), `${name} placeholder`]);
  if (element.matches("button, select, input:not([type=range])") && style.borderStyle !== "none")
    edges.push([ratio(style.borderColor, behind(element.parentElement)), name]);
  if (element.matches(".curve, .orbit, .clearance, .cursor")) edges.push([ratio(style.stroke, behind(element)), name]);
}
return [texts, edges];
"""

# Faults of a page: language, title, width, landmarks, headings, names of controls and pictures, order of the focus.
STRUCTURE = """
const found = [], say = (fault, element) => found.push(element ? `${fault}: ${element.outerHTML.slice(0, 120)}` : fault);
const all = (selector) => [...document.querySelectorAll(selector)].filter((one) => one.checkVisibility());
const named = (one) => one.getAttribute("aria-label") || one.textContent.trim() || one.title || one.labels?.length || one.placeholder;
if (document.documentElement.lang !== "en") say("no language");
if (!document.title) say("no title");
if (!document.querySelector("meta[name=viewport]")) say("no viewport");
if (all("main").length !== 1) say(`${all("main").length} main landmarks`);
if (all("h1").length !== 1) say(`${all("h1").length} first headings`);
const levels = all("h1, h2, h3, h4").map((one) => Number(one.tagName[1]));
levels.forEach((level, k) => { if (k && level > levels[k - 1] + 1) say(`a heading of level ${level} follows one of ${levels[k - 1]}`); });
for (const one of all("button, input, select, textarea, a, summary, [role=separator], [role=region], section.panel")) if (!named(one)) say("no name", one);
for (const one of all("img")) if (!one.alt) say("no alternative", one);
for (const one of all("svg")) {
  const silent = one.closest("[aria-hidden=true]") || one.parentElement.closest("svg");
  if (!silent && !(one.getAttribute("role") === "img" && (one.getAttribute("aria-label") || one.querySelector("title")))) say("no name", one);
}
for (const one of all("iframe")) if (!one.title) say("no title", one);
for (const one of all("table")) if (![...one.querySelectorAll("th")].every((head) => head.textContent.trim())) say("an empty heading", one);
const ids = [...document.querySelectorAll("[id]")].map((one) => one.id);
if (new Set(ids).size < ids.length) say("an id stands twice");
for (const one of all("[tabindex]")) if (one.tabIndex > 0) say("an own place in the order of the focus", one);
for (const one of all("main *, header *")) {
  const scrolls = ["auto", "scroll"].includes(getComputedStyle(one).overflowY) && one.scrollHeight > one.clientHeight + 1;
  if (scrolls && one.tabIndex < 0 && !one.querySelector("button, input, select, a, [tabindex='0']")) say("scrolls without the keyboard", one);
}
for (const one of document.body.children)
  if (one.checkVisibility() && one.innerText?.trim() && !one.matches("main, header, nav, footer, dialog")) say("outside all landmarks", one);
return found;
"""


def prefer(browser, feature, value):
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [{"name": feature, "value": value}]})


def faults(browser):
    """Return the faults of the page that a browser shows."""
    found = browser.execute_script(STRUCTURE)
    texts, edges = browser.execute_script(CONTRASTS)
    found += [f"text with a contrast of {ratio:.2f}: {name}" for ratio, name in texts if ratio < 4.5]
    found += [f"line with a contrast of {ratio:.2f}: {name}" for ratio, name in edges if ratio < 3.0]
    return found


def axe_violations(browser):
    """Return the violations that axe-core finds; None where it is not available."""
    if not (path := os.environ.get("AXE_CORE")):
        return None
    browser.execute_script(Path(path).read_text(encoding="utf-8"))
    return browser.execute_async_script(
        """const done = arguments[0];
        axe.run(document, {resultTypes: ["violations"]}).then(({violations}) =>
            done(violations.map(({id, nodes}) => `${id}: ${nodes.map(({html}) => html.slice(0, 120)).join(" | ")}`)));"""
    )
