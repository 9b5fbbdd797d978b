"""The patent's claims 1 to 7, one by one: its models in the nominal four-bar of the example."""

from __future__ import annotations

from functools import cache

import numpy as np

from linkages import Trajectory, extremes, find_file, ideal, impacts, load, simulate
from replication.dry import COMMAND, stored
from replication.patent_designs import Array, pair
from replication.verdicts import WITHIN, Claim, parts

RESTITUTION, STATIC, DYNAMIC, SLIDING = 0.9, 0.15, 0.1, 0.01  # of four_bar_dry.toml, assumed; the speed in m/s
_LOADED = 100.0  # N: contacts that count for the friction
_SHORT = 0.01  # s, of the run on Drake
_STEP = 1e-5  # s, of the differences that give accelerations


@cache
def _run() -> Trajectory:
    return simulate(load(find_file("four_bar_dry.toml")), "compiled")


def method() -> list[Claim]:
    """Claims 1 to 7."""
    found = stored("fourbar_jitter")
    run = _run()
    system = pair("fourbar_jitter").systems[0]
    clearance = system.experiment.joints["B"].clearance
    radius = np.hypot(run["B.ex"], run["B.ey"])
    free = radius < clearance
    carried = float(np.abs(run["B.load"][free]).max())
    law = _normal_law(run)
    back = [one.separation_speed / one.approach_speed for one in impacts(run, ["B"]) if one.separation_speed > 0.0]
    sliding, most = _friction(run)
    theirs, ours = _multipliers()
    short = load(find_file("four_bar_dry.toml"), {"duration": _SHORT})
    drake, compiled = (
        extremes(simulate(short, engine), ["B.force"])["B.force"].peak for engine in ("drake", "compiled")
    )
    return [
        Claim(
            "claim 1: the six steps lower the departure of this linkage's acceleration", "none",
            f"study `fourbar_jitter`: {len(pair('fourbar_jitter').study.names)} lengths; at the start {found.start}, running {found.running}",
            [parts([found.start.high < 0.0, found.running.high < 0.0])], "median and interval over start angles; tables 1 and 2 are lost", stored=COMMAND,
        ),
        Claim(
            "claim 2: contact where e - c is not negative, c = r_B - r_J", "formula lost",
            f"{int(free.sum())} of {len(free)} states of the run have e < c; the largest normal force there is {carried:g} N",
            [parts([carried == 0.0, bool(np.any(free)), bool(np.any(run["B.load"][~free] > 0.0))])], "every start and end of a contact is located in time",
        ),
        Claim(
            "claim 3: normal force of Lankarani and Nikravesh, n = 1.5", "formula lost",
            f"{law[0]:.1f} N at the deepest point of the first contact, engine {law[1]:.1f} N", [parts([_same(*law)])],
            "K δⁿ [1 + 3(1 - c_e²)/4 · (dδ/dt)/(dδ/dt)₀], K by Hertz with r_B - r_J: the law named by the remaining words, from the literature",
        ),
        Claim(
            "claim 3: c_e is the coefficient of restitution", f"{RESTITUTION} (assumed)",
            f"separation over approach speed {np.median(back):.3f} (median of {len(back)} contacts)", [parts([abs(float(np.median(back)) / RESTITUTION - 1.0) < WITHIN])],
            "the law is valid for restitution near 1",
        ),
        Claim(
            "claim 4: friction μ(v_t) F_n, dynamic above v_d, at most static", f"{DYNAMIC} and {STATIC} (assumed)",
            f"friction over normal force {sliding:.4f} (median where |v_t| > {SLIDING:g} m/s), nowhere above {most:.4f}",
            [parts([abs(sliding / DYNAMIC - 1.0) < WITHIN, most <= STATIC * 1.000001])], "cubic steps in between, as [0051]-[0055] say",
        ),
        Claim(
            "claim 5: ideal linkage by Lagrange multipliers, eq. (6)", "formula lost",
            f"largest force in B by Newton's equations of each bar {theirs:.2f} N, ours {ours:.2f} N", [parts([_same(theirs, ours)])],
            "each bar in absolute coordinates, its accelerations by differences of positions",
        ),
        Claim(
            "claim 6: linkage with clearance, eq. (7)", "formula lost",
            f"largest force in B within {1e3 * _SHORT:g} ms on Drake {drake:.2f} N, compiled {compiled:.2f} N", [parts([_same(drake, compiled)])],
            "the joint is cut and its force applied; the two engines share the force law, not the dynamics",
        ),
        _problem(),
    ]  # fmt: skip


