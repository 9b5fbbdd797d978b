"""Tolerances: distributions and yields against closed forms, resumed and extended studies, rejected input."""

import json
import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import norm, trapezoid, triang

import linkages
from linkages import InputError
from linkages.cli.main import main
from optim.evaluate import remote
from optim.evaluate.evaluator import Evaluator
from optim.problem.distributions import Empirical, Marginal, of_fit, of_shape
from optim.problem.load import load_study
from optim.problem.scatter import Scatter
from optim.report.tolerance_text import format_tolerances
from optim.search.optimise import optimise
from optim.search.sampled_machines import Sampling
from optim.search.tolerance_statistics import clopper_pearson, moments, quantile, variance_shares, yield_of
from optim.search.tolerances import tolerances
from optim.store.store import read_store

HEAD = 'experiment = "slider_crank_dry.toml"\n'
SUM = """
[scatter.a]
path = "sdf.links.rod.mass"
normal = [1.0, 0.1]
[scatter.b]
path = "sdf.links.slider.mass"
normal = ["2000 g", "200 g"]
[constraints.sum]
formula = "a + 2 * b"
at_most = 5.5
"""
SCATTER = '[algorithm]\nname = "scatter"\n'


@pytest.fixture
def study_of(tmp_path):
    def make(text, settings="samples = 4096", name="study.toml"):
        path = tmp_path / name
        path.write_text(HEAD + text + SCATTER + settings + "\n")
        return load_study(path)

    return make


# -- distributions -----------------------------------------------------------------------------------------------------


def test_clearance_of_a_fit():
    """30 H7/f7: hole 0 to 21 um, shaft -41 to -20 um: the radial clearance is 10 to 31 um."""
    fit = linkages.fit("30 H7/f7")
    x = np.linspace(10e-6, 31e-6, 15)[1:-1]
    normal = of_fit(fit, "normal").law
    assert (normal.mean(), normal.std()) == pytest.approx((20.5e-6, math.hypot(10.5e-6, 10.5e-6) / 6.0), rel=1e-12)
    uniform = of_fit(fit, "uniform").law  # of equal widths: a triangle
    assert uniform.cdf(x) == pytest.approx(triang(0.5, 10e-6, 21e-6).cdf(x), abs=1e-12)
    assert uniform.std() == pytest.approx(10.5e-6 / math.sqrt(6.0), rel=1e-12)
    parts = of_fit(fit, "triangular").law
    one = triang(0.5, 0.0, 10.5e-6)
    for at in x:
        expected, _ = quad(lambda s, at=at: one.pdf(s) * one.cdf(at - 10e-6 - s), 0.0, 10.5e-6, epsabs=1e-12)
        assert float(parts.cdf(at)) == pytest.approx(expected, abs=1e-9)
    assert parts.std() == pytest.approx(math.sqrt(2.0) * one.std(), rel=1e-12)


def test_unequal_parts_of_a_fit():
    """50 H8/g6: radial tolerances 19.5 and 8 um: a trapezoid between 4.5 and 32 um."""
    law = of_fit(linkages.fit("50 H8/g6"), "uniform").law
    expected = trapezoid(8.0 / 27.5, 19.5 / 27.5, 4.5e-6, 27.5e-6)
    shares = np.array([1e-6, 0.01, 0.3, 0.5, 0.9, 1.0 - 1e-6])
    assert law.ppf(shares) == pytest.approx(expected.ppf(shares), rel=1e-9)
    assert law.pdf(np.array([6e-6, 18e-6])) == pytest.approx(expected.pdf([6e-6, 18e-6]), rel=1e-9)


