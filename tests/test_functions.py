"""Functions of time and of the state: formulas as programs against the formulas themselves, and their derivatives."""

import math

import numpy as np
import pytest
from machines import four_bar
from test_loads import GOOD, NO_STATES, RNG, direction, slope, states, wrenches_along

from linkages import InputError, ideal, load, simulate
from linkages.elements.machine import add_elements
from linkages.input.files.formula import FUNCTIONS, parse
from linkages.input.functions.definitions import formula, program, table_over
from linkages.mechanics.planar.jets import CODES
from linkages.mechanics.planar.motion import Motions, evaluate_motions, function_jet, monotone_table

#: Every function and operator, smooth and defined for a and b between 0.2 and 0.8.
FORMULAS = (
    "-a + +b - 2.5*a*b",
    "(a - 0.3)/(b + a*a)",
    "a**3 - b**2 + a**1 + b**0 + a**0.5",
    "(-a)**3 + 2**b",
    "a**b",
    "sqrt(a)*exp(-b) + log(a + b)",
    "sin(a*b)*cos(3*a) + tan(b)*tanh(a - b)",
    "asin(a) + acos(b)*atan(a/b)",
    "atan2(a, -b) + atan2(-b, a*a)",
    "hypot(a, b, a*b) + pi",
    "abs(a - 1)*b + abs(a)",
    "min(a, b + 1, 2*a)*max(b, a - 1)",
)


def jet(text, a, b, da=(0.0, 0.0), db=(0.0, 0.0)):
    motions = Motions([program(parse(text), {"a": 1, "b": 2})])
    return function_jet(motions.arrays, 0, np.array([[0.0, 0.0, 0.0], [a, *da], [b, *db]]))


def test_programs_compute_formulas_and_their_derivatives():
    """Along a parabola in the plane of a and b, against differences; the two evaluations share the parser alone."""
    named = {name for text in FORMULAS for name in CODES if f"{name}(" in text}
    assert set(FUNCTIONS) <= named
    for text in FORMULAS:
        for _ in range(5):
            (a, b), (a1, b1), (a2, b2) = RNG.uniform(0.25, 0.75, 2), *RNG.normal(size=(2, 2))

            def along(s, k, text=text, a=a, b=b, a1=a1, b1=b1, a2=a2, b2=b2):
                at = a + s * a1 + 0.5 * s * s * a2, b + s * b1 + 0.5 * s * s * b2
                return jet(text, *at, (a1 + s * a2, a2), (b1 + s * b2, b2))[k]

            found = jet(text, a, b, (a1, a2), (b1, b2))
            assert found[0] == pytest.approx(parse(text)({"a": a, "b": b}), rel=1e-14)
            assert found[1] == pytest.approx(slope(lambda s, f=along: f(s, 0), 1e-3), rel=1e-8, abs=1e-9)
            assert found[2] == pytest.approx(slope(lambda s, f=along: f(s, 1), 1e-3), rel=1e-7, abs=1e-8)


def test_kinks_and_zeros_have_numbers():
    assert jet("max(0, a)", -1.0, 0.0, (2.0, 0.0)) == (0.0, 0.0, 0.0)
    assert jet("max(0, a)", 1.0, 0.0, (2.0, 0.0)) == (1.0, 2.0, 0.0)
    assert jet("a**2", 0.0, 0.0, (3.0, 0.0)) == (0.0, 0.0, 18.0)
    assert jet("hypot(a, b)", 0.0, 0.0, (1.0, 0.0)) == (0.0, 0.0, 0.0)
    assert math.isnan(jet("sqrt(a)", -1.0, 0.0)[0])


def test_a_table_over_a_position_is_monotone_and_keeps_its_ends():
    places, values = [-1.0, 0.0, 0.5, 2.0], [3.0, 3.0, -1.0, -2.0]
    motions = Motions([monotone_table(places, values), table_over(1, 0)])

    def at(x):
        return function_jet(motions.arrays, 1, np.array([[0.0, 0.0, 0.0], [x, 1.0, 0.0]]))

    for x, value in zip(places, values, strict=True):
        assert at(x)[0] == pytest.approx(value, abs=1e-14)
    assert at(-7.0) == (3.0, 0.0, 0.0)
    assert at(9.0) == pytest.approx((-2.0, 0.0, 0.0), abs=1e-14)
    inside = np.array([at(x)[0] for x in np.linspace(-1.0, 2.0, 200)])
    assert np.all(np.diff(inside) <= 1e-14)
    assert at(0.3)[1] == pytest.approx(slope(lambda s: at(0.3 + s)[0], 1e-3), rel=1e-9)


