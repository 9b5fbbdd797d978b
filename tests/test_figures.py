"""Figures: every axis has a label with its unit, no panel is empty, no text is cut off or lies on another."""

import dataclasses
import re

import numpy as np
import pytest
from figure_texts import faults
from machines import four_bar
from matplotlib.backends.backend_agg import FigureCanvasAgg

import linkages
import optim
from linkages.base.palette import IDEAL
from linkages.cli.main import main
from linkages.show.plots.drawing.drawing import draw
from linkages.show.plots.headlines import headline
from linkages.show.plots.histories import forces_figure, output_figure, torques_figure, write_figures
from linkages.show.plots.linear_figures import bode_figure
from linkages.show.plots.presentation import presented
from linkages.show.plots.quantities import quantity
from linkages.show.plots.style import engineering, figure_style, look, write_figure

SHIPPED = (
    "seven_bar", "seven_bar_dry", "seven_bar_mixed", "seven_bar_rig", "four_bar_dry", "five_bar_dry", "six_bar_dry",
    "slider_crank_dry", "slider_crank_lubricated", "slider_crank_guide", "slider_crank_flexible",
    "three_rrr_clearance",
)  # fmt: skip
QUICK = ("seven_bar", "slider_crank_flexible")
SHORT = 0.02  # s: the first contacts of each machine lie within it

#: Counts and names, which have no unit.
COUNTS = {"revolutions", "cycles", "evaluations", "elements in each link"}
_TOLERANCE = 1.5  # pixels by which a text may extend beyond the picture


def _label(axes, which):
    """Label of an axis, or of the axes that it shares its scale with in the same figure."""
    own = getattr(axes, f"get_{which}label")()
    shared = getattr(axes, f"get_shared_{which}_axes")().get_siblings(axes)
    return own or next((text for one in shared if (text := getattr(one, f"get_{which}label")())), "")


def check(figure, name):
    for axes in figure.axes:
        if not axes.get_visible() or not axes.axison or axes.name == "polar":
            continue
        assert axes.lines or axes.collections or axes.patches or axes.images, f"{name}: a panel is empty"
        if axes.get_label() == "<colorbar>":
            continue
        for which in "xy":
            words = [text.get_text() for text in getattr(axes, f"get_{which}ticklabels")()]
            if any(re.search("[A-Za-z]", re.sub(r"\$.*?\$", "", word)) for word in words):
                continue  # names, not numbers
            label = _label(axes, which)
            assert label, f"{name}: an axis has no label"
            assert label in COUNTS or re.search(r"\[[^\]]+\]", label), f"{name}: {label!r} has no unit"
            assert not getattr(axes, f"{which}axis").get_offset_text().get_text(), f"{name}: {label!r} has an offset"
    _check_texts(figure, name)


def _check_texts(figure, name):
    """No text beyond the figure; no label of an axis or in a legend of the figure on another one."""
    renderer = figure.canvas.get_renderer()
    width, height = figure.bbox.width, figure.bbox.height
    boxes = {}
    for axes in figure.axes:
        for text in (axes.xaxis.label, axes.yaxis.label, axes.title, axes._left_title):
            if text.get_text() and text.get_visible() and axes.get_visible() and axes.axison:
                boxes[text] = text.get_window_extent(renderer)
    if figure._suptitle is not None and figure._suptitle.get_text():
        boxes[figure._suptitle] = figure._suptitle.get_window_extent(renderer)
    boxes |= {text: text.get_window_extent(renderer) for legend in figure.legends for text in legend.get_texts()}
    for text, box in boxes.items():
        inside = box.x0 >= -_TOLERANCE and box.y0 >= -_TOLERANCE
        inside &= box.x1 <= width + _TOLERANCE and box.y1 <= height + _TOLERANCE
        assert inside, f"{name}: {text.get_text()!r} is cut off"
    found = list(boxes.items())
    for k, (one, box) in enumerate(found):
        for other, beside in found[k + 1 :]:
            apart = box.x1 <= beside.x0 + _TOLERANCE or beside.x1 <= box.x0 + _TOLERANCE
            apart |= box.y1 <= beside.y0 + _TOLERANCE or beside.y1 <= box.y0 + _TOLERANCE
            assert apart, f"{name}: {one.get_text()!r} lies on {other.get_text()!r}"


@pytest.mark.parametrize(
    "name", [name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in SHIPPED]
)
def test_the_figures_of_a_run(name, drawn, tmp_path):
    system = linkages.load(linkages.find_file(f"{name}.toml"))
    system = system.replaced({"duration": min(system.experiment.duration, SHORT)})
    write_figures(linkages.assess(system, "compiled", error_estimate=False), tmp_path)
    assert "joint_forces.png" in drawn
    assert ("orbits.png" in drawn) == bool(system.tree.journals)
    assert ("links.png" in drawn) == bool(system.tree.substructures)
    for file, figure in drawn.items():
        check(figure, f"{name}/{file}")


