// Elements of the page, units, changes as text, and choices that last.

import {number} from "./curves.js";

const YEAR = 31536000; // [s]
const MULTIPLE = 2, SAME = 1e-4, NOTHING = 1e-9; // ratio that is a multiple; relative changes that are neglected, or none

export function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  element.append(...children);
  return element;
}
export function marked(element, color) { // with the colour of a link
  if (color) Object.assign(element.style, {boxShadow: `inset 4px 0 ${color}`, paddingLeft: "8px"});
  return element;
}
export function button(text, action, title) {
  const element = make("button", {type: "button", title}, text);
  element.addEventListener("click", action);
  return element;
}
export function toggle(text, action, title, pressed = false) { // action gets whether it is pressed now
  const element = button(text, () => {
    const now = element.getAttribute("aria-pressed") !== "true";
    element.setAttribute("aria-pressed", now);
    action(now);
  }, title);
  element.setAttribute("aria-pressed", pressed);
  return element;
}
export function select(options, chosen, label, action) { // options are texts, or pairs of a value and its text
  const element = make("select", label ? {"aria-label": label, title: label} : {}, ...options.map((option) => {
    const [value, text] = [option].flat();
    return make("option", {value}, text ?? value);
  }));
  element.value = chosen;
  if (action) element.addEventListener("change", () => action(element.value));
  return element;
}
export function table(heads, rows, attributes = {}) { // the first cell of a row names it
  const cells = ([first, ...others]) => [make("th", {scope: "row"}, first), ...others.map((cell) => make("td", {}, cell))];
  const head = make("tr", {}, ...heads.map((one) => (one instanceof Element ? one : make("th", {scope: "col"}, one))));
  return make("table", attributes, make("thead", {}, head), make("tbody", {}, ...rows.map((row) => make("tr", {}, ...cells(row)))));
}
export function download(name, text, type) {
  const link = make("a", {href: URL.createObjectURL(new Blob([text], {type})), download: name});
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}
export function kept(key, value) { // keeps a choice if it is given; cookies, unlike other storage, are the same for all ports
  try { // a frame of a notebook may forbid them
    const text = encodeURIComponent(JSON.stringify(value));
    if (value !== undefined) document.cookie = `linkages-${key}=${text}; path=/; max-age=${YEAR}; SameSite=Strict`;
    const found = document.cookie.split("; ").find((one) => one.startsWith(`linkages-${key}=`));
    return JSON.parse(decodeURIComponent(found.split("=")[1]));
  } catch { return value; }
}
export function scaled(factor, value) { // no value is not zero
  return Number.isFinite(value) ? factor * value : null;
}
export function changeOf(now, before) { // as the terminal's tables
  if (now === null || !before || before < NOTHING * now) return "-";
  const ratio = now / before, part = Math.abs(ratio - 1);
  if (ratio >= MULTIPLE) return `${number(ratio, 3)} ×`;
  if (part < SAME) return part ? "< 0.01 %" : "0 %";
  return `${ratio > 1 ? "+" : "−"}${number(100 * part, 2)} %`;
}