def test_a_formula_of_time_gives_rate_and_acceleration():
    motions = Motions([program(formula("0.3*sin(5*t)", of_state=False), {"t": 0}), monotone_table([0, 1], [0.0, 2.0])])
    value, rate, second = np.zeros((3, 2))
    evaluate_motions(motions.arrays, 0.7, value, rate, second)
    s, c = math.sin(3.5), math.cos(3.5)
    np.testing.assert_allclose([value[0], rate[0], second[0]], [0.3 * s, 1.5 * c, -7.5 * s], rtol=1e-14)
    assert (value[1], rate[1]) == pytest.approx((1.4, 2.0))


STATE = """
[forces.drag]
point = "coupler_tip"
formula = ["-2*coupler_tip.vx*hypot(coupler_tip.vx, coupler_tip.vy)", "3*sin(4*t) - crank.angle*follower.omega"]
[forces.jet]
point = "follower_tip"
axes = "body"
formula = ["1.5*follower_tip.y", "Q.coordinate*O.rate"]
[forces.cutting]
point = "coupler"
over = "coupler_tip.x"
at = [-20.0, 0.0, 20.0]
forces = [[1.0, 0.0], [0.0, 2.0], [3.0, 1.0]]
[torques.motor]
joint = "Q"
over = "Q.rate"
at = [-30.0, 0.0, 30.0]
torques = [2.0, 1.0, -1.0]
[torques.stirrer]
link = "coupler"
formula = "-0.1*coupler.omega*abs(coupler.omega)"
"""


@pytest.fixture(params=["0 0 1", "0 0 -1"])
def driven(request, system_of):
    sdf = four_bar()
    axis = '<joint name="Q" type="revolute"><parent>world</parent><child>follower</child>\n<axis><xyz>{}</xyz>'
    assert axis.format("0 0 1") in sdf
    sdf = sdf.replace(axis.format("0 0 1"), axis.format(request.param))
    return system_of(sdf, GOOD + STATE), 1.0 if request.param == "0 0 1" else -1.0


def test_wrenches_are_those_of_the_formulas_as_written(driven):
    """Power of all loads at any state, from positions and velocities of points by independent rigid-body formulas."""
    system, sign = driven
    tree, t = system.tree, 0.3
    for _ in range(5):
        q, v = RNG.normal(size=(2, tree.size))
        pose, vel = states(tree, q, v)

        def point(name, pose=pose, vel=vel):
            body, x, y = tree.named_marker(name)
            angle, w = pose[body, 2], vel[body, 0]
            arm = np.array([x * np.cos(angle) - y * np.sin(angle), x * np.sin(angle) + y * np.cos(angle)])
            frame = angle + tree.mechanism.point[name].angle
            return pose[body, :2] + arm, vel[body, 1:] + w * np.array([-arm[1], arm[0]]), frame, w

        (tip, v_tip, *_), (_, v_coupler, _, w) = point("coupler_tip"), point("coupler")
        follower_tip, v_follower, axis, w_follower = point("follower_tip")
        drawn = tree.mechanism.point["follower"].angle
        crank = point("crank")
        drag = np.array([-2 * v_tip[0] * np.hypot(*v_tip), 3 * np.sin(4 * t) - crank[2] * w_follower])
        across = np.array([1.5 * follower_tip[1], sign * (axis - drawn) * crank[3]])
        c, s = np.cos(axis), np.sin(axis)
        jet_force = np.array([c * across[0] - s * across[1], s * across[0] + c * across[1]])
        places = [-20.0, 0.0, 20.0]
        cutting = [_at(places, values, tip[0]) for values in ([1.0, 0.0, 3.0], [0.0, 2.0, 1.0])]
        motor = _at([-30.0, 0.0, 30.0], [2.0, 1.0, -1.0], sign * w_follower)
        expected = drag @ v_tip + jet_force @ v_follower + np.dot(cutting, v_coupler)
        expected += motor * sign * w_follower - 0.1 * abs(w) ** 3
        wrench = np.zeros_like(vel)
        add_elements(system.elements, system.loads[1:], t, NO_STATES, pose, vel, wrench)
        assert np.sum(wrench * vel) == pytest.approx(expected, rel=1e-10)