@pytest.mark.parametrize(
    ("kind", "numbers", "mean", "deviation"),
    [
        ("uniform", [1.0, 3.0], 2.0, 1.0 / math.sqrt(3.0)),
        ("normal", [2.0, 0.5], 2.0, 0.5),
        ("triangular", [0.0, 1.0, 2.0], 1.0, 1.0 / math.sqrt(6.0)),
        ("lognormal", [2.0, 0.5], 2.0, 0.5),
        ("beta", [2.0, 2.0, -1.0, 1.0], 0.0, 2.0 * math.sqrt(0.05)),
        ("truncated", [0.0, 1.0, -1.0, 1.0], 0.0, math.sqrt(1.0 - 2.0 * norm.pdf(1.0) / (2.0 * norm.cdf(1.0) - 1.0))),
    ],
)
def test_moments_of_shapes(kind, numbers, mean, deviation):
    found = of_shape(kind, numbers)
    assert (found.law.mean(), found.law.std()) == pytest.approx((mean, deviation), rel=1e-9, abs=1e-12)
    narrow = found.narrowed(0.5).law
    assert (narrow.mean(), narrow.std()) == pytest.approx((mean, 0.5 * deviation), rel=1e-9, abs=1e-12)
    shares = np.array([0.1, 0.5, 0.8])
    assert narrow.cdf(narrow.ppf(shares)) == pytest.approx(shares, abs=1e-9)


def test_measured_values():
    law = Empirical(np.array([3.0, 1.0, 2.0]))
    assert law.ppf(np.array([0.0, 0.25, 1.0])).tolist() == [1.0, 1.5, 3.0]
    assert (law.mean(), law.std()) == pytest.approx((2.0, 1.0 / math.sqrt(3.0)))  # uniform from 1 to 3
    assert law.pdf(np.array([0.5, 1.5, 3.0])).tolist() == [0.0, 0.5, 0.5]


# -- results -----------------------------------------------------------------------------------------------------------


def test_sum_of_normal_values(study_of):
    """The sum has the mean 5 and the variance 0.17."""
    result = tolerances(study_of(SUM))
    entry, deviation = result["outputs"]["sum"], math.sqrt(0.17)
    assert entry["mean"] == pytest.approx(5.0, abs=1e-3)
    assert entry["deviation"] == pytest.approx(deviation, rel=5e-3)
    assert result["yield"]["value"] == pytest.approx(norm.cdf(0.5 / deviation), abs=2e-3)
    assert entry["capability"] == pytest.approx(0.5 / (3.0 * deviation), rel=1e-2)
    assert entry["quantiles"]["0.95"][0] == pytest.approx(5.0 + 1.644854 * deviation, rel=2e-3)
    assert result["shares"]["sum"] == {name: entry["variance"]["values"][name]["first"] for name in "ab"}
    shares = entry["variance"]["values"]
    assert [shares[name]["first"] for name in "ab"] == pytest.approx([1.0 / 17.0, 16.0 / 17.0], abs=3e-3)
    assert entry["first_order"]["deviation"] == pytest.approx(deviation, rel=1e-9)
    assert entry["corners"]["range"] == pytest.approx([5.0 - 1.5, 5.0 + 1.5], rel=1e-9)
    for name, halved in (("a", math.sqrt(0.0025 + 0.16)), ("b", math.sqrt(0.01 + 0.04))):
        one = result["contributions"][name]
        assert one["halved"] == pytest.approx(norm.cdf(0.5 / halved), abs=3.0 * one["error"] + 1e-3)
    assert next(iter(result["contributions"])) == "b"


def test_correlated_values(study_of):
    result = tolerances(study_of(SUM + '[[correlated]]\nnames = ["a", "b"]\ncorrelation = 0.5\n'))
    deviation = math.sqrt(0.17 + 2.0 * 0.5 * 0.1 * 0.4)
    entry = result["outputs"]["sum"]
    assert entry["deviation"] == pytest.approx(deviation, rel=5e-3)
    assert entry["first_order"]["deviation"] == pytest.approx(deviation, rel=1e-9)
    halved = math.sqrt(0.01 + 0.04 + 2.0 * 0.5 * 0.1 * 0.2)
    assert result["contributions"]["b"]["halved"] == pytest.approx(norm.cdf(0.5 / halved), abs=5e-3)


