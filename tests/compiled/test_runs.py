"""Runs of the compiled engine: integrators, threads and processes, states between steps, edited kernels."""

import os
import shutil
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest
from machines import BEARING, four_bar
from reference_machines import chain_sdf, double_pendulum
from shipped import run as run_shipped
from shipped import shipped

import linkages
from linkages import laws, simulate
from linkages.base.errors import notice
from linkages.base.kernel import kernel
from linkages.base.kernel.by_reference import packed, reference
from linkages.engines.compiled.run.replay import replay
from linkages.engines.compiled.run.runner import Runner, join
from linkages.engines.drop import GRAVITY, drop
from linkages.engines.methods import method
from linkages.mechanics.integrate.stepper import COUNT, make_stepper


@pytest.mark.parametrize("method", ["dormand_prince_5_4", "radau_iia_5"])
def test_double_pendulum_swings_as_lagrange_says_and_keeps_its_energy(system_of, method):
    lengths, angles = (0.3, 0.2), (0.4, -0.9)
    text = f'duration = 2.0\ngravity = [0.0, -9.81, 0.0]\n[solver]\naccuracy = 1e-12\nintegrator = "{method}"\n'
    run = simulate(system_of(chain_sdf(lengths, angles), text), "compiled")
    assert run.provenance["method"] == method
    q, v = double_pendulum(lengths, angles, run.time)
    for i in range(2):
        np.testing.assert_allclose(run[f"bar{i + 1}.angle"], q[:, i], rtol=0, atol=1e-8)
        np.testing.assert_allclose(run[f"bar{i + 1}.omega"], v[:, i], rtol=0, atol=1e-7)
    energy = run["kinetic_energy"] + run["potential_energy"]
    np.testing.assert_allclose(energy, energy[0], rtol=0, atol=1e-9 * run["kinetic_energy"].max())


def test_a_machine_of_another_size_makes_the_same_steps(system_of):
    """Equal masses and times, lengths and forces 64 times as large: floating-point numbers scale exactly."""

    def run(size):
        bearing = BEARING.replace("0.01<", f"{0.01 * size}<").replace("0.02<", f"{0.02 * size}<")
        sdf = four_bar(*(size * np.array([0.3, 0.1, 0.25, 0.2]))).replace(BEARING, bearing)
        text = f"""duration = 0.05\n[drives.O]\nspeed = 15.0
[joints.B]\nmodel = "dry"\nclearance = {1e-4 * size}
contact = {{law = "flores", restitution = 0.8, youngs_modulus = {2e11 / size}}}
[joints.B.friction]\nlaw = "lugre"\ncoefficient = 0.1\nv_1 = {0.01 * size}\nbristle_stiffness = {1e5 / size}"""
        return simulate(system_of(sdf, text), "compiled")

    small, large = run(1.0), run(64.0)
    np.testing.assert_array_equal(small.time, large.time)
    for name, power in (("B.force", 1), ("B.friction_torque", 2), ("B.ex", 1), ("O.torque", 2), ("follower.omega", 0)):
        np.testing.assert_allclose(large[name], 64.0**power * small[name], rtol=1e-12, err_msg=name)


def test_arrays_of_any_layout_give_the_same_run():
    """Functions called by address cannot look at the layout that they are given."""
    system, strided = (shipped("seven_bar_dry", duration=1e-3) for _ in range(2))
    ends = np.repeat(strided.ends, 2)[::2]
    assert not ends.flags.c_contiguous
    strided.__dict__["ends"] = ends
    last = []
    for each in (system, strided):
        runner = Runner(each)
        last.append(runner.run(0.0, runner.start, 0.0, 10**6).states[-1])
    np.testing.assert_array_equal(*last)


@pytest.mark.processes
def test_a_result_can_be_sent_to_another_process():
    """Its functions' addresses are of no use there: the same evaluation in a process that has compiled nothing yet."""
    result = run_shipped("compiled", "slider_crank_dry", duration=1e-3)
    times = np.linspace(0.0, 1e-3, 7)
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        there = pool.submit(result.evaluate, times).result()
    np.testing.assert_array_equal(there["B.force"], result.evaluate(times)["B.force"])


