"""Drives that move only within backlash: they run, and have no linkage with ideal joints beside them."""

import json

import numpy as np
import pytest
from machines import joint, model, solid

from linkages import InputError, Status, assess, format_summary, summarize
from linkages.cli.main import main

WHEELS = model("pair", solid("pinion", 0.44, 2.0e-4) + solid("wheel", 1.78, 3.2e-3, "0.09 0 0 0 0 0")
               + joint("A", "world", "pinion") + joint("B", "world", "wheel"))  # fmt: skip
RATIO, SLACK, RADIUS, STIFFNESS, RESTITUTION = -0.5, 50e-6, 0.0564, 5e8, 0.6
MESH = f"""
[gears.mesh]
joints = ["A", "B"]
ratio = {RATIO}
[gears.mesh.backlash]
normal = {SLACK}
radius = {RADIUS}
[gears.mesh.backlash.contact]
law = "flores"
restitution = {RESTITUTION}
stiffness = {STIFFNESS}
[solver]
integrator = "dormand_prince_5_4"
accuracy = 1e-9
max_step = 1e-5
"""
HEAD = "duration = 0.02\noutputs = ['pinion.omega', 'wheel.omega']\n"
TORQUES = HEAD + "[drives.A]\ntorque = 1.0\nspeed = 80.0\n[drives.B]\ntorque = 1.0\nspeed = -40.0\n" + MESH
ANGLES = HEAD + "[drives.A]\nspeed = 80.0\n[drives.B]\nspeed = -40.1\n" + MESH


def test_two_torques_on_geared_wheels_keep_their_balance(run):
    """The teeth's torque T on the second wheel is -n T on the first: J1 w1' + n J2 w2' = T1 + n T2 at any time."""
    found = run(WHEELS, TORQUES)
    gained = 2.0e-4 * (found["pinion.omega"] - 80.0) + RATIO * 3.2e-3 * (found["wheel.omega"] + 40.0)
    np.testing.assert_allclose(gained, (1.0 + RATIO) * found.time, atol=1e-9)
    assert np.abs(found["mesh.torque"]).max() > 1.0


def test_two_prescribed_wheels_press_their_flanks_together(run):
    """They approach at 0.1 rad/s: contact begins after half the play, and the depth grows at the speed of the impact.

    The law of Flores is then K d^1.5 (1 + 8 (1 - e)/(5 e)), d the angle beyond the play times the base radius.
    """
    found = run(WHEELS, ANGLES)
    beyond = np.clip(0.1 * found.time - 0.5 * SLACK / RADIUS, 0.0, None)
    damped = 1.0 + 8.0 * (1.0 - RESTITUTION) / (5.0 * RESTITUTION)
    force = STIFFNESS * (RADIUS * beyond) ** 1.5 * damped
    np.testing.assert_allclose(found["mesh.torque"], RADIUS * force, rtol=1e-3, atol=1e-3 * RADIUS * force.max())
    np.testing.assert_allclose(found["B.torque"], -found["mesh.torque"], atol=1e-9 * force.max())
    np.testing.assert_allclose(found["A.torque"], RATIO * found["mesh.torque"], atol=1e-9 * force.max())


@pytest.mark.parametrize("text", [TORQUES, ANGLES])
def test_a_missing_ideal_linkage_is_null_with_a_reason(system_of, text):
    found = assess(system_of(WHEELS, text), "compiled", error_estimate=False)
    assert found.run.status is Status.OK
    assert found.ideal is None
    summary = summarize(found)
    assert summary["ideal"] is None
    assert summary["no_ideal"] == "2 drives for 1 degree of freedom of pair"
    assert all(window["ideal"] is None for window in summary["windows"].values())
    said = format_summary(summary)
    assert "no linkage with ideal joints to compare with: 2 drives for 1 degree of freedom of pair" in said


def test_files_figures_and_report_cope_without_an_ideal_linkage(experiment_file, tmp_path, capsys):
    path, out = experiment_file(WHEELS, TORQUES), tmp_path / "run"
    out.mkdir()
    for text in ("simulate", "report"):
        given = [str(path), "--out", str(out), "--no-animation"] if text == "simulate" else [str(out)]
        assert main([text, *given]) == 0
    summary = json.loads((out / "summary.json").read_text())
    assert summary["ideal"] is None
    assert not (out / "ideal.npz").exists()
    assert (out / "output_wheel.omega.png").exists()
    page = (out / "report.html").read_text()
    assert "linkage with ideal joints to compare with: 2 drives for 1 degree of freedom of pair" in page
    assert "Wide and pale: ideal joints" not in page
    assert "below: their difference" not in page
    assert "raceback" not in capsys.readouterr().err


@pytest.mark.parametrize(
    ("angle", "refused"),
    [
        (0.4 * SLACK / RADIUS, ""),
        (0.01, "start 0.01 rad from the middle of the backlash of mesh, which allows 0.0004433 rad"),
    ],
)
def test_prescribed_wheels_start_within_the_play(system_of, angle, refused):
    system = system_of(WHEELS, ANGLES.replace("speed = -40.1", f"speed = -40.1\nangle = {angle}"))
    if refused:
        with pytest.raises(InputError, match=refused):
            _ = system.assembly
    else:
        assert dict(zip(system.tree.coordinates, system.assembly.q, strict=True)) == {"A": 0.0, "B": angle}


IDLER = model("train", solid("one", 0.1, 1e-4) + solid("idler", 0.1, 1e-4, "0.1 0 0 0 0 0") + solid("two", 0.1, 1e-4, "0.2 0 0 0 0 0")
              + joint("A", "world", "one") + joint("I", "world", "idler") + joint("B", "world", "two"))  # fmt: skip


def test_a_wheel_between_two_prescribed_ones_starts_in_the_middle_of_what_they_leave(system_of):
    """The gears have ratio -1: with a lead of 1 mrad and half plays of 1 mrad each, each gear is 0.5 mrad off."""
    text = "duration = 0.1\n[drives.A]\nspeed = 3.0\n[drives.B]\nspeed = 3.0\nangle = 1e-3\n"
    for name, joints in (("g", ["A", "I"]), ("h", ["I", "B"])):
        text += f"[gears.{name}]\njoints = {joints}\nratio = -1.0\n[gears.{name}.backlash]\nplay = 2e-3\n"
        text += f"[gears.{name}.backlash.contact]\nlaw = 'hunt-crossley'\nrestitution = 0.9\nstiffness = 1e4\n"
    system = system_of(IDLER, text)
    q, v = (dict(zip(system.tree.coordinates, x.tolist(), strict=True)) for x in (system.assembly.q, system.assembly.v))
    assert q == pytest.approx({"A": 0.0, "I": -5e-4, "B": 1e-3}, abs=1e-15)
    assert v == pytest.approx({"A": 3.0, "I": -3.0, "B": 3.0}, abs=1e-12)
