// Exploring and keeping on the live page: sweeps, sensitivities, tolerances; notebooks, reports, notes. See joints.js.

import {drawCurves, number} from "./curves.js";
import {button, download, make, scaled, select, table} from "./dom.js";

const RUNS = 500, MOST = 40; // runs of tolerances, values of one request

export function explore(page) {
  const {root, at, send, state} = page;
  let output = null, notes = ""; // the output that was chosen last
  const paragraph = (text) => make("p", {}, text);
  const ineffective = ({without}) => Object.entries(without).map(([path, why]) => paragraph(`${page.labelOf(path)}: ${why}.`));

  // -- requests of many runs

  async function compute(what, kind, request) { // shows the progress, and can be stopped
    const progress = make("p", {role: "status"}, "computing ...");
    page.open(what, [progress], button("stop", () => { send("stop", {}).catch(() => {}); page.close(); }, "give up"));
    const telling = setInterval(async () => {
      const {said} = await send("status", {}).catch(() => ({}));
      if (said) progress.textContent = said;
    }, 300);
    const reply = await page.ask(kind, {values: state.values, ...request});
    clearInterval(telling);
    if (!reply.error && !reply.outdated) return reply;
    page.close();
    return null;
  }
  function present(what, {labels}, content, owner = "") { // content(output) is drawn for the chosen output; at first one of the owner of a value
    const names = Object.keys(labels), usual = [`${owner}.force`, `${owner}.stress`, output, names.find((name) => name.endsWith(".force"))];
    const holder = make("div", {class: "explored"}), show = (name) => { output = name; holder.replaceChildren(...content(name)); };
    const first = usual.find((name) => names.includes(name)) ?? names[0];
    page.open(what, [select(Object.entries(labels), first, "output", show), holder]);
    holder.replaceChildren(...content(first));
  }
  function shownNumbers() { // paths of the numbers that rows show, without drives
    const able = ({path, choices, whole}) => !choices.length && !whole && page.valueOf(path) !== null && !path.startsWith("drives.");
    return state.shown.filter((path) => able(state.controls.get(path)));
  }

  // -- sweep

  root.addEventListener("row", ({detail: {row, control}}) => {
    if (!control.choices.length) row.querySelector(".slider").append(button("sweep", () => sweep(control), "peaks over the range of this slider"));
  });
  async function sweep({path, label, low, high, unit: si, logarithmic}) {
    const what = `Sweep: ${label}`, reply = await compute(what, "sweep", {path, low, high}), [unit, factor] = page.unitOf(si);
    if (reply) present(what, reply, (name) => {
      const [outUnit, outFactor] = page.unitOf(reply.units[name]), here = page.valueOf(path), holder = make("div", {class: "plots"});
      const run = {time: reply.values.map((value) => factor * value), values: reply.peaks[name].map((peak) => scaled(outFactor, peak))};
      const curve = {name, label: `Peak of ${reply.labels[name]}`, unit: outUnit, run};
      const set = (x) => page.change({[path]: Number((x / factor).toPrecision(6))});
      if (run.values.every((value) => value === null)) holder.append(paragraph("no run reaches its end"));
      else requestAnimationFrame(() => {
        const plot = drawCurves(holder, [curve], () => {}, {unit, logarithmic, dots: true});
        if (typeof here === "number") plot.point(factor * here);
      });
      const now = scaled(outFactor, state.view.table?.find((row) => row.name === name)?.value);
      return [holder, target(run, now, unit, outUnit, logarithmic, set), ...failures(reply.reasons, run.time, unit)];
    }, path.replace(/^sdf\./, "").split(".")[1]);
  }
  function failures(reasons, places, unit) {
    const failed = reasons.filter(Boolean), ends = places.filter((_, k) => !reasons[k]).map((x) => number(x));
    const reach = `${failed.length} of ${places.length} runs fail, all but ${ends[0] ?? "-"} to ${ends.at(-1) ?? "-"} ${unit}`;
    return failed.length ? [paragraph(`${reach}; set such a value to see where. The first: ${failed[0].split(";")[0]}`)] : [];
  }
  function target({time, values}, now, unit, outUnit, logarithmic, use) { // where the peak has a wanted value, by interpolation between the runs
    const hint = `such as "× 2", "−10 %" or a number in ${outUnit || "1"}`, found = make("span", {role: "status"});
    const field = make("input", {size: 8, class: "target", placeholder: "× 2", "aria-label": "wanted peak", title: hint});
    field.addEventListener("input", () => {
      const [, times, typed, part] = /^\s*([×x*]?)\s*([-+]?[\d.]+)\s*(%?)\s*$/.exec(field.value.replace("−", "-")) ?? [];
      const wanted = (times ? now : part ? now / 100 : 1) * (Number(typed) + (part ? 100 : 0));
      if (!Number.isFinite(wanted)) return found.replaceChildren(hint);
      const places = time.slice(1).flatMap((x1, k) => {
        const [x0, y0, y1] = [time[k], values[k], values[k + 1]], share = (wanted - y0) / (y1 - y0);
        if (y0 === null || y1 === null || y0 < wanted === y1 < wanted) return [];
        return [logarithmic ? x0 * (x1 / x0) ** share : x0 + share * (x1 - x0)];
      });
      const said = places.length ? "has the value at" : "is reached nowhere in this range";
      found.replaceChildren(` ${number(wanted)} ${outUnit} ${said} `, ...places.map((x) => button(`${number(x)} ${unit}`, () => use(x), "set this value")));
    });
    return make("p", {}, "Where is the peak ", field, found);
  }

  // -- sensitivities and tolerances

  async function sensitivities(paths) {
    const what = "Which value matters most", reply = await compute(what, "sensitivities", {paths});
    if (!reply) return;
    const lengths = [...state.controls.values()].filter(({path, unit, aside}) => ["m", "kg"].includes(unit) && page.valueOf(path) && !aside);
    const all = [...new Set([...shownNumbers(), ...lengths.map(({path}) => path)])].slice(0, MOST);
    present(what, reply, (name) => {
      const found = Object.entries(reply.changes).map(([path, of]) => [path, of[name]]).sort(([, a], [, b]) => Math.abs(b ?? 0) - Math.abs(a ?? 0));
      const most = Math.max(...found.map(([, value]) => Math.abs(value ?? 0)), 1e-12);
      const bar = (value) => make("meter", {class: value < 0 ? "negative" : "", min: 0, max: most, value: Math.abs(value), "aria-label": "size"});
      const rows = found.map(([path, value]) => [button(page.labelOf(path), () => page.pick(path), path), number(value, 3),
        value === null ? make("small", {}, reply.reasons[path][name]) : bar(value)]);
      const more = button(`all ${all.length} values with lengths and masses`, () => sensitivities(all), "may take half a minute");
      return [...(all.length > paths.length ? [more] : []), paragraph(`Change of the peak of ${reply.labels[name]} [%] when a value grows by 1 %:`),
        ...(found.some(([, value]) => value === null) ? [paragraph(reply.why)] : []), table([], rows, {class: "bars"}), ...ineffective(reply)];
    });
  }
  async function tolerances() {
    const fields = [["of each shown value [%], three standard deviations", "1"], ["runs", String(RUNS)]];
    const asked = await page.form("Tolerances", "Scattered values and their runs:", fields, "run"), [part, runs] = asked.map(Number);
    const spreads = Object.fromEntries(shownNumbers().map((path) => [path, part / 300]));
    const what = `Tolerances of ±${number(part, 3)} %`, reply = await compute(what, "tolerances", {spreads, runs});
    if (!reply) return;
    state.bands = reply;
    root.dispatchEvent(new CustomEvent("pinned")); // the curves have their bands
    const rows = Object.entries(reply.peaks).map(([name, {mean, deviation, quantiles}]) => {
      const [unit, factor] = page.unitOf(reply.units[name]);
      return [reply.labels[name], ...[mean, deviation, ...quantiles].map((one) => number(scaled(factor, one))), unit];
    });
    const failed = reply.failed ? `, ${reply.failed} failed` : "", scattered = Object.keys(reply.spreads).map(page.labelOf).join(", ");
    page.open(what, [paragraph(`${reply.runs} runs${failed}; the curves show the band of 90 % of them. Scattered: ${scattered}.`),
      ...ineffective(reply), table(["peak of", "mean", "deviation", "5 %", "median", "95 %", "unit"], rows)]);
  }

  // -- keeping

  async function notebook() {
    const [name, replace] = await page.form("Notebook", `Write a notebook in ${state.start.folder}:`, [["name", state.start.name]], "write", true);
    const reply = await page.ask("notebook", {values: state.values, name, replace});
    if (reply.error) return;
    page.note(`written: ${reply.written}; ${reply.command}`);
    page.open("Code of this state", [make("pre", {tabindex: 0}, reply.code)], button("copy", () => navigator.clipboard?.writeText(reply.code), "copy the code"));
  }
  async function report() {
    const all = [...state.pins, {name: "now", values: state.values, view: state.view}];
    const runs = all.map(({name, values, view}) => ({name, values, peaks: Object.fromEntries((view.table ?? []).map((row) => [row.name, row.value]))}));
    const reply = await page.ask("report", {values: state.values, runs, notes, units: root.querySelector("[aria-label=units]").value});
    if (reply.error) return;
    download(`${state.start.name}.html`, reply.page.replace("<!-- curves -->", () => at(".plots").outerHTML), "text/html");
    page.note("a page with the pinned runs is downloaded; print it for a PDF");
  }
  function note() {
    const text = make("textarea", {rows: 8, "aria-label": "notes"});
    text.value = notes;
    text.addEventListener("input", () => { notes = text.value; });
    page.open("Notes for the report", [text]);
  }
  at(".tools").append(button("sensitivities", () => sensitivities(shownNumbers()), "which value matters most"),
    button("tolerances", tolerances, "bands of scattered values"), button("notebook", notebook, "code that repeats this state"),
    button("report", report, "one page with the pinned runs, for print"), button("notes", note, "notes for the report"));
}