@pytest.mark.processes
@pytest.mark.parametrize("name", ["seven_bar", "slider_crank_dry"])
def test_a_run_can_be_repeated_to_the_last_bit_in_threads_too(name):
    system = shipped(name)
    first = simulate(system, "compiled")
    with ThreadPoolExecutor(4) as pool:
        others = list(pool.map(lambda _: simulate(system, "compiled"), range(8)))
    for other in others:
        assert other.columns.keys() == first.columns.keys()
        for column, values in first.columns.items():
            np.testing.assert_array_equal(other[column], values)


@pytest.mark.parametrize("name", ["seven_bar", "slider_crank_lubricated", "seven_bar_mixed"])
@pytest.mark.parametrize("accuracy", [1e-4, 1e-7])
def test_states_between_steps_are_those_of_a_run_that_ends_there(name, accuracy):
    """Also if a step cannot be repeated as a whole."""
    system = shipped(name, **{"solver.accuracy": accuracy})
    result = simulate(system, "compiled")
    times = np.linspace(0.0, result.time[-1], 2003)
    columns = result.evaluate(times)
    assert all(np.isfinite(values).all() for values in columns.values())
    middle = float(times[1001])
    ended, finest = (
        simulate(system.replaced({"duration": middle, "solver.accuracy": each}), "compiled")
        for each in (accuracy, 1e-11)
    )
    joint = system.tree.play[0]
    for end in ("ex", "ey"):
        name = f"{joint}.{end}"
        size = np.abs(columns[name]).max()
        error = abs(ended[name][-1] - finest[name][-1])
        assert abs(columns[name][1001] - finest[name][-1]) < 10.0 * error + 100.0 * accuracy * size


PROBE = """
import ctypes
import numpy as np
from numba import types
import linkages
from linkages.base.kernel import address
from linkages.laws import FILMS, PARAMETERS
from linkages.laws.film.films import film_force

NONE = np.zeros(1)
SHORT = np.zeros(1, PARAMETERS)[0]
SHORT["film"] = FILMS["short"].address

def probe(eps):
    return film_force(SHORT, eps, 0.1, 0.2, 0.25, NONE)[0]

pair = address(probe, types.float64(types.float64))  # of the addresses of the functions for floats and for duals
by_address = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_double)(ctypes.c_int64.from_address(pair).value)
print(linkages.__file__, probe(0.5), by_address(0.5))
"""


@kernel
def again(equations, stepper, tolerance, steps, times, y):
    """Go through a run's states at times; returns the evaluations that it took."""
    s = reference(stepper)
    for t in times:
        replay(reference(equations), s, tolerance, reference(steps), t, y)
    return s.memory[COUNT]


@pytest.mark.parametrize("name", ["seven_bar", "slider_crank_flexible", "three_rrr_clearance"])
def test_states_between_steps_take_less_than_a_step(name):
    """Newton's method starts from the run's own states, near enough not to fail; three stages, five iterations at most."""
    system = shipped(name, duration=0.3)
    runner = Runner(system)
    steps = join([runner.run(0.0, runner.start, 0.0, 10**6)])
    n, times = len(runner.start), np.linspace(0.0, 0.3, 1001)
    stepper = packed(make_stepper(n, len(runner.model.free)))
    taken = again(runner.aside(), stepper, runner.tolerance, packed(steps), times, np.zeros(n))
    assert taken < 3 * 5 * len(times)


def test_a_state_before_a_collapse_is_not_sought_for_ever():
    """Newton's method converges over parts of the last step that are as small as rounding: there is no number then."""
    runner = Runner(shipped("seven_bar", duration=0.01, **{"sdf.links.link2.inertia": 1e30}))
    steps = join([runner.run(0.0, runner.start, 1e-9, 10**6)])
    assert steps.times[-1] < 1e-6
    n = len(runner.start)
    stepper, middle = packed(make_stepper(n, len(runner.model.free))), steps.times[-2:].mean(keepdims=True)
    taken = again(runner.aside(), stepper, runner.tolerance, packed(steps), middle, np.zeros(n))
    assert taken < 100_000


