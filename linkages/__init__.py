"""Dynamics of planar linkages with imperfect joints.

Each folder imports only from those above it:

| folder    | what lives there                                                                            |
|-----------|---------------------------------------------------------------------------------------------|
| errors    | bad input, failed runs, named statuses with remedies                                        |
| kernel    | how functions are compiled                                                                  |
| files     | SDFormat, TOML, shipped files, files written whole or not at all                            |
| laws      | force laws of a joint with clearance: contact, film, friction                               |
| integrate | integrators and the location of events                                                      |
| planar    | kernels on plain arrays: markers, kinematics, dynamics, closure, contacts, loads, reactions |
| model     | `Mechanism` and `Experiment`: what a user writes, checked                                   |
| flexible  | beam elements, component modes, generalised-alpha                                           |
| system    | `System`: the numeric model, built once from both                                           |
| outputs   | one registry of named outputs                                                               |
| results   | trajectories, extremes, impacts, summaries                                                  |
| engines   | the compiled and the Drake engine; runs that belong together                                |
| explore   | sections, sweeps, exponents, spectra, comparison of the engines                             |
| three_rrr | the flexible 3-RRR parallel robot                                                           |
| plots     | figures and animations                                                                      |
| report    | a folder of results as one page                                                             |
| cli       | the command line                                                                            |

Conventions: SI units; angles counter-clockwise about the plane's normal; a joint's coordinate is zero in the pose
that the SDF file draws; joint forces act on the joint's child (the journal); eccentricity points from the bearing's
centre to the journal's.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from linkages.engines.compiled.batch import Batch as Batch
    from linkages.engines.compiled.batch import simulate_batch as simulate_batch
    from linkages.engines.study import ideal as ideal
    from linkages.engines.study import simulate as simulate
    from linkages.engines.study import study as study
    from linkages.errors import AssemblyError as AssemblyError
    from linkages.errors import InputError as InputError
    from linkages.errors import RunError as RunError
    from linkages.errors import Status as Status
    from linkages.explore.compare import compare as compare
    from linkages.explore.lyapunov import largest_exponent as largest_exponent
    from linkages.explore.sections import crossings as crossings
    from linkages.explore.sections import horizon as horizon
    from linkages.explore.sections import stroboscopic as stroboscopic
    from linkages.explore.spectra import spectrum as spectrum
    from linkages.explore.sweep import sweep as sweep
    from linkages.files.shipped import find_file as find_file
    from linkages.model.experiment import Experiment as Experiment
    from linkages.model.experiment import load_experiment as load_experiment
    from linkages.model.mechanism import Mechanism as Mechanism
    from linkages.model.mechanism import load_mechanism as load_mechanism
    from linkages.report.terminal import format_summary as format_summary
    from linkages.results.extremes import extremes as extremes
    from linkages.results.extremes import integral as integral
    from linkages.results.impacts import impacts as impacts
    from linkages.results.impacts import phases as phases
    from linkages.results.summary import Study as Study
    from linkages.results.summary import summarize as summarize
    from linkages.results.trajectory import Trajectory as Trajectory
    from linkages.results.trajectory import load_trajectory as load_trajectory
    from linkages.system.ideal_motion import IdealMotion as IdealMotion
    from linkages.system.system import System as System
    from linkages.system.system import load as load

#: Modules and their public names, which are loaded on first use, so that ``import linkages`` is fast.
_NAMES = {
    "engines.compiled.batch": ("Batch", "simulate_batch"),
    "engines.study": ("ideal", "simulate", "study"),
    "errors": ("AssemblyError", "InputError", "RunError", "Status"),
    "explore.compare": ("compare",),
    "explore.lyapunov": ("largest_exponent",),
    "explore.sections": ("crossings", "horizon", "stroboscopic"),
    "explore.spectra": ("spectrum",),
    "explore.sweep": ("sweep",),
    "files.shipped": ("find_file",),
    "model.experiment": ("Experiment", "load_experiment"),
    "model.mechanism": ("Mechanism", "load_mechanism"),
    "report.terminal": ("format_summary",),
    "results.extremes": ("extremes", "integral"),
    "results.impacts": ("impacts", "phases"),
    "results.summary": ("Study", "summarize"),
    "results.trajectory": ("Trajectory", "load_trajectory"),
    "system.ideal_motion": ("IdealMotion",),
    "system.system": ("System", "load"),
}
_HOME = {name: module for module, names in _NAMES.items() for name in names}

__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'linkages' has no attribute '{name}'")
    import importlib

    return getattr(importlib.import_module(f"linkages.{_HOME[name]}"), name)