@pytest.mark.slow
def test_the_figures_of_the_robot(drawn, tmp_path):
    assert main(["modes", "three_rrr.toml", "--no-animation", "--out", str(tmp_path / "robot")]) == 0
    assert len(drawn) == 12
    written = list((tmp_path / "robot").glob("fig*.png"))
    assert {path.name[:5] for path in written} == {f"fig{number:02d}" for number in range(5, 13)}  # of the paper
    assert all(path.stat().st_size > 10_000 for path in written)
    for file, figure in drawn.items():
        check(figure, file)


def test_the_figures_of_a_sweep_and_of_a_life(drawn, tmp_path):
    sweep = ["sweep", "seven_bar.toml", "--vary", "joints.A.clearance=0.1mm:0.4mm:2", "--revolutions", "2"]
    assert main([*sweep, "--transient", "0", "--out", str(tmp_path / "sweep")]) == 0
    diagram = drawn.pop("sweep.png")
    check(diagram, "diagram")
    wear = ["wear", "slider_crank_wear.toml", "--cycles", "2000", "--no-animation", "--out", str(tmp_path / "wear")]
    assert main(wear) == 0
    grid = ["--vary", "drives.O1.speed=2:4:2", "--limit", "A.force=20N", "--out", str(tmp_path / "grid")]
    assert main([*sweep, *grid, "--transient", "0", "--output", "A.force", "--output", "slider7.ax"]) == 0
    panels = ["sweep", "four_bar_dry.toml", "--set", "joints={}", "--vary", "drives.O.speed=20:40:3"]
    some = [word for name in ("O.torque", "follower.alpha", "follower_B.ax") for word in ("--output", name)]
    assert main([*panels, *some, "--out", str(tmp_path / "panels")]) == 0
    names = {"sweep.png", "map_A.force.png", "map_slider7.ax.png", "wear_B.png", "wear_history.png"}
    assert set(drawn) == names
    assert diagram.bbox.height > 2.0 * drawn["sweep.png"].bbox.height
    for file, figure in drawn.items():
        check(figure, file)
    legend = [text.get_text() for text in drawn["wear_history.png"].legends[0].get_texts()]
    assert all(re.search(r", new [\d.e+-]+ (k?N|N m|[mµ]m)$", text) for text in legend), legend


def test_the_figures_of_a_study(drawn, tmp_path):
    study = optim.load_study(optim.find_study("sevenbar_pareto"))
    result = optim.optimise(study, algorithm={"name": "nsga2", "population": 6, "generations": 2})
    optim.write_pareto_front(study, result, tmp_path / "front.png")
    report = optim.sensitivity(study, samples=2)
    optim.write_indices(study, report, tmp_path / "sobol.png")
    optim.write_one_at_a_time(study, report, tmp_path / "single.png")
    assert len(drawn) == 3
    for file, figure in drawn.items():
        for axes in (one for one in figure.axes if one.get_visible()):
            for which in "x" if "sobol" in file else "xy":  # the variables' names are next to the bars
                assert re.search(r"\[[^\]]+\]", _label(axes, which)), (file, which, _label(axes, which))
        _check_texts(figure, study.title)


def test_the_front_of_two_objectives_fits_its_figure(drawn, tmp_path):
    study = optim.load_study(optim.find_study("sevenbar_pareto"))
    first, second = list(study.file.objectives)[:2]
    kept = {name: study.file.objectives[name] for name in (first, second)}
    study = dataclasses.replace(study, file=study.file.model_copy(update={"objectives": kept}))
    entry = optim.Design.model_construct(objectives={first: 1.0, second: 2.0})
    result = optim.StudyResult.model_construct(front=[entry], best=entry, nominal=entry, designs={})
    optim.write_pareto_front(study, result, tmp_path / "front.png")
    (figure,) = drawn.values()
    assert figure.get_suptitle().startswith("1 design on the front; the compromise: ")
    _check_texts(figure, study.title)


def test_every_curve_of_a_figure_has_its_own_look():
    looks = [(look(k)["color"], str(look(k)["ls"])) for k in range(36)]
    assert len(set(looks)) == 36