def test_stroke_of_a_slider_crank(study_of):
    """The stroke is twice the length of the crank, whatever the rod's."""
    study = study_of(
        """
[scatter.crank]
path = "sdf.frames.crank_A.pose.x"
normal = ["0 mm", "0.05 mm"]
relative_to = "nominal"
[scatter.rod]
path = "sdf.frames.rod_B.pose.x"
uniform = ["-0.1 mm", "0.1 mm"]
relative_to = "nominal"
[constraints.stroke]
terms = [{ functional = "range", output = "ideal.slider.x" }]
at_most = 0.1001
""",
        "samples = 64",
    )
    result = tolerances(study)
    entry = result["outputs"]["stroke"]
    assert entry["mean"] == pytest.approx(0.1, abs=2e-6)
    assert entry["first_order"]["deviation"] == pytest.approx(1e-4, rel=1e-6)
    assert entry["first_order"]["shares"] == pytest.approx({"crank": 1.0, "rod": 0.0}, abs=1e-6)
    low, high = result["yield"]["interval"]
    assert low < norm.cdf(1.0) < high


def test_intervals_hold_what_they_say(study_of):
    """Of 200 yields with 95 % intervals, 93 to 97 % hold the true one; random machines, as the interval assumes."""
    study = study_of(SUM, 'samples = 400\nsequence = "random"')
    true = norm.cdf(0.5 / math.sqrt(0.17))
    z = np.random.default_rng(5)
    assert abs(tolerances(study)["yield"]["value"] - true) < 0.06
    inside = 0
    for _ in range(200):
        good = int((z.normal(1.0, 0.1, 400) + 2.0 * z.normal(2.0, 0.2, 400) <= 5.5).sum())
        lower, upper = clopper_pearson(good, 400, 0.95)
        inside += lower <= true <= upper
    assert 0.93 <= inside / 200 <= 0.97


def test_intervals_of_quantiles():
    """Order statistics about the median of 10 values: the second and the ninth with 97.9 % (binomial table)."""
    assert quantile(np.arange(10.0), 0.5, 0.95) == (4.5, 1.0, 8.0)
    assert quantile(np.arange(10.0), 0.99, 0.95)[2] is None


def test_shares_of_a_product():
    """The variance of x + y + x y of standard normal values is 3, a third for each term."""
    normal = np.random.default_rng(1).standard_normal((20000, 2))
    found = variance_shares(normal, normal.sum(axis=1) + normal.prod(axis=1))
    assert found.first == pytest.approx([1.0 / 3.0] * 2, abs=4.0 * found.first_error.max())
    assert found.total == pytest.approx([2.0 / 3.0] * 2, abs=4.0 * found.total_error.max())
    assert found.unexplained == pytest.approx(0.0, abs=1e-12)


def test_sobol_points_are_better_than_random(study_of):
    errors = {"sobol": [], "random": []}
    for sequence, found in errors.items():
        study = study_of(SUM, f'samples = 256\nsequence = "{sequence}"')
        found += [tolerances(study, seed=seed)["outputs"]["sum"]["mean"] - 5.0 for seed in range(12)]
    assert np.std(errors["random"]) > 10.0 * np.std(errors["sobol"])


def test_stops_at_a_narrow_interval(study_of):
    result = tolerances(study_of(SUM, "samples = 100000\nwidth = 0.05"))
    assert result["samples"] == 1024  # 0.065 wide after 512
    assert np.diff(result["yield"]["interval"])[0] < 0.05


def test_interference_counts_as_failed(study_of):
    text = """
[scatter.play]
path = "joints.B.clearance"
fit = "20 H7/k6"
interference = "failed"
parts = "uniform"
[constraints.stroke]
terms = [{ functional = "range", output = "slider.x" }]
at_most = 1.0
"""
    result = tolerances(study_of("set.duration = 1e-3\n" + text, "samples = 32"))
    share = 1.0 - of_fit(linkages.fit("20 H7/k6"), "uniform").law.cdf(0.0)
    low, high = result["yield"]["interval"]
    assert low < share < high
    assert result["failed"] == round(32 * (1.0 - result["yield"]["value"]))


