"""Derivatives of runs against independently computed values.

The values of the ball, the rattling block and the oscillator come from variational equations with jumps at the contacts
(SciPy, relative tolerance 1e-13), and from central differences of solutions with 32 digits (mpmath); the oscillator's
from the closed form of its linear pieces, with 40 digits. Those of the slider-crank are differences of runs with the
accuracy 2e-13, extrapolated over two ladders of steps.
"""

import numpy as np
import pytest
from machines import BEARING, bar, four_bar, joint, model, solid, written
from scipy.linalg import expm

import linkages

BALL = (
    model("block", solid("block", 2.0) + joint("slide", "world", "block", "prismatic", "0 1 0")),
    """duration = 0.9
gravity = [0.0, 0.0, 0.0]
outputs = ["block.y"]
[drives.slide]
angle = 0.0
speed = 0.0
force = -19.62
[stops.floor]
joint = "slide"
side = "lower"
limit = -0.2
contact = { law = "hunt-crossley", restitution = 0.7, stiffness = 1e6 }
[solver]
max_step = 1e-2
""",
)
RATTLE = (
    model(
        "rattle",
        solid("block", 0.7)
        + joint("slide", "world", "block", "prismatic", "1 0 0")
        + joint("B", "world", "block", inner=BEARING.replace("0.01<", "0.05<")),
    ),
    """duration = 0.07
gravity = [0.0, 0.0, 0.0]
outputs = ["block.x"]
[drives.slide]
angle = 0.0
speed = 0.2
force = 0.0
[forces.shake]
point = "block"
formula = ["60.0*sin(157.07963267948966*t)", "0"]
[joints.B]
model = "dry"
clearance = 1e-3
contact = { law = "lankarani-nikravesh", restitution = 0.8, stiffness = 1e9 }
[solver]
max_step = 1e-3
""",
)
OSCILLATOR = (
    model("block", solid("block", 1.0) + joint("slide", "world", "block", "prismatic", "1 0 0")),
    """duration = 0.75398223686155
gravity = [0.0, 0.0, 0.0]
outputs = ["block.x", "block.vx"]
[drives.slide]
angle = -0.01
speed = 0.0
force = 0.0
[forces.shake]
point = "block"
formula = ["-20*cos(25*t)", "0"]
[springs.spring]
point = "block"
anchor = [-1.0, 0.0]
stiffness = 400.0
free_length = 1.0
damping = 4.0
[stops.end]
joint = "slide"
side = "upper"
limit = 0.02
contact = { law = "kelvin-voigt", restitution = 1.0, stiffness = 4000.0, damping = 8.0 }
[solver]
max_step = 1e-3
""",
)
#: Machine: path, output, time [s], derivative.
VALUES = {
    "ball": [
        ("drives.slide.force", "block.y", 0.15, 0.15**2 / 4.0),  # t2/(2 m), before the contact
        ("drives.slide.force", "block.y", 0.21, -0.002041330852804687),
        ("drives.slide.force", "block.y", 0.45, 0.008904540786374933),
        ("drives.slide.force", "block.y", 0.6, -0.007564088133081761),
        ("stops.floor.limit", "block.y", 0.3, 1.0242075048004315),
        ("stops.floor.limit", "block.y", 0.53, 1.1732853012180176),
        ("stops.floor.limit", "block.y", 0.8, 2.2213910252068256),
        ("stops.floor.contact.stiffness", "block.y", 0.45, -2.4041015686425575e-09),
        ("sdf.links.block.mass", "block.y", 0.8, -0.13540808338890079),
        ("drives.slide.angle", "block.y", 0.6, -0.4735842978245312),
    ],
    "rattle": [
        ("drives.slide.force", "block.x", 0.014, -1.1946934178831524e-05),
        ("drives.slide.force", "block.x", 0.03, 0.000230007081651091),
        ("joints.B.clearance", "block.x", 0.03, -5.927597395839152),
        ("joints.B.contact.restitution", "block.x", 0.022, -0.005590083958678197),
        ("sdf.links.block.mass", "block.x", 0.03, -0.010136466435053292),
    ],
    "oscillator": [
        ("sdf.links.block.mass", "block.vx", 0.3, -2.125191526827646),
        ("springs.spring.stiffness", "block.x", 0.2, -8.528294717202981e-05),
        ("springs.spring.damping", "block.vx", 0.7, 0.16392853374892016),
        ("stops.end.limit", "block.x", 0.3, -0.5709600835734128),
        ("stops.end.contact.stiffness", "block.vx", 0.3, 9.158909447220645e-05),
        ("stops.end.contact.damping", "block.x", 0.7, 0.002101425979848421),
        ("drives.slide.angle", "block.vx", 0.2, 1.3013616347657047),
        ("drives.slide.speed", "block.x", 0.3, 0.0218453255323931),
    ],
    "slider_crank_dry": [
        ("joints.B.clearance", "B.ex", 0.00077, -0.4739159738262496),
        ("joints.B.contact.restitution", "slider.x", 0.00077, 0.00010539105762435523),
        ("joints.B.friction.coefficient", "slider.x", 0.00077, -0.0014850920285759304),
        ("drives.O.speed", "B.ey", 0.001, 2.231018814699612e-06),
        ("sdf.links.slider.mass", "B.ex", 0.00077, -0.000894103884183865),
    ],
}
MACHINES = {"ball": BALL, "rattle": RATTLE, "oscillator": OSCILLATOR}


