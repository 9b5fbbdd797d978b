"""The robot's stresses, and the formulas of section 3.3: claims of sections 2.2, 3.3 and 4."""

from __future__ import annotations

import numpy as np

from linkages.three_rrr.finite_elements import FiniteElementModel
from linkages.three_rrr.response import quasi_static_response
from linkages.three_rrr.robot import changed
from linkages.three_rrr.stress import platform_stress
from replication import robot_printed as as_printed
from replication.computed import read
from replication.robot_runs import (
    PRINTED_COUPLER,
    PRINTED_CRANK,
    PRINTED_PLATFORM,
    PRINTED_SHEAR,
    Stresses,
    drifting,
    loaded_as_printed,
    results,
    robot,
    second,
    shaken,
    stresses,
)  # fmt: skip
from replication.verdicts import Claim, Number, Printed, parts

#: File of the computed stresses over time steps, starts and assemblies: ``python docs/make_robot.py``.
FACTORS = "robot_factors"


def _reason(name: str, printed: float, ours: float) -> str:
    """Say what of a printed stress the candidates explain: ours times as large, and each candidate's value [kPa]."""
    swapped = changed(robot(), sections={"crank_diameter": 0.04, "coupler_diameter": 0.03})
    model, theirs = results().model, loaded_as_printed()
    axial, bending = as_printed.rod_stress(model, theirs)
    first, low, shear = as_printed.platform_stress(model, theirs)
    rods = [float(np.max(axial[:, k] + bending[:, k])) for k in (2, 3)]
    other = FiniteElementModel(swapped)
    found = {
        "printed loads and formulas": Stresses(*rods, float(low.min()), float(first.max()), float(shear.max())),
        "d₁ and d₂ exchanged": stresses(other, quasi_static_response(other, results().motion)),
        "other assembly": stresses(second().model, second().static),
        "free roots": stresses(*drifting()),
    }
    values = {key: getattr(stress, name) for key, stress in found.items()}
    told = ", ".join(f"{key} {1e-3 * value:.3g}" for key, value in values.items())
    right = [key for key, value in values.items() if Number(printed, value).grade == 0]
    return f"{printed / ours:.3g} times ours, {f'explained by {right[0]}' if right else 'unexplained'}: {told} kPa"


def stress() -> list[Claim]:
    """Judge the stresses of section 4, where they are largest, and one factor for two of them."""
    here, moving = results(), shaken()
    static = stresses(here.model, here.static)
    assert moving.plate is not None  # the robot's platform is a triangle
    plate = moving.plate
    dynamic = Stresses(
        moving.largest["crank2"],
        moving.largest["coupler2"],
        *map(float, (plate[0, :, 1].min(), plate[1, :, 0].max(), plate[1, :, 2].max())),
    )
    rows = (
        ("crank", "A₂B₂, fig. 12a", PRINTED_CRANK), ("coupler", "B₂C₂, fig. 12b", PRINTED_COUPLER),
        ("low", "the platform, least normal, fig. 12c", PRINTED_PLATFORM[0]),
        ("high", "the platform, largest normal, fig. 12c", PRINTED_PLATFORM[1]), ("shear", "the platform, shear, fig. 12c", PRINTED_SHEAR),
    )  # fmt: skip
    plate_most = max(abs(dynamic.low), abs(dynamic.high))
    asked = PRINTED_SHEAR / PRINTED_PLATFORM[1]
    ratio, ratio_static = (one.shear / max(abs(one.low), abs(one.high)) for one in (dynamic, static))
    links = here.stress[2:4]
    places = [1e3 * float(link.s[np.argmax(link.largest) % len(link.s)]) for link in links]
    lengths = [1e3 * float(link.s[-1]) for link in links]
    return [
        *(
            Claim(
                f"stress of {where}", f"{1e-3 * printed:.4g} kPa",
                f"{1e-3 * getattr(dynamic, name):.3g} kPa over the revolution from rest, {1e-3 * getattr(static, name):.3g} kPa quasi-static",
                [Number(1e-3 * printed, 1e-3 * getattr(dynamic, name), "kPa")],
                _reason(name, printed, getattr(dynamic, name)),
                "density and speeds", [],
            )
            for name, where, printed in rows
        ),
        Claim(
            "where the stress is largest, section 3.3", "at a rod's end",
            f"A₂B₂ at {places[0]:.0f} mm (its root), B₂C₂ at {places[1]:.0f} mm of {lengths[1]:.0f} mm",
            [parts(min(s, length - s) < 0.05 * length for s, length in zip(places, lengths, strict=True))],
            "right for the crank; the bending of a pinned coupler is largest near mid-span",
        ),
        Claim(
            "the largest stress is in the input rod, section 4", "A₂B₂",
            f"A₂B₂ {1e-3 * dynamic.crank:.3g} kPa, B₂C₂ {1e-3 * dynamic.coupler:.3g} kPa, platform {1e-3 * plate_most:.3g} kPa",
            [parts(dynamic.crank > other for other in (dynamic.coupler, plate_most))], "the crank's root carries the drive's torque",
        ),
        Claim(
            "the shear in the platform is very small, section 4: its share of the normal stress", f"{asked:.3f}",
            f"{ratio:.2f} ({ratio_static:.2f} quasi-static)", [Number(asked, ratio)],
            "a ratio, independent of density, speed and unit. As printed the two principal stresses would differ by less than a tenth at every instant: the pins would pull equally in all directions; inertia forces do not", because=[],
        ),
        _common_factor(),
    ]  # fmt: skip