ALLOCATION = """
machines = 1024
[variables.t_a]
path = "scatter.a.factor"
lower = 0.2
upper = 5.0
[variables.t_b]
path = "scatter.b.factor"
lower = 0.2
upper = 5.0
[objectives.cost]
formula = "1 / t_a + 1 / t_b"
"""


def test_allocation_of_tolerances(tmp_path):
    """Least cost 1/t_a + 1/t_b where 90 % of the sums a + 2 b are below 5.7: Lagrange's condition."""
    file = tmp_path / "cost.toml"
    text = SUM.replace("at_most = 5.5", "at_most = 5.7\nover_scatter = 0.9")
    file.write_text(HEAD + ALLOCATION + text + '[algorithm]\nname = "grg"\nstep = 1e-3\n')
    best = optimise(load_study(file))["best"]
    deviation = 0.7 / norm.ppf(0.9) / math.sqrt(1.0 + 4.0 ** (2.0 / 3.0))
    t_a, t_b = deviation / 0.1, 4.0 ** (1.0 / 3.0) * deviation / 0.4
    assert best["feasible"]
    assert best["objectives"]["cost"] == pytest.approx(1.0 / t_a + 1.0 / t_b, rel=0.02)
    assert best["variables"]["scatter.a.factor"] == pytest.approx(t_a, rel=0.1)  # a flat optimum
    assert best["variables"]["scatter.b.factor"] == pytest.approx(t_b, rel=0.05)


def test_quantities_over_machines(tmp_path):
    file = tmp_path / "many.toml"
    kinds = {"mean": '"mean"', "deviation": '"deviation"', "high": "0.9", "share": "{ at_most = 5.5 }"}
    objectives = "".join(
        f'[objectives.{name}]\nformula = "a + 2 * b + 0 * t_a"\nover_scatter = {how}\n' for name, how in kinds.items()
    )
    text = SUM[: SUM.index("[constraints")] + objectives
    file.write_text(HEAD + ALLOCATION[: ALLOCATION.index("[objectives")] + text + '[algorithm]\nname = "nsga2"\n')
    study = load_study(file)
    found = Evaluator(study)(np.array([[1.0, 1.0], [0.5, 0.5]])).objectives
    for row, factor in zip(found, (1.0, 0.5), strict=True):
        deviation = factor * math.sqrt(0.17)
        expected = [5.0, deviation, 5.0 + 1.281552 * deviation, norm.cdf(0.5 / deviation)]
        assert row == pytest.approx(expected, rel=5e-3)


def test_search_over_machines_is_checked(tmp_path):
    file = tmp_path / "wrong.toml"
    good = HEAD + ALLOCATION + SUM + '[algorithm]\nname = "grg"\n'
    for text, problem in (
        (good, 'scattering value "a"'),
        (good.replace("scatter.b.factor", "scatter.c.factor"), '"scatter.c.factor" is unknown'),
        (good + 'derivatives = "sensitivities"\n', "over_scatter"),
        (good.replace("at_most = 5.5", "at_most = 5.5\nover_scatter = {}"), "a number between 0 and 1"),
    ):
        file.write_text(text)
        with pytest.raises(InputError, match=problem):
            load_study(file)


# -- statistics that have no value -------------------------------------------------------------------------------------


def test_corners_of_a_quantity_with_its_greatest_value_inside(study_of):
    """The corners of 1 - (a - 1)^2 have -8: no machine is there, and the mean is 0."""
    text = SUM.replace("a + 2 * b", "1 - (a - 1)**2 * 100 + 0 * b").replace("at_most = 5.5", "at_least = -2.0")
    study = study_of(text, "samples = 256")
    result = tolerances(study)
    corners = result["outputs"]["sum"]["corners"]
    assert corners["range"] == pytest.approx([-8.0, -8.0], rel=1e-9)
    assert corners["outside"] == 1.0
    printed = format_tolerances(study, result)
    assert "corners of the tolerance limits: -8 to -8; 100% of the machines and their mean are outside" in printed


