"""From runs to objectives and constraints: functionals by hand, failures, and independence of how runs are divided."""

import pickle
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from linkages import RunError
from linkages.engines import parcels
from linkages.engines.parcels import Parcel
from optim.evaluate import remote
from optim.evaluate.evaluations import Evaluations
from optim.evaluate.evaluator import Evaluator
from optim.evaluate.limits import in_units, problem_of, values_of
from optim.evaluate.requests import Statistics
from optim.problem.load import load_study

STUDY = """
experiment = "seven_bar.toml"
[variables.mass]
path = "sdf.links.link2.mass"
relative = true
lower = 0.5
upper = 2.0
[variables.oil]
path = "joints.A.viscosity"
lower = 0.05
upper = 0.6
[linked]
"joints.B.viscosity" = "oil / 2"
[windows.halves]
start = 0.0
end = 2.0
count = 2
[points.cold.set]
"joints.A.clearance" = 3e-4
[points.worn]
set."joints.A.clearance" = 5e-4
linked."joints.B.clearance" = "4e-4 + 0 * mass"
{quantities}
[algorithm]
name = "ga"
"""


@pytest.fixture
def study(tmp_path):
    def write(quantities):
        path = tmp_path / "mine.toml"
        path.write_text(STUDY.replace("{quantities}", quantities))
        return load_study(path)

    return write


def engine(monkeypatch, minimum, maximum, mean=0.0, rms=0.0, status=(), reason=()):
    """An engine that gives these numbers, by (point, window) in which a design's first value is a factor."""
    asked = []

    def run_compiled(request):
        asked.append(request)
        p = 0 if request.point.name == "cold" else 1
        factor = request.values[:, 0][:, None, None] * np.ones((1, 1, len(request.outputs)))

        def table(values):
            return factor * np.atleast_2d(values)[min(p, len(np.atleast_2d(values)) - 1)][None, :, None]

        m = len(request.values)
        return Statistics(
            np.stack([table(values) for values in (minimum, maximum, mean, rms)]),
            list(status) or ["ok"] * m,
            list(reason) or [""] * m,
        )

    monkeypatch.setattr("optim.evaluate.evaluator.run_compiled", run_compiled)
    return asked


LOW = [[-3.0, 1.0], [-1.0, -5.0]]  # by operating point and window
HIGH = [[2.0, 4.0], [6.0, 0.5]]
MEAN = [[0.5, 1.5], [2.5, -0.5]]
RMS = [[1.0, 2.0], [3.0, 4.0]]


@pytest.mark.parametrize(
    ("term", "expected"),
    [
        # functional per window and point, then over windows, then over points
        ('functional = "peak"', max(3, 4, 6, 5)),
        ('functional = "peak", over_windows = "mean"', max((3 + 4) / 2, (6 + 5) / 2)),
        ('functional = "peak", over_windows = "mean", over_points = "mean"', (3.5 + 5.5) / 2),
        ('functional = "peak", over_windows = "min", over_points = "mean"', (3 + 5) / 2),
        ('functional = "max", over_points = "min"', min(4, 6)),
        ('functional = "min", over_windows = "min", over_points = "min"', -5),
        ('functional = "min"', max(1, -1)),
        ('functional = "range"', max(5, 3, 7, 5.5)),
        ('functional = "mean", over_windows = "mean"', max(1.0, 1.0)),
        ('functional = "rms", over_windows = "mean", over_points = "mean"', 2.5),
        ('functional = "integral", over_windows = "min"', max(0.5, -0.5)),  # windows of 1 s
        ('functional = "rms", weight = -2.0', -8),
    ],
)
def test_functionals(study, monkeypatch, term, expected):
    engine(monkeypatch, LOW, HIGH, MEAN, RMS)
    found = study(f'[objectives.f]\nterms = [{{ output = "A.force", window = "halves", {term} }}]')
    values = Evaluator(found)(np.array([[1.0, 0.4], [0.25, 0.1]]))
    assert values.objectives[:, 0] == pytest.approx([expected, expected / 4.0])
    assert values.status == ("ok", "ok")


@pytest.mark.parametrize(("over", "expected"), [("sum", 0.5 * 4.0 + 2.0 * 6.0), ("max", 12.0), ("min", 2.0)])
def test_terms(study, monkeypatch, over, expected):
    engine(monkeypatch, LOW, HIGH, MEAN, RMS)
    found = study(
        f'[objectives.f]\nover_terms = "{over}"\nterms = ['
        '{ functional = "rms", output = "A.force", weight = 0.5, window = "halves" },'
        '{ functional = "max", output = "O1.torque", weight = 2.0, window = "halves" }]'
    )
    assert Evaluator(found)(np.array([[1.0, 0.4]])).objectives[0, 0] == expected


def test_the_finished_part_of_a_population_is_told(study, monkeypatch):
    """A genetic algorithm's first population takes half a minute."""
    asked = engine(monkeypatch, *[[[1.0] * 2]] * 4)
    found = study('[objectives.f]\nterms = [{ functional = "peak", output = "A.force", window = "halves" }]')
    Evaluator(found, progress=(told := [].append))(np.array([[0.2, 0.3]]))
    assert asked[0].progress is told


