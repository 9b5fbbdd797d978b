// Elements of the page, numbers as text, and choices that last.

const SVG = "http://www.w3.org/2000/svg";
const YEAR = 31536000; // [s]

export function g(value, digits = 5) { // as Python's format(value, ".5g")
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const exponent = Number(value.toExponential(digits - 1).split("e")[1]);
  if (exponent >= -4 && exponent < digits) return String(Number(value.toPrecision(digits)));
  const [mantissa, power] = value.toExponential(digits - 1).split("e");
  return `${Number(mantissa)}e${power[0]}${power.slice(1).padStart(2, "0")}`;
}
export function product(factor, value) { // no value is not zero
  return Number.isFinite(value) ? factor * value : NaN;
}
export function percent(value, other) {
  if (value === null || !other) return "–";
  const change = 100 * (value / other - 1), size = Math.abs(change);
  if (size < 5e-4 || size > 1e6) return size < 1 ? "0 %" : "≫"; // less than the digits of the table; `other` is rounding
  return `${change > 0 ? "+" : "−"}${Number(size.toPrecision(3))} %`;
}
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
export function draw(tag, attributes) {
  const element = document.createElementNS(SVG, tag);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
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
export function select(options, chosen) {
  const element = make("select", {}, ...options.map((option) => make("option", {value: option}, option)));
  element.value = chosen;
  return element;
}
export function ask(dialog, title, fields, action, replaces = false) { // promise of the texts of the fields, and whether a file is replaced
  const inputs = fields.map(([, value]) => make("input", {value})), tick = make("input", {type: "checkbox"});
  const form = make("form", {method: "dialog"}, make("p", {}, title), ...fields.map(([label], k) => make("label", {}, `${label} `, inputs[k])),
    ...(replaces ? [make("label", {}, tick, " replace a file of this name")] : []),
    make("div", {class: "buttons"}, button("cancel", () => dialog.close(), "Escape"), make("button", {}, action)));
  dialog.replaceChildren(form);
  dialog.showModal();
  inputs[0].select();
  return new Promise((done) => form.addEventListener("submit", () => done([...inputs.map(({value}) => value), tick.checked])));
}
export function download(name, text, type) {
  const link = make("a", {href: URL.createObjectURL(new Blob([text], {type})), download: name});
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}
export function kept(key, value) { // keeps a choice if it is given; cookies, unlike other storage, are the same for all ports
  try { // a frame of a notebook may forbid them
    if (value !== undefined) document.cookie = `linkages-${key}=${encodeURIComponent(JSON.stringify(value))}; path=/; max-age=${YEAR}; SameSite=Strict`;
    const found = document.cookie.split("; ").find((one) => one.startsWith(`linkages-${key}=`));
    return JSON.parse(decodeURIComponent(found.split("=")[1]));
  } catch { return value; }
}
