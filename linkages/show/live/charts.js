// Curves over time of the run, the pinned runs and ideal joints, or their difference from the compared run.

import {drawCurves, legend, valueAt} from "./curves.js";
import {button, make, scaled, toggle} from "./dom.js";

const CAPTION = 34, NARROW = 256, SMALLEST = [125, 50]; // heights and widths of figures [px]

export function charts(page) {
  const {root, at, state} = page;
  let names = "", difference = false, height = null; // of figures, if all are seen at once
  const high = (width) => height ?? Math.min(190, 60 + 0.3 * width);
  at(".curves").append(
    make("div", {class: "head"}, make("h2", {}, "Curves"), button("whole time", () => state.plots?.all(), "show the whole time (0)"),
      toggle("difference", (on) => { difference = on; show(); }, "show the run minus the compared run"), make("p")),
    make("div", {class: "plots"}));

  function show() {
    const {view} = state;
    if (!view?.curves.length) return;
    const curves = view.curves.filter(({unit}) => view.locked === null || ["m", "rad"].includes(unit)).map(shown), now = curves.map(({name}) => name).join(" ");
    legend(at(".curves .head p"), curves);
    if (state.plots && names === now) return state.plots.update(curves);
    arrange(curves.length);
    state.plots = drawCurves(at(".plots"), curves, (time) => page.hold(time / (state.view.to - state.view.from)), {high});
    names = now;
  }
  function arrange(count) { // the columns with which all figures are seen and are large; else they scroll
    const panel = at(".curves"), plots = at(".plots"), width = plots.clientWidth, whole = panel.clientHeight - (plots.offsetTop - panel.offsetTop);
    const sizes = Array.from({length: count}, (_, k) => [k + 1, width / (k + 1), whole / Math.ceil(count / (k + 1)) - CAPTION]);
    const fitting = at(".border.low").checkVisibility() ? sizes.filter(([, wide, tall]) => wide >= SMALLEST[0] && tall >= SMALLEST[1]) : [];
    const [best] = fitting.sort((a, b) => Math.min(b[1], 3 * b[2]) - Math.min(a[1], 3 * a[2]));
    plots.style.setProperty("--columns", best?.[0] ?? Math.max(1, Math.floor(width / NARROW)));
    height = best ? Math.min(best[2], 0.6 * best[1]) : null;
  }
  function shown({name, label, unit: si, run, ideal, measured}) {
    const [unit, factor] = page.unitOf(si), reference = page.reference();
    const inUnit = (line) => line && {time: line.time, values: line.values.map((value) => scaled(factor, value))};
    const of = (pinned) => pinned.view.curves.find((curve) => curve.name === name)?.run, other = reference ? of(reference) : ideal;
    if (difference) return {name, label: `${label} minus ${reference?.name ?? "ideal"}`, unit, run: inUnit(other ? minus(run, other) : run)};
    const others = state.pins.filter(of).map((pinned) => ({...inUnit(of(pinned)), look: pinned.look, name: pinned.name}));
    const {time, bands} = state.bands ?? {}, [low, , top] = (bands?.[name] ?? []).map((values) => inUnit({values}).values);
    const band = low && {time, low, high: top}, color = state.start.colors[name.split(".")[0]];
    return {name, label, unit, run: inUnit(run), ideal: inUnit(ideal), measured: inUnit(measured), others, band, color};
  }
  new ResizeObserver(() => { if (state.plots) { arrange(at(".plots").children.length); state.plots.fit(); } }).observe(at(".curves"));
  for (const event of ["shown", "units", "pinned"]) root.addEventListener(event, show);
}

function minus(run, other) {
  const end = Math.min(run.time.at(-1), other.time.at(-1));
  const time = [...new Set([...run.time, ...other.time])].filter((t) => t <= end).sort((a, b) => a - b);
  const values = time.map((t) => [valueAt(run, t), valueAt(other, t)]);
  return {time, values: values.map((pair) => (pair.includes(null) ? null : pair[0] - pair[1]))};
}
