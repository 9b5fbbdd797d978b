"""Validity of laws: each rule at its limit, by independent formulas."""

import json
import re
from dataclasses import replace
from math import pi, sqrt

import numpy as np
import pytest
from laws_page import bearing_ratio
from machines import BEARING, joint, model, solid
from shipped import FAST_PRESS, shipped

from linkages import InputError, Status, assess, find_file, load, summarize
from linkages.cli.main import main
from linkages.laws.film.closed_form import half_film_long
from linkages.laws.film.map_nodes import finite_force
from linkages.laws.viscosity import density, iso_vg_viscosity
from linkages.results.films import film_error
from linkages.results.impacts import Impact
from linkages.results.joint_validity import outside
from linkages.results.trajectory import Trajectory
from linkages.show.report.terminal import format_summary

RADIUS, LENGTH, CLEARANCE = 0.015, 0.04, 3e-4  # of the press, joints A and B
FINITE = {"joints.A.film": "finite", "joints.B.film": "finite"}


def run_of(system, omega, ratio=0.5, force=0.0):
    """A run of two steps in which links turn at these rates [rad/s], eccentricity ratios are one number."""
    turning = {f"{name}.omega": np.array([0.0, omega.get(name, 0.0)]) for name in system.mechanism.link}
    wide = {f"{name}.ex": np.array([0.1, ratio]) * CLEARANCE for name in system.tree.play}
    still = {f"{name}.{key}": np.zeros(2) for name in system.tree.play for key in ("ey", "fx", "load")}
    carried = {f"{name}.fy": np.array([0.0, force]) for name in system.tree.play}
    eccentric = {f"{name}.eccentricity_ratio": np.array([0.1, ratio]) for name in system.tree.play}
    deep = {
        f"{label}.penetration": (np.array([0.1, ratio]) - 1.0) * law["clearance"]
        for (_, label), law in zip(system.contacts, system.laws, strict=True)
    }
    return Trajectory(np.array([0.0, 0.25]), turning | wide | still | carried | eccentric | deep, Status.OK)


def found(system, impacts=(), ratio=0.5, **omega):
    """Warnings of such a run."""
    return outside(system, run_of(system, omega, ratio), impacts)


@pytest.mark.parametrize(("part", "count"), [(0.99, 0), (1.01, 1)])
def test_a_film_is_laminar_up_to_taylors_limit(part, count):
    """Both bodies turn: what counts is how fast one turns in the other."""
    viscosity = 870.0 * 400.0 * CLEARANCE**2 / 0.9  # the inertia of the film is small
    system = shipped("seven_bar", **FINITE, **{"joints.A.viscosity": viscosity, "joints.A.clearance": CLEARANCE})
    limit = 41.1 * sqrt(RADIUS / CLEARANCE)
    assert limit > 0.9 * RADIUS / CLEARANCE  # of this bearing, films with inertia are laminar
    thin = system.replaced({"joints.A.viscosity": 870.0 * 400.0 * RADIUS * CLEARANCE / limit})
    turbulent = [
        entry for entry in found(thin, crank1=100.0 * part, link2=-300.0 * part) if "not laminar" in entry["what"]
    ]
    assert len(turbulent) == count
    assert found(system, crank1=100.0, link2=-300.0) == []
    for entry in turbulent:
        assert (entry["kind"], entry["time"]) == ("film", 0.25)
        assert f"{1.01 * limit:.3g} in A at 0.25 s" in entry["what"]
        assert f"{limit:.3g}, with a density of 870 kg/m3 assumed" in entry["what"]


@pytest.mark.parametrize(("part", "count"), [(0.99, 0), (1.01, 1)])
def test_the_inertia_of_a_film_is_small_up_to_a_reduced_reynolds_number_of_one(tmp_path, part, count):
    """Uses the density of a named oil at its temperature."""
    oil = "oil = {grade = 10, temperature = 90.0, density = 850.0}"
    text, count_of = re.subn(r"viscosity += 0\.4", oil, find_file("seven_bar.toml").read_text())
    assert count_of == 2
    (tmp_path / "e.toml").write_text(text.replace("seven_bar.sdf", str(find_file("seven_bar.sdf"))))
    system = load(tmp_path / "e.toml", FINITE)
    rho, viscosity = density(90.0, 850.0), iso_vg_viscosity(10, 90.0, 850.0)
    warnings = found(system, crank1=part * viscosity / (rho * CLEARANCE**2))
    inert = [entry for entry in warnings if "inertia" in entry["what"]]
    assert len(inert) == count
    for entry in inert:
        assert f"1.01 in A at 0.25 s (small below 1, with a density of {rho:.0f} kg/m3)" in entry["what"]


