"""Records of three machines of laboratories: quoted samples against runs with the values that the first halves fit.

Sources: GitHub, Noah-Abeson/2003LocoMotive, Test1_5pt5V (slider-crank); PMKS-Web/PMKS_Verification,
TeachingLab_Four_Bar, WitMotion, second record (four-bar); dfki-ric-underactuated-lab/double_pendulum, design C.0, system
identification, trajectory_00 (double pendulum). `docs/measured_machines.py` makes the fits.
"""

import shutil
from pathlib import Path

import numpy as np

import linkages

FILES = Path(__file__).resolve().parents[1] / "docs" / "measured"
#: Slider-crank, second half: time [s], angle of the wheel [deg], place of the slide [mm].
SLIDES = [
    (5.60, 4968.90, 198.338), (5.82, 5050.40, 158.585), (6.04, 5159.80, 17.750), (6.26, 5263.32, 82.225), (6.48,
    5292.62, 149.111), (6.70, 5320.84, 192.734), (6.92, 5394.64, 175.629), (7.14, 5499.24, 41.673), (7.36, 5613.50,
    60.759), (7.58, 5648.64, 140.359), (7.80, 5673.72, 185.195), (8.02, 5736.90, 189.079), (8.24, 5835.54, 73.504),
    (8.46, 5957.90, 32.399), (8.68, 6004.04, 130.608), (8.90, 6027.14, 175.890), (9.12, 6079.88, 198.507), (9.34,
    6176.28, 101.542), (9.56, 6300.02, 10.656), (9.78, 6360.20, 121.549), (10.00, 6382.66, 168.734), (10.22,
    6426.62, 202.054), (10.44, 6518.78, 125.449), (10.66, 6638.96, 0.200),
]  # fmt: skip
#: Four-bar: rates of the crank [deg/s], each 0.1007 s.
CRANK = [
    -61.035, -60.303, -61.646, -61.157, -60.974, -61.401, -61.523, -61.951, -61.646, -62.073, -62.256, -61.279,
    -62.317, -61.340, -62.927, -62.073, -61.584, -61.218, -60.791, -60.791, -60.669, -61.584, -61.035, -61.829,
    -61.890, -61.951,
]  # fmt: skip
#: Four-bar: time of the same clock [s], rate of the rocker [deg/s].
ROCKER = [
    (0.2140, -36.804), (0.3147, -38.635), (0.4155, -38.818), (0.5162, -38.452), (0.6169, -36.560), (0.7176,
    -33.203), (0.8183, -28.381), (0.9190, -22.705), (1.0197, -16.968), (1.1204, -10.681), (1.2212, -3.296), (1.3219,
    2.502), (1.4226, 7.446), (1.5233, 12.024), (1.6240, 15.808), (1.7247, 19.226), (1.8254, 21.973), (1.9261,
    24.475), (2.0268, 26.550), (2.1276, 27.649),
]  # fmt: skip
#: Double pendulum: time [s], angle of the shoulder, relative angle of the elbow [rad], their torques [N m].
ARM = [
    (0.0000, 0.0002, 0.0006, 0.0088, 0.0088), (0.0555, -0.0196, 0.0505, 0.2081, 0.6593), (0.1023, -0.0696, 0.1581,
    0.3253, 0.4249), (0.1503, -0.1177, 0.2695, 0.3839, 0.2198), (0.2023, -0.1272, 0.3164, 0.3546, -0.0498), (0.2503,
    -0.0883, 0.2615, -0.0205, -0.4601), (0.3023, 0.0032, 0.1020, 0.0264, -0.7004), (0.3503, 0.1261, -0.1333,
    -0.1319, -0.7062), (0.4023, 0.2581, -0.4015, -0.2432, -0.6476), (0.4503, 0.3374, -0.5949, -0.2667, -0.3722),
    (0.5023, 0.3481, -0.6792, -0.3370, 0.1495), (0.5503, 0.2817, -0.6231, -0.1905, 0.3839), (0.6024, 0.1295,
    -0.3965, 0.0029, 0.6007), (0.6504, -0.0933, -0.0277, 0.1026, 0.7004), (0.7024, -0.3779, 0.4740, 0.2256, 0.7707),
    (0.7504, -0.6029, 0.8875, 0.3370, 0.4542), (0.8024, -0.7536, 1.1843, 0.3722, 0.1084), (0.8504, -0.7918, 1.2961,
    0.2960, -0.2491), (0.9024, -0.7315, 1.2392, 0.0322, -0.5597), (0.9504, -0.5819, 1.0222, -0.0967, -0.5714),
    (1.0024, -0.3191, 0.5819, -0.3194, -0.5011), (1.0504, -0.0063, 0.0212, -0.3136, -0.4425), (1.1024, 0.3035,
    -0.5491, -0.3546, -0.3136), (1.1504, 0.4908, -0.8978, -0.2198, 0.1084), (1.2024, 0.5766, -1.0691, -0.0967,
    0.6066), (1.2504, 0.5545, -1.0481, -0.0088, 0.5245), (1.3024, 0.4347, -0.8513, 0.2256, 0.5363), (1.3504, 0.2440,
    -0.5041, 0.4132, 0.3604), (1.4024, -0.0296, 0.0093, 0.4015, 0.1201), (1.4504, -0.2672, 0.4774, 0.3018, -0.0029),
    (1.5024, -0.4290, 0.8021, 0.1377, -0.4484), (1.5504, -0.4679, 0.8989, 0.0850, -0.5480), (1.6024, -0.4126,
    0.8066, -0.4659, -0.6125), (1.6504, -0.2874, 0.5751, -0.3194, -0.4073), (1.7024, -0.1024, 0.2100, -0.3194,
    -0.2198), (1.7504, 0.0601, -0.1272, -0.3253, 0.0440), (1.8024, 0.1600, -0.3550, -0.2432, 0.2960), (1.8504,
    0.1581, -0.3916, -0.1201, 0.2725), (1.9024, 0.0681, -0.2630, 0.0850, 0.6007), (1.9504, -0.0792, -0.0071, 0.2725,
    0.5949), (2.0025, -0.2626, 0.3359, 0.3253, 0.3956),
]  # fmt: skip


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


