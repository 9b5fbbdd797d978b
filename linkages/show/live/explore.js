// Exploring and keeping on the live page: sweeps, sensitivities, tolerances; notebooks, reports, notes. See joints.js.

import {ask, button, download, draw, g, make, product, select} from "./dom.js";
import {labelOfOutput, labelOfPath, OUT_OF_PLANE, refusal, unitOf} from "./words.js";

const RUNS = 500; // of tolerances
const MOST = 40; // values of one request

export function explore(page) {
  const {root, at, send, state} = page;
  const shown = make("dialog", {class: "explore", "aria-label": "exploring"});
  root.append(shown);
  let output = null, notes = ""; // the output that was chosen last

  // -- requests of many runs -------------------------------------------------------------------------------------------

  async function compute(what, kind, request) { // shows the progress, and can be stopped
    const progress = make("p", {role: "status"}, "computing ...");
    shown.replaceChildren(make("h2", {}, what), progress,
      button("stop", () => { send("stop", {}).catch(() => {}); shown.close(); }, "give up"));
    if (!shown.open) shown.showModal();
    const telling = setInterval(async () => {
      const {said} = await send("status", {}).catch(() => ({}));
      if (said) progress.textContent = said;
    }, 300);
    const reply = await send(kind, {values: state.values, ...request}).catch(({message}) => ({error: `the server does not answer (${message})`}));
    clearInterval(telling);
    if (reply.error || reply.outdated) {
      shown.close();
      page.complain(refusal(reply, state.controls));
      return null;
    }
    return reply;
  }
  function present(what, outputs, content, owner = "") { // content(output) is drawn for the chosen output; at first one of the owner of a value
    const names = Object.keys(outputs), usual = [`${owner}.force`, `${owner}.stress`, output, names.find((name) => name.endsWith(".force"))];
    const chosen = select(names, usual.find((name) => names.includes(name)) ?? names[0]);
    [...chosen.options].forEach((option) => { option.textContent = labelOfOutput(option.value); });
    chosen.setAttribute("aria-label", "output");
    const holder = make("div", {class: "explored"}), show = () => holder.replaceChildren(...content(chosen.value));
    chosen.addEventListener("change", () => { output = chosen.value; show(); });
    shown.replaceChildren(make("div", {class: "head"}, make("h2", {}, what), chosen, button("close", () => shown.close(), "Escape")), holder);
    show();
  }
  const numbers = () => state.shown.filter((path) => {
    const control = state.controls.get(path);
    return !control.choices.length && !control.whole && typeof page.valueOf(path) !== "object" && !path.startsWith("drives.");
  });

  const everything = () => [...new Set([...numbers(), ...[...state.controls.values()].filter(({path, unit}) =>
    ["m", "kg"].includes(unit) && page.valueOf(path) && !OUT_OF_PLANE.test(path)).map(({path}) => path)])].slice(0, MOST);

  // -- sweep -----------------------------------------------------------------------------------------------------------

  root.addEventListener("row", ({detail: {row, control}}) => {
    if (control.choices.length) return;
    const one = button("sweep", () => sweep(control), "peaks over the range of this slider");
    one.classList.add("sweep");
    row.querySelector(".slider").append(one);
  });
  async function sweep({path, low, high, unit: si, logarithmic}) {
    const what = `Sweep: ${labelOfPath(path)}`, reply = await compute(what, "sweep", {path, low, high});
    if (!reply) return;
    const [unit, factor] = unitOf(si, state.units);
    present(what, reply.peaks, (name) => {
      const [outUnit, outFactor] = unitOf(reply.units[name], state.units), failed = reply.reasons.filter(Boolean);
      const points = reply.values.map((value, k) => [factor * value, reply.peaks[name][k] === null ? null : outFactor * reply.peaks[name][k]]);
      const reach = points.filter((_, k) => !reply.reasons[k]).map(([x]) => g(x, 4)), here = page.valueOf(path), marker = typeof here === "number" ? factor * here : null;
      return [plot(points, marker, logarithmic, `${labelOfPath(path)} [${unit || "1"}]`, `Peak of ${labelOfOutput(name)} [${outUnit || "1"}]`),
        target(points, product(outFactor, state.view.table?.find((row) => row.name === name)?.value), unit, outUnit, logarithmic, (x) => page.change({[path]: Number((x / factor).toPrecision(6))})),
        ...failed.length ? [make("p", {}, `${failed.length} of ${points.length} runs fail, all but ${reach[0] ?? "–"} to ${reach.at(-1) ?? "–"} ${unit}; set such a value to see where. The first: ${failed[0].split(";")[0]}`)] : []];
    }, path.replace(/^sdf\./, "").split(".")[1]);
  }

  function target(points, now, unit, outUnit, logarithmic, use) { // where the peak has a wanted value, by interpolation between the runs
    const field = make("input", {size: 8, class: "target", placeholder: "× 2", "aria-label": "wanted peak", title: `such as "× 2", "−10 %" or a number in ${outUnit || "1"}`});
    const found = make("span", {role: "status"});
    field.addEventListener("input", () => {
      const [, times, number, part] = /^\s*([×x*]?)\s*([-+]?[\d.]+)\s*(%?)\s*$/.exec(field.value.replace("−", "-")) ?? [];
      const wanted = (times ? now : part ? now / 100 : 1) * (Number(number) + (part ? 100 : 0));
      if (!Number.isFinite(wanted)) return found.replaceChildren(field.title);
      const places = points.slice(1).flatMap(([x1, y1], k) => {
        const [x0, y0] = points[k], share = (wanted - y0) / (y1 - y0);
        return y0 === null || y1 === null || y0 < wanted === y1 < wanted ? [] : [logarithmic ? x0 * (x1 / x0) ** share : x0 + share * (x1 - x0)];
      });
      const said = places.length ? "has the value at" : "is reached nowhere in this range";
      found.replaceChildren(` ${g(wanted)} ${outUnit} ${said} `, ...places.map((x) => button(`${g(x, 4)} ${unit}`, () => { shown.close(); use(x); }, "set this value")));
    });
    return make("p", {}, "Where is the peak ", field, found);
  }

  const ineffective = ({without}) => Object.entries(without).map(([path, why]) => make("p", {}, `${labelOfPath(path)}: ${why}.`));

  // -- sensitivities ---------------------------------------------------------------------------------------------------

  async function sensitivities(paths) {
    const what = "Which value matters most", reply = await compute(what, "sensitivities", {paths});
    if (!reply) return;
    present(what, reply.peaks, (name) => {
      const found = Object.entries(reply.changes).map(([path, of]) => [path, of[name]]).sort(([, a], [, b]) => Math.abs(b ?? 0) - Math.abs(a ?? 0));
      const most = Math.max(...found.map(([, value]) => Math.abs(value ?? 0)), 1e-12), all = everything();
      return [...all.length > paths.length ? [button(`all ${all.length} values with lengths and masses`, () => sensitivities(all), "may take half a minute")] : [], make("p", {}, `Change of the peak of ${labelOfOutput(name)} [%] when a value grows by 1 %:`),
        ...found.some(([, value]) => value === null) ? [make("p", {class: "unstated"}, `–: no statement about 1 % is possible. The row tells up to which change of the value the derivative predicts the peak, or why there is none: ${reply.why}.`)] : [],
        make("table", {class: "bars"}, make("tbody", {}, ...found.map(([path, value]) => {
        const bar = make("span", {class: value < 0 ? "bar negative" : "bar"});
        bar.style.width = `${9 * Math.abs(value ?? 0) / most}rem`;
        return make("tr", {}, make("th", {scope: "row", title: path}, button(labelOfPath(path), () => { shown.close(); page.show(path); }, "show this value")), make("td", {}, g(value, 3).replace("-", "−")), make("td", {}, value === null ? make("small", {}, reply.reasons[path][name]) : bar));
      }))), ...ineffective(reply)];
    });
  }

  // -- tolerances ------------------------------------------------------------------------------------------------------

  async function tolerances() {
    const asked = await ask(shown, "Tolerances", [["of each shown value [%], three standard deviations", "1"], ["runs", String(RUNS)]], "run");
    const [part, runs] = asked.map(Number), spreads = Object.fromEntries(numbers().map((path) => [path, part / 300]));
    const what = `Tolerances of ±${g(part, 3)} %`, reply = await compute(what, "tolerances", {spreads, runs});
    if (!reply) return;
    state.bands = reply;
    root.dispatchEvent(new CustomEvent("pinned")); // the curves have their bands
    const units = new Map((state.view.table ?? []).map(({name, unit}) => [name, unitOf(unit, state.units)]));
    const rows = Object.entries(reply.peaks).map(([name, {mean, deviation, quantiles}]) => {
      const [unit, factor] = units.get(name) ?? ["", 1];
      return make("tr", {}, make("th", {scope: "row"}, labelOfOutput(name)), ...[mean, deviation, ...quantiles].map((one) => make("td", {}, g(product(factor, one)))), make("td", {}, unit));
    });
    shown.replaceChildren(make("div", {class: "head"}, make("h2", {}, what), button("close", () => shown.close(), "Escape")),
      make("p", {}, `${reply.runs} runs${reply.failed ? `, ${reply.failed} failed` : ""}; the curves show the band of 90 % of them. Scattered: ${Object.keys(reply.spreads).map(labelOfPath).join(", ")}.`), ...ineffective(reply),
      make("table", {}, make("thead", {}, make("tr", {}, ...["peak of", "mean", "deviation", "5 %", "median", "95 %", ""].map((head) => make("th", {scope: "col"}, head)))), make("tbody", {}, ...rows)));
  }

  // -- keeping ---------------------------------------------------------------------------------------------------------

  async function notebook() {
    const asked = await ask(shown, `Write a notebook in ${state.start.folder}`, [["name", state.start.name]], "write", true);
    const reply = await send("notebook", {values: state.values, name: asked[0], replace: asked[1]}).catch(({message}) => ({error: message}));
    page.complain(reply.error ?? "");
    if (reply.error) return;
    page.note(`written: ${reply.written}; ${reply.command}`);
    shown.replaceChildren(make("div", {class: "head"}, make("h2", {}, "Code of this state"),
      button("copy", () => navigator.clipboard?.writeText(reply.code), "copy the code"), button("close", () => shown.close(), "Escape")), make("pre", {tabindex: 0}, reply.code));
    shown.showModal();
  }
  async function report() {
    const pins = [...state.pins, {name: "now", values: state.values, view: state.view}];
    const paths = [...new Set(pins.flatMap(({values}) => Object.keys(values)))], tables = pins.map(({view}) => new Map((view.table ?? []).map((row) => [row.name, row])));
    const names = [...new Set(tables.flatMap((table) => [...table.keys()]))], heads = pins.map(({name}) => make("th", {}, name));
    const value = (path, values) => {
      const control = state.controls.get(path), [unit, factor] = unitOf(control?.unit ?? "", state.units), one = values[path] ?? control?.value ?? "–";
      return typeof one === "number" ? `${g(factor * one)} ${unit}` : one;
    };
    const table = (first, rows) => make("table", {}, make("thead", {}, make("tr", {}, make("th", {}, first), ...heads.map((head) => head.cloneNode(true)))), make("tbody", {}, ...rows));
    const body = make("main", {class: "linkages-live report"}, make("h1", {}, state.start.title), make("p", {}, `${state.start.file}; ${Object.entries(state.start.versions).map((one) => one.join(" ")).join(", ")}`),
      ...notes.split("\n").filter(Boolean).map((line) => make("p", {}, line)),
      at(".picture svg")?.cloneNode(true) ?? "",
      table("value", paths.map((path) => make("tr", {}, make("th", {}, `${labelOfPath(path)} (${path})`), ...pins.map(({values}) => make("td", {}, String(value(path, values))))))),
      table("peak of", names.map((name) => make("tr", {}, make("th", {}, labelOfOutput(name)), ...tables.map((of) => {
        const row = of.get(name), [unit, factor] = unitOf(row?.unit ?? "", state.units);
        return make("td", {}, row ? `${g(product(factor, row.value))} ${unit}` : "–");
      })))), at(".curves").cloneNode(true));
    body.querySelectorAll("button, input, select").forEach((element) => element.remove());
    const rules = [...document.styleSheets].flatMap((sheet) => { try { return [...sheet.cssRules]; } catch { return []; } }).map(({cssText}) => cssText).join("\n");
    const page_ = make("html", {lang: "en"}, make("head", {}, make("meta", {charset: "utf-8"}), make("title", {}, state.start.title),
      make("style", {}, `${rules}\n.linkages-live.report { display: block; height: auto; max-width: 60rem; overflow: visible; }`)), make("body", {}, body));
    download(`${state.start.name}.html`, `<!DOCTYPE html>\n${page_.outerHTML}`, "text/html");
    page.note("a page with the pinned runs is downloaded; print it for a PDF");
  }
  async function note() {
    const text = make("textarea", {rows: 8, cols: 50, "aria-label": "notes"});
    text.value = notes;
    text.addEventListener("input", () => { notes = text.value; });
    shown.replaceChildren(make("div", {class: "head"}, make("h2", {}, "Notes for the report"), button("close", () => shown.close(), "Escape")), text);
    shown.showModal();
  }
  at(".tools").append(button("sensitivities", () => sensitivities(numbers()), "which value matters most"), button("tolerances", tolerances, "bands of scattered values"),
    button("notebook", notebook, "code that repeats this state"), button("report", report, "one page with the pinned runs, for print"), button("notes", note, "notes for the report"));
}

