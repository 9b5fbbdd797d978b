"""The press paper's figure 8: the acceleration at the start, and what makes it."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np

from linkages import Trajectory, extremes, find_file, ideal, load
from linkages.results.extremes import Extremes
from replication import press_paper as paper
from replication import press_steps
from replication.claims import change
from replication.press_conditions import ASSUMED, CHOSEN, overrides
from replication.press_paper import DESIGNS, PRINTED, START
from replication.verdicts import Claim, Fitted, FittedChange, Number, parts

#: Accuracy at which the peak is known to 0.1 %: the corrected force jumps at eps_0.
FINE = {"solver.accuracy": 1e-9}


@cache
def plain_run(name: str) -> Trajectory:
    """Run a design without eqs. (12)-(13)."""
    return paper.run({**overrides(CHOSEN), **DESIGNS[name], **FINE}, START)


def spike(design: Mapping[str, Any]) -> Extremes:
    """Extremes of the slider's acceleration within `START`, of a design by path [m/s2]."""
    return _acceleration(paper.run({**design, **FINE}, START))


def lasts(level: float) -> float:
    """How long the nominal acceleration at the start exceeds the ideal one by a part of the largest excess [s]."""
    run = paper.run(FINE, START)
    times = np.linspace(0.0, 1e-3, 20001)
    excess = np.abs(run.evaluate(times)["slider7.ax"]) - np.abs(paper.ideal_run().evaluate(times)["slider7.ax"])
    return float(np.sum(excess > level * excess.max()) * times[1])


def at_steps() -> float:
    """Largest size of the nominal acceleration at multiples of the paper's step, without the start itself [m/s2]."""
    times = press_steps.STEP * np.arange(1, round(START / press_steps.STEP))
    return float(np.abs(paper.run(FINE, START).evaluate(times)["slider7.ax"]).max())


def claims() -> list[Claim]:
    """List the acceleration at the start, its changes, and its causes."""
    printed, found = PRINTED["slider7.ax"], {name: spike(design) for name, design in DESIGNS.items()}
    sizes = {name: one.peak for name, one in found.items()}
    plain = {name: _acceleration(plain_run(name)).peak for name in DESIGNS}
    run = paper.design_run("nominal")
    later = _acceleration(run.within(START, float(run.time[-1]))).peak
    perfect = _acceleration(paper.ideal_run()).peak
    other = load(find_file(paper.PAPER), {"duration": paper.DURATION, **overrides(ASSUMED)})
    assumed = _acceleration(ideal(other, paper.ENGINE)).peak
    first, corrected = paper.patch()
    patch = f"ε₀ = {first:.3g}, m = {corrected:.3g}, fitted to these numbers"
    unknown = "the paper's ε₀ and m"
    cause = [Fitted(printed[name], sizes[name], "m/s²") for name in DESIGNS]
    changes = [
        Claim(
            f"change of the acceleration at the start, design {name[-1]}", f"{text} ({asked:+.2f} % by its own numbers)", f"{ours:+.2f} %",
            [FittedChange(asked, ours, "%")], why, unknown, [],
        )
        for name, text, why in (
            ("paper 1", "-25 %", "thinner oil stops the falling journals later and more gently"),
            ("paper 2", "+0.15 %", "the sign agrees, the magnitude does not: the film stops lighter links in thicker oil more abruptly"),
        )
        for asked, ours in [[change(x["nominal"], x[name]) for x in (printed, sizes)]]
    ]  # fmt: skip
    return [
        Claim(
            "acceleration at the start, nominal, 1, 2, fig. 8", _three(printed), f"{_three(sizes)}, all along -x, after {1e6 * found['nominal'].time:.0f} µs",
            cause, f"magnitudes compared. Centred journals carry no load: the links fall until the film stops them; {patch}", unknown,
        ),
        Claim(
            "the same without eqs. (12)-(13)", _three(printed), _three(plain), [Number(printed[name], plain[name], "m/s²") for name in DESIGNS],
            f"the film alone overshoots the ideal slider's {abs(_at_start()):.3f} m/s² too, but not less with design 1", "ε₀ and m", cause, trial=True,
        ),
        *changes,
        Claim(
            "smooth after the start, nominal, fig. 8", "smooth, less than at the start",
            f"up to {later:.3f} m/s² after {START:g} s, {sizes['nominal']:.3f} before; the ideal slider {perfect:.3f}",
            [parts([later < sizes["nominal"], later < 1.001 * perfect])], "after the start the slider moves like the ideal one",
        ),
        Claim(
            "4.290 m/s² is the largest acceleration of design 1, fig. 8", f"{printed['paper 1']:.3f} m/s²",
            f"the ideal slider needs {perfect:.3f} m/s² in the first second, {assumed:.3f} m/s² at 2π and 2π rad/s",
            [parts([perfect < printed["paper 1"]])],
            "no design changes the motion of the ideal slider: its largest acceleration is a lower bound. The speeds decide whether 4.290 is above it", "the drives' speeds",
        ),
        Claim(
            "the peak in steps of 0.1 ms, Tables 4 and 5", f"{printed['nominal']} m/s²",
            f"{at_steps():.3f} m/s² at multiples of 0.1 ms; the peak is above half its height for {1e6 * lasts(0.5):.0f} µs",
            [Number(printed["nominal"], at_steps(), "m/s²")], "results at intervals of 0.1 ms do not show this peak; the steps of an integrator do", "the integrator", [], trial=True,
        ),
        Claim(
            "fixed steps of 0.1 ms as the cause", f"{printed['nominal']} m/s²",
            f"Runge-Kutta leaves the bearing after {1e3 * press_steps.explicit():.1f} ms; implicit Euler: at most"
            f" {press_steps.implicit():.2f} m/s² in the first {1e3 * press_steps.END:.0f} ms",
            [Number(printed["nominal"], press_steps.implicit(), "m/s²")],
            f"without eqs. (12)-(13). The film's least time constant is {1e6 * press_steps.fastest():.2g} µs, and Runge-Kutta is stable only above"
            f" {1e6 * press_steps.STEP / press_steps.STABLE:.0f} µs with such steps; results computable with such steps have no peak; eqs. (12)-(13) cause one",
            "the integrator", cause[:1], trial=True,
        ),
    ]  # fmt: skip


def _at_start() -> float:
    """Acceleration of the ideal slider at t = 0 [m/s2]."""
    return float(paper.ideal_run()["slider7.ax"][0])


def _acceleration(run: Trajectory) -> Extremes:
    return extremes(run, ["slider7.ax"])["slider7.ax"]


def _three(values: Mapping[str, float]) -> str:
    return ", ".join(f"{value:.3f}" for value in values.values()) + " m/s²"