def test_what_the_engine_is_asked(study, monkeypatch):
    asked = engine(monkeypatch, *[[[1.0] * 3]] * 4)
    found = study(
        '[objectives.f]\nterms = [{ functional = "peak", output = "A.force", window = "halves" },'
        '{ functional = "peak", output = "slider7.ax.jitter" }, { functional = "rms", output = "A.force" }]'
    )
    Evaluator(found, threads=1)(np.array([[0.2, 0.3], [0.25, 0.4]]))
    cold, worn = asked
    assert cold.point.paths == ("sdf.links.link2.mass", "joints.A.viscosity", "joints.B.viscosity")
    assert cold.values.tolist() == [[0.2, 0.3, 0.15], [0.25, 0.4, 0.2]]
    assert worn.point.paths == (*cold.point.paths, "joints.B.clearance")
    assert worn.values.tolist() == [[0.2, 0.3, 0.15, 4e-4], [0.25, 0.4, 0.2, 4e-4]]
    assert worn.point.system.experiment.joints["A"].clearance == 5e-4
    assert cold.outputs == ("A.force", "slider7.ax.jitter")
    assert cold.windows.tolist() == [[0.0, 1.0], [1.0, 2.0], [0.0, 2.0]]
    assert cold.threads == 1


LIMITED = """
[objectives.f]
relative = true
terms = [{ functional = "max", output = "A.force" }]
[objectives.film]
maximise = true
terms = [{ functional = "min", output = "A.film_thickness", over_points = "min" }]
[constraints.range]
at_least = 2.0
at_most = 8.0
terms = [{ functional = "range", output = "slider7.x" }]
[constraints.rms]
relative = true
at_most = 1.5
terms = [{ functional = "rms", output = "slider7.x" }]
[constraints.even]
formula = "oil - 0.4"
equals = 0.0
"""


def test_what_the_algorithm_sees(study, monkeypatch):
    engine(monkeypatch, [[1.0]], [[6.0]], rms=[[2.0]])
    found = study(LIMITED)
    evaluator = Evaluator(found)
    nominal = evaluator(np.array([[0.5, 0.4]]))
    evaluations = evaluator(np.array([[0.25, 0.3], [1.0, 0.4], [2.0, 0.5]]))
    objectives, constraints = in_units(found, evaluations, nominal)
    assert objectives == pytest.approx(np.array([[0.5, 0.25], [2.0, 1.0], [4.0, 2.0]]))
    assert constraints == pytest.approx(np.array([[1.25, 0.5, -0.1], [5.0, 2.0, 0.0], [10.0, 4.0, 0.1]]))
    values = values_of(found, evaluations, nominal)
    problem = problem_of(found, evaluator, nominal)
    assert problem.inequalities == ("range.at_most", "range.at_least", "rms.at_most")
    assert problem.equalities == ("even.equals",)
    assert values.objectives == pytest.approx(np.array([[0.5, -0.25], [2.0, -1.0], [4.0, -2.0]]))
    assert values.inequalities == pytest.approx(
        np.array([[-6.75 / 8, 0.75 / 2, -1.0 / 1.5], [-3.0 / 8, -3.0 / 2, 0.5 / 1.5], [2.0 / 8, -8.0 / 2, 2.5 / 1.5]])
    )
    assert values.equalities == pytest.approx(np.array([[-0.1], [0.0], [0.1]]))
    assert values.violation == pytest.approx([0.375 + 0.1, 0.5 / 1.5, 0.25 + 2.5 / 1.5 + 0.1])


def test_failures_are_explicit(study, monkeypatch):
    engine(monkeypatch, [[1.0]], [[6.0]], rms=[[2.0]])
    found = study(LIMITED)
    nominal = Evaluator(found)(np.array([[0.5, 0.4]]))
    statuses, reasons = ("ok", "no-assembly", "ok"), ("", "the loops do not close", "")
    engine(monkeypatch, [[1.0]], [[6.0]], rms=[[2.0]], status=statuses, reason=reasons)
    evaluations = Evaluator(found)(np.array([[0.5, 0.4], [0.5, 0.4], [np.nan, 0.4]]))
    assert evaluations.status == ("ok", "no-assembly", "no-value")
    assert evaluations.reason == ("", "cold: the loops do not close", "f has no finite value")
    assert np.isnan(evaluations.objectives[1:]).all()
    assert np.isnan(evaluations.constraints[1:]).all()
    values = values_of(found, evaluations, nominal)
    assert values.failed.tolist() == [False, True, True]
    assert np.isinf(values.objectives[1:]).all()
    assert np.isinf(values.violation[1:]).all()
    assert np.isfinite(values.violation[0])
    failed = Evaluations(
        evaluations.objectives[1:2], evaluations.constraints[1:2], evaluations.status[1:2], evaluations.reason[1:2]
    )
    with pytest.raises(
        RunError, match=r"mine\.toml: objectives\.f is relative to the nominal design, .*: cold: the loops"
    ):
        values_of(found, evaluations, failed)


