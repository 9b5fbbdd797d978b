// Panels of the page: borders that move, panels that can be hidden, units, light and dark.

import {kept, make, select, toggle} from "./dom.js";
import {SYSTEMS} from "./words.js";

const BORDERS = { // the size that a border changes: its axis, the side from which it is measured
  left: ["clientX", "left"], right: ["clientX", "right"], low: ["clientY", "bottom"],
};
const LABELS = {left: "width of the controls", right: "width of the numbers", low: "height of the curves"};
const STEP = 20; // of a border that is moved by a key [px]
const PANELS = ["controls", "joints", "curves", "numbers"];

export function layout(page) {
  const panels = page.at(".layout"), {state} = page, sizes = kept("sizes") ?? {}, hidden = kept("hidden") ?? [];
  const resize = (name, size) => {
    const box = panels.getBoundingClientRect(), whole = name === "low" ? box.height : box.width;
    sizes[name] = Math.round(Math.min(Math.max(size, 120), 0.6 * whole));
    panels.style.setProperty(`--${name}`, `${sizes[name]}px`);
    page.at(`.border.${name}`).setAttribute("aria-valuenow", sizes[name]);
  };
  const sizeNow = (name) => page.at({left: ".controls", right: ".numbers", low: ".curves"}[name]).getBoundingClientRect()[name === "low" ? "height" : "width"];
  for (const [name, [axis, side]] of Object.entries(BORDERS)) {
    const border = make("div", {class: `border ${name}`, role: "separator", tabindex: 0, "aria-label": LABELS[name], "aria-valuenow": sizes[name] ?? 0,
      "aria-orientation": name === "low" ? "horizontal" : "vertical", title: `${LABELS[name]}: drag, or arrow keys`});
    border.addEventListener("pointerdown", (event) => { border.setPointerCapture(event.pointerId); event.preventDefault(); border.focus(); });
    border.addEventListener("pointermove", (event) => {
      if (border.hasPointerCapture(event.pointerId)) resize(name, Math.abs(event[axis] - panels.getBoundingClientRect()[side]));
    });
    border.addEventListener("pointerup", () => kept("sizes", sizes));
    border.addEventListener("keydown", (event) => {
      const more = {left: ["ArrowRight", "ArrowLeft"], right: ["ArrowLeft", "ArrowRight"], low: ["ArrowUp", "ArrowDown"]}[name].indexOf(event.key);
      if (more < 0) return;
      event.preventDefault();
      resize(name, sizeNow(name) + (more ? -STEP : STEP));
      kept("sizes", sizes);
    });
    panels.append(border);
    if (sizes[name]) panels.style.setProperty(`--${name}`, `${sizes[name]}px`);
  }
  const settings = page.at(".settings");
  for (const name of PANELS) {
    const set = (shown) => panels.classList.toggle(`no-${name}`, !shown);
    set(!hidden.includes(name));
    settings.append(toggle(name, (shown) => {
      set(shown);
      kept("hidden", PANELS.filter((one) => panels.classList.contains(`no-${one}`)));
    }, `show or hide the ${name}`, !hidden.includes(name)));
  }
  const choice = (label, options, key, set) => {
    const field = select(options, kept(key) ?? options[0]);
    field.setAttribute("aria-label", label);
    field.title = label;
    field.addEventListener("change", () => set(kept(key, field.value) ?? field.value));
    settings.append(field);
    set(field.value);
  };
  choice("units", SYSTEMS, "units", (value) => { state.units = value; page.root.dispatchEvent(new CustomEvent("units")); });
  choice("colours", ["system", "light", "dark"], "colours", (value) => { page.root.style.colorScheme = {light: "light", dark: "dark"}[value] ?? ""; });
}
