"""Pages in narrow and wide windows: nothing is cut off, everything that is named is seen."""

import pytest
from browser import find_browser, open_page

import linkages
from linkages.cli.main import main
from linkages.show.plots import write_animation

SIZES = [(800, 900), (1280, 900)]
needs_browser = pytest.mark.skipif(find_browser() is None, reason="no Chromium with its driver")

_MOMENTS = 24  # of the recording, at which labels are looked at

_LABELS = f"""
await decoded(window);
const pane = document.querySelector("#meshcat-pane").getBoundingClientRect();
const slider = document.querySelector("#bar input"), labels = [...document.querySelectorAll(".label")];
const outside = [];
for (let k = 0; k <= {_MOMENTS}; k++) {{
  slider.value = slider.max * k / {_MOMENTS};
  slider.dispatchEvent(new Event("input"));
  await frames(2);  // the page writes its labels in the next one
  for (const label of labels) {{
    const box = label.getBoundingClientRect();
    if (box.left < pane.left || box.right > pane.right || box.top < pane.top || box.bottom > pane.bottom)
      outside.push(`${{label.textContent}} at ${{slider.value}}`);
  }}
}}
const notes = document.querySelector("#notes"), select = notes.querySelector("select").getBoundingClientRect();
return {{outside, labels: labels.length,
  hidden: notes.scrollHeight - notes.clientHeight, below: select.bottom - innerHeight,
  wide: document.documentElement.scrollWidth - innerWidth}};
"""


@needs_browser
@pytest.mark.slow
@pytest.mark.parametrize("name", ["seven_bar", "slider_crank_guide"])
def test_an_animation_fits_its_window_at_all_times(name, tmp_path):
    system = linkages.load(linkages.find_file(f"{name}.toml"))
    write_animation(linkages.assess(system, "compiled", error_estimate=False), tmp_path / "animation.html")
    for size in SIZES:
        seen = open_page(tmp_path / "animation.html", tmp_path, _LABELS, size).seen
        assert seen["labels"] > 3
        assert seen["outside"] == []
        assert seen["hidden"] <= 0  # no text below the edge of its box
        assert seen["below"] < 0
        assert seen["wide"] <= 0


@needs_browser
@pytest.mark.slow
def test_the_pages_of_a_life_and_of_a_drawing_fit_their_window(tmp_path):
    wear = ["wear", "slider_crank_wear.toml", "--cycles", "20", "--no-plots", "--out", str(tmp_path / "wear")]
    assert main(wear) == 0
    assert main(["report", str(tmp_path / "wear")]) == 0
    assert main(["draw", "seven_bar.toml", "--out", str(tmp_path / "drawing")]) == 0
    look = """return {wide: document.documentElement.scrollWidth - innerWidth,
      captions: document.querySelectorAll("figcaption").length, times: document.querySelectorAll("output")[1]?.value}"""
    for page in ("wear/wear.html", "wear/report.html", "drawing/drawing.html"):
        for size in SIZES:
            seen = open_page(tmp_path / page, tmp_path, look, size).seen
            assert seen["wide"] <= 0, page
            if page == "wear/wear.html":
                assert seen["captions"] == 1
                assert "times" in seen["times"]
