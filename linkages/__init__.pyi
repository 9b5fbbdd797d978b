"""Public names, which are loaded on first use: the one list of them, for type checkers and for `lazy_loader`."""

from .base.errors import (
    AssemblyError as AssemblyError,
    InputError as InputError,
    RunError as RunError,
    Status as Status,
)
from .engines.assessment import assess as assess, ideal as ideal, simulate as simulate
from .engines.compiled.batch.batch import Batch as Batch, simulate_batch as simulate_batch
from .engines.compiled.stepping import Stepper as Stepper
from .explore.bearing import bearing as bearing
from .explore.bearing_heat import warm_bearing as warm_bearing
from .explore.compare import compare as compare
from .explore.grid import sweep_grid as sweep_grid
from .explore.linearisation import StateSpace as StateSpace, linearise as linearise
from .explore.lyapunov import largest_exponent as largest_exponent
from .explore.modes import Modes as Modes, modes as modes
from .explore.periodic.branches import branches as branches
from .explore.periodic.motion import PeriodicMotion as PeriodicMotion, periodic_motion as periodic_motion
from .explore.sections import crossings as crossings, horizon as horizon, stroboscopic as stroboscopic
from .explore.sensitivity import Sensitivities as Sensitivities, sensitivities as sensitivities
from .explore.spectra import spectrum as spectrum
from .explore.sweep import sweep as sweep
from .explore.wear.life import wear_life as wear_life
from .input.files.fits import Fit as Fit, fit as fit
from .input.files.general_tolerances import general_tolerance as general_tolerance
from .input.files.shipped import find_file as find_file
from .input.model.experiment import Experiment as Experiment, load_experiment as load_experiment
from .input.model.mechanism import Mechanism as Mechanism, load_mechanism as load_mechanism
from .laws.heat import Heat as Heat
from .results.assessment import Assessment as Assessment
from .results.derivatives import Direction as Direction
from .results.extremes import extremes as extremes, integral as integral
from .results.impacts import impacts as impacts, phases as phases
from .results.steady_state import Motion as Motion, motion_of as motion_of
from .results.summary import summarize as summarize
from .results.trajectory import Trajectory as Trajectory, load_trajectory as load_trajectory
from .show.live.answers import play as play
from .show.report.terminal import format_summary as format_summary
from .system.ideal_motion import IdealMotion as IdealMotion
from .system.loading import load as load
from .system.system import System as System
