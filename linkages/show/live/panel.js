// The panel at the side, for all that is asked and found beside the machine: it covers no number, and Escape closes it.

import {button, make} from "./dom.js";

export function panel(page) {
  const holder = page.at(".panel");
  let opener = null; // what had the focus before
  holder.addEventListener("keydown", (event) => { if (event.key === "Escape") close(); });

  function open(title, content, ...tools) {
    if (holder.hidden) opener = document.activeElement;
    const heading = make("h2", {tabindex: -1}, title), head = make("div", {class: "head"}, heading, ...tools, button("close", close, "Escape"));
    holder.setAttribute("aria-label", title);
    holder.replaceChildren(head, ...content);
    holder.hidden = false;
    heading.focus();
  }
  function close() {
    if (holder.contains(document.activeElement)) opener?.focus();
    holder.hidden = true;
    holder.replaceChildren();
  }
  function form(title, text, fields, action, replaces = false) { // promise of the texts of the fields, and whether a file is replaced
    const inputs = fields.map(([, value]) => make("input", {value})), tick = make("input", {type: "checkbox"});
    const asking = make("form", {}, make("p", {}, text), ...fields.map(([label], k) => make("label", {}, `${label} `, inputs[k])),
      ...(replaces ? [make("label", {}, tick, " replace a file of this name")] : []), make("button", {}, action));
    open(title, [asking]);
    inputs[0].select();
    return new Promise((done) => asking.addEventListener("submit", (event) => {
      event.preventDefault();
      close();
      done([...inputs.map(({value}) => value), tick.checked]);
    }));
  }
  return {open, close, form};
}
