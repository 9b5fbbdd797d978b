"""Write docs/press_films.md and its figures: ``python docs/make_press_films.py``, about three minutes.

Runs the seven-bar press with seven models of its films at two speeds, and over the speed with a heat balance. The numbers
are stored in docs/replication/computed/press_films.json; ``--page`` writes page and figures from them.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from replication.computed import keep, read

import linkages
from linkages.laws.viscosity import iso_vg_viscosity
from linkages.results.steady_state import common_period
from linkages.show.plots import COLORS, LINES, figure_style

NAME, JOINTS, PERIODS, SAMPLES = "press_films", ("A", "B"), 10, 180
PAGE = Path(__file__).with_name("press_films.md")
FIGURES = PAGE.parent / "figures"
#: Assumed: conduction of a joint into the links [W/K]; temperature of oil and surroundings, at which the oil ISO VG 460
#: has the viscosity of the source, 0.4 Pa s [degC].
CONDUCTANCE, SUPPLY = 0.5, 40.0
SPEEDS = (1.0, 10.0)  # strokes per second: of the shipped file, and ten times as fast
WARMING = (1.0, 2.0, 3.0, 5.0, 7.0, 10.0)
GROOVE = {"angle": 0.0, "extent": math.radians(20.0), "length": 0.8}
_HEAT = {"inlet": SUPPLY, "conductance": CONDUCTANCE}
_GROOVED: dict[str, Any] = {"film": "finite", "cavitation": "mass-conserving", "groove": GROOVE}
#: The steps: keys of both joints.
STEPS: dict[str, dict[str, Any]] = {
    "long film": {"film": "long"},
    "finite film": {"film": "finite"},
    "finite, Reynolds": {"film": "finite", "cavitation": "reynolds"},
    "groove, Reynolds": _GROOVED | {"cavitation": "reynolds"},
    "groove, mass-conserving": _GROOVED,
    "groove, heat, fed": _GROOVED | {"heat": {**_HEAT, "fresh": 1.0}},
    "groove, heat, sealed": _GROOVED | {"heat": {**_HEAT, "fresh": 0.0}},
}
#: Steps that the figures of both speeds show.
DRAWN = tuple(step for step in STEPS if step != "finite, Reynolds")


def system(step: str, strokes: float) -> linkages.System:
    """Return the press with one model of its films at a number of strokes per second."""
    speed = 2.0 * math.pi * strokes
    values: dict[str, Any] = {"drives.O1.speed": speed, "drives.O4.speed": speed, "duration": PERIODS / strokes}
    values["gravity"] = [0.0, 0.0, 0.0]
    for joint in JOINTS:
        model = {"model": "lubricated", "clearance": 0.3e-3, "oil": {"grade": 460, "temperature": SUPPLY}}
        values[f"joints.{joint}"] = model | STEPS[step]
    return linkages.load(linkages.find_file("seven_bar.toml"), values)


def assessment(step: str, strokes: float) -> linkages.Assessment:
    """Run the press with one model of its films."""
    return linkages.assess(system(step, strokes), error_estimate=False)


def row(step: str, strokes: float) -> dict[str, Any]:
    """Compute one step: numbers of the last period, and its curves."""
    found = assessment(step, strokes)
    run, period = found.run, common_period(found.system)
    assert period is not None
    assert run.evaluate is not None
    assert run.status is linkages.Status.OK
    end = float(run.time[-1])
    part = run.within(end - period, end)
    curve = run.evaluate(np.linspace(end - period, end, SAMPLES + 1))
    joints = {}
    for name in JOINTS:
        heat = found.heat.get(name)
        peaks = linkages.extremes(part, [f"{name}.force", f"{name}.eccentricity_ratio"])
        joints[name] = {
            "force": peaks[f"{name}.force"].peak,
            "ratio": peaks[f"{name}.eccentricity_ratio"].peak,
            "power": -linkages.integral(part, f"{name}.power") / period,
            "temperature": SUPPLY if heat is None else heat.temperature,
            "flow": None if heat is None else heat.flow,
            "orbit": [np.round(curve[f"{name}.e{axis}"] / 0.3e-3, 5).tolist() for axis in "xy"],
            "forces": np.round(curve[f"{name}.force"], 5).tolist(),
        }
    ideal = linkages.extremes(found.ideal.within(end - period, end), [f"{name}.force" for name in JOINTS])
    return {"joints": joints, "ideal": [ideal[f"{name}.force"].peak for name in JOINTS], "kind": found.motion.kind}


def compute() -> dict[str, Any]:
    """Compute all rows."""
    cases = [(step, strokes) for strokes in SPEEDS for step in STEPS]
    cases += [(step, strokes) for step in list(STEPS)[-2:] for strokes in WARMING if strokes not in SPEEDS]
    found = {}
    for step, strokes in cases:
        print(f"{step}, {strokes:g} strokes per second", flush=True)
        found[f"{step}/{strokes:g}"] = row(step, strokes)
    return found


def page(found: dict[str, Any]) -> str:
    """Return the text of the page."""
    return TEXT.format(
        table=_table(found),
        warming=_warming(found),
        conductance=f"{CONDUCTANCE:g}",
        supply=f"{SUPPLY:g}",
        periods=PERIODS,
        **_heated(found),
    )


def _table(found: dict[str, Any]) -> str:
    """Table of the steps: peak force over the ideal one and largest eccentricity ratio in A, power of both films, at each speed."""
    speeds = [f"{60.0 * strokes:g}" for strokes in SPEEDS]
    names = ("peak force in A over ideal", "largest e/c in A", "power of both films [W]")
    lines = [
        f"| step | {' | '.join(f'{name}, {speed}/min' for name in names for speed in speeds)} |",
        "|---" * (1 + len(names) * len(speeds)) + "|",
    ]
    for step in STEPS:
        rows = [found[f"{step}/{strokes:g}"] for strokes in SPEEDS]
        joints = [row["joints"] for row in rows]
        force = [
            f"{100.0 * (both['A']['force'] / row['ideal'][0] - 1.0):+.2f} %"
            for both, row in zip(joints, rows, strict=True)
        ]
        ratio = [f"{both['A']['ratio']:.3f}" for both in joints]
        power = [f"{both['A']['power'] + both['B']['power']:.3g}" for both in joints]
        lines.append(f"| {step} | {' | '.join([*force, *ratio, *power])} |")
    return "\n".join(lines)


def _warming(found: dict[str, Any]) -> str:
    lines = [
        "| strokes per minute | fed: A, B [°C] | sealed: A, B [°C] | sealed: largest e/c, A |",
        "|---|---|---|---|",
    ]
    fed, sealed = list(STEPS)[-2:]
    for strokes in WARMING:
        one, other = (found[f"{step}/{strokes:g}"]["joints"] for step in (fed, sealed))
        warm = [", ".join(f"{joints[name]['temperature']:.2f}" for name in JOINTS) for joints in (one, other)]
        lines.append(f"| {60.0 * strokes:g} | {warm[0]} | {warm[1]} | {other['A']['ratio']:.3f} |")
    return "\n".join(lines)


def _heated(found: dict[str, Any]) -> dict[str, str]:
    """Rise of the temperature of fed and sealed joints at the higher speed, and the viscosity of the sealed ones."""
    rises, words = {}, {}
    for name in ("fed", "sealed"):
        joints = found[f"groove, heat, {name}/{SPEEDS[-1]:g}"]["joints"]
        rises[name] = sorted(joints[joint]["temperature"] - SUPPLY for joint in JOINTS)
        words[name] = "{:.1f} to {:.1f} K".format(*rises[name])
    cold, *warm = (iso_vg_viscosity(460, SUPPLY + rise) for rise in (0.0, *reversed(rises["sealed"])))
    return words | {"thin": "{:.0f} to {:.0f} %".format(*(100.0 * value / cold for value in warm))}


def orbits(found: dict[str, Any], path: Path) -> None:
    """Draw the orbits of journal A in its clearance circle, one panel for each speed."""
    figure = Figure(figsize=(8.4, 4.6), layout="constrained")
    for axes, strokes in zip(figure.subplots(1, len(SPEEDS)), SPEEDS, strict=True):
        angle = np.linspace(0.0, 2.0 * math.pi, 200)
        axes.plot(np.cos(angle), np.sin(angle), color="0.6", lw=1.0)
        for step, color, line in zip(DRAWN, COLORS, LINES, strict=True):
            x, y = found[f"{step}/{strokes:g}"]["joints"]["A"]["orbit"]
            axes.plot(x, y, color=color, ls=line, lw=1.2, label=step)
        axes.set(
            aspect="equal",
            xlabel="$e_x/c$",
            ylabel="$e_y/c$",
            xticks=(-1, -0.5, 0, 0.5, 1),
            title=f"A, {60.0 * strokes:g} strokes per minute",
        )
    figure.legend(*axes.get_legend_handles_labels(), ncols=3, loc="outside lower center")
    figure.savefig(path)


def forces(found: dict[str, Any], path: Path) -> None:
    """Draw force in A over a period and its difference from the step before, at the higher speed."""
    figure = Figure(figsize=(7.4, 5.0), layout="constrained")
    upper, lower = figure.subplots(2, 1, sharex=True)
    curves = {step: np.array(found[f"{step}/{SPEEDS[-1]:g}"]["joints"]["A"]["forces"]) for step in DRAWN}
    turn = np.linspace(0.0, 360.0, SAMPLES + 1)
    before = curves["long film"]
    for (step, curve), color, line in zip(curves.items(), COLORS, LINES, strict=True):
        upper.plot(turn, curve, color=color, ls=line, lw=1.2, label=step)
        lower.plot(turn, curve - before, color=color, ls=line, lw=1.2)
    upper.set(ylabel="force in A [N]")
    lower.set(xlabel="crank angle [deg]", ylabel="difference from\nthe long film [N]")
    upper.legend(ncols=2, fontsize=7)
    figure.savefig(path)


def temperatures(found: dict[str, Any], path: Path) -> None:
    """Draw temperature and power of the film in A over the speed."""
    figure = Figure(figsize=(7.4, 3.4), layout="constrained")
    left, right = figure.subplots(1, 2)
    for step, color, line in zip(list(STEPS)[-2:], COLORS, LINES, strict=False):
        joints = [found[f"{step}/{strokes:g}"]["joints"]["A"] for strokes in WARMING]
        strokes_per_minute = 60.0 * np.array(WARMING)
        left.loglog(
            strokes_per_minute,
            [joint["temperature"] - SUPPLY for joint in joints],
            color=color,
            ls=line,
            marker="o",
            ms=3,
        )
        label = step.rpartition(", ")[2]
        right.loglog(
            strokes_per_minute,
            [joint["power"] for joint in joints],
            color=color,
            ls=line,
            marker="o",
            ms=3,
            label=label,
        )
    ticks = [60, 120, 300, 600]
    for axes, label in ((left, "oil in A above the supply [K]"), (right, "power of the film in A [W]")):
        axes.minorticks_off()
        axes.set(xlabel="strokes per minute", ylabel=label, xticks=ticks, xticklabels=ticks)
    right.legend()
    figure.savefig(path)


TEXT = """# The press step by step: finite length, groove, heat