@pytest.mark.processes
@pytest.mark.parametrize("parts", [1, 2, 3, 7, 50])
def test_division_into_requests_does_not_change_a_bit(study, invented_engine, parts):
    found = study(LIMITED)
    rng = np.random.default_rng(3)
    designs = rng.uniform(found.lower, found.upper, (23, 2))
    whole = Evaluator(found)(designs)
    with ThreadPoolExecutor(3) as executor:
        for divided in (Evaluator(found, parts=parts)(designs), Evaluator(found, executor, parts)(designs)):
            assert divided.objectives.tobytes() == whole.objectives.tobytes()
            assert divided.constraints.tobytes() == whole.constraints.tobytes()
    alone = Evaluator(found)(designs[7:8])
    assert alone.objectives.tobytes() == whole.objectives[7:8].tobytes()


@pytest.mark.processes
def test_requests_to_an_executor_carry_enough_work(study, invented_engine, monkeypatch):
    """By the clock a population takes 20 ms a design: five designs make 0.1 s, at both operating points."""
    found, real, asked = study(LIMITED), remote.answer, []

    def answer(shared, values):
        asked.append(len(values))
        return real(shared, values)._replace(seconds=0.02 * len(values))

    monkeypatch.setattr(remote, "answer", answer)
    designs = np.random.default_rng(3).uniform(found.lower, found.upper, (12, 2))
    with ThreadPoolExecutor(1) as executor:
        evaluate = Evaluator(found, executor, parts=50)
        assert evaluate.population(512) == 512
        evaluate(designs[:3])
        assert asked == [1] * 6, "nothing is known of the first population"
        asked.clear()
        evaluate(designs)
        assert asked == [6, 6] * 2
        assert evaluate.population(512) == 3 * 512, "1250 designs are half a second of work for each of 50 requests"


@pytest.mark.processes
def test_a_population_is_work_enough_for_all_workers(study, invented_engine, monkeypatch):
    """Of 0.31 ms each, 3226 designs make two requests of half a second: seven times 512; and four workers are followed.

    A quick request beside slow ones changes nothing: the time of all counts.
    """
    found, workers, given = study(LIMITED), [1], iter([1e-6, 0.62e-3] * 100)
    real = remote.answer
    monkeypatch.setattr(
        remote, "answer", lambda shared, values: real(shared, values)._replace(seconds=next(given) * len(values))
    )
    with ThreadPoolExecutor(1) as executor:
        evaluate = Evaluator(found, executor, parts=lambda: 2 * workers[0])
        evaluate(np.tile(found.nominal, (4, 1)))
        assert evaluate.population(512) == 7 * 512
        workers[0] = 4
        assert evaluate.population(512) == 26 * 512
        workers[0] = 0
        assert evaluate.population(512) == 4 * 512


def test_another_process_reads_what_requests_share_once(study, invented_engine):
    """Two requests that were pickled apart have one system afterwards."""
    shared = Parcel((study(LIMITED).points[0].system, "engines"))
    one, other = (pickle.loads(pickle.dumps((shared, k))) for k in (1, 2))
    assert one[0] is other[0]
    assert one[0].content[0] is not shared.content[0]


def test_a_worker_that_comes_later_with_another_version_is_refused(monkeypatch):
    sent = pickle.dumps(Parcel("other versions"))
    monkeypatch.setattr(parcels, "determining", lambda: {"linkages": "0.0", "numba": "0", "numpy": "0", "scipy": "0"})
    with pytest.raises(
        RunError, match=r"worker process \d+ on \S+ has linkages 0\.0, and .* is needed; install the same"
    ):
        pickle.loads(sent)


def test_answers_are_sent_by_columns():
    """10,000 designs of which one failed: 32 bytes of numbers and one of the status, each."""
    values = np.random.default_rng(1).random((4, 10_000, 1, 1))
    status, reason = ["ok"] * 10_000, [""] * 10_000
    status[7], reason[7] = "no-assembly", "the loops do not close"
    answer = remote.answered(Statistics(values, status, reason), 1.0)
    again = pickle.loads(sent := pickle.dumps(answer)).statistics()
    assert (again.status, again.reason) == (status, reason)
    assert again.values.tobytes() == values.tobytes()
    assert len(sent) < 33 * 10_000 + 2000


def test_formulas_alone_need_no_run(study, monkeypatch):
    asked = engine(monkeypatch, [[1.0]], [[1.0]])
    found = study('[objectives.f]\nformula = "(mass - 0.2)**2 + log(oil - 0.1)"')
    evaluations = Evaluator(found)(np.array([[0.3, 1.1], [0.3, 0.1]]))
    assert evaluations.objectives[0, 0] == pytest.approx(0.01)
    assert evaluations.status == ("ok", "no-value")
    assert not asked