def test_few_attempts_fail_where_films_are_thin():
    """Steps do not grow beyond what Newton's method can solve: without that limit 101 attempts fail in 177 steps."""
    runner = Runner(shipped("slider_crank_flexible", duration=0.1, **{"solver.accuracy": 1e-5}))
    run = runner.run(0.0, runner.start, 0.0, 10**6)
    assert run.rejected < 0.2 * run.steps


@pytest.mark.parametrize("accuracy", [1e-8, 1e-5, 1e-3, 1e-1])
def test_a_tighter_accuracy_is_another_run(accuracy):
    """However loose it is: else a run's error is estimated by the run itself."""
    loose, tight = (Runner(shipped("seven_bar", **{"solver.accuracy": a})) for a in (accuracy, 0.1 * accuracy))
    np.testing.assert_allclose(loose.tolerance, 10.0 * tight.tolerance, rtol=1e-14)


@pytest.mark.slow
def test_an_edited_law_reaches_the_kernels_that_call_it(tmp_path):
    """A copy of the package, run, edited, and run again: nothing stale comes from the compiler's cache."""
    shutil.copytree(Path(linkages.__file__).parent, tmp_path / "linkages")
    film = tmp_path / "linkages" / "laws" / "film" / "closed_form.py"
    (tmp_path / "probe.py").write_text(PROBE)
    environment = os.environ | {"PYTHONPATH": str(tmp_path), "NUMBA_CACHE_DIR": str(tmp_path / "cache")}

    def value():
        done = subprocess.run(
            [sys.executable, "probe.py"], env=environment, cwd=tmp_path, capture_output=True, text=True, check=True
        )
        path, called, by_address = done.stdout.split()
        assert Path(path).is_relative_to(tmp_path)
        assert called == by_address
        return float(called)

    before = value()
    assert value() == before
    text = film.read_text()
    edited = text.replace("scale = 4.0 * slenderness", "scale = 8.0 * slenderness")
    assert edited != text
    film.write_text(edited)
    assert value() == 2.0 * before


@pytest.mark.slow
@pytest.mark.processes
def test_ctrl_c_pressed_during_compiled_code_stops_the_run_and_not_the_process():
    """In a separate process: an interrupt while compiled code returns its results ends the process."""
    script = """
import linkages, strikes
from linkages.engines.compiled.run.runner import Runner
strikes.registered_film("striking", strike := strikes.Strike())
runner = Runner(linkages.load(linkages.find_file("seven_bar.toml"), {"duration": 1e5, "joints.A.film": "striking"}))
runner.run(0.0, runner.start, 0.0, 1)
strike.arm(10_000)
try:
    runner.run(0.0, runner.start, 0.0, 100_000)
except KeyboardInterrupt:
    print("stopped within a step:", strike.calls < 10_100)
"""
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).parents[1])}
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False, env=environment)
    assert done.stdout == "stopped within a step: True\n", done.stderr


@pytest.mark.parametrize(
    ("engine", "given", "used"),
    [
        ("compiled", "radau_iia_5", "radau_iia_5"),
        ("compiled", "radau3", "radau_iia_5"),
        ("compiled", "bogacki_shampine3", "dormand_prince_5_4"),
        ("drake", "radau3", "radau3"),
        ("drake", "radau_iia_5", "radau3"),
        ("drake", "dormand_prince_5_4", "runge_kutta5"),
    ],
)
def test_an_engine_replaces_a_method_of_the_other_one_with_a_notice(capsys, engine, given, used):
    notice.cache_clear()
    system = drop().replaced({"solver.integrator": given})
    assert method(system, engine) == method(system, engine) == used
    same = given == used or used == "runge_kutta5"  # Drake's name for the same tableau
    text = f"notice: solver.integrator: the {engine} engine does not have {given} and uses {used}\n"
    assert capsys.readouterr().err == ("" if same else text)