def _system(name, folder, overrides):
    if name in MACHINES:
        return linkages.load(written(folder, *MACHINES[name]), overrides)
    return linkages.load(linkages.find_file(f"{name}.toml"), {"duration": 0.0011, **overrides})


def _derivatives(system, wanted):
    run = linkages.simulate(system, outputs=sorted({one[1] for one in wanted}), wrt=sorted({one[0] for one in wanted}))
    assert run.sensitivity.status == "ok"
    return np.array([run.sensitivity.evaluate(np.array([t]))[path][output][0] for path, output, t, _ in wanted])


@pytest.mark.parametrize("name", VALUES)
@pytest.mark.parametrize(("accuracy", "limit"), [(1e-12, 2e-6), (1e-9, 1e-3)])
def test_derivatives_are_the_independent_values(name, accuracy, limit, tmp_path):
    """The slider-crank's own references are known to 1e-6."""
    found = _derivatives(_system(name, tmp_path, {"solver.accuracy": accuracy}), VALUES[name])
    np.testing.assert_allclose(found, [one[3] for one in VALUES[name]], rtol=limit if name[0] == "s" else limit / 2)


@pytest.mark.parametrize("shift", [-1.0, -5.0])
def test_derivatives_by_a_stop_do_not_depend_on_where_its_coordinate_begins(shift, tmp_path):
    wanted = [one for one in VALUES["ball"] if one[0] == "stops.floor.limit"]
    overrides = {"drives.slide.angle": -shift, "stops.floor.limit": -0.2 - shift, "solver.accuracy": 1e-11}
    found = _derivatives(_system("ball", tmp_path, overrides), wanted)
    np.testing.assert_allclose(found, [one[3] for one in wanted], rtol=1e-6)


def test_derivatives_of_a_kelvin_voigt_contact_converge_with_the_accuracy(tmp_path):
    """The force vanishes before the bodies part: steps end there."""
    path, output, time, right = next(one for one in VALUES["oscillator"] if one[0] == "drives.slide.angle")
    errors = [
        abs(
            _derivatives(_system("oscillator", tmp_path, {"solver.accuracy": a}), [(path, output, time, right)])[0]
            - right
        )
        for a in (1e-8, 1e-10, 1e-12)
    ]
    assert errors[1] < 1e-5 * right
    assert errors[2] < 1e-7 * right


STRUCK = """duration = 0.4
gravity = [0.0, 0.0, 0.0]
[drives.O]
speed = 2.0
%s = 0.0
[stops.end]
joint = "O"
side = "upper"
limit = 0.3
[stops.end.contact]
stiffness = 20.0
"""
CONTACTS = {
    "kelvin-voigt": {"law": "kelvin-voigt", "restitution": 1.0, "damping": 0.05},
    "unclipped": {"law": "hunt-crossley", "exponent": 1.0, "restitution": 0.4, "clip": False},
}