function plot(points, marker, logarithmic, xLabel, yLabel) {
  const [W, H, left, bottom, top, right] = [640, 320, 70, 46, 12, 16], known = points.filter(([, y]) => y !== null);
  const svg = draw("svg", {viewBox: `0 0 ${W} ${H}`, role: "img", "aria-label": `${yLabel} over ${xLabel}`, class: "sweep-plot"});
  if (!known.length) return make("p", {}, "no run reaches its end");
  const scale = logarithmic ? Math.log : (x) => x, xs = points.map(([x]) => x), ys = known.map(([, y]) => y);
  const [x0, x1, low, high] = [scale(xs[0]), scale(xs.at(-1)), Math.min(...ys), Math.max(...ys)], room = 0.06 * (high - low) || 0.5 * Math.abs(high) || 1;
  const x = (value) => left + (scale(value) - x0) / (x1 - x0) * (W - left - right), y = (value) => top + (high + room - value) / (high - low + 2 * room) * (H - top - bottom);
  const digits = Math.min(Math.max(2 + Math.ceil(Math.log10(Math.max(Math.abs(low), Math.abs(high)) / (high - low))) || 0, 5), 10); // neighbours differ
  const text = (content, attributes) => { const one = draw("text", attributes); one.textContent = content; svg.append(one); };
  for (let k = 0; k <= 4; k++) {
    const value = low + k / 4 * (high - low), at = logarithmic ? Math.exp(x0 + k / 4 * (x1 - x0)) : x0 + k / 4 * (x1 - x0);
    svg.append(draw("path", {class: "grid", d: `M${left} ${y(value)}H${W - right}`}));
    text(g(value, digits), {x: left - 6, y: y(value) + 4, "text-anchor": "end"});
    text(String(Number(at.toPrecision(3))), {x: x(at), y: H - bottom + 18, "text-anchor": "middle"});
  }
  text(xLabel, {x: (left + W) / 2, y: H - 8, "text-anchor": "middle"});
  text(yLabel, {x: left, y: top, class: "title"});
  let pen = "M";
  const path = points.map(([px, py]) => { const step = py === null ? "" : `${pen}${x(px)} ${y(py)}`; pen = py === null ? "M" : "L"; return step; }).join("");
  svg.append(draw("path", {class: "curve", d: path}));
  for (const [px, py] of known) {
    const dot = draw("circle", {class: "dot", cx: x(px), cy: y(py), r: 3.5}), title = draw("title", {});
    title.textContent = `${g(px)}: ${g(py)}`;
    dot.append(title);
    svg.append(dot);
  }
  if (marker !== null && scale(marker) >= x0 && scale(marker) <= x1) svg.append(draw("path", {class: "cursor", d: `M${x(marker)} ${top}V${H - bottom}`}));
  return svg;
}
