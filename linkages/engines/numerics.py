"""Numbers that tune both engines, batches and derivatives, in the order of the modules that read them.

Each line has name, value, unit and effect. ``python tests/constants.py linkages/engines/numerics.py FILES`` changes
each by a factor of three and says whether a test in these files notices. Kernels have their own numbers.
"""

# assessment
ASSESSMENT_TIGHTER = 0.1  # [tolerance of the run] tolerance of the run that estimates its error

# cluster
CLUSTER_LOOK = 0.2  # [s] between two looks for the scheduler's file
CLUSTER_LEAST = 1.0  # [s] time that a scheduler has to answer, and a worker to appear
CLUSTER_SAID = 3.0  # [s] time after which a line says what is waited for
CLUSTER_RETRIES = 5  # [1] deaths of its worker that a piece of work survives

# compiled/batch/batch
BATCH_OF_RUNS = 0.1  # [time of the batch] part that the runs of a batch with derivatives take

# compiled/batch/lengths
LENGTHS_NEAR = 2.0  # [grid] largest error of the difference of two places

# compiled/batch/runs
RUNS_AT_ONCE = 16  # [1] most runs in one call of compiled code
RUNS_PARTS = 4  # [1/thread] calls, at least
RUNS_PATIENCE = 0.3  # [s] longest wait of a thread to build alone: a design may need a film map of seconds

# compiled/derivatives/neighbours
NEIGHBOURS_STEP = 3e-5  # [value] step of differences: their error of the second order is 1e-9
NEIGHBOURS_ZERO = 1e-7  # [SI] values of a smaller magnitude count as zero
NEIGHBOURS_UNIT = 1e-2  # [SI] magnitude of a value of zero without a usual one of its unit
NEIGHBOURS_SAME = 1e-15  # [number] change by rounding: the value does not change it

# compiled/derivatives/sensitivity
SENSITIVITY_FINE = 1e-10  # [1] accuracy of runs below which a grade of 3 has more than 1 % of the error of the run
SENSITIVITY_FELT = 0.01  # [scale] error of a run in the state up to which derivatives have a meaning
SENSITIVITY_AT_ONCE = 2000  # [1] most times of one evaluation: memory

# compiled/derivatives/start_derivatives
START_DERIVATIVES_DEPENDENT = 1e-11  # [largest] singular values of dependent rows are below
START_DERIVATIVES_LEFT = 1e-9  # [largest without them] change of the closure rows that the coordinates may leave

# compiled/effects
EFFECTS_SAME = 1e-9  # [size, rad] difference of places and angles that is rounding
EFFECTS_STEP = 1e-2  # [value, size or rad] change of a value to see its effect

# compiled/run/job
JOB_TRAVEL = 0.1  # [rad or m] largest travel of the fastest drive in a step of a prescribed motion
JOB_FEWEST = 200  # [1] steps of a prescribed motion: its loads may vary faster

# compiled/simulation
SIMULATION_FEW = 200  # [1] steps between checks of links without mass

# compiled/stepping
STEPPING_EARLY = 1e-12  # [time] rounding of a time that is reached

# drake/diagram
DIAGRAM_FIRST = 1e-3  # [largest step] first step of `Linkage.advance`

# drake/plant
PLANT_WIDTH = 0.02  # [size] width of a bar
PLANT_LIGHT = 1e-6  # [radius of gyration] size of the linkage, for a gearbox' wheel
PLANT_BLOCK = 0.06  # [size] side of a block, for a link with one joint

# drake/simulation
SIMULATION_BETWEEN = 3e-2  # [accuracy of the run] accuracy of the repeated integration between two steps
SIMULATION_FIRST = 0.1  # [step of the run] longest first step of it at this accuracy: a longer one is rejected
SIMULATION_FINEST = 1e-10  # [1] accuracy beyond which rounding keeps Drake's implicit schemes from converging

# drake/steps
STEPS_FIRST = 1e-3  # [longest step] first step after a sample at the start
STEPS_SMALLEST = 1e-9  # [longest step] step below which the run has collapsed
STEPS_EVENT_ACCURACY = 1e-3  # [accuracy] tolerance of contact times
STEPS_SHRUNK = 0.5  # [1] ratio of successive steps below which an implicit integrator is restarted
STEPS_CUT = 0.1  # [step] step after an attempt without finite forces
STEPS_SHORTER = 0.9  # [step] repeated step that needed a second attempt

# repetition
REPETITION_SHORTER = 0.5  # [step] steps of the repetition: equal ones would have equal errors
REPETITION_FILM = 0.25  # [error] what films with history permit, of first order: the run takes four times as many steps
REPETITION_CELLS = 2  # [1] ratio of their cells in each direction
REPETITION_FEWEST = 50  # [1] steps of the repetition

# threads
THREADS_LOOK = 0.05  # [s] interval between two calls of the observer