def _at(places, values, x):
    from scipy.interpolate import PchipInterpolator

    return float(PchipInterpolator(places, values)(x))


def test_derivatives_of_loads_that_depend_on_the_state(driven):
    system, _ = driven
    loads, tree = (system.loads, system.elements), system.tree
    for _ in range(5):
        pose, vel = states(tree, *RNG.normal(size=(2, tree.size)))
        dpose, dvel, wrench = direction(loads, 0.4, pose, vel)
        found = wrenches_along(loads, 0.4, pose, vel, dpose, dvel)
        np.testing.assert_allclose(found, slope(wrench, 1e-4), rtol=1e-7, atol=1e-7)


def test_a_drive_by_a_formula_needs_the_torque_of_its_acceleration(system_of):
    from machines import bar, joint, model

    sdf = model("crank", bar("crank", 0.4, "__model__", mass=1.5) + joint("O", "world", "crank"))
    times = np.linspace(0.0, 1.0, 11)
    columns = ideal(system_of(sdf, 'duration = 1.0\n[drives.O]\nformula = "0.3*sin(5*t)"\n')).evaluate(times)
    np.testing.assert_allclose(columns["q.O"], 0.3 * np.sin(5 * times), atol=1e-14)
    np.testing.assert_allclose(columns["O.torque"], -0.08 * 7.5 * np.sin(5 * times), atol=1e-13)


#: Elements whose formulas read a frame on a flexible link.
READERS = {
    "torque": "[torques.M]\njoint = 'O'\nformula = '-0.5*middle.vy*t'\n",
    "state": "[states.z]\nrate = '-0.5*middle.vy*t'\n[torques.M]\njoint = 'O'\nformula = 'z'\n",
    "motor": "[motors.M]\njoint = 'O'\nkind = 'dc'\nresistance = 1\ntorque_constant = 1\nformula = '-0.5*middle.vy*t'\n",
    "controller": "[controllers.C]\nkind = 'pid'\nsignal = '2*middle.vy'\nreference = '0'\nproportional = 1\n",
}


@pytest.mark.parametrize("reader", READERS)
def test_a_section_that_a_formula_looks_at_is_there_in_runs(system_of, reader):
    """Signals of a flexible link without other loads: runs omit unloaded sections."""
    from machines import bar, elastic_bar, joint, model

    links = bar("crank", 0.15, "__model__") + elastic_bar("rod", 0.3, "crank_tip", 0.4)
    links += '<frame name="middle" attached_to="rod"><pose>0.15 0 0 0 0 0</pose></frame>'
    links += '<frame name="other" attached_to="rod"><pose>0.1 0 0 0 0 0</pose></frame>'
    sdf = model("pendulum", links + joint("O", "world", "crank") + joint("A", "crank_tip", "rod"))
    text = "duration = 0.1\n[links.rod]\nmodel = 'flexible'\nbending = 2\ndamping = 0.01\n"
    system = system_of(sdf, text + READERS[reader])
    assert system.tree.acting < len(system.tree.bodies.records)
    assert system.arrays.signals["term"]["b"]["body"].max() < system.tree.acting