@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
@pytest.mark.parametrize("integrator", ["radau_iia_5", "dormand_prince_5_4"])
@pytest.mark.parametrize("law", CONTACTS)
def test_derivatives_do_not_depend_on_how_exactly_the_start_of_a_contact_is_met(kind, integrator, law, tmp_path):
    """A free body meets a stop, whose force is proportional to the speed w of the impact.

    The penetration is w g(t - t0) with t0 = (limit - angle)/w, before and after the bodies part, so that the derivatives
    follow from coordinate and speed.
    """
    axis, drive, place = ("0 0 1", "torque", "angle") if kind == "revolute" else ("1 0 0", "force", "x")
    sdf = model("struck", solid("body", 0.02, 0.02) + joint("O", "world", "body", kind, axis))
    system = linkages.load(
        written(tmp_path, sdf, STRUCK % drive),
        {"solver.integrator": integrator, "solver.accuracy": 1e-10}
        | {f"stops.end.contact.{key}": value for key, value in CONTACTS[law].items()},
    )
    names, times = [f"body.{place}", "body.omega" if kind == "revolute" else "body.vx"], np.array([0.16, 0.2, 0.39])
    paths = ["stops.end.limit", "drives.O.speed"]
    for angle in [0.0, *np.random.default_rng(3).uniform(0.0, 0.05, 15)]:
        run = linkages.simulate(system.replaced({"drives.O.angle": angle}), outputs=names, wrt=paths)
        assert run.sensitivity.status == "ok"
        found, (where, speed) = run.sensitivity.evaluate(times), (run.evaluate(times)[name] for name in names)
        expected = [1.0 - speed / 2.0, (where - 0.3) / 2.0 + speed * (0.3 - angle) / 4.0]
        for path, right in zip(paths, expected, strict=True):
            np.testing.assert_allclose(found[path][names[0]], right, rtol=1e-5, atol=1e-6)


def test_bristles_that_come_to_rest_when_a_contact_ends_have_derivatives(tmp_path):
    """Their rate jumps there; the next contact begins with their state. Differences of runs of the fourth order."""
    text = """duration = 0.016
gravity = [0.0, -9.81, 0.0]
[drives.O]
speed = 15.0
torque = 0.3
[joints.B]
model = "dry"
clearance = 5e-4
contact = { law = "lankarani-nikravesh", restitution = 0.8, stiffness = 1e8 }
friction = { law = "lugre", coefficient = 0.1, static = 0.14, v_1 = 1e-2, bristle_stiffness = 1e4, bristle_damping = 1.0 }
[solver]
accuracy = 1e-11
integrator = "dormand_prince_5_4"
"""
    system = linkages.load(written(tmp_path, four_bar(), text))
    path, output, times, step = "drives.O.torque", "B.ex", np.array([0.0125, 0.0158]), 2e-4
    found = linkages.simulate(system, outputs=[output], wrt=[path]).sensitivity.evaluate(times)[path][output]
    near = [
        linkages.simulate(system.replaced({path: 0.3 + k * step}), outputs=[output]).evaluate(times)[output]
        for k in (-2, -1, 1, 2)
    ]
    expected = ((near[0] - near[3]) / 12 + (near[2] - near[1]) * 2 / 3) / step
    np.testing.assert_allclose(found, expected, rtol=2e-6)


