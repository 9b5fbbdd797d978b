"""Write docs/transient_film.md and its figures: ``python docs/make_transient_film.py``, about fifteen minutes.

Compares the quasi-static map of a grooved film with the film that has a history: along oscillating orbits of a single
bearing, and in runs of the seven-bar press with a history in joint A. The numbers are stored in
docs/replication/computed/transient_film.json; ``--page`` writes page and figures from them.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from replication.computed import keep, read
from replication.transient_film_runs import CELLS, FREQUENCIES, PRESSURES, STROKES, TURNS, compute

from linkages.show.plots import COLORS, LINES, figure_style

NAME = "transient_film"
PAGE = Path(__file__).with_name("transient_film.md")
FIGURES = PAGE.parent / "figures"
BOUND = 0.05  # error of the force that the rule allows


def limit(found: dict[str, Any]) -> float:
    """Largest product of frequency and filling time up to which every bearing keeps the bound, rounded down."""
    rows = [row for rows in found["swings"].values() for row in rows]
    least = min(row["number"] for row in rows if row["error"] > BOUND)
    kept = max(row["number"] for row in rows if row["number"] < least)
    return math.floor(10.0 * kept) / 10.0


def page(found: dict[str, Any]) -> str:
    """Return the text of the page."""
    joint = found["press"]
    unfed = joint["maps"]["0"]
    dry, fed = (joint["runs"][f"{pressure:g}"] for pressure in PRESSURES)
    variants = [dry, *joint["accuracies"].values(), *joint["meshes"].values()]
    head = (
        "| bearing | filling time | "
        + " | ".join(f"{f:g}" for f in FREQUENCIES)
        + " |\n|"
        + "---|" * (2 + len(FREQUENCIES))
    )
    lines = [
        f"| {name} | {rows[0]['number'] / rows[0]['frequency']:.1f} | "
        + " | ".join(f"{100.0 * r['error']:.1f}" for r in rows)
        + " |"
        for name, rows in found["swings"].items()
    ]
    return TEXT.format(
        table="\n".join([head, *lines]),
        limit=f"{limit(found):g}",
        bound=f"{100.0 * BOUND:g}",
        around=CELLS[0],
        along=CELLS[1],
        map=f"{_largest(unfed):.2f}",
        map_fed=f"{_largest(joint['maps'][f'{PRESSURES[1]:g}']):.2f}",
        first=f"{dry['ratio'][0]:.2f}",
        ratio=f"{dry['ratio'][-1]:.2f}",
        content=f"{dry['content'][-1]:.2f}",
        turns=TURNS,
        pressure=f"{PRESSURES[1] / 1e5:g}",
        fed=f"{fed['ratio'][-1]:.2f}",
        full=f"{fed['content'][-1]:.3f}",
        ratios=_range([row["ratio"][-1] for row in variants], ".2f"),
        contents=_range([row["content"][-1] for row in variants], ".2f"),
        forces=_range([row["force"][-1] for row in variants], ".1f"),
        rms=f"{100.0 * joint['along']['rms']:.1f}",
        largest=f"{100.0 * joint['along']['largest']:.0f}",
        turned="{:.0f} to {:.0f}".format(*_turned(unfed)),
        filling="{:.0f} to {:.0f} (in units of $1/\\omega$)".format(min(joint["filling"]), max(joint["filling"])),
        strokes=f"{60.0 * STROKES:g}",
    )


def _range(values: list[float], digits: str) -> str:
    return f"{min(values):{digits}} to {max(values):{digits}}"


def _largest(places: list[list[float]]) -> float:
    return float(np.hypot(*np.transpose(places)).max())


def _turned(places: list[list[float]]) -> tuple[float, float]:
    """Smallest and largest angle between groove and eccentricity [deg]."""
    angles = [abs(math.degrees(math.atan2(y, x))) for x, y in places]
    return min(angles), max(angles)


def errors(found: dict[str, Any], path: Path) -> None:
    """Draw the error of the map over the product of frequency and filling time."""
    figure = Figure(figsize=(6.4, 4.2), layout="constrained")
    axes = figure.subplots()
    for (name, rows), color, line in zip(found["swings"].items(), COLORS, LINES, strict=False):
        numbers, values = [row["number"] for row in rows], [100.0 * row["error"] for row in rows]
        axes.loglog(numbers, values, color=color, ls=line, marker="o", ms=3, lw=1.2, label=name)
    axes.axhline(100.0 * BOUND, color="0.5", lw=0.8)
    axes.axvline(limit(found), color="0.5", lw=0.8)
    axes.set(xlabel="frequency of the motion x filling time", ylabel="largest error of the force / largest force [%]")
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", fontsize=7, ncols=2)
    figure.savefig(path)


def orbits(found: dict[str, Any], path: Path) -> None:
    """Draw the orbit of journal A of the press with the map and with the history; eccentricity and content by turns."""
    figure = Figure(figsize=(7.4, 4.2), layout="constrained")
    left, right = figure.subplots(1, 2)
    joint, angle = found["press"], np.linspace(0.0, 2.0 * math.pi, 200)
    left.plot(np.cos(angle), np.sin(angle), color="0.6", lw=1.0)
    for (pressure, row), color, line in zip(joint["runs"].items(), COLORS[1:], LINES[1:], strict=False):
        bar = f"{float(pressure) / 1e5:g} bar"
        label, mapped = f"history, {bar}", joint["maps"][pressure]
        left.plot(*np.transpose(mapped), color=color, lw=0.8, label=f"map, {bar}")
        right.axhline(_largest(mapped), color=color, lw=0.8, label=f"largest e/c: map, {bar}")
        left.plot(*np.transpose(row["place"]), color=color, ls=line, lw=1.2, label=f"{label}, turn {TURNS}")
        turns = range(1, TURNS + 1)
        right.plot(turns, row["ratio"], color=color, ls=line, marker="o", ms=3, lw=1.2, label=f"largest e/c: {label}")
        right.plot(
            turns, row["content"][1:], color=color, ls=line, marker="s", ms=3, mfc="white", lw=0.8,
            label=f"film content: {label}",
        )  # fmt: skip
    left.set(aspect="equal", xlabel="$e_x/c$ in the bearing", ylabel="$e_y/c$")
    left.legend(fontsize=7, loc="upper center", bbox_to_anchor=(0.5, -0.18))
    right.set(xlabel="turn of the crank after a full film", ylabel="e/c, film content", ylim=(0.0, 1.05))
    right.legend(fontsize=7, loc="upper center", bbox_to_anchor=(0.5, -0.18))
    figure.savefig(path)


TEXT = """# Films with history: when a map is sufficient