def test_a_film_is_for_its_slenderness():
    """L/D is 1.33 in A and B, and the fit of long bearings is for more than 8."""
    (entry,) = found(shipped("seven_bar_fast"))
    assert (entry["kind"], entry["time"]) == ("film", None)
    assert "1.33 in A (pinkus-sternlicht: L/D > 8), 1.33 in B" in entry["what"]
    assert found(shipped("seven_bar_fast", **FINITE)) == []
    assert found(shipped("seven_bar_fast", **{f"sdf.joints.{name}.bearing.length": 0.25 for name in "AB"})) == []
    (entry,) = found(shipped("seven_bar_fast", **(FINITE | {"joints.A.film": "short"})))
    assert "1.33 in A (short: L/D < 1/4)" in entry["what"]


@pytest.mark.parametrize(("limit", "ratio", "count"), [(0.9995, 0.9997, 1), (0.9995, 0.9985, 0), (0.998, 0.9997, 0)])
def test_a_finite_film_ends_with_its_map(limit, ratio, count):
    system = shipped("seven_bar_mixed", **{f"joints.{name}.mixed.film_limit": limit for name in "AB"})
    system = system.replaced({f"joints.{name}.viscosity": 0.1 for name in "AB"})
    entries = found(system, ratio=ratio)
    assert len(entries) == count
    for entry in entries:
        assert f"{min(limit, ratio):.3g} in A at 0.25 s (its map ends at 0.999)" in entry["what"]


@pytest.mark.parametrize(("law", "restitution", "count"), [("lankarani-nikravesh", 0.5, 1), ("flores", 0.5, 0)])
def test_a_contact_law_is_for_its_restitution(law, restitution, count):
    changed = {"joints.B.contact.law": law, "joints.B.contact.restitution": restitution}
    entries = found(shipped("slider_crank_dry", **changed))
    assert [entry["kind"] for entry in entries] == ["contact"] * count
    assert all(f"0.5 in B ({law}: e > 0.9)" in entry["what"] for entry in entries)
    assert found(shipped("slider_crank_dry")) == []


def line(system):
    """Contact modulus [Pa], the relative radius [m], the journal's radius and the length [m] of joint B."""
    contact, bearing = system.experiment.joints["B"].contact, system.mechanism.joint["B"].bearing
    modulus = contact.youngs_modulus / (2.0 * (1.0 - contact.poissons_ratio**2))
    journal = bearing.radius - system.value("joints.B.clearance")
    return modulus, 1.0 / (1.0 / journal - 1.0 / bearing.radius), journal, bearing.length


@pytest.mark.parametrize(("part", "count"), [(0.99, 0), (1.01, 1)])
def test_a_contact_is_narrow_up_to_half_the_radius(part, count):
    system = shipped("slider_crank_dry")
    modulus, radius, journal, length = line(system)
    force = pi * modulus * length * (part * 0.5 * journal) ** 2 / (4.0 * radius)
    hit = Impact("B", 0.125, 1.0, 0.0, 1e-5, force, 1e-6, 1.0, force)
    entries = found(system, [hit, replace(hit, start=0.2, peak_normal_force=0.5 * force)])
    assert len(entries) == count
    for entry in entries:
        assert (entry["kind"], entry["time"]) == ("contact", 0.125)
        assert f"{part * 0.5:.3g} in B at 0.125 s" in entry["what"]
    assert found(system.replaced({"joints.B.contact.law": "johnson"}), [hit]) == []


@pytest.mark.parametrize(("part", "count"), [(0.99, 0), (1.01, 1)])
def test_a_contact_yields_at_its_largest_pressure(part, count):
    """A line contact of steel: p^2 = F E'/(pi L R), and it yields at 1.67 of the yield strength."""
    system = shipped("slider_crank_dry", **{"joints.B.contact.yield_strength": 3e8})
    modulus, radius, _, length = line(system)
    force = pi * length * radius * (part * 1.67 * 3e8) ** 2 / modulus
    hit = Impact("B", 0.125, 1.0, 0.0, 1e-5, force, 1e-6, 1.0, force)
    entries = found(system, [hit])
    assert len(entries) == count
    assert all(f"{part * 1.67:.3g} in B at 0.125 s" in entry["what"] for entry in entries)


