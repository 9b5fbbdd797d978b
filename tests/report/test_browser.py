"""The report and the animation in a browser: content, and no network requests."""

import re

import numpy as np
import pytest
from browser import find_browser, open_page, picture

from linkages.base.palette import LINKS
from linkages.results.trajectory import load_trajectory
from linkages.show.plots.animation.magnified import GAP, REACH
from linkages.show.plots.names import name_of_output, sentence
from linkages.show.report.page import write_report
from linkages.show.report.result_folder import load_results

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(find_browser() is None, reason="no Chromium with its chromedriver on the PATH"),
]

LOOK = """
const frame = document.querySelector("iframe");
frame.scrollIntoView();
await decoded(frame.contentWindow);
const viewer = frame.contentWindow.viewer;
await frames(2);
const at = (time) => { viewer.animator.pause(); viewer.animator.seek(time); return viewer.capture_image(400, 300); };
const box = (element) => { const b = element.getBoundingClientRect(); return [b.x, b.y, b.width, b.height]; };
const place = (...path) => viewer.scene_tree.find(["joints", "A", ...path]).object.position.toArray();
const still = (time) => {
  viewer.animator.seek(time);
  return {spot: place("touch", "spot", "shape"), journal: place("journal"), head: place("arrow", "head")};
};
document.querySelectorAll("figure button")[1].click();
const [button, slider] = ["button", "input"].map((tag) => frame.contentDocument.querySelector(`#bar ${tag}`));
const bar = [button.textContent];
slider.value = slider.max / 4;
slider.dispatchEvent(new Event("input"));
bar.push(button.textContent, viewer.animator.actions[0].time / viewer.animator.duration);
button.click();
bar.push(button.textContent);
const enlarged = document.querySelector("dialog img");
const curve = document.querySelector("#curves .plots svg"), span = curve.getBoundingClientRect();
const caption = () => document.querySelector("#curves figcaption").textContent;
const ticks = () => curve.querySelectorAll("text").length && [...curve.querySelectorAll("text")].at(-1).textContent;
const point = (kind, Event, part, more = {}) => curve.dispatchEvent(
  new Event(kind, {clientX: span.left + part * span.width, clientY: span.top + 40, cancelable: true, ...more}));
curve.setPointerCapture = () => {};  // of no real pointer
point("pointermove", PointerEvent, 0.5);
const told = [caption()], whole = ticks();
point("pointerdown", PointerEvent, 0.75);
point("pointerup", PointerEvent, 0.75);
told.push(viewer.animator.actions[0].time / viewer.animator.duration);
point("wheel", WheelEvent, 0.5, {deltaY: -800});
told.push(whole, ticks());
const plot = frame.contentDocument.querySelector("#plot");
const result = {
  plot: [plot.querySelectorAll("path.curve").length, plot.querySelector("figcaption").textContent,
    [...frame.contentDocument.querySelectorAll("#notes option")].map((option) => option.textContent)],
  told, width: curve.clientWidth, curves: [...document.querySelectorAll("#curves figcaption")].length,
  bar, figures: [...document.querySelectorAll("figure img")].map((image) => [image.naturalWidth, image.naturalHeight]),
  enlarged: [document.querySelector("dialog").open, enlarged.naturalWidth, enlarged.alt],
  fetched: performance.getEntriesByType("resource").map((entry) => entry.name),
  frame: box(frame), duration: viewer.animator.duration, frames: [at(0.0), at(7.5)],
  stills: [0.0, 2.0, 4.0, 6.0].map(still),
  overflow: document.documentElement.scrollWidth - innerWidth,
};
document.querySelector("dialog").close();
return result;"""


@pytest.fixture(scope="module")
def page(results_folder, tmp_path_factory):
    folder = tmp_path_factory.mktemp("browser")
    write_report(load_results(results_folder), folder / "report.html")
    return open_page(folder / "report.html", folder, LOOK)


def test_curves_tell_values_zoom_and_lead_the_animation(page, results_folder):
    """The animation goes where a curve is clicked; after zooming in, the axis ends earlier."""
    read, part, whole, zoomed = page.seen["told"]
    width = page.seen["width"]
    run = load_trajectory(results_folder / "trajectory.npz")
    assert page.seen["curves"] == 5  # two outputs, two clearance joints, a drive
    time, value = map(
        float, re.match(r"Angular velocity of follower \[rad/s\] at (\S+) s: (\S+),", read.replace("−", "-")).groups()
    )
    assert value == pytest.approx(np.interp(time, run.time, run["follower.omega"]), rel=1e-3)
    assert part == pytest.approx((0.75 * width - 52) / (width - 64), abs=0.02)
    assert float(zoomed.removesuffix(" s")) < float(whole.removesuffix(" s"))