def test_the_figures_of_derivatives_and_of_a_frequency_response(drawn, tmp_path):
    run = "sensitivity slider_crank_lubricated.toml --duration 0.002 --output slider.x --output B.force --quiet"
    run += " --set report=whole"
    assert main([*run.split(), "--wrt", "joints.B.clearance", "joints.B.viscosity", "--out", str(tmp_path)]) == 0
    (table,) = drawn["matrix.png"].axes
    assert [label.get_text().replace("\n", " ") for label in table.get_xticklabels()] == [
        "clearance of B",
        "viscosity of B",
    ]
    cells = [text.get_text() for text in table.texts]
    assert cells[:2] == ["-", "-"]  # the start is the peak of the slider's position
    assert all(float(text.replace("−", "-")) for text in cells[2:])
    turned = {"joints": {}, "drives.O": {"angle": 0.5, "torque": 0.0}}
    system = linkages.load(linkages.find_file("slider_crank_dry.toml"), turned)
    model = linkages.linearise(system, outputs=["slider.x", "slider.ax"])
    frequencies = np.geomspace(1.0, 1e3, 20)
    figure = bode_figure(model, frequencies, model.frequency_response(2.0 * np.pi * frequencies))
    FigureCanvasAgg(figure).draw()
    check(figure, "bode.png")
    units = [axes.get_ylabel() for axes in figure.axes[::2]]
    assert units == ["magnitude\n[m/(N m)]", "magnitude\n[(m/s²)/(N m)]"]
    assert figure.axes[0].get_title(loc="left") == "position x of slider / torque of O"


def test_a_picture_has_the_bytes_that_matplotlib_saves(tmp_path):
    study = linkages.assess(linkages.load(linkages.find_file("seven_bar.toml"), {"duration": SHORT}))
    with figure_style():
        write_figure(forces_figure(study), tmp_path / "ours")
        figure = forces_figure(study)
        figure.savefig(tmp_path / "theirs.png", metadata={"Description": figure.get_label()})
    assert (tmp_path / "ours.png").read_bytes() == (tmp_path / "theirs.png").read_bytes()


def test_a_difference_beyond_its_panel_is_stated():
    """The films carry nothing at t = 0; the panel shows the motion after that."""
    system = linkages.load(linkages.find_file("seven_bar.toml"), {"duration": 0.1})
    study = linkages.assess(system, error_estimate=False)
    figure = forces_figure(study)
    assert len(figure.axes) == 4
    for name, bottom in zip("AB", figure.axes[1::2], strict=True):
        (note,) = bottom.texts
        assert note.get_text().endswith(f"; at the start {study.ideal[f'{name}.force'][0]:.3g} N")


def test_the_line_above_a_figure_has_the_numbers_of_the_table():
    system = linkages.load(linkages.find_file("seven_bar_dry.toml"), {"duration": 0.05})
    study = linkages.assess(system, "compiled", error_estimate=False)
    summary = linkages.summarize(study)
    shown = summary["windows"][summary["report"]] if summary["report"] != "whole" else summary
    figure = forces_figure(study)
    for name, top in zip("AB", figure.axes[::2], strict=True):
        force = shown["joints"][name]["force"]
        said = f"force in {name}: {force['peak']:.4g} N at {1e3 * force['time']:.3g} ms, "
        (text,) = [text.get_text() for text in top.texts]
        assert text.startswith(said)
        ratio = force["peak"] / shown["ideal"]["joints"][name]["force"]["peak"]
        assert text.removeprefix(said) == f"{ratio:.3g} times ideal"
        assert text[1:] in figure.get_label()


def test_an_effect_that_is_too_small_to_be_seen_has_two_thirds_of_the_height():
    """The films of the press change its forces by less than 1 %, the impacts of the dry one by far more."""
    for name, share in (("seven_bar", 2.0 / 3.0), ("seven_bar_dry", 0.25)):
        system = linkages.load(linkages.find_file(f"{name}.toml"), {"duration": 0.1})
        top, bottom, *_ = forces_figure(linkages.assess(system, "compiled", error_estimate=False)).axes
        heights = [axes.get_position().height for axes in (top, bottom)]
        assert heights[1] / sum(heights) == pytest.approx(share)


@pytest.mark.parametrize("size", ["85x60mm", "160mm"])
@pytest.mark.parametrize("name", ["seven_bar", "seven_bar_dry", "slider_crank_flexible", "slider_crank_guide"])
def test_no_text_lies_on_another_at_the_two_widths_of_a_page(name, size, drawn, tmp_path):
    system = linkages.load(linkages.find_file(f"{name}.toml"), {"duration": SHORT})
    study = linkages.assess(system, "compiled", error_estimate=False)
    with presented(size=size):
        write_figures(study, tmp_path)
    assert "joint_forces.png" in drawn
    for file, figure in drawn.items():
        assert figure.get_size_inches()[0] == pytest.approx(float(size[:-2].split("x")[0]) / 25.4)
        assert faults(figure) == [], file


def test_forces_and_torques_of_zero_are_not_drawn(tmp_path):
    """The bearings of a gear pair have no force in the model, and a crank that a motor turns has no drive."""
    gears = linkages.load(linkages.find_file("gear_rattle.toml"), {"duration": SHORT})
    paths = write_figures(linkages.assess(gears, "compiled", error_estimate=False), tmp_path)
    assert "joint_forces" not in {path.stem for path in paths}
    system = linkages.load(linkages.find_file("slider_crank_motor.toml"), {"duration": SHORT})
    study = linkages.assess(system, "compiled", error_estimate=False)
    assert torques_figure(study).get_label().startswith("Torque of M: ")
    assert "torque of O" not in torques_figure(study).get_label()
    assert not np.any(study.run["O.torque"])


