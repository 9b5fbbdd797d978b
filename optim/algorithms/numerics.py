"""Numbers that tune algorithms of optimisation and are no settings of theirs.

Each line has name, value, unit and effect. ``python tests/constants.py optim/algorithms/numerics.py FILES`` changes
each by a factor of three and says whether a test in these files notices.
"""

# ga
GA_TOURNAMENT = 4  # [1] designs of a tournament, drawn from elites and children
GA_EQUAL = 1e-14  # [1] difference of genes that are not crossed
GA_WORST = 1e5  # [1] scaled objective that no feasible design exceeds
GA_VIOLATION = 1e9  # [1] violation that no infeasible design exceeds, half of the value for a failed one