@pytest.mark.parametrize(("part", "count"), [(0.99, 0), (1.01, 1)])
@pytest.mark.parametrize("given", [True, False], ids=["stiffness", "material"])
def test_a_journal_lies_in_its_bearing_to_a_hundredth_of_its_radius(part, count, given):
    """Whatever the stiffness of the contact comes from, and at the largest depth of the run."""
    system = shipped("slider_crank_dry", **({"joints.B.contact.stiffness": 1e7} if given else {}))
    clearance, journal = system.value("joints.B.clearance"), line(system)[2]
    entries = found(system, ratio=1.0 + part * 0.01 * journal / clearance)
    assert [entry["kind"] for entry in entries] == ["contact"] * count
    for entry in entries:
        assert f"{part * 0.01:.3g} in B at 0.25 s (small below 0.01 of the journal's radius)" in entry["what"]


@pytest.mark.parametrize(("part", "count"), [(0.99, 0), (1.01, 1)])
def test_a_block_lies_in_the_walls_of_its_slot_to_a_thousandth_of_its_height(part, count):
    system = shipped("slider_crank_guide")
    clearance, height = system.value("joints.guide.clearance"), system.mechanism.joint["guide"].slot.height
    entries = found(system, ratio=1.0 + part * 0.001 * height / clearance)
    assert [entry["kind"] for entry in entries] == ["contact"] * count
    for entry in entries:
        assert f"{part * 0.001:.3g} in guide at 0.25 s (small below 0.001 of the block's height)" in entry["what"]


@pytest.mark.parametrize(("part", "count"), [(0.98, 0), (1.02, 1)])
def test_a_journal_that_hangs_too_deep_in_its_bearing_is_said_to(system_of, part, count):
    """At rest its weight is K delta: as a spring would hold it, at a depth near a hundredth of its radius."""
    radius, mass = 0.01 - 1e-4, 0.2
    stiffness = mass * 9.81 / (part * 0.01 * radius)
    text = f"""duration = 0.01
gravity = [0.0, -9.81, 0.0]
start = "equilibrium"
[joints.J]
model = "dry"
clearance = 1e-4
[joints.J.contact]
law = "hertz"
restitution = 1.0
stiffness = {stiffness}
exponent = 1.0
"""
    system = system_of(model("bowl", solid("disc", mass) + joint("J", "world", "disc", inner=BEARING)), text)
    entries = summarize(assess(system, "compiled", error_estimate=False))["warnings"]
    assert len(entries) == count
    assert all(
        "a contact is too soft" in entry["what"] and f"{part * 0.01:.3g} in J" in entry["what"] for entry in entries
    )


def test_a_yield_strength_needs_a_pressure():
    with pytest.raises(InputError, match="yield_strength needs youngs_modulus"):
        shipped("slider_crank_guide", **{"joints.guide.contact.yield_strength": 3e8})


def test_a_run_that_yields_says_so_wherever_its_numbers_are():
    system = shipped("slider_crank_dry", duration=8e-4, **{"joints.B.contact.yield_strength": 1e6})
    result = assess(system, "compiled", error_estimate=False)
    summary = summarize(result)
    (entry,) = [entry for entry in summary["warnings"] if "yields" in entry["what"]]
    hardest = max(result.contacts, key=lambda impact: impact.peak_normal_force)
    assert entry["time"] == hardest.start
    assert entry["what"] in format_summary(summary)


