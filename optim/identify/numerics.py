"""Numbers that tune identification, in the order of the modules that read them.

Each line has name, value, unit and effect. ``python tests/constants.py optim/identify/numerics.py FILES`` changes each
by a factor of three and says whether a test in these files notices.
"""

# several modules
TINY = 1e-120  # [1] stands for zero in denominators: its square is a number, too

# accuracy
ACCURACY_ENOUGH = 0.1  # [deviation] largest shift of a value by the error of the runs
ACCURACY_FINER = 0.1  # [accuracy] of the runs that tell the error
ACCURACY_FINEST = 1e-12  # [1] accuracy at which rounding errors are as large
ACCURACY_SAFETY = 0.3  # [largest shift] part that the next accuracy shall leave
ACCURACY_ROUNDS = 4  # [1] times that the accuracy is tightened

# algebra
ALGEBRA_INDEPENDENT = 1e-9  # [largest] size of an independent column, at least

# budget
BUDGET_SEARCH = 0.7  # [limit of time] part for the search; the rest is for accurate runs at its end

# certainty
CERTAINTY_KNOWN = 0.5  # [value, or deviation of a uniform one between its limits] largest deviation of a known value
CERTAINTY_LEAST = 1e-9  # [largest] singular value that counts
CERTAINTY_LAGS = 20  # [1] lags of the test of whiteness
CERTAINTY_LEAST_FREEDOM = 3.0  # [1] degrees of freedom that a factor of coverage assumes, at least
CERTAINTY_FAR = 4.0  # [1] chi-square of a sample from which on the error of a model exceeds the noise

# content
CONTENT_NEARLY = 2.0  # [1] largest ratio of sums of squares of predictions that are nearly as good

# curves
CURVES_STEP = 1e-3  # [interval of samples] step of differences with respect to time
CURVES_DIFFERENCE = 1e-5  # [scale of the unknown] step of differences of runs, for models without derivatives

# filters
FILTERS_UNEVEN = 1e-3  # [mean interval] largest deviation of the intervals of a column with a filter

# fit
FIT_FIRST = 20  # [1] fewest samples of the first window, and samples for each value
FIT_GROWTH = 2.0  # [1] ratio of two windows
FIT_CANDIDATES = 8  # [1] points of which one becomes a start
FIT_ROUNDS = 2  # [1] fits with deviations that follow from residuals, after the first
FIT_MOST_BATCHES = 4  # [1] evaluations of statistics in a stage
FIT_WORTH = 1.02  # [1] least ratio of two windows, at the horizon
FIT_LED = 15  # [1] runs with integrals of each order
FIT_TOGETHER = 2  # [1] starts between two checks whether one has led
FIT_SAME = 0.05  # [1] relative difference of chi-square up to which two starts have found the same

# identify
IDENTIFY_HALF = 0.5  # [data] part that is predicted where alternatives are compared, by default
IDENTIFY_NEW = 8  # [1] further starts where the best one is hopeless
IDENTIFY_ROUNDS = 3  # [1] times that they are added, as long as they help
IDENTIFY_BETTER = 0.95  # [1] largest ratio of chi-square that helps

# integrals
INTEGRALS_IMPACTS = 3  # [1] first impacts that lead
INTEGRALS_HEIGHT = 0.2  # [range of the column] least prominence of an impact
INTEGRALS_CERTAIN = 6.0  # [deviation of a sample] least prominence of an impact
INTEGRALS_BEYOND = 1.5  # [time of the last of these impacts] end of the window
INTEGRALS_DEVIATION = 0.02  # [spread] deviation of an integral
INTEGRALS_PART = 64  # [1] designs between two looks at the clock
INTEGRALS_TIME = 0.3  # [limit of time] part for designs
INTEGRALS_SAMPLES = 2000  # [1] most samples of a window with which designs are compared
INTEGRALS_SHIFTS = 51  # [1] most shifts of a clock with which they are compared
INTEGRALS_SHIFT = 0.5  # [window] largest of these shifts

# load
LOAD_FEWEST = 8  # [1] samples of a column
LOAD_BEFORE = 1e-2  # [duration] data before the start of the run, where it continues in straight lines
LOAD_LONGEST = 100.0  # [duration] last time of data: longer ones have a wrong unit
LOAD_LARGEST = 1e100  # [SI] sample: sums of squares are numbers

# nodes
NODES_LAST = 2  # [1] coefficients that show whether a polynomial has converged
NODES_FINEST = 1e-8  # [1] least tolerance: derivatives of stiff films have rounding errors of this size
NODES_AT_ONCE = 20000  # [1] times that are interpolated together: memory

# plan
PLAN_NOISE = 0.01  # [spread of the output] deviation of a sensor that is proposed
PLAN_PROPOSED = 3  # [1] sensors that are proposed
PLAN_FEWEST = 8  # [1] samples of a planned run

# posterior
POSTERIOR_WALKERS = 16  # [1] walkers, at least, and at least three for each value
POSTERIOR_ENOUGH = 50  # [autocorrelation time] length of the chains
POSTERIOR_BEGINNING = 5  # [autocorrelation time] part that is left out
POSTERIOR_LOOK = 50  # [1] steps between two estimates of the autocorrelation time
POSTERIOR_REACH = 6.0  # [deviation] largest distance of a fitted shift from its best value
POSTERIOR_KEPT = 2000  # [1] samples in the result

# profile
PROFILE_MOST = 15  # [1] runs on each side
PROFILE_FEW = 4  # [1] runs at a value: the others start from where they should be
PROFILE_CLOSE = 0.02  # [root of the difference of chi-square] tolerance of a limit

# residuals
RESIDUALS_UNKNOWN = 0.01  # [spread of the column] deviation of a sample, before residuals tell it

# search
SEARCH_ENOUGH = 1e-8  # [1] relative change of the sum of squares, or of the values, at which a fit ends
SEARCH_HELD = 1e-2  # [1] residual of a value that moves from one limit to the other
SEARCH_HELD_SENSOR = 1e-6  # [effect on all residuals] the same of a value without limits

# statistics
STATISTICS_PARTS = 10  # [1] parts of the run, whose highest and lowest samples count
STATISTICS_POINTS = 8  # [1/value] points
STATISTICS_KNOWN = 1e-3  # [deviation of the column] least deviation of a statistic: no model is better