def _problem() -> Claim:
    """Claim 7: the optimisation model."""
    file = pair("fourbar_jitter").study.file
    lengths = sum(variable.path.endswith("pose.x") for variable in file.variables.values())
    (objective,) = file.objectives.values()
    formulas = sum(constraint.formula is not None for constraint in file.constraints.values())
    asked = objective.terms is not None and [(t.functional, t.output) for t in objective.terms] == [
        ("peak", "follower.alpha.jitter")
    ]
    return Claim(
        "claim 7: lengths X, least largest departure F(X), constraints g_k(X)", "formula lost",
        f"study `fourbar_jitter`: {lengths} lengths, the follower's largest departure, {formulas} constraints by formulas of the lengths alone",
        [parts([lengths == len(file.variables), asked, formulas == len(file.constraints)])],
        "assumed constraints: all bars turn fully, transmission angle between 20 and 160 degrees",
    )  # fmt: skip


def _same(one: float, other: float) -> bool:
    """Tell whether two computations agree to a thousandth; their formula is not printed, so that no verdict on print follows."""
    return abs(one / other - 1.0) < 1e-3


def _normal_law(run: Trajectory) -> tuple[float, float]:
    """Compute the normal force at the deepest point of the first contact by the words of claim 3 and by the engine [N]."""
    first = impacts(run, ["B"])[0]
    inside = (run.time >= first.start) & (run.time <= first.start + first.duration)
    at = np.flatnonzero(inside)[np.argmax(run["B.penetration"][inside])]
    joint = pair("fourbar_jitter").systems[0]
    bearing = 0.015  # m, four_bar.sdf
    journal = bearing - joint.experiment.joints["B"].clearance
    soft = 2.0 * (1.0 - 0.3**2) / 206e9  # 1/Pa, both of steel
    stiffness = 4.0 / (3.0 * soft) * np.sqrt(bearing * journal / (bearing - journal))
    depth, rate = float(run["B.penetration"][at]), float(run["B.closing"][at])
    factor = 1.0 + 0.75 * (1.0 - RESTITUTION**2) * rate / first.approach_speed
    return stiffness * depth**1.5 * factor, float(run["B.load"][at])


def _friction(run: Trajectory) -> tuple[float, float]:
    """Friction over normal force where the journal slides, a median, and its largest value."""
    pressed = run["B.load"] > _LOADED
    e = np.stack([run["B.ex"], run["B.ey"]])[:, pressed]
    n = e / np.hypot(*e)
    f = np.stack([run["B.fx"], run["B.fy"]])[:, pressed]
    ratio = np.abs(n[0] * f[1] - n[1] * f[0]) / run["B.load"][pressed]
    return float(np.median(ratio[np.abs(run["B.sliding"][pressed]) > SLIDING])), float(ratio.max())


def _multipliers() -> tuple[float, float]:
    """Largest force in B of the ideal linkage after the ramp: by the multipliers of coupler and follower, and ours [N]."""
    system = pair("fourbar_jitter").systems[0]
    perfect = ideal(system, "compiled")
    times = np.linspace(0.03, system.experiment.duration - 2.0 * _STEP, 2001)
    at = [perfect.evaluate(times + k * _STEP) for k in (-1.0, 0.0, 1.0)]
    sizes = {
        link: (system.value(f"sdf.links.{link}.mass"), system.value(f"sdf.links.{link}.inertia"))
        for link in ("coupler", "follower")
    }
    pins = {"coupler": "sdf.frames.coupler_B.pose.x", "follower": "sdf.frames.follower_B.pose.x"}
    rows = []
    for link, (mass, inertia) in sizes.items():
        length = system.value(pins[link])
        angle, x, y = (np.stack([part[f"{link}.{key}"] for part in at]) for key in ("angle", "x", "y"))
        along = np.stack([np.cos(angle[1]), np.sin(angle[1])])
        centre = np.stack([x + 0.5 * length * np.cos(angle), y + 0.5 * length * np.sin(angle)])
        force = mass * (centre[:, 0] - 2.0 * centre[:, 1] + centre[:, 2]) / _STEP**2
        spin = inertia * (angle[0] - 2.0 * angle[1] + angle[2]) / _STEP**2
        # moments about the link's first pin: spin + (l/2) along x force = l along x (force at B)
        rows.append((length * along, spin + 0.5 * length * (along[0] * force[1] - along[1] * force[0])))
    (p, a), (q, b) = rows
    b = -b  # the coupler feels the opposite force
    matrix = np.array([[-p[1], p[0]], [-q[1], q[0]]]).transpose(2, 0, 1)
    solved: Array = np.linalg.solve(matrix, np.stack([a, b]).T[..., None])[..., 0]
    return float(np.hypot(*solved.T).max()), float(np.hypot(at[1]["B.fx"], at[1]["B.fy"]).max())
