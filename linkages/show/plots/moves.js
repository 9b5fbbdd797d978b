"use strict";
// Moves the shapes of a drawing with its bodies. `shapesOf` finds them; `placeShapes` puts them where the bodies are, of
// which a pose has x, y [m] and angle [rad]; a drawing has low and high, its left and upper edge [m], and scale [px/m].

function shapesOf(svg) {
  return [...svg.querySelectorAll("[data-at]")].map((element) =>
    [element, element.dataset.at.split(" ").map((row) => row.split(",").map(Number))]);
}

function placeShapes(shapes, pose, {low, high, scale}) {
  for (const [element, rows] of shapes) {
    const points = rows.map(([body, x, y, dx, dy]) => {
      const [px, py, angle] = pose[body], c = Math.cos(angle), s = Math.sin(angle);
      return [(px + c * x - s * y + dx - low) * scale, (high - (py + s * x + c * y + dy)) * scale].map((value) => value.toFixed(2));
    });
    if (element.points) element.setAttribute("points", points.map((point) => point.join(",")).join(" "));
    else ["x", "y"].forEach((axis, k) => element.setAttribute(element.tagName === "circle" ? `c${axis}` : axis, points[0][k]));
  }
}