def _common_factor() -> Claim:
    """Say whether the stresses of crank and platform miss by one factor for a reason."""
    found = read(FACTORS)
    pairs = {name: (PRINTED_CRANK / row["crank"], PRINTED_SHEAR / row["shear"]) for name, row in found.items()}
    apart = max(abs(a / b - 1.0) for a, b in pairs.values())
    told = "; ".join(f"{name} {a:.3f} and {b:.3f}" for name, (a, b) in pairs.items())
    return Claim(
        "one factor between print and ours for the crank's stress and the platform's shear", "none named", told, [],
        f"additional question: the factors agree within 0.1 % by coincidence. They differ by up to {100.0 * apart:.0f} % with another time step, start or"
        " assembly, so they indicate no missing factor of section, unit or formula", "the paper's start and step",
        stored="python docs/make_robot.py",
    )  # fmt: skip


def formulas() -> list[Claim]:
    """Judge the loads of section 2.2 and stresses of section 3.3 as printed."""
    here, theirs = results(), loaded_as_printed()
    place = np.argmax(np.abs(here.static.platform[:, 0]))
    ours, loaded = (1e6 * float(r.platform[place, 0]) for r in (here.static, theirs))
    axial, bending = (1e-3 * x[:, 3] for x in as_printed.rod_stress(here.model, here.static))
    coupler = here.stress[3]
    shear = 1e-3 * float(as_printed.platform_stress(here.model, here.static)[2].max())
    right = 1e-3 * float(platform_stress(here.model, here.static).largest_shear.max())
    stretched, bent = (1e-3 * float(np.max(np.abs(x))) for x in (coupler.axial, coupler.bending))
    return [
        Claim(
            "generalised forces of inertia, section 2.2", "+∫ρ a N, the platform's without translation",
            f"they move the platform by {loaded:.3g} µm along x where the right ones do by {ours:.3g} µm",
            [Printed(loaded, ours, "µm")], "d'Alembert: -ρ a; the translation of the platform's centre has inertia too",
        ),
        Claim(
            "axial stress of a rod, section 3.3", "Σ η′ u",
            f"{1e3 * float(axial.max()):.2g} Pa in B₂C₂, with E {stretched:.3g} kPa",
            [Printed(float(axial.max()), stretched, "kPa")], "a strain: E is missing",
        ),
        Claim(
            "bending stress of a rod, section 3.3", "E d/2 Σ φ″ v at its ends",
            f"{float(bending.max()):.3g} kPa in B₂C₂, from equilibrium {bent:.3g} kPa",
            [Printed(float(bending.max()), bent, "kPa")],
            "the end of a pinned rod has no moment; a cubic omits the inertia along the rod",
        ),
        Claim(
            "shear stress, eq. (14)", "E/(1 + μ²) γ", f"{shear:.3g} kPa, with E/(2(1 + μ)) {right:.3g} kPa",
            [Printed(shear, right, "kPa")], "as printed the stress depends on the axes",
        ),
    ]  # fmt: skip