For readers who use a map of a mass-conserving film in a machine: what the map leaves out, how large the error is, and when to expect it.
`python docs/make_transient_film.py` repeats the computations and writes this page.

## What has a history

After a change of motion the cavity fills at the rate at which grooves supply oil. The [map of a joint](bearing_grooves.md) is quasi-static: it uses the film content of a steady
motion at each place of the journal. The transient film has the content as a state: one number for each cell of the developed surface ({around} x {along} cells here). A step of time solves

$$\\frac{{(\\varphi h)^{{n+1}} - (\\varphi h)^n}}{{\\Delta t}} + \\nabla\\cdot\\left(\\frac U2 \\varphi h - \\frac{{h^3}}{{12\\mu}}\\nabla p\\right)^{{n+1}} = 0,
\\qquad p \\geq p_c,\\quad \\varphi \\leq 1,\\quad (p - p_c)(1 - \\varphi) = 0$$

with the solver of `linkages bearing`. The oil is balanced to 1e-10 in each step. The error is of first order in the step.

`linkages.laws.film.surface` has functions for an orbit of one bearing (`follow`) and a loaded journal (`move`), with examples; lengths are in units of the clearance, times in units of $1/\\omega$.

## The rule

The filling time is the volume of oil that the cavity of the steady film lacks, over the flow out of the grooves (`filling_time`). **A map is sufficient (force
within {bound} %) if the angular frequency of the motion times the filling time is below {limit}.** Above it the error can be large; the bearings with a groove at
-90 degrees keep the bound three to ten times longer, because this groove fills the film just ahead of the loaded zone.

Largest difference between the forces of the map and of the transient film, over the largest force [%], for a journal that oscillates about a place of a steady film at a frequency over the angular
velocity of the journal; filling time in units of $1/\\omega$:

{table}

At low frequency the deviation of the two meshes remains, 0.2 to 2 %.

![Error of the map over the product of frequency and filling time](figures/transient_film_errors.png)

- A change of the speed alone leaves the content of the steady film as it is: the map is exact, as long as the speed keeps its sign.
- Where a groove lies in the loaded zone little oil flows in: a map is not sufficient for an orbit that carries the load past the groove.
- Below an eccentricity ratio of about 0.3 the map has an error of its own (7 % at 0.2).

## In a machine

A lubricated joint with grooves and `cavitation = "mass-conserving"` takes a table `history`. The content of its film is then part of the state of the run, and its mean the output `A.film_content`:

```toml
[joints.A]
model      = "lubricated"
clearance  = 3e-4              # m
viscosity  = 0.4               # Pa s
cavitation = "mass-conserving"
groove     = {{angle = "0 deg", extent = "20 deg", length = 0.8, pressure = "0.2 bar"}}
history    = {{content = 1.0}}   # at the start; {{}} takes all defaults
```

