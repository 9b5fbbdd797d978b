"""Statements of the press paper that are not numbers of its results: lubrication, the better objective, the stabilisation."""

from __future__ import annotations

import numpy as np

from linkages import extremes
from replication import press_paper as paper
from replication import press_spike
from replication.claims import change
from replication.press_paper import DESIGNS, peaks
from replication.verdicts import Claim, parts

#: Parameter beta of eq. (22) [1/s], and other values of alpha beside it.
BETA = 50.0
_ALPHAS = (12.5, 25.0, 100.0, 200.0)
#: A change of the acceleration that is "very small" [%]; the paper's own is 0.94.
_SMALL = 5.0
#: Dry forces are at least this many times the lubricated ones: a chaotic run has no digits.
_ROUGH = 2.0


def context() -> list[Claim]:
    """Compare dry and lubricated joints, both objectives, and parameters of the stabilisation."""
    dry = paper.run(
        {key: value for key, value in paper.conditions().items() if not key.startswith("joints.")},
        paper.DURATION, "seven_bar_dry.toml",
    )  # fmt: skip
    outputs = ("A.force", "B.force", "slider7.ax")
    rough = extremes(dry, outputs)
    ratios = [rough[output].peak / extremes(paper.design_run("nominal"), [output])[output].peak for output in outputs]
    start = {name: press_spike.spike(design).peak for name, design in DESIGNS.items()}
    forces = [peaks(f"{joint}.force") for joint in "AB"]
    shares = {
        "design 1 lowers the acceleration at the start": start["paper 1"] < start["nominal"],
        "it raises F_A": forces[0]["paper 1"] > forces[0]["nominal"],
        "it raises F_B": forces[1]["paper 1"] > forces[1]["nominal"],
        "design 2 lowers F_A": forces[0]["paper 2"] < forces[0]["nominal"],
        "it lowers F_B": forces[1]["paper 2"] < forces[1]["nominal"],
        f"it changes the acceleration by less than {_SMALL:g} %": abs(change(start["nominal"], start["paper 2"]))
        < _SMALL,
    }
    failed = [name for name, holds in shares.items() if not holds]
    rates = {alpha: _rate(alpha) for alpha in (*_ALPHAS, BETA)}
    return [
        Claim(
            "lubrication lessens impacts and friction in the joints, sections 1 and 3.2", "none",
            f"dry joints multiply the largest F_A, F_B and acceleration by more than {_ROUGH:g}",
            [parts(ratio > _ROUGH for ratio in ratios)], "dry: contact and friction of `seven_bar_dry.toml`, gravity and speeds of `seven_bar_paper.toml`,"
            " 1 s; the exact factors depend on rounding",
        ),
        Claim(
            "objective 2 is better overall, section 4", "design 1: acceleration falls, forces rise; design 2: forces fall, acceleration hardly changes",
            f"{len(shares) - len(failed)} of {len(shares)} parts; not: {', '.join(failed) or 'none'} (acceleration"
            f" {change(start['nominal'], start['paper 1']):+.1f} % and {change(start['nominal'], start['paper 2']):+.1f} %)",
            [parts(shares.values())], "runs of the paper's designs in this package", "the paper's ε₀ and m, and its speeds",
        ),
        Claim(
            "equal alpha and beta make eq. (22) converge fast, section 1.2", f"alpha = beta = {BETA:g}",
            f"the constraint error decays at {rates[BETA]:.1f} 1/s; with alpha = {', '.join(f'{a:g}' for a in _ALPHAS)} 1/s at"
            f" {', '.join(f'{rates[a]:.1f}' for a in _ALPHAS)} 1/s", [parts(rates[BETA] > rates[alpha] for alpha in _ALPHAS)],
            "slowest root of s² + 2 alpha s + beta²: critical damping gives the fastest decay for a given beta, without overshoot",
        ),
    ]  # fmt: skip


def _rate(alpha: float) -> float:
    """Give the slowest decay of the constraint error of eq. (22) [1/s]."""
    return float(-np.max(np.roots([1.0, 2.0 * alpha, BETA**2]).real))
