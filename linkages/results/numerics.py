"""Numbers that tune the evaluation of results, in the order of the modules that read them.

Each line has name, value, unit and effect. ``python tests/constants.py linkages/results/numerics.py FILES`` changes
each by a factor of three and says whether a test in these files notices. Limits of physical meaning, formats, and
thresholds that docs/stated_errors.md states are in the modules themselves. No number here acts in compiled code.
"""

# several modules
ROUNDED = 1e-9  # [1] relative differences that are rounding: interpolation, shares, ratios of frequencies, equal nodes
COMPARED = 500  # [1] times at which two runs are compared: a difference between them is missed

# assessment: long runs, and their start
ASSESSMENT_CYCLES = 20  # [1] cycles of a periodic motion that stand for all of them in errors and figures
ASSESSMENT_LONG = 5  # [1] run over these cycles from which it is long
ASSESSMENT_TAKEN_UP = 0.005  # [run] time in which a centred journal takes up its load: in microseconds in fact

# divergence: when two runs part
DIVERGENCE_CLEAR = 0.1  # [limit] part up to which interpolation decides, with contacts, where it is less accurate
DIVERGENCE_PART = 256  # [1] times of one evaluation, of which an engine may need a millisecond for each

# extremes
EXTREMES_NEAR = 0.01  # [range] deficit from which on the smaller of two extremes is not refined for a peak

# films: oil, and the film of finite length
FILMS_UNSETTLED = 0.1  # [K] change of the temperature from run to run that is named in a warning
FILMS_LARGEST = 0.999  # [1] largest eccentricity ratio at which the film of finite length is solved
FILMS_STEP = 1e-4  # [1] of the slope for the step of Newton's method

# link_loads: mesh of a flexible link for finite elements

# peak_errors: other maxima than the peak
PEAK_ERRORS_MAXIMA = 8  # [1] other maxima of a column that are compared
PEAK_ERRORS_HIGH = 0.5  # [highest] height from which on they are
PEAK_ERRORS_SHIFTED = 0.05  # [shortest step] shift from which on maxima are compared at shifted times
PEAK_ERRORS_REACH = 4.0  # [three samples] farthest place of the same maximum in the other run

# soundness: singular positions
SOUNDNESS_LOOKS = 5  # [1] examined positions of a motion
SOUNDNESS_NOTHING = 1e-6  # [largest] of a quantity in self-balanced reactions
SOUNDNESS_MOST = 4000  # [1] first samples of the search for the smallest ratio of singular values
SOUNDNESS_TAKES_PART = 0.1  # [largest] component from which a joint takes part in the motion with fixed drives
SOUNDNESS_NEARBY = 1e-3  # [rad, or linkage lengths] distance at which the tangent of the motion is taken
SOUNDNESS_STEP = 1e-5  # [rad, or linkage lengths] of differences of the closure's Jacobian
SOUNDNESS_ALONE = 1e-2  # [1] ratio of singular values of second order above which no other branch passes

# start_up: until films carry their loads
START_UP_CARRIED = 0.1  # [ideal force] difference within which a film carries its load
START_UP_OVERSHOOT = 0.25  # [ideal force] excess before that from which there was a start-up
START_UP_LOADED = 3.0  # [flight of a journal] time in which a film takes up its load to a thousandth

# statistic_derivatives
STATISTIC_DERIVATIVES_POINTS = 3  # [1] of Gauss's quadrature within a step; one more gives its error
STATISTIC_DERIVATIVES_VISIBLE = 1e-6  # [values] smallest bend; forces of contacts are rounded to 1e-11 of themselves
STATISTIC_DERIVATIVES_BESIDE = 1e-3  # [step] distance from an extreme at which it is tested for a kink
STATISTIC_DERIVATIVES_STEEP = 0.05  # [range in a step] slope there, and difference of both sides, of a kink

# steady_state
STEADY_STATE_PHASES = 48  # [1] compared states per period; a multiple of 4
STEADY_STATE_SHRINKS = 0.5  # [1] ratio of later to earlier changes of a transient
STEADY_STATE_TURNS = 12  # [1] most revolutions of one drive in a common period
STEADY_STATE_LOOKS = 2001  # [1] times at which a drive's table or formula is sampled
STEADY_STATE_ROUNDS = 8  # [1] iterations that refine a period
STEADY_STATE_REPEATED = 1e-6  # [range] tolerance of a repeated motion

# trajectory, validity, warnings
TRAJECTORY_AT_ONCE = 2000  # [1] most times of one evaluation: memory
WARNINGS_NOTHING = 1e-6  # [largest peak of its kind] peak whose change means nothing