def test_a_machine_with_a_spring_and_no_contact_has_derivatives_by_the_place_of_a_joint(tmp_path):
    """A double pendulum from rest, its second joint on a spring: differences of runs of the fourth order."""
    bars = bar("rod", 0.3, "__model__", 0.3) + bar("tail", 0.2, "rod_tip", -0.5)
    pendulum = model("pendulum", bars + joint("O", "world", "rod") + joint("A", "rod_tip", "tail"))
    text = """duration = 0.4
outputs = ["rod_tip.x"]
[springs.s]
point = "rod_tip"
anchor = [0.1, 0.4]
stiffness = 30.0
free_length = 0.2
damping = 0.5
[solver]
accuracy = 1e-12
"""
    system = linkages.load(written(tmp_path, pendulum, text))
    path, times = "sdf.frames.rod_tip.pose.x", np.array([0.1, 0.2, 0.4])
    found = linkages.simulate(system, wrt=[path]).sensitivity.evaluate(times)[path]["rod_tip.x"]
    near = [
        linkages.simulate(system.replaced({path: 0.3 + k * 1e-4})).evaluate(times)["rod_tip.x"] for k in (-2, -1, 1, 2)
    ]
    expected = ((near[0] - near[3]) / 12 + (near[2] - near[1]) * 2 / 3) / 1e-4
    np.testing.assert_allclose(found, expected, rtol=1e-7)


@pytest.mark.parametrize(
    ("path", "expected"),
    [
        ("drives.O.speed", {"B.force": 5.138, "rod.stress": 1.859e6}),
        ("sdf.links.rod.beam.height", {"B.force": 70.81, "rod.stress": -1.678e10}),
    ],
)
def test_peaks_of_a_flexible_machine_have_derivatives_within_their_stated_errors(path, expected):
    """The values are differences of runs with tight accuracy."""
    system = linkages.load(linkages.find_file("slider_crank_flexible.toml"), {"duration": 0.03})
    found = linkages.sensitivities(system, [path], list(expected))
    for output, right in expected.items():
        key = f"{output}.peak"
        off = abs(found.derivatives[path][key] - right)
        assert off < 2.0 * found.errors[path][key] + 2e-4 * abs(right)
        assert off < 2e-3 * abs(right)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "overrides", "paths", "outputs"),
    [
        (
            "slider_crank_flexible",
            {"duration": 0.03},
            ["drives.O.speed", "joints.B.clearance"],
            ["B.force", "rod.stress"],
        ),
        ("slider_crank_dry", {}, ["joints.B.clearance", "sdf.links.slider.mass"], ["B.force", "slider.ax", "O.torque"]),
        (
            "slider_crank_lubricated",
            {"duration": 0.01},
            ["joints.B.clearance", "drives.O.speed"],
            ["B.force", "slider.ax"],
        ),
        ("ball", {}, ["drives.slide.force", "stops.floor.limit", "sdf.links.block.mass"], ["block.vy", "floor.load"]),
        ("oscillator", {}, ["drives.slide.angle", "stops.end.contact.damping"], ["block.vx", "end.load"]),
    ],
)
def test_stated_errors_of_derivatives_are_at_least_half_of_the_true_ones(name, overrides, paths, outputs, tmp_path):
    """At the default accuracy, against a run with the accuracy 1e-11."""
    found, right = (
        linkages.sensitivities(_system(name, tmp_path, {**overrides, **more}), paths, outputs, error_estimate=not more)
        for more in ({}, {"solver.accuracy": 1e-11})
    )
    for path in paths:
        for key, rate in found.derivatives[path].items():
            assert abs(rate - right.derivatives[path][key]) <= 2.0 * found.errors[path][key]


@pytest.mark.parametrize("exponent", [1.5, 1.6])
def test_the_largest_depth_has_a_derivative_with_respect_to_the_exponent(exponent, tmp_path):
    """Energy: m v^2/2 = K d^(n + 1)/(n + 1) at the largest depth d."""
    text = """duration = 0.2
gravity = [0.0, 0.0, 0.0]
[drives.slide]
force = 0.0
speed = 2.0
[stops.end]
joint = "slide"
side = "upper"
limit = 0.1
contact = { law = "hertz", restitution = 1.0, stiffness = 1e4 }
[solver]
accuracy = 1e-10
"""
    sdf = model("block", solid("block", 2.0) + joint("slide", "world", "block", "prismatic", "1 0 0"))
    path = "stops.end.contact.exponent"
    system = linkages.load(written(tmp_path, sdf, text), {path: exponent})
    found, n = linkages.sensitivities(system, [path], ["block.x"]).derivatives[path]["block.x.peak"], exponent + 1.0
    share = n * 2.0 * 2.0**2 / (2.0 * 1e4)
    assert found == pytest.approx(share ** (1.0 / n) * (1.0 - np.log(share)) / n**2, rel=1e-7)


