"use strict";
// Plays a page: a button and a slider with the frames of `show(part, frame)`, part from 0 to 1, in `length` seconds. Space
// plays and pauses, arrow keys step. At the end it begins again, or with `back` goes back. Only one on a page plays.

const players = [];
function makePlayer(holder, show, {length = 8, back = false, sense = 1, keys = null} = {}) {
  const [button, slider] = ["button", "input"].map((tag) => holder.querySelector(tag)), last = Number(slider.max);
  let playing = false, way = sense, place = Number(slider.value), before = 0;
  const part = () => place / last;
  function put(value) {
    place = Math.min(Math.max(value, 0), last);
    slider.value = Math.round(place);
    show(part(), Math.round(place));
  }
  function play(on) {
    if (on) players.filter((other) => other !== own).forEach((other) => other.play(false));
    playing = on;
    button.textContent = on ? "pause" : "play";
  }
  function seek(value) {
    play(false);
    put(value * last);
  }
  function step(now) {
    const next = place + way * last * Math.min(now - before, 100) / 1000 / length;
    before = now;
    if (playing && back && (next < 0 || next > last)) way = -way;
    else if (playing) put(next > last ? 0 : next < 0 ? last : next);
    requestAnimationFrame(step);
  }
  button.addEventListener("click", () => play(!playing));
  slider.addEventListener("input", () => seek(slider.value / last));
  keys?.addEventListener("keydown", (event) => {
    const steps = {ArrowLeft: -1, ArrowRight: 1}[event.key], other = event.target.matches("input, select, svg, button");
    if (other || (event.key !== " " && !steps)) return;
    if (steps) seek((Math.round(place) + steps) / last);
    else play(!playing);
    event.preventDefault();
  });
  const own = {play, seek, part, reset: (value) => { play(false); slider.value = place = value; }};
  players.push(own);
  requestAnimationFrame(step);
  return own;
}