def test_first_order_says_nothing_where_the_derivatives_vanish(study_of):
    study = study_of(SUM.replace("a + 2 * b", "(a - 1)**2 + 0 * b"), "samples = 256")
    result = tolerances(study)
    entry = result["outputs"]["sum"]["first_order"]
    assert (entry["error"], entry["shares"]) == (None, None)
    assert entry["deviation"] == pytest.approx(0.0, abs=1e-12)
    printed = format_tolerances(study, result)
    assert "first order says nothing here: the derivatives vanish at the means" in printed
    assert "first order by derivatives" not in printed


def test_no_machine_in_half_a_tolerance(study_of, tmp_path, capsys):
    """Of two machines of the uniform distribution none is in its middle half: the yield there is unknown, not 0/0."""
    text = '[scatter.a]\npath = "sdf.links.rod.mass"\nuniform = [0.0, 1.0]\n'
    text += '[constraints.end]\nformula = "a"\nat_most = 0.5\n'
    settings = 'samples = 2\nsequence = "random"'
    seed = next(s for s in range(100) if sorted(uniform_pair(s)) == pytest.approx([0.12, 0.88], abs=0.12))
    study = study_of(text, settings, "mine.toml")
    result = tolerances(study, seed=seed)
    assert result["contributions"]["a"] == {"halved": None, "error": None}
    assert "half the tolerance of a: yield unknown" in format_tolerances(study, result)
    assert main(["tolerances", str(tmp_path / "mine.toml"), "--seed", str(seed), "--out", str(tmp_path / "out")]) == 0
    assert "yield unknown" in capsys.readouterr().out


def uniform_pair(seed):
    return norm.cdf(np.random.default_rng(seed).standard_normal((2, 1)))[:, 0].tolist()


def test_yield_of_few_machines_has_an_error():
    """One machine of 1 in half the tolerance tells little: Laplace's rule gives 1/(n + 2)."""
    scatter = Scatter(("a",), (of_shape("uniform", [0.0, 1.0]),), np.eye(1))
    designs = np.array([[0.5], [0.1], [0.95]])
    share, error = yield_of(scatter, scatter.narrowed(0, 0.5), designs, np.array([True, False, True]))
    assert (share, error) == pytest.approx((1.0, 1.0 / 3.0))


def test_measured_values_that_occur_twice_have_no_density():
    marginal = Marginal(Empirical(np.array([1.0, 2.0, 2.0, 3.0])), 1.0, 3.0)
    scatter = Scatter(("a",), (marginal,), np.eye(1))
    designs = scatter.values(norm.ppf([[0.1], [0.5], [0.9]]))
    assert yield_of(scatter, scatter.narrowed(0, 0.5), designs, np.ones(3, dtype=bool)) == (None, None)


def test_error_of_the_deviation_of_few_machines():
    """The variance of a sample's variance is 2 sigma^4/(n - 1) for normal values; two values are no certain deviation."""
    assert moments(np.array([1.0, 2.0]))["deviation_error"] > 0.2 * moments(np.array([1.0, 2.0]))["deviation"]
    rows = np.random.default_rng(2).standard_normal((4000, 50))
    stated = np.mean([moments(row)["deviation_error"] for row in rows])
    assert stated == pytest.approx(np.std([row.std(ddof=1) for row in rows]), rel=0.1)


@pytest.mark.parametrize("formula", ["0.1 + 0 * a", "abs(a - 1.26) + a - 1.26", "exp(700 * a)", "1 / (a - 1)"])
def test_tolerances_warn_of_nothing(study_of, formula, recwarn):
    """Constant, kinked, overflowing and singular quantities have statistics or say why not; numpy prints nothing."""
    study = study_of(SUM.replace("a + 2 * b", formula + " + 0 * b"), "samples = 256")
    result = tolerances(study)
    printed = format_tolerances(study, result)
    assert not [str(one.message) for one in recwarn if issubclass(one.category, RuntimeWarning)]
    assert "nan" not in printed.split()
    if formula.startswith("0.1"):
        assert "no shares of the variance: the quantity varies in too few machines" in printed
        assert result["outputs"]["sum"]["deviation"] == 0.0
        assert result["outputs"]["sum"]["capability"] is None