def test_peaks_of_columns_that_part_have_no_error_even_if_they_come_before():
    """The tighter run is made into one that parts at half of the time, and strikes harder then."""
    result = assess(shipped("slider_crank_dry", duration=8e-4), "compiled")
    assert None not in summarize(result)["error"].values()
    tighter, clearance = result.tighter, result.system.value("joints.B.clearance")
    half = 0.5 * tighter.time[-1]
    late = tighter.time > half
    columns = tighter.columns | {
        "B.ex": tighter["B.ex"] + 0.01 * clearance * late,
        "B.force": tighter["B.force"] * np.where(late, 1.4, 1.0),
        "slider.vx": tighter["slider.vx"] + 0.02 * late,
    }
    summary = summarize(replace(result, tighter=replace(tighter, columns=columns, evaluate=None)))
    (entry,) = [entry for entry in summary["warnings"] if entry["kind"] == "rough"]
    looked_at = tighter.time[:: 1 + len(tighter.time) // 500]
    assert entry["time"] == looked_at[looked_at <= half][-1]
    assert summary["joints"]["B"]["force"]["time"] < half
    assert [key for key, error in summary["error"].items() if error is None] == ["B.force.peak"]
    assert 0.02 <= summary["error"]["slider.vx.peak"] < 0.021  # plus the difference of the runs


def test_windows_in_which_two_runs_are_together_have_errors():
    """The tighter run is made into one that is apart from the run, and strikes harder, around the second contact."""
    edges = {"before": (0.0, 6e-4), "apart": (6.2e-4, 7.6e-4), "after": (7.7e-4, 8e-4)}
    windows = {f"windows.{name}": {"start": start, "end": end} for name, (start, end) in edges.items()}
    result = assess(shipped("slider_crank_dry", duration=8e-4, **windows), "compiled")
    tighter, clearance = result.tighter, result.system.value("joints.B.clearance")
    apart = (tighter.time > 6.2e-4) & (tighter.time < 7.6e-4)
    columns = tighter.columns | {
        "B.ex": tighter["B.ex"] + 0.01 * clearance * apart,
        "B.force": tighter["B.force"] * np.where(apart, 2.0, 1.0),
    }
    changed = replace(result, tighter=replace(tighter, columns=columns, evaluate=None))
    looked_at = tighter.time[:: 1 + len(tighter.time) // 500]
    assert changed.apart == (looked_at[looked_at <= 6.2e-4][-1], looked_at[looked_at >= 7.6e-4][0])
    summary, key = summarize(changed), "B.force.peak"
    found = {name: summary["windows"][name]["error"][key] for name in edges}
    assert found["apart"] is None
    assert summary["error"][key] is None
    assert found["before"] < 1e-3 * summary["joints"]["B"]["force"]["peak"]
    assert found["after"] is not None


def test_compare_shows_the_warnings_of_both_engines(tmp_path, capsys):
    arguments = ["--duration", "1e-3", "--accuracy", "1e-8", "--out", str(tmp_path)]
    assert main(["compare", str(FAST_PRESS), *arguments]) == 0
    assert "warning of both engines (film): a film law is used at an L/D" in capsys.readouterr().out
    written = json.loads((tmp_path / "warnings.json").read_text())
    assert written.keys() == {"compiled", "drake"}
    for (entry,) in written.values():
        assert entry.keys() == {"kind", "time", "what", "remedy", "changes"}
        assert "1.33 in A" in entry["what"]
        assert entry["changes"] == {"joints.A.film": "finite", "joints.B.film": "finite"}


def test_a_film_warning_estimates_what_a_finite_film_changes():
    """A journal that turns steadily at eps = 0.5 under a long film: the force errs by the computed table's factor.

    The eccentricity is that at which the finite film carries the same force at the same speeds.
    """
    system = shipped("seven_bar", **{"joints.A.film": "long", "joints.B.film": "finite"})
    law = system.laws[0]
    unit = float(law.viscosity * LENGTH * RADIUS**3 / CLEARANCE**2)
    slenderness = 0.5 * LENGTH / RADIUS
    f_n, f_t, _ = half_film_long(0.5, 0.0, 0.5 * 7.0, slenderness)
    error = film_error(law, slenderness, np.array([[0.5 * CLEARANCE, 0.0]]), unit * np.array([[f_n, f_t]]))
    assert error is not None
    assert error.force == pytest.approx(bearing_ratio("long", slenderness, 0.5, "rotation"), rel=1e-6)
    assert error.eccentricity == pytest.approx(0.5)
    finite = finite_force(error.finite, slenderness, 0.0, 0.5 * error.finite * 7.0)
    assert np.hypot(*finite) == pytest.approx(np.hypot(f_n, f_t), rel=1e-4)
    (entry,) = outside(system, run_of(system, {}, 0.5, 1.0), ())
    assert "times too large, eccentricity ratio 0.5 instead of 0." in entry["what"]