def test_a_curve_goes_with_the_animation(page):
    """Tables of the run and of ideal joints, by selection."""
    lines, told, choices = page.seen["plot"]
    assert lines == 2
    assert told.startswith("Angular velocity of follower [rad/s] at ")  # a value: it has been moved
    names = ["follower.omega", "coupler.ax", "A.force", "B.force", "O.torque"]
    assert choices == [sentence(name_of_output(name)) for name in names]


def test_every_figure_renders_and_can_be_enlarged(page, results_folder):
    drawn = sorted(results_folder.glob("*.png"))
    assert len(page.seen["figures"]) == len(drawn) == 6
    assert all(width > 300 and height > 300 for width, height in page.seen["figures"])
    is_open, width, alt = page.seen["enlarged"]
    assert is_open
    assert width == page.seen["figures"][1][0]
    assert alt.startswith("Acceleration x of coupler: ")
    assert page.seen["overflow"] <= 0  # nothing sticks out of the page


def test_the_animation_renders_and_moves(page):
    first, last = (picture(uri) for uri in page.seen["frames"])
    assert len(np.unique((255 * first).astype(int).reshape(-1, 3), axis=0)) > 50  # not blank
    background = first[2, 2]
    drawn = np.abs(first - background).max(axis=2) > 0.2
    assert drawn.mean() > 0.01
    assert np.mean(np.abs(first - last).max(axis=2) > 0.2) > 1e-3
    x, y, width, height = (int(v) for v in page.seen["frame"])
    seen = page.image[y + 40 : y + height - 2, x + 2 : x + width - 2]  # below the bar of controls
    assert np.mean(np.abs(seen - seen[2, 2]).max(axis=2) > 0.2) > 0.005


def test_links_have_the_same_colours_in_the_animation_and_the_drawing(page):
    """Faces in the plane: less than 0.03 of each channel from the colour of the link."""
    shown = picture(page.seen["frames"][0]).reshape(-1, 3)
    for color in LINKS[:3]:
        wanted = [int(color[k : k + 2], 16) / 255 for k in (1, 3, 5)]
        assert np.sum(np.abs(shown - wanted).max(axis=1) < 0.03) > 100, color


def test_the_animation_plays_stops_and_seeks(page):
    playing, stopped, part, again = page.seen["bar"]
    assert (playing, stopped, again) == ("pause", "play", "pause")
    assert part == pytest.approx(0.25, abs=0.01)


def test_the_magnified_journal_is_true_to_scale(page, results_folder):
    run = load_trajectory(results_folder / "trajectory.npz")
    assert page.seen["duration"] == pytest.approx(8.0)
    for time, still in zip((0.0, 2.0, 4.0, 6.0), page.seen["stills"], strict=True):
        now = time / 8.0 * run.time[-1]
        e = np.array([np.interp(now, run.time, run[f"A.{part}"]) for part in ("ex", "ey")]) / 1e-4
        radius = still["spot"][0]  # the spot lies on the wall
        # within a frame, a 240th of the run, the film moves the journal by less than this
        np.testing.assert_allclose(np.array(still["journal"][:2]) / (GAP * radius), e, atol=2e-3)
        force = np.interp(now, run.time, run["A.force"])
        share = (still["head"][0] / (REACH * radius)) ** 2
        assert share == pytest.approx(force / run["A.force"].max(), abs=0.02)


def test_nothing_is_fetched_and_nothing_wants_to_be(page):
    assert page.requests == []
    assert page.seen["refused"] == []
    assert all(name.startswith(("data:", "blob:")) for name in page.seen["fetched"])


def test_a_page_that_fetches_would_be_found(tmp_path, results_folder):
    text = (
        '<body><img src="http://127.0.0.1:9/x.png"><iframe srcdoc="<img src=\'https://127.0.0.1:9/y.png\'>"></iframe>'
    )
    (tmp_path / "bad.html").write_text(text)
    page = open_page(tmp_path / "bad.html", tmp_path)
    assert page.requests == ["http://127.0.0.1:9/x.png", "https://127.0.0.1:9/y.png"]
    write_report(load_results(results_folder), tmp_path / "report.html")
    report = (tmp_path / "report.html").read_text()
    (tmp_path / "report.html").write_text(report.replace("<main>", '<main><img src="http://127.0.0.1:9/x.png">'))
    page = open_page(tmp_path / "report.html", tmp_path)
    assert page.requests == []  # the page's own policy refuses
    assert page.seen["refused"] == ["http://127.0.0.1:9/x.png"]