FORCE = '[forces.P]\npoint = "follower_tip"\n'
#: case -> (text, expected part of the message)
WRONG = {
    "underscore": (
        FORCE + 'formula = ["2_0*t", "0"]\n',
        'forces.P: has the number "2_0"; write it without underscores',
    ),
    "not a formula": (FORCE + 'formula = ["2*", "0"]\n', 'forces.P: "2*" is not a formula'),
    "one component": (FORCE + 'formula = ["2*t"]\n', "forces.P.formula"),
    "unknown name": (FORCE + 'formula = ["2*x", "0"]\n', '"2*x" has "x"; it may have t, the time'),
    "unknown part": (
        FORCE + 'formula = ["crank.z", "0"]\n',
        '"crank.z" is not arithmetic: after a dot, known are: angle, coordinate',
    ),
    "unknown point": (FORCE + 'formula = ["cranck.x", "0"]\n', 'formula: "cranck" is not in machine.sdf; did you mean'),
    "unknown joint": (FORCE + 'formula = ["P.rate", "0"]\n', 'formula: "P" is not in machine.sdf'),
    "no number at the start": (FORCE + 'formula = ["log(-crank.x - 1)", "0"]\n', "forces.P.formula: is not a number"),
    "two kinds": (FORCE + 'force = [0.0, 1.0]\nformula = ["0", "0"]\n', "give either force"),
    "over without at": (
        FORCE + 'over = "crank.x"\nforces = [[0.0, 0.0], [1.0, 1.0]]\n',
        "over and at must both be given",
    ),
    "over what": (FORCE + 'over = "crank"\nat = [0.0, 1.0]\nforces = [[0.0, 0.0], [1.0, 1.0]]\n', "give POINT.x"),
    "over time and place": (
        FORCE + 'over = "crank.x"\nat = [0.0, 1.0]\ntimes = [0.0, 2.0]\nforces = [[0.0, 0.0], [1.0, 1.0]]\n',
        "give either times, or over and at",
    ),
    "falling places": (FORCE + 'over = "crank.x"\nat = [1.0, 0.0]\nforces = [[0.0, 0.0], [1.0, 1.0]]\n', "at must inc"),
    "too few places": (
        FORCE + 'over = "crank.x"\nat = [1.0]\nforces = [[0.0, 0.0], [1.0, 1.0]]\n',
        "1 places at and 2",
    ),
    "another unit": (
        FORCE + 'over = "crank.x"\nat = ["1 s", "2 s"]\nforces = [[0.0, 0.0], [1.0, 1.0]]\n',
        'forces.P.at: is "1 s"; it must be measured in m',
    ),
    "torque nowhere": ("[torques.M]\ntorque = 1.0\n", "give either link or joint"),
    "torque in no joint": ('[torques.M]\njoint = "P"\ntorque = 1.0\n', 'torques.M.joint: "P" is not in'),
    "drive by the state": (
        "\n[drives.Q]\nformula = 'crank.x'\n",
        'drives.Q: "crank.x" has "crank.x"; it may have t, the time',
    ),
    "drive with a kink": ("\n[drives.Q]\nformula = '0.1*sqrt(t)'\n", "drives.Q.formula: it, its rate"),
    "drive by two": ("\n[drives.Q]\nformula = '0.1*t'\nspeed = 1.0\n", "the formula prescribes the complete motion"),
}


@pytest.mark.parametrize("case", WRONG)
def test_wrong_functions_are_refused_in_one_line(experiment_file, case):
    text, reason = WRONG[case]
    start = "duration = 1.0\n" if "drives" in text else GOOD
    with pytest.raises(InputError) as problem:
        load(experiment_file(four_bar(), start + text)).assembly  # noqa: B018
    assert reason in str(problem.value)
    assert "\n" not in str(problem.value)


def test_a_controller_of_seventy_thousand_characters_moves_as_its_sum(experiment_file):
    """A formula as programs write it: 1,600 terms, whose sum is one term."""
    factors = [1e-6 * (k + 1) for k in range(1600)]
    terms = " - ".join(f"{factor!r}*sin(O.coordinate)*cos(A.coordinate)" for factor in factors)
    short = f"-{math.fsum(factors)!r}*sin(O.coordinate)*cos(A.coordinate)"
    assert len(terms) > 70_000
    runs = []
    for text in (f"-{terms}", short):
        load_text = f'duration = 0.2\ngravity = [0.0, -9.81, 0.0]\n[torques.P]\njoint = "O"\nformula = "{text}"\n'
        runs.append(simulate(load(experiment_file(four_bar(), load_text)), "compiled"))
    assert len(runs[0].time) == len(runs[1].time)
    assert np.abs(runs[0]["P.torque"]).max() > 0.1
    assert runs[0]["crank.angle"] == pytest.approx(runs[1]["crank.angle"], abs=1e-10)


def test_a_part_of_a_formula_that_comes_again_is_computed_once():
    steps = program(parse("sin(a*b) + 2*sin(a*b) - sin(a*b)*cos(b)"), {"a": 1, "b": 2}).steps
    assert len(steps) == len({tuple(step) for step in steps.tolist()}) == 10
    assert jet("sin(a*b) + 2*sin(a*b) - sin(a*b)*cos(b)", 0.3, 0.7)[0] == pytest.approx(
        math.sin(0.21) * (3.0 - math.cos(0.7)), rel=1e-15
    )


def test_a_long_sum_within_something_else_is_refused_in_one_line():
    with pytest.raises(ValueError, match="a deeply nested part is not arithmetic"):
        parse(f"[{'+'.join(['x'] * 2000)}]")