def test_steps_of_accurate_runs_end_at_kinks_of_friction():
    """The sliding speed reverses within 30 ns; the times between its kinks do not depend on the accuracy."""
    speeds, between = np.array([-1e-3, -1e-4, 1e-4, 1e-3]), []  # m/s, of the friction law
    for accuracy in (1e-10, 1e-12):
        overrides = {"duration": 7.2e-4, "solver.accuracy": accuracy}
        run = linkages.simulate(linkages.load(linkages.find_file("slider_crank_dry.toml"), overrides))
        reversal = (run.time > 6.98e-4) & (run.time < 7.0e-4)
        apart = np.abs(run["B.sliding"][reversal] - speeds[:, None])
        assert np.all(apart.min(axis=1) < 2e-9 * np.abs(speeds))
        between.append(np.diff(run.time[reversal][apart.argmin(axis=1)]))
    np.testing.assert_allclose(between[0], between[1], rtol=1e-6)


def _ramp(v, joint):
    """Ambrosio's coefficient, which is built in."""
    return joint.mu_d * min(max((abs(v) - joint.v_0) / (joint.v_1 - joint.v_0), 0.0), 1.0) * (1.0 if v > 0.0 else -1.0)


@pytest.mark.parametrize(("kinks", "limit"), [(["v_0", 1e-3], 1e-12), ([], None)])
def test_a_user_names_the_kinks_of_a_friction_law(own_registries, kinks, limit):
    """A copy of a built-in law then has the run and the derivatives of the built-in law; without its kinks it errs."""
    laws.register_friction("ramp", _ramp, kinks=kinks)
    path, found = "joints.B.friction.v_0", []
    for law in ("ambrosio", "ramp"):
        values = {"duration": 7.3e-4, "solver.accuracy": 1e-10, "joints.B.friction.law": law}
        system = linkages.load(linkages.find_file("slider_crank_dry.toml"), values)
        run = linkages.simulate(system, outputs=["slider.ax", "B.force"], wrt=[path])
        found.append(np.array([run["B.force"][-1], *(run.sensitivity[path][n][-1] for n in ("slider.ax", "B.force"))]))
    errors = np.abs(found[1] - found[0]) / np.abs(found[0])
    assert errors.max() < limit if limit else errors.max() > 1e-6


@pytest.mark.parametrize(
    ("kinks", "problem"),
    [
        (["v_9"], 'kinks: "v_9" is no parameter of the law'),
        ([-1.0], "kinks: -1.0 is not a speed of 0 or more"),
        ([0.0, "v_0", "v_1"], "kinks: there may be two speeds, or zero and one speed"),
    ],
)
def test_wrong_kinks_of_a_friction_law_are_refused(own_registries, kinks, problem):
    with pytest.raises(ValueError, match=f'friction law "ramp": {problem}'):
        laws.register_friction("ramp", _ramp, kinks=kinks)


UNCOMPILED = """
import linkages
from linkages.engines.drop import GRAVITY, drop

system = drop().replaced({"duration": 1e-3})
run = linkages.simulate(system)
print(run["journal.y"][-1], run.evaluate([5e-4])["journal.y"][0])
for refused in (
    lambda: linkages.simulate(system.replaced({"solver.integrator": "radau_iia_5"})),
    lambda: linkages.simulate(system, wrt=["joints.J.clearance"]),
    lambda: linkages.linearise(system),
):
    try:
        refused()
    except linkages.InputError as refusal:
        print(refusal)
"""


def test_without_the_compiler_the_explicit_method_runs_and_what_needs_duals_is_refused():
    command, environment = [sys.executable, "-c", UNCOMPILED], os.environ | {"NUMBA_DISABLE_JIT": "1"}
    found = subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout.splitlines()
    places = [float(place) for place in found[0].split()]  # at the end, and between two steps
    assert places == pytest.approx([-0.5 * GRAVITY * 1e-6, -0.125 * GRAVITY * 1e-6], rel=1e-9)
    start = "environment: NUMBA_DISABLE_JIT:"
    assert found[1:] == [
        f"{start} the implicit method needs the compiler; unset it, or set solver.integrator to dormand_prince_5_4",
        f"{start} derivatives need the compiler; unset it",
        f"{start} linear models need the compiler; unset it",
    ]
