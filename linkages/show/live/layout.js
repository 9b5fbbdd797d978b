// Panels of the page: borders that move, panels that can be hidden, units, light and dark.

import {kept, make, select, toggle} from "./dom.js";

const BORDERS = { // what a border changes; the axis and the side from which it is measured; keys that make it larger, smaller
  left: ["width of the values", "clientX", "left", "ArrowRight", "ArrowLeft"],
  right: ["width of the peaks", "clientX", "right", "ArrowLeft", "ArrowRight"],
  low: ["height of the curves", "clientY", "bottom", "ArrowUp", "ArrowDown"],
};
const MOVE = 20, THINNEST = 120, WIDEST = 0.6; // way of a border with a key, least size [px], most of the page
const PANELS = ["controls", "joints", "curves", "numbers"];

export function layout(page) {
  const {root, state} = page, panels = page.at(".layout"), sizes = kept("sizes") ?? {}, hidden = kept("hidden") ?? [];
  const sized = {left: page.at(".side"), right: page.at(".numbers"), low: page.at(".curves")};

  for (const [name, [label, axis, side, larger, smaller]] of Object.entries(BORDERS)) {
    const across = axis === "clientX", border = make("div", {class: `border ${name}`, role: "separator", tabindex: 0, "aria-label": label,
      "aria-valuenow": sizes[name] ?? 0, "aria-orientation": across ? "vertical" : "horizontal", title: `${label}: drag, or arrow keys`});
    const resize = (size) => {
      const box = panels.getBoundingClientRect(), whole = across ? box.width : box.height;
      sizes[name] = Math.round(Math.min(Math.max(size, THINNEST), WIDEST * whole));
      panels.style.setProperty(`--${name}`, `${sizes[name]}px`);
      border.setAttribute("aria-valuenow", sizes[name]);
      kept("sizes", sizes);
    };
    border.addEventListener("pointerdown", (event) => { border.setPointerCapture(event.pointerId); event.preventDefault(); border.focus(); });
    border.addEventListener("pointermove", (event) => {
      if (border.hasPointerCapture(event.pointerId)) resize(Math.abs(event[axis] - panels.getBoundingClientRect()[side]));
    });
    border.addEventListener("keydown", ({key}) => {
      const box = sized[name].getBoundingClientRect(), way = {[larger]: MOVE, [smaller]: -MOVE}[key];
      if (way) resize((across ? box.width : box.height) + way);
    });
    panels.append(border);
    if (sizes[name]) panels.style.setProperty(`--${name}`, `${sizes[name]}px`);
  }
  const show = (name, shown) => panels.classList.toggle(`no-${name}`, !shown);
  const toggles = PANELS.map((name) => {
    show(name, !hidden.includes(name));
    return toggle(name, (shown) => {
      show(name, shown);
      kept("hidden", PANELS.filter((one) => panels.classList.contains(`no-${one}`)));
    }, `show or hide the ${name}`, !hidden.includes(name));
  });
  const paint = (value) => { root.style.colorScheme = {light: "light", dark: "dark"}[kept("colours", value)] ?? ""; };
  page.at(".settings").append(...toggles, select(["system", "light", "dark"], kept("colours") ?? "system", "colours", paint));
  paint();

  root.addEventListener("ready", () => { // the server knows the systems of units
    const {units} = state.start, names = Object.keys(units);
    const choose = (name) => {
      state.units = units[kept("units", name)] ?? units[names[0]];
      root.dispatchEvent(new CustomEvent("units"));
    };
    page.at(".settings").append(select(names, kept("units") ?? names[0], "units", choose));
    choose();
  });
}
