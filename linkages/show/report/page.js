"use strict";
// Enlarges a figure in a dialog: wheel and keys zoom, dragging and arrow keys move.
(() => {
  const dialog = document.querySelector("dialog");
  if (!dialog) return;
  const stage = dialog.querySelector(".stage");
  const image = stage.querySelector("img");
  let scale = 1, x = 0, y = 0;

  function place() {
    image.style.transform = `translate(${x}px, ${y}px) scale(${scale})`;
  }
  function fit() {
    [scale, x, y] = [1, 0, 0];
    place();
  }
  function zoom(factor, atX, atY) {
    const next = Math.min(Math.max(scale * factor, 1), 12);
    x = atX - (atX - x) * next / scale;
    y = atY - (atY - y) * next / scale;
    scale = next;
    if (scale === 1) x = y = 0;
    place();
  }
  function move(dx, dy) {
    x += dx;
    y += dy;
    place();
  }

  for (const button of document.querySelectorAll("figure button")) {
    button.addEventListener("click", () => {
      const shown = button.querySelector("img");
      image.src = shown.src;
      image.alt = shown.alt;
      fit();
      dialog.showModal();
    });
  }
  stage.addEventListener("wheel", (event) => {
    event.preventDefault();
    const box = stage.getBoundingClientRect();
    zoom(Math.exp(-event.deltaY / 400), event.clientX - box.left, event.clientY - box.top);
  }, {passive: false});
  stage.addEventListener("pointerdown", (event) => {
    event.preventDefault();
    stage.setPointerCapture(event.pointerId);
  });
  stage.addEventListener("pointermove", (event) => {
    if (stage.hasPointerCapture(event.pointerId)) move(event.movementX, event.movementY);
  });
  const keys = {
    "+": () => zoom(1.4, stage.clientWidth / 2, stage.clientHeight / 2),
    "-": () => zoom(1 / 1.4, stage.clientWidth / 2, stage.clientHeight / 2),
    "0": fit,
    ArrowLeft: () => move(60, 0), ArrowRight: () => move(-60, 0),
    ArrowUp: () => move(0, 60), ArrowDown: () => move(0, -60),
  };
  dialog.addEventListener("keydown", (event) => {
    const action = keys[event.key];
    if (action) {
      event.preventDefault();
      action();
    }
  });
})();