# -- the store ---------------------------------------------------------------------------------------------------------

RUNS = """
[scatter.mass]
path = "sdf.links.rod.mass"
normal = [0.2, 0.02]
[scatter.play]
path = "joints.B.clearance"
uniform = ["0.2 mm", "0.4 mm"]
[objectives.force]
terms = [{ functional = "peak", output = "B.force" }]
[constraints.torque]
terms = [{ functional = "peak", output = "O.torque" }]
at_most = 2.058
"""


@pytest.mark.processes
def test_same_rows_however_they_are_run(study_of, tmp_path, invented_engine):
    study = study_of(RUNS, "samples = 1500")
    whole = tolerances(study, tmp_path / "a.sqlite")
    with ThreadPoolExecutor(2) as pool:
        assert tolerances(study, tmp_path / "b.sqlite", evaluator=Evaluator(study, pool, 4)) == whole

    def strike(part):
        if part > 0.5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        tolerances(study, tmp_path / "c.sqlite", progress=strike)
    resumed = tolerances(study, tmp_path / "c.sqlite", resume=True)
    assert json.dumps(resumed.content) == json.dumps(whole.content)
    tables = []
    for name in "abc":
        with read_store(tmp_path / f"{name}.sqlite") as store:
            designs, found = store.evaluations()
        tables.append((designs.tobytes(), found.constraints.tobytes()))
    assert tables[0] == tables[1] == tables[2]


@pytest.mark.processes
def test_a_study_on_workers_stops_at_the_same_machine(study_of, invented_engine, monkeypatch):
    """A chunk of 2048 machines, as quick runs have, is judged after each 512, as the chunks of one process are."""
    study = study_of(RUNS, "samples = 6000\nwidth = 0.04")
    alone = tolerances(study)
    assert 512 < alone["samples"] < 6000
    monkeypatch.setattr(remote.Dispatcher, "population", lambda self, least: 4 * least)
    with ThreadPoolExecutor(2) as executor:
        assert tolerances(study, evaluator=Evaluator(study, executor, 4)).content == alone.content


@pytest.mark.processes
def test_workers_get_the_next_chunk_before_the_last_one_is_judged(study_of, invented_engine, monkeypatch):
    """No worker waits while the results of a chunk are stored."""
    study, told, real = study_of(RUNS, "samples = 2048"), [], (remote.Dispatcher.send, remote.Dispatcher.receive)

    def send(self, shared, values):
        told.append(f"send {len(values)}")
        return real[0](self, shared, values)

    def receive(self, sent):
        told.append("receive")
        return real[1](self, sent)

    monkeypatch.setattr(remote.Dispatcher, "send", send)
    monkeypatch.setattr(remote.Dispatcher, "receive", receive)
    monkeypatch.setattr(remote.Dispatcher, "population", lambda self, least: least)
    with ThreadPoolExecutor(2) as executor:
        tolerances(study, evaluator=Evaluator(study, executor, 4))
    chunk = "send 512"
    assert told[:10] == ["send 1", "receive", chunk, chunk, *["receive", chunk] * 2, "receive", "receive"]


def test_more_machines_later(study_of, tmp_path, invented_engine):
    study = study_of(RUNS, "samples = 700")
    tolerances(study, tmp_path / "a.sqlite")
    more = tolerances(study, tmp_path / "a.sqlite", samples=1100, resume=True)
    assert more == tolerances(study, samples=1100)
    with pytest.raises(InputError, match="continue with --resume"):
        tolerances(study, tmp_path / "a.sqlite")