For readers who decide how detailed a film model must be: what each refinement of the film changes in the seven-bar press, in force, orbit, power and
temperature. `python docs/make_press_films.py` repeats the runs and writes this page.

## The steps

Joints A and B of `sdf/seven_bar.toml` (L/D 1.33, radial clearance 0.3 mm), here without weight and with cranks that turn alike, have one of these films:

| step | film |
|---|---|
| long film | exact half film of a bearing of infinite length |
| finite film | Reynolds equation of the real length, Guembel's rule |
| finite, Reynolds | the same with Reynolds' rule |
| groove, Reynolds | the same with a groove of 20 degrees at angle 0, 80 % of the length |
| groove, mass-conserving | the same groove; the film content is conserved |
| groove, heat, fed | the same with a [heat balance](bearing_heat.md#heat-balance-of-a-joint); fresh oil replaces all that leaves |
| groove, heat, sealed | the same; no fresh oil |

The oil is ISO VG 460 at {supply} °C: 0.39 Pa s, the viscosity of the source. Assumed: supply and surroundings at {supply} °C, conductance {conductance} W/K of each joint, both cranks in
the same sense at the speed of the file, and at ten times this speed. The source gives neither temperature nor speed. All numbers refer to period {periods}, after a start with
centred journals.

## What each step changes

{table}

Joint B behaves alike, with smaller eccentricity ratios in a grooved film.

- **Force.** The acceleration of the links determines the joint forces. No step changes a peak by more than 3 %.
- **Orbit.** The finite film carries less than the long one, the groove interrupts the pressure, and the cavity of a mass-conserving film must fill before it carries:
  each of the three moves the journals farther.
- **Power.** A thinner film dissipates more; a cavity shears only the oil that it contains.
- **Temperature.** A tenth of a kelvin at the speed of the file. At ten times the speed a fed joint
  warms by {fed}, a sealed one by {sealed}, which lowers the viscosity to {thin}.

![Orbits of journal A for the steps, at two speeds](figures/press_films_orbits.png)

![Force in A over a stroke for the steps, and its differences](figures/press_films_forces.png)

## Temperature and speed

{warming}

![Temperature and power of the film in A over the speed](figures/press_films_temperature.png)

The power grows about with the square of the speed. A sealed joint warms in proportion to the power, a fed joint less, because the flow out of the ends grows as well.

**Conclusion for this machine.** The finite length changes the orbits at any speed and costs nothing. A groove, and the conservation of the oil with it, matters as soon
as the smallest film matters. A heat balance matters for sealed joints above about 300 strokes per minute. If only forces or accelerations are of interest, the film
model does not matter.

Limits: the heat balance is a lumped model, and the maps of the films are quasi-static; with this groove the real film has [less oil](transient_film.md#the-press). The range from fed to sealed shows
the influence of the unknown supply and conductance.
"""


def write() -> None:
    """Write page and figures from the stored numbers."""
    found = read(NAME)
    PAGE.write_text(page(found), encoding="utf-8")
    with figure_style():
        for name, draw in (("orbits", orbits), ("forces", forces), ("temperature", temperatures)):
            draw(found, FIGURES / f"{NAME}_{name}.png")


if __name__ == "__main__":
    if "--page" not in sys.argv:
        keep(NAME, compute())
    write()