def test_a_curve_has_the_colour_of_its_link_in_the_drawing():
    """A joint's is the one of the link that it carries: link2 turns in A, link3 in B, crank1 in O1."""
    system = linkages.load(linkages.find_file("seven_bar.toml"), {"duration": SHORT})
    study = linkages.assess(system, error_estimate=False)
    colors = {shape.text: shape.color for shape in draw(system).shapes if shape.role == "link name"}
    for figure, links in (
        (output_figure(study, "slider7.ax"), ["slider7"]),
        (forces_figure(study), ["link2", "link3"]),
        (torques_figure(study), ["crank1", "crank4"]),
    ):
        assert [axes.lines[-1].get_color() for axes in figure.axes[::2]] == [colors[link] for link in links]
        assert {axes.lines[0].get_color() for axes in figure.axes[::2]} == {IDEAL}
    (legend,) = forces_figure(study).legends
    assert legend.legend_handles[-1].get_color() not in colors.values()


def test_noise_is_not_drawn_as_a_motion(system_of):
    """A linkage with ideal joints moves as the ideal linkage: the difference is zero, whatever its rounding is."""
    system = system_of(four_bar(), 'duration = 0.3\noutputs = ["follower.omega"]\n[drives.O]\nspeed = 6.0\n')
    study = linkages.assess(system, "compiled", error_estimate=False)
    top, bottom = output_figure(study, "follower.omega").axes
    assert np.abs(study.run["follower.omega"] - study.ideal.evaluate(study.run.time)["follower.omega"]).max() > 0.0
    assert not np.any(bottom.lines[0].get_ydata())
    assert np.ptp(top.lines[0].get_ydata()) > 1.0
    small = {"follower.omega": 1e3}  # a stated error above the motion itself
    assert not np.any(output_figure(study, "follower.omega", small).axes[0].lines[0].get_ydata())


@pytest.mark.slow
def test_the_magnified_orbit_is_as_many_times_larger_as_its_title_says(drawn, tmp_path):
    """The scale of the axes over the scale of the whole clearance, each in micrometres per pixel."""
    system = linkages.load(linkages.find_file("seven_bar.toml"), {"duration": 0.05})
    write_figures(linkages.assess(system, "compiled", error_estimate=False), tmp_path)
    assert len(drawn["orbits.png"].axes) == 2
    pairs = [(wide, inset) for wide in drawn["orbits.png"].axes for inset in wide.child_axes]
    assert pairs
    for wide, magnified in pairs:
        scales = [np.ptp(axes.get_xlim()) / axes.get_window_extent().width for axes in (wide, magnified)]
        stated = float(re.fullmatch(r"([\d.]+) times", magnified.texts[0].get_text()).group(1))
        assert scales[0] / scales[1] == pytest.approx(stated, rel=1e-6)
        assert stated > 1.0


@pytest.mark.parametrize(
    ("unit", "largest", "shown", "factor"),
    [
        ("N m", 6e-5, "µN m", 1e6), ("N m", 0.1, "mN m", 1e3), ("N", 2e4, "kN", 1e-3), ("Pa", 2.8e5, "kPa", 1e-3),
        ("m/s2", 2e-3, "mm/s²", 1e3), ("m/s2", 2e4, "km/s²", 1e-3), ("rad", 1.4e-5, "µrad", 1e6), ("J", 6e-4, "µJ", 1e6), ("1", 3.0, "", 1.0),
        ("kg m2", 3.0, "kg m²", 1.0), ("m", 0.0, "m", 1.0), ("m", 3e-4, "µm", 1e6), ("m", 0.02, "mm", 1e3), ("m", 3.0, "m", 1.0),
        ("N", 12.0, "N", 1.0), ("1", 0.3, "", 1.0), ("rad/s2", 1.5e5, "krad/s²", 1e-3),
    ],
)  # fmt: skip
def test_a_unit_suits_the_magnitude(unit, largest, shown, factor):
    assert engineering(unit, largest) == (shown, factor)


def test_a_figure_and_the_table_tell_the_same_difference():
    """Of the press's first moments: the largest over time, at the end of the start-up, where no step need be."""
    system = linkages.load(linkages.find_file("seven_bar.toml"), {"duration": 0.1})
    found = linkages.assess(system, "compiled", error_estimate=False)
    largest = linkages.summarize(found).difference["A.force"].peak
    assert headline(found, "A.force", "force in A").difference.startswith(f"at most {quantity(largest, 'N', 3)}")