def test_command(study_of, tmp_path, invented_engine, capsys):
    study_of(RUNS, "samples = 300", "mine.toml")
    out = tmp_path / "out"
    for words in (["optimise", str(tmp_path / "mine.toml")], ["optimise", str(tmp_path / "mine.toml"), "--resume"]):
        assert main([*words, "--out", str(out)]) == 0
        printed = capsys.readouterr().out
        assert "yield: " in printed
        assert "half the tolerance of mass" in printed
    result = json.loads((out / "tolerances.json").read_text())
    assert result["samples"] == 300
    for name in ("histograms", "contributions", "influence"):
        assert (out / f"{name}.png").stat().st_size > 5000
    assert main(["optimise", str(tmp_path / "mine.toml"), "--check", "--out", str(out)]) == 2
    assert "study of tolerances" in capsys.readouterr().err


# -- rejected input ----------------------------------------------------------------------------------------------------

PLAY = '[scatter.a]\npath = "joints.B.clearance"\n'
LIMIT = '[constraints.f]\nformula = "a"\nat_most = 1.0\n'


@pytest.mark.parametrize(
    ("text", "where", "problem"),
    [
        (PLAY + 'fit = "30 Q7/f7"\n', "scatter.a.fit", "has the deviation Q"),
        (PLAY + 'fit = "600 H7/f7"\n', "scatter.a.fit", "at most 500 mm"),
        (PLAY + 'fit = "30 H7/p6"\n', "scatter.a.fit", "has interference"),
        (PLAY + "normal = [1e-4, 0.0]\n", "scatter.a.normal", "must be positive"),
        (PLAY + "normal = [1e-4, -1e-5]\n", "scatter.a.normal", "must be positive"),
        (PLAY + "uniform = [2e-4, 1e-4]\n", "scatter.a.uniform", "the lower one must come first"),
        (PLAY + "triangular = [1e-4, 3e-4, 2e-4]\n", "scatter.a.triangular", "must lie between"),
        (PLAY + "beta = [0.0, 1.0, 1e-4, 2e-4]\n", "scatter.a.beta", "exponents"),
        (PLAY + "normal = [1e-4]\n", "scatter.a", "normal has 1 numbers; give 2"),
        (PLAY + 'normal = ["1 kg", "1 mm"]\n', "scatter.a.normal", "must be measured in m"),
        (PLAY, "scatter.a", "no distribution"),
        (PLAY + 'empirical = "none.txt"\n', "none.txt", "cannot be read"),
        ('[scatter.a]\npath = "joints.X.clearance"\nnormal = [1.0, 0.1]\n', "scatter.a.path", 'has no "X"'),
        ('[scatter.a]\npath = "sdf.links.rod.mass"\nfit = "30 H7/f7"\n', "scatter.a.path", "a fit gives the clearance"),
        (
            PLAY + 'normal = [1e-4, 1e-5]\n[[correlated]]\nnames = ["a", "b"]\ncorrelation = 0.5\n',
            "correlated[0].names",
            '"b" is not in [scatter]',
        ),
        ("", "", "[scatter] is missing"),
    ],
)
def test_rejected(study_of, text, where, problem):
    with pytest.raises(InputError) as caught:
        study_of(text + LIMIT)
    message = str(caught.value)
    assert where in message
    assert problem in message
    assert "\n" not in message


def test_impossible_correlations(study_of):
    pairs = [("a", "b", 0.9), ("a", "c", 0.9), ("b", "c", -0.9)]
    text = SUM.replace("[constraints", '[scatter.c]\npath = "joints.B.clearance"\nnormal = [1e-3, 1e-4]\n[constraints')
    text += "".join(f'[[correlated]]\nnames = ["{a}", "{b}"]\ncorrelation = {r}\n' for a, b, r in pairs)
    with pytest.raises(InputError, match="is not positive definite"):
        study_of(text)


def test_settings_are_checked(study_of):
    assert Sampling().samples == 1024
    with pytest.raises(InputError, match="algorithm: samples: is 1"):
        tolerances(study_of(SUM, "samples = 1"))
