"""Dynamics of planar linkages with clearance joints.

| module           | responsibility                                                                  |
|------------------|---------------------------------------------------------------------------------|
| mechanism        | SDFormat file -> `Mechanism`, validated (sdf_reader reads the file itself)       |
| experiment       | TOML file -> `Experiment`; values replaced by dotted path                        |
| schema           | the tables of an experiment: drives, joint models, settings                      |
| load_tables      | the tables of applied loads: forces, torques, springs                            |
| toml_tables      | TOML files as typed tables, comments as sources, errors in one line              |
| laws             | force laws of a clearance joint: scalar, pure, compiled                          |
| joint_parameters | an experiment's joint models -> the records that the laws read                   |
| loads            | applied loads: names checked, packed into the records that the kernels read      |
| planar           | planar multibody kernels: spanning tree, kinematics, dynamics, closure           |
| assembly         | loop closure, consistent initial state, ideal motion over time                   |
| drake            | the Drake engine: plant, `ClearanceJoints`, `Drives`, simulation, animation      |
| compiled         | the compiled engine: integrators, batches                                        |
| flexible         | the 3-RRR robot with flexible links: kinematics, finite elements, modes          |
| columns          | states -> named quantities over time                                             |
| trajectory       | the result of a run; save and load                                               |
| analysis         | extremes over continuous time, integrals                                         |
| run              | one experiment from start to end, and its summary                                |
| plots, table     | figures (plots_nonlinear: of nonlinear dynamics; figure_style: all alike); tables |
| report           | a folder of results as one HTML page                                             |
| impacts          | contacts of a joint, one by one                                                  |
| folder           | a folder of results, written whole or not at all                                 |
| compare          | both engines on one experiment: differences, and up to where they mean anything  |
| quantities       | units of columns                                                                 |
| nonlinear        | Poincare sections, bifurcation diagrams, Lyapunov exponents, spectra             |
| engines          | which engines there are                                                          |
| cli, commands    | the command line and its subcommands                                             |
| doctor           | is the installation sound                                                        |
| parsing          | command lines: errors of one line that name the nearest valid word               |
| errors           | `InputError`, `RunError`, `Status`                                               |
| data             | where the shipped machines and experiments are                                   |

Conventions: SI units; angles counter-clockwise about the plane's normal; a joint's coordinate is zero in the pose
that the SDF file draws; joint forces act on the joint's child (the journal); eccentricity points from the bearing's
centre to the journal's.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from linkages.engines.study import simulate as simulate
    from linkages.engines.study import study as study
    from linkages.errors import InputError as InputError
    from linkages.errors import Status as Status
    from linkages.model.experiment import Experiment as Experiment
    from linkages.model.experiment import load as load
    from linkages.model.experiment import load_experiment as load_experiment
    from linkages.model.mechanism import Mechanism as Mechanism
    from linkages.model.mechanism import load_mechanism as load_mechanism
    from linkages.results.trajectory import Trajectory as Trajectory
    from linkages.results.trajectory import load_trajectory as load_trajectory
    from linkages.system.assembly import assemble as assemble

#: Public names and where they live; loaded on first use, so that ``import linkages`` is fast.
_HOME = {
    "assemble": "system.assembly",
    "InputError": "errors",
    "Status": "errors",
    "Experiment": "model.experiment",
    "load": "model.experiment",
    "load_experiment": "model.experiment",
    "Mechanism": "model.mechanism",
    "load_mechanism": "model.mechanism",
    "simulate": "engines.study",
    "study": "engines.study",
    "Trajectory": "results.trajectory",
    "load_trajectory": "results.trajectory",
}

__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'linkages' has no attribute '{name}'")
    import importlib

    return getattr(importlib.import_module(f"linkages.{_HOME[name]}"), name)
