"""Numbers that tune analyses of one linkage, in the order of the modules that read them.

Each line has name, value, unit and effect. ``python tests/constants.py linkages/explore/numerics.py FILES`` changes
each by a factor of three and says whether a test in these files notices. No number here acts in compiled code.
"""

# bearing
BEARING_SMOOTH = 1e-6  # [thinnest film] step of differences of films in closed form
BEARING_THINNEST = 1e-3  # [clearance] film thickness below which films are not solved

# compare
COMPARE_IMPACTS = 2  # [1] individually compared contacts of each joint
COMPARE_FEWEST = 20  # [1] steps, or parts of them, that a stage makes in any case: one sample cannot be compared

# flow
FLOW_MOST = 20_000  # [1] steps of a part of a run
FLOW_LOOKS = 7  # [1] attempts to find the period of a formula, each over twice the duration

# linearisation
LINEARISATION_STEP = 2e-3  # [scale of the state] largest step of the differences; two halvings follow
LINEARISATION_LEAST = 1e-9  # [usual acceleration] least one by a unit input that limits the input's step

# local_coordinates
LOCAL_COORDINATES_PREFERRED = 1e-3  # [1] weight of those with a drive in the choice of dependent ones: they stay free

# lyapunov
LYAPUNOV_ACCURACY = 1e-4  # [distance] accuracy of the two trajectories
LYAPUNOV_BLOCKS = 10  # [1] blocks of revolutions for the standard error

# modes
MODES_ZERO = 1e-13  # [largest eigenvalue] below it an eigenvalue belongs to a free motion
MODES_SYMMETRIC = 1e-6  # [1] relative asymmetry below which the stiffness matrix counts as symmetric
MODES_AT_REST = 1e-6  # [length of the linkage] distance from equilibrium that counts as rest
MODES_SPARE = 4  # [1] additional modes for crossings
MODES_SAMPLES = 25  # [1] samples of a flexible link, or of a substructure

# operating_point
OPERATING_POINT_AT_REST = 1e-9  # [scale of the state, largest pole] rate below which a state is an equilibrium
OPERATING_POINT_ROUNDS = 100  # [1] iterations for an equilibrium
OPERATING_POINT_LONGEST = 0.2  # [length of the linkage] longest step of them
OPERATING_POINT_SAME = 1e-15  # [length of the linkage] step at which they end
OPERATING_POINT_FLAT = 1e-30  # [1/s2] least eigenvalue of the slope, so that steps stay finite

# periodic/branches
BRANCHES_SHOWN = 0.98  # [1] largest progress before the end
BRANCHES_MOST = 400  # [1] points of a branch in one direction
BRANCHES_SAME = 1e-4  # [range] distance of two bifurcations below which they are one

# periodic/continuation
CONTINUATION_ROUNDS = 12  # [1] Newton iterations
CONTINUATION_HALVINGS = 5  # [1] halvings of a Newton step that increases the residual
CONTINUATION_GOOD = 3  # [1] iterations of a correction after which the step is kept
CONTINUATION_BENT = 0.9  # [1] cosine of two tangents below which the step is repeated with half its length
CONTINUATION_FAR = 2.0  # [step] correction above which the solution may be one of another branch
CONTINUATION_BISECTIONS = 60  # [1] bisections that locate a zero of a test function
CONTINUATION_WIDEST = 100.0  # [1] largest growth of a scale

# periodic/motion
MOTION_UNDECIDED = 1e-6  # [1] distance from the unit circle within which a multiplier decides nothing

# periodic/return_map
RETURN_MAP_LOOSE = 1e-4  # [value] step of differences of the period
RETURN_MAP_STEPS = 200  # [1] least steps per period: no error control sees what a steady motion does with a disturbance
RETURN_MAP_AMPLE = 5.0  # [clearance] usual change of a coordinate
RETURN_MAP_APART = 1e4  # [usual change] scale of approach speeds, which may jump: they do not count in a distance
RETURN_MAP_LIFTS = 8  # [1] corrections of a state towards closed loops
RETURN_MAP_LIFTED = 1e-14  # [scale of the state] error of the independent coordinates

# periodic/tracing
TRACING_LOCATED = 1e-8  # [scaled arclength] to which bifurcations are located
TRACING_GRAZED = 1e-9  # [scaled arclength] to which a change of the contacts is located
TRACING_SMOOTH = 1e-3  # [1] distance of a located multiplier from the circle above which it jumped there

# prediction
PREDICTION_DEPARTS = 0.1  # [predicted change] largest departure of a run from the straight line
PREDICTION_TOGETHER = 3  # [1] steps, one after the other, at which the runs follow the line: at one they may by chance
PREDICTION_FELT = 0.01  # [change of the value] relative change of a number below which it counts as none

# range_of_motion
RANGE_OF_MOTION_BESIDE = 1e-6  # [search] distance from a dead point within which rates do not count

# sections
SECTIONS_HALVINGS = 60  # [1] halvings that locate a crossing
SECTIONS_LOOKS = 200  # [1/revolution] comparisons of two runs
SECTIONS_AT_ONCE = 40  # [1] most comparisons at once

# sensitivity
SENSITIVITY_SAFETY = 1.5  # [1] factor on the change, because the tighter run has an error too
SENSITIVITY_SHARED = 1e-6  # [derivative] error that both runs share: of differences of laws, of the times of peaks
SENSITIVITY_ROUNDING = 1e-11  # [number over the value's magnitude] error of the differences in derivatives
SENSITIVITY_NEAR = 1e-3  # [1] relative distance of two maxima whose order may change
SENSITIVITY_CHECK = 1e-3  # [value] step of the differences that check derivatives; of the unit for a value of zero

# transmission
TRANSMISSION_STILL = 1e-6  # [fastest body, or size] slower points and shorter lines have no direction

# wear/life
LIFE_FIRST = 5.0  # [tolerance] depth of the first jump
LIFE_ROUGH = 4.0  # [1] scatter of the first block, which only predicts the middle of the first jump, over the others'

# wear/measure
MEASURE_SETTLING = 2  # [1] cycles after the drive's ramp without measurement
MEASURE_UNSETTLED = 4  # [1] discarded cycles of a block without convergence
MEASURE_SAMPLES = 600  # [1] samples kept of a block, for each joint
MEASURE_NOTHING = 1e-30  # [m] depth that counts as zero; experiments have no smaller number
MEASURE_ASPERITIES = 4.0  # [standard deviation of the roughness] gap at which asperities carry load

# wear/stages
STAGES_CLOSE = 1e-4  # [length of the jump] tolerance of the cycle of a limit
STAGES_MISSED = 0.01  # [work] largest fraction without a found journal position
