"""Groups of related runs: a run, its ideal linkage, and the run that estimates its error."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TypeVar

from linkages.base.arguments import Names, validated
from linkages.base.errors import AssemblyError, InputError, RunError, Status
from linkages.elements.analysis import Analysis
from linkages.engines import DEFAULT, check_engine
from linkages.engines import engine as load_engine
from linkages.engines.methods import expect_run
from linkages.engines.numerics import ASSESSMENT_TIGHTER
from linkages.engines.repetition import finer_cells, tightened
from linkages.laws.heat import NEAR
from linkages.results.assessment import SMOOTHINGS, Assessment
from linkages.results.derivatives import Wrt
from linkages.results.films import heated, joint_heat
from linkages.results.measured import check_data
from linkages.results.outputs.columns import columns
from linkages.results.outputs.registry import check_outputs, unit
from linkages.results.trajectory import Loops, TimeReport, Trajectory, sample
from linkages.system import System
from linkages.system.ideal_motion import check_duration, ideal_motion
from linkages.system.rigid_segments import Segmented

T = TypeVar("T")


@validated
def simulate(
    system: System,
    engine: str = DEFAULT,
    progress: TimeReport | None = None,
    outputs: Names | None = None,
    wrt: Wrt = (),
) -> Trajectory:
    """Run a system.

    Use `assess` to also get the ideal linkage and errors of peaks, `simulate_batch` for many runs with other values.

    Parameters
    ----------
    system : System
        From `linkages.load`.
    engine : str
        "compiled", the default, or "drake".
    progress : callable, optional
        Called with the simulated time [s] at intervals; a `linkages.base.errors.TimeOverError` ends the run.
    outputs : sequence of str, optional
        Columns of the trajectory, for the compiled engine: fewer take less time. Default: all.
    wrt : sequence of str or Direction, optional
        Dotted paths of values, or values that several paths follow, for the compiled engine: `Trajectory.sensitivity`
        has the derivatives of the columns at fixed times with respect to them, in units of the column per unit of the
        value.

    Returns
    -------
    Trajectory
        Columns up to the end, or until the run failed or was interrupted (`Trajectory.status`).

    Raises
    ------
    InputError
        If the engine or an output is unknown, a path has no number or no derivative or changes no number of the model,
        `outputs` or `wrt` are given for Drake, or Drake or `wrt` does not support a model.
    AssemblyError
        If the linkage cannot be assembled at t = 0.

    Examples
    --------
    >>> import linkages
    >>> system = linkages.load(linkages.find_file("seven_bar.toml"), {"duration": 0.1})
    >>> run = linkages.simulate(system, "compiled")
    >>> run.status.value
    'ok'
    >>> round(linkages.extremes(run, ["A.force"])["A.force"].peak, 2)  # N
    6.96
    >>> run = linkages.simulate(system, outputs=["slider7.x"], wrt=["sdf.frames.link6_D.pose.x"])
    >>> run.sensitivity["sdf.frames.link6_D.pose.x"]["slider7.x"][-1].round(4).item()  # m/m
    1.0031
    """
    if outputs is None and not wrt:
        return _with_units(system, load_engine(engine).simulate(system, progress))
    if engine != DEFAULT:
        what = "wrt" if wrt else "outputs"
        raise InputError("argument", what, "is for the compiled engine alone; leave it out")
    if wrt:
        from linkages.engines.compiled.effects import check_differentiated

        system.check_analysis(Analysis.DERIVATIVES)
        check_differentiated(system, wrt, outputs or ())
    return differentiated(system, outputs, wrt, progress)


def differentiated(
    system: System, outputs: Names | None, wrt: Wrt = (), progress: TimeReport | None = None
) -> Trajectory:
    """Run a system in the compiled engine as `simulate`; derivatives may be with respect to values without effect."""
    from linkages.engines.compiled.simulation import simulate as simulate_compiled

    return _with_units(system, simulate_compiled(system, progress, outputs, wrt))


def _with_units(system: System, run: Trajectory) -> Trajectory:
    """Add the units of the columns to a trajectory, and the times at which they jump."""
    named = system.whole if isinstance(system, Segmented) else system
    units = {name: "s" if name == "time" else unit(named, name) for name in run.columns}
    return replace(run, units=units, jumps=system.sampling_times(float(run.time[-1])))


@validated
def assess(
    system: System,
    engine: str = DEFAULT,
    error_estimate: bool = True,
    progress: Callable[[str], TimeReport] | None = None,
) -> Assessment:
    """Run a system, its ideal counterpart and optionally the run at a tighter tolerance.

    Use `simulate` if the run alone is needed. With a heat balance (``joints.NAME.heat``) the run is repeated until the
    temperature of the oil settles, see `linkages.engines.assessment`; `Assessment.system` has this temperature.

    Parameters
    ----------
    system : System
    engine : str
        "compiled", the default, or "drake".
    error_estimate : bool
        Whether to repeat the run at a ten times tighter tolerance.
    progress : callable, optional
        Called with the name of each stage; returns the stage's progress function.

    Returns
    -------
    Assessment
        For `linkages.summarize` and the figures.

    Raises
    ------
    InputError, AssemblyError
        See `simulate`.

    Examples
    --------
    >>> import linkages
    >>> system = linkages.load(linkages.find_file("seven_bar.toml"), {"duration": 0.1})
    >>> assessment = linkages.assess(system, "compiled", error_estimate=False)
    >>> assessment.ideal.status.value
    'ok'
    """
    stage = progress or (lambda name: lambda time: None)
    check_engine(engine)
    expect_run(system, engine)  # before the ideal linkage
    check_data(system)
    _ = system.assembly  # faults of the machine itself are raised
    exact, _ = _of_ideal(system, lambda: _with_exact_motion(system))
    if exact is not None:
        check_duration(exact)
    run = simulate(system, engine, stage("run"))
    perfect, problem = _of_ideal(system, lambda: ideal(system, engine))
    found = Assessment(system, engine, run, perfect, None, no_ideal=problem)
    found = settle(found, lambda warmer, name: simulate(warmer, engine, stage(name)))
    return estimate_error(found, stage) if error_estimate else found


def _of_ideal(system: System, compute: Callable[[], T]) -> tuple[T | None, str]:
    """Compute something of the ideal linkage; None and the reason if only the real one can be computed.

    The comparison does not decide what may run. Without clearance, backlash and deformation both are the
    same, and the errors too.
    """
    try:
        return compute(), ""
    except (AssemblyError, InputError) as problem:
        if not system.imperfect:
            raise
        return None, (problem.problem if isinstance(problem, InputError) else str(problem)).partition(";")[0]


def estimate_error(assessment: Assessment, stage: Callable[[str], TimeReport]) -> Assessment:
    """Add the run at a ten times tighter tolerance to an assessment whose run reached its end.

    Of a long run that repeats itself it covers the first part alone, see `Assessment.repeating`. With signals from data
    files also the runs with half and double smoothing, with films that have a history one with twice as many cells.
    """
    if assessment.run.status is not Status.OK:
        return assessment
    system, engine, part = assessment.system, assessment.engine, {}
    if assessment.repeating is not None:
        part = {"duration": assessment.repeating.settled, "windows": {}, "report_from": None}
    files = system.recorded
    resmoothed = {}
    for name, factor in SMOOTHINGS.items() if files else ():
        values = {f"{path}.smoothing": factor * (table.smoothing or 1.0) for path, table in files.items()}
        resmoothed[name] = simulate(system.replaced(part | values), engine, stage(f"{name} smoothing"))
    finer = tightened(system, assessment.run, ASSESSMENT_TIGHTER)
    finer = finer.replaced(part) if part else finer
    tighter = simulate(finer, engine, stage("error estimate"))
    remeshed = None
    if cells := finer_cells(system):  # apart from the film step, whose error may have the other sign
        remeshed = simulate(system.replaced(part | cells), engine, stage("error estimate of the cells"))
    return replace(assessment, tighter=tighter, resmoothed=resmoothed, remeshed=remeshed)


@validated
def ideal(system: System, engine: str = DEFAULT) -> Trajectory:
    """Compute the motion of the ideal linkage: exactly if its drives determine it, otherwise by a run.

    `IdealMotion` gives the exact motion at any time, without outputs.

    Parameters
    ----------
    system : System
    engine : str
        Engine of the run, if one is needed.

    Returns
    -------
    Trajectory
        Columns without the quantities of clearances. They may end early, at a dead point (`Trajectory.status`).

    Raises
    ------
    AssemblyError
        If the linkage cannot be assembled at t = 0, or cannot leave its start.
    InputError
        If the motion has more revolutions than the stored positions support.

    Examples
    --------
    >>> import linkages
    >>> system = linkages.load(linkages.find_file("seven_bar.toml"), {"duration": 1.0})
    >>> motion = linkages.ideal(system)
    >>> round(linkages.extremes(motion, ["slider7.ax"])["slider7.ax"].peak, 3)  # m/s2
    3.556
    """
    check_outputs(system)
    determined = _with_exact_motion(system)
    if determined is None:
        return simulate(system.ideal(), engine)
    system, motion = determined, ideal_motion(determined)
    if len(motion.times) < 2:
        raise AssemblyError(motion.status, "the ideal linkage cannot leave its start position")
    exact = sample(
        motion.times,
        lambda times: columns(system, times, *motion.states(times)),
        motion.status,
        {"engine": "kinematics"},
        Loops(system.tree, system.tree.closure_rows),
    )
    return _with_units(system, exact)


def _with_exact_motion(system: System) -> System | None:
    """Return the system, or the ideal one, whose motion the drives determine; None if they determine neither."""
    if system.determinate:
        return system
    ideal_system = system.ideal()
    return ideal_system if ideal_system.determinate else None


#: Most runs for one equilibrium, and the origin of the temperatures that it sets.
_MOST, _ORIGIN = 12, "heat balance"


def settle(assessment: Assessment, rerun: Callable[[System, str], Trajectory]) -> Assessment:
    """Repeat a run until the temperatures of its oil change by less than `linkages.laws.heat.NEAR`.

    Each run's motion gives the power and flow of a cycle (`linkages.results.films`). The next temperature is the
    one at which this motion would be in balance; the power is taken as proportional to the viscosity. The temperature
    that settles has no approximation left. The given run is at the first guess; `rerun` runs a system, and its second
    argument names the run. Returns the assessment of the system with the last temperatures, and its `heat`; without it
    if a run fails. RunError if no temperature balances.
    """
    names = heated(assessment.system)
    for count in range(1, _MOST + 1):
        if not names or assessment.run.status is not Status.OK:
            return assessment
        try:
            heats = {name: joint_heat(assessment.system, assessment.run, name, *_cycle(assessment)) for name in names}
        except ArithmeticError as problem:
            raise RunError(f"{problem}; the joints are {', '.join(names)}") from None
        if count == _MOST or all(abs(heat.change) < NEAR for heat in heats.values()):
            return replace(assessment, heat=heats)
        values = {f"joints.{name}.oil.temperature": heat.balanced for name, heat in heats.items()}
        system = assessment.system.replaced(values, _ORIGIN)
        assessment = replace(assessment, system=system, run=rerun(system, f"run {count + 1}, oil temperature"))
    raise AssertionError("the loop returns at its last round")


def _cycle(assessment: Assessment) -> tuple[tuple[float, float], bool]:
    """Return the last period of the motion, or the reported part of a run without one; whether the motion repeats."""
    motion, end = assessment.motion, float(assessment.run.time[-1])
    if motion.cycle is not None:
        return motion.cycle, True
    if motion.period is not None and motion.period <= end:
        return (end - motion.period, end), False
    return assessment.reported_span, False
