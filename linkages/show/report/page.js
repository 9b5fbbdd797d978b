"use strict";
// Enlarges a figure in a dialog, and ties the curves to the animation: a click takes it there, the cursor goes where it is.
const dialog = document.querySelector("dialog"), image = dialog?.querySelector("img"), data = document.querySelector("#curve-data");
for (const button of document.querySelectorAll("figure button")) {
  const {src, alt} = button.querySelector("img");
  button.addEventListener("click", () => {
    Object.assign(image, {src, alt});
    image.style.setProperty("--zoom", 1);
    dialog.showModal();
  });
}
dialog?.querySelectorAll("[type=button]").forEach((button, k) => button.addEventListener("click", () => {
  const zoom = Number(image.style.getPropertyValue("--zoom")) * [1.4, 1 / 1.4][k];
  image.style.setProperty("--zoom", Math.min(Math.max(zoom, 1), 8));
}));
if (data) {
  const curves = JSON.parse(data.textContent), frame = document.querySelector("#animation iframe");
  const {time} = curves[0].run, from = time[0], span = time.at(-1) - from;
  const plots = drawCurves(document.querySelector("#curves .plots"), curves, (t) => frame?.contentWindow.player?.seek((t - from) / span));
  legend(document.querySelector("#curves .key"), curves);
  document.querySelector("#curves button").addEventListener("click", plots.all);
  let last = null;
  requestAnimationFrame(function follow() {
    const part = frame?.contentWindow.player?.part() ?? null;
    if (part !== null && part !== last) plots.point(from + part * span);
    last = part;
    requestAnimationFrame(follow);
  });
}
