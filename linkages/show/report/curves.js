"use strict";
// Ties the curves to the animation: a click takes it there, and the cursor goes where it is.
(() => {
  const curves = JSON.parse(document.querySelector("#curve-data").textContent);
  const frame = document.querySelector("#animation iframe");
  const from = curves[0].run.time[0], to = curves[0].run.time.at(-1);
  const plots = drawCurves(document.querySelector("#curves .curves"), curves, (t) => {
    const slider = frame?.contentDocument?.querySelector("#bar input");
    if (!slider) return;
    slider.value = Math.round((t - from) / (to - from) * slider.max);
    slider.dispatchEvent(new Event("input"));
  });
  document.querySelector("#curves button").addEventListener("click", plots.all);
  let last = null;
  function follow() {
    const animator = frame?.contentWindow?.viewer?.animator;
    const part = animator?.duration && animator.actions[0] ? animator.actions[0].time / animator.duration : null;
    if (part !== null && part !== last) plots.point(from + part * (to - from));
    last = part;
    requestAnimationFrame(follow);
  }
  requestAnimationFrame(follow);
})();