def test_equal_numbers_of_a_friction_have_their_own_derivatives(tmp_path):
    """A block on a rail, -F/m = a = g (mu + (mu_s - mu) exp(-(v/v_s)^2)) tanh(v/v_1): v_1 = mu = mu_s - mu, v_s = 2."""
    text = """duration = 1e-3
gravity = [0.0, -9.81, 0.0]
drives = { slide = { force = 0.0, speed = 0.7 } }
[frictions.rail]
joint = "slide"
coefficient = 0.5
speed = 0.5
static_coefficient = 1.0
stribeck_speed = 2.0
"""
    sdf = model("block", solid("block", 2.0) + joint("slide", "world", "block", "prismatic", "1 0 0"))
    system, v = linkages.load(written(tmp_path, sdf, text)), 0.7
    fall, grip = np.exp(-((v / 2.0) ** 2)), np.tanh(v / 0.5)
    right = {
        "coefficient": (1.0 - fall) * grip,
        "static_coefficient": fall * grip,
        "speed": (0.5 + 0.5 * fall) * (grip**2 - 1.0) * v / 0.5**2,
        "stribeck_speed": 0.5 * fall * grip * v**2 / 4.0,
    }
    paths = [f"frictions.rail.{key}" for key in right]
    found = linkages.simulate(system, outputs=["block.ax"], wrt=paths).sensitivity
    for path, slope in zip(paths, right.values(), strict=True):
        assert found[path]["block.ax"][0] == pytest.approx(-9.81 * slope, rel=1e-9)


def test_the_friction_in_a_joint_jumps_with_the_force_of_a_contact(tmp_path):
    """A block on a rail meets a slope with a damper, whose force presses it onto the rail: linear after that."""
    text = """duration = 0.08
gravity = [0.0, -9.81, 0.0]
drives = { slide = { force = 0.0, speed = 2.0 } }
[frictions.rail]
joint = "slide"
coefficient = 0.3
speed = 1e-3
[contacts.slope]
point = "block"
anchor = [0.1, 0.0]
angle = "120 deg"
contact = { law = "kelvin-voigt", restitution = 1.0, stiffness = 1e3, damping = 50.0 }
[solver]
accuracy = 1e-11
"""
    sdf = model("block", solid("block", 2.0) + joint("slide", "world", "block", "prismatic", "1 0 0"))

    def exact(speed=2.0, mu=0.3, damping=50.0, slope=np.pi / 1.5):
        brake, normal, press = 9.81 * mu, np.sin(slope), -np.cos(slope)
        met = np.sqrt(speed**2 - 2.0 * brake * 0.1)
        share = normal * (normal + mu * press) / 2.0
        rates = np.array([[0.0, 1.0, 0.0], [-share * 1e3, -share * damping, -brake], [0.0, 0.0, 0.0]])
        return (expm(rates * (0.08 - (speed - met) / brake)) @ [0.0, met, 1.0])[0] + 0.1

    paths = {
        "drives.slide.speed": ("speed", 2.0),
        "frictions.rail.coefficient": ("mu", 0.3),
        "contacts.slope.contact.damping": ("damping", 50.0),
        "contacts.slope.angle": ("slope", np.pi / 1.5),
    }
    run = linkages.simulate(linkages.load(written(tmp_path, sdf, text)), outputs=["block.x"], wrt=list(paths))
    assert run["block.x"][-1] == pytest.approx(exact(), rel=1e-9)
    for path, (name, value) in paths.items():
        right = (exact(**{name: value * (1 + 1e-5)}) - exact(**{name: value * (1 - 1e-5)})) / (2e-5 * value)
        assert run.sensitivity[path]["block.x"][-1] == pytest.approx(right, rel=1e-6)