The state is the volume $D$ that is missing in the gap $W$ of each cell. It changes by

$$\\dot D = m - \\frac D\\tau, \\qquad \\nabla\\cdot\\left(\\frac U2 (1-d) h - \\frac{{h^3}}{{12\\mu}}\\nabla p\\right) + \\dot W + \\frac D\\tau = m,
\\qquad m = \\left(\\frac W\\tau + \\dot W\\right) d, \\qquad p \\geq p_c,\\quad d \\geq 0,\\quad (p - p_c)\\, d = 0 .$$

This is the implicit step above over the film step $\\tau$ (key [`step`](experiment.md#all-keys)), written as a rate. Within a step of the
run, of up to $\\tau/4$, the force is a continuous function of place and velocity, as Radau IIA needs; then the missing volumes move on. The film is passive for any content, and
the oil is balanced to round-off. The error is of first order in $\\tau$.

A run chooses $\\tau$ after each step: the forces at $2\\tau$ and $\\tau$ may differ by the part [`accuracy`](experiment.md#all-keys) of the largest force so far. Where a journal crosses a cavity and hits the oil
the film step becomes up to 65,000 times shorter: a film that builds up pressure too early would be a cushion that takes the peak. A key `step` without `accuracy` makes $\\tau$ constant. The error estimate of the summary
repeats the run with a quarter of the accuracy, also if $\\tau$ is constant, and once more with twice as many cells in each direction. The force jumps where a cell fills, so two meshes differ by some
percent between their jumps. Each repetition contributes 1.5 times the larger of the peak's change and the root mean square of the difference while the output exceeds half of its peak.

## The press

The crank carries the bearing of joint A, and the eccentricity stays {turned} degrees from the groove, in the converging, loaded film: the
filling time of the steady film is {filling} along the orbit, and the rule is not satisfied by far. At {strokes} strokes per minute
the eccentricity ratio reaches {map} with the map. With history and without supply pressure it is {first} in the first turn after a full film and {ratio} in turn {turns}, where the
film content is {content}: the groove replaces less oil than the ends lose. With a supply pressure of {pressure} bar the film stays full
(content {full}), and the eccentricity ratio is {fed} ({map_fed} with the map).

![Journal of joint A with the map and with history](figures/transient_film_press.png)

With this groove orbits, smallest films and temperatures of the map are estimates only; the joint forces [hardly depend](press_films.md) on the films.

In the starved film the journal crosses the cavity once a turn and hits the oil on the other side. The peak of this impact depends on the accuracy of the film step and the cells ({forces} N in turn {turns});
the largest eccentricity ratio ({ratios}) and the content ({contents}) do not.

## What is offered

- Along any orbit of one bearing, and for one loaded journal with a mass: any grooves, holes, supply and cavity pressure, any $L/D$; about 3 ms a step along an orbit.
- In the runs of a machine on both engines: any lubricated joints, driven ones too, with grooves and holes and a cavity at ambient pressure; runs, batches, sweeps, sections, design studies
  (gradient methods take differences), the heat balance. A solution takes 200 times as long as a map; a turn of the press two seconds of processor time, more with impacts.
- Drake diagrams, derivatives, periodic motions, Lyapunov exponents, linear models, wear, the live page and a start in equilibrium refuse a `history`.

## Evidence

| case | quantity | deviation |
|---|---|---|
| plates that open and close, exact solution (Ausas, Jai and Buscaglia 2009 compare with it) | volume of the cavity through rupture and filling; load | 0.3 %, of first order; 2 % |
| partly filled gap that closes, closed form | content; pressure; outflow | 1e-9; 1e-4; 1e-10 |
| centred ring that fills behind a groove, closed form | volume of oil | 1e-5 |
| journal, or film of a machine, at a place | force and content of the steady film | 1e-6 |
| film of a machine along an orbit, first turn above | force of the transient film above | {rms} % (rms), {largest} % at most; of first order in the film step |
| machine of one journal under a constant load | place of `linkages bearing`, over the clearance; flow, friction | 0.005; 1 % |
| journal of a machine that hits the oil, both engines | peak of the force of the loaded journal above | 0.5 % |
| film of a machine, random motions and contents | balance of oil; power without supply pressure | 1e-11; never positive |

`pytest tests/laws/test_transient_film.py tests/test_film_history.py` repeats these comparisons.
"""


def write() -> None:
    """Write page and figures from the stored numbers."""
    found = read(NAME)
    PAGE.write_text(page(found), encoding="utf-8")
    with figure_style():
        errors(found, FIGURES / f"{NAME}_errors.png")
        orbits(found, FIGURES / f"{NAME}_press.png")


if __name__ == "__main__":
    if "--page" not in sys.argv:
        keep(NAME, compute())
    write()
