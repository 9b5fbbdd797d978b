"""Numbers that tune searches, samples and checks of studies, in the order of the modules that read them.

Each line has name, value, unit and effect. ``python tests/constants.py optim/search/numerics.py tests/optim`` changes
each by a factor of three and says whether a test notices.
"""

# derivative_check
DERIVATIVE_CHECK_DOUBT = 2.0  # [1] factor on the change of a difference with its step, within which it says nothing

# rare_limits: shares of machines beyond a limit
RARE_LIMITS_RARE = 1e-3  # [1] share beyond a limit below which more of these machines are sought
RARE_LIMITS_CHAOTIC = 0.01  # [variance] share by a change of the values by 1e-6 above which derivatives mean nothing
RARE_LIMITS_FAR = 8.0  # [deviation] distance of the limit from the mean from which nothing is sought
RARE_LIMITS_APART = 3.0  # [standard error] difference of two estimates above which they contradict each other

# rare_shares: subset simulation and importance sampling
RARE_SHARES_LENGTH = 10  # [1] points of a chain, its first one included
RARE_SHARES_LEAST = 1e-7  # [1] share at which the climb ends
RARE_SHARES_STUCK = 0.5  # [1] part of the points at a level above which the next level is no higher
RARE_SHARES_ACCEPTED = 0.44  # [1] part of the candidates that the width of the moves aims at (Papaioannou et al.)
RARE_SHARES_ENOUGH = 0.1  # [share] standard error at which sampling ends, after two batches
RARE_SHARES_WIDE = 0.3  # [1] part of the points that have the wide density

# known_designs
KNOWN_DESIGNS_FIRST = 1024  # [1] rows of empty columns: memory

# sampled_machines
SAMPLED_MACHINES_CHUNK = 512  # [1] machines after which the yield is judged; chunks of the store are multiples
SAMPLED_MACHINES_UNDER_WAY = 2  # [1] chunks at once: no worker waits while one is stored and judged
SAMPLED_MACHINES_STEP = 0.1  # [deviation] of differences

# sensitivity
SENSITIVITY_STEPS = 21  # [1] of one variable at a time; odd
SENSITIVITY_RESAMPLES = 100  # [1] bootstrap samples for a standard error

# tolerances and their statistics
TOLERANCE_STATISTICS_GROUPS = 10  # [1] groups of the jackknife
TOLERANCE_STATISTICS_BLOCK = 2**16  # [1] machines whose densities are computed at once: memory
TOLERANCE_STATISTICS_ROUNDING = 1e-12  # [largest] differences of values that count as none
TOLERANCE_STATISTICS_EACH = 4  # [1] machines for each coefficient of the regression, at least
TOLERANCES_CHANGE = 1e-6  # [value] change that shows how predictable the machines are
TOLERANCES_CORNERS = 6  # [1] most values for which all corners of their limits are run
TOLERANCES_NOTHING = 0.1  # [deviation] deviation to first order that explains 1 % of the variance, or less
TOLERANCES_REPEATED = 64  # [1] machines that are run again with this change

# verification
VERIFICATION_TIGHTER = 0.1  # [tolerance of the study] tolerance of the checking runs
VERIFICATION_PHASES = 10  # [1] starts of dry machines that the search has not seen