def columns(path, **named):
    np.savetxt(path, np.column_stack(list(named.values())), delimiter=",", header=",".join(named), comments="")


def machine(name, folder, values):
    """Copy the files of a machine and load it."""
    for path in (FILES / name).iterdir():
        shutil.copy(path, folder)
    return linkages.load(folder / f"{name}.toml", values)


def slide_error(folder, lengths):
    """Deviation of the slide [mm], less its mean, in the half of the record that no value was fitted to."""
    time, wheel, slide = np.array(SLIDES).T
    columns(folder / "record.csv", time=time - time[0], wheel=wheel, slide=slide)
    values = {f"sdf.parameters.{key}": value for key, value in lengths.items()}
    end = float(time[-1] - time[0])
    system = machine("slider_crank", folder, values | {"duration": end, "drives.O.offset": 3.166838})
    found = 1e3 * linkages.simulate(system).evaluate(time - time[0])["slide.x"] + slide
    return rms(found - found.mean())


def test_the_slide_is_where_the_fitted_lengths_put_it(tmp_path):
    """0.42 mm in the whole second half; with the lengths that the laboratory states 2.4 mm."""
    assert slide_error(tmp_path, {"r": 0.07777, "l": 0.250906, "h": 0.147272}) < 0.5
    assert slide_error(tmp_path, {"r": 0.075, "l": 0.26, "h": 0.155}) > 1.5


def test_the_rocker_turns_as_the_crank_moves_it(tmp_path):
    """0.26 deg/s in the whole record."""
    columns(tmp_path / "crank.csv", time=0.1007000862 * np.arange(len(CRANK)), rate=np.array(CRANK))
    time, rate = np.array(ROCKER).T
    values = {"duration": 2.4, "drives.O.angle": 0.868778, "drives.O.gain": 1.004083}
    found = linkages.simulate(machine("four_bar", tmp_path, values)).evaluate(time + 0.052594)["rocker.omega"]
    assert rms(np.degrees(found) / -0.998361 - rate) < 0.5
    assert rms(rate) > 20.0


def test_a_double_pendulum_follows_its_measured_torques(tmp_path):
    """0.017 and 0.021 rad in the first half of the record; here with every eighth sample of the torques."""
    time, q1, q2, T1, T2 = np.array(ARM).T
    columns(tmp_path / "record.csv", time=time, T1=T1, T2=T2)
    fitted = {
        "sdf.links.upper.com.y": -0.224003, "sdf.links.upper.inertia": 0.00547991, "sdf.links.lower.mass": 0.473461,
        "sdf.links.lower.com.y": -0.329127, "sdf.links.lower.inertia": 0.00417266, "frictions.shoulder.constant": 0.0739044,
        "frictions.shoulder.viscous": 1e-4, "frictions.elbow.constant": 0.186964, "frictions.elbow.viscous": 1e-4,
    }  # fmt: skip
    run = linkages.simulate(machine("double_pendulum", tmp_path, fitted | {"duration": 2.0})).evaluate(time[:-1])
    assert rms(run["q.S"] - q1[:-1] - 0.0792319) < 0.05
    assert rms(run["q.E"] - q2[:-1] + 0.0971861) < 0.07
    assert q2.max() - q2.min() > 2.3
