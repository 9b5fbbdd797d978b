"""Compare ideal linkages in Exudyn and SciPy's LSODA: ``python benchmarks/ideal_exudyn.py [--page FILE]``.

Machines without films, contacts and user functions: the six-bar with ideal joints, its crank released at 300 r/min,
over 1 s, and a hanging zigzag chain of ten bars, released from rest, over 1 s. Exudyn (``pip install exudyn``) as in
sevenbar_exudyn.py; LSODA (`odeint`) calls this package's compiled right-hand side from Python. The error is the largest
distance of the last link's centre of mass from that at an accuracy of 1e-12, over the range of its path, at 200 times.
CPU times are medians of turns, without set-up; at equal error, by interpolation between the points of a code. The
flexible slider-crank is on [its own page](flexible_theory.md).
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from batch import markdown
from growth import chain
from scipy.integrate import odeint
from sevenbar_engines import Line, wall_at
from sevenbar_exudyn import NEWTON, Model

from linkages import load
from linkages.engines.compiled.run.equations import derivatives
from linkages.engines.compiled.run.runner import Runner, join
from linkages.input.files.shipped import data_folder
from linkages.mechanics.planar.kinematics import body_states

sys.exudynFast = True
DURATION = 1.0
TIMES = np.linspace(0.0, DURATION, 201)
ACCURACIES = tuple(10.0**-k for k in range(2, 10))
STEPS = (500, 1000, 2000, 4000, 8000, 16000, 32000, 64000)
LEVELS = (1e-3, 1e-4, 1e-5)
BEGIN, COMMAND = "\n## Ideal linkages\n", "`python benchmarks/ideal_exudyn.py`."


def six_bar(folder):
    """Load the six-bar with ideal joints and a free crank."""
    text = f"""mechanism = "{data_folder() / "six_bar.sdf"}"
duration = {DURATION}
[drives.O2]
torque = 0.0
speed = {10.0 * np.pi}
"""
    (folder / "six.toml").write_text(text)
    return load(folder / "six.toml")


MACHINES = {
    "six-bar, free crank": six_bar,
    "chain of ten bars": lambda folder: chain(folder, 10).replaced({"duration": DURATION}),
}


class Motion:
    """A machine, its state as the compiled engine knows it, and the path of its last link."""

    def __init__(self, system):
        self.system, tree = system, system.tree
        self.link = system.mechanism.links[-1].name
        self.body = tree.index[self.link]
        runner = Runner(system)
        self.start, self.free, self.problem = runner.start, runner.model.free, runner.aside()
        self.pose, self.velocity = np.empty((len(tree.bodies.records), 5)), np.empty((len(tree.bodies.records), 3))

    def place(self, q):
        """Centre of mass of the last link at coordinates (n,)."""
        body_states(self.system.tree.bodies, q, np.zeros_like(q), self.pose, self.velocity)
        body, (x, y, _, c, s) = self.system.tree.bodies.records[self.body], self.pose[self.body]
        return x + c * body.cx - s * body.cy, y + s * body.cx + c * body.cy

    def ours(self, accuracy):
        """CPU time and path of a run of the compiled engine."""
        runner = Runner(self.system.replaced({"solver.accuracy": accuracy}))
        begun = time.process_time()
        steps = runner.run(0.0, runner.start, 0.0, 10**7)
        spent = time.process_time() - begun
        return spent, np.array([self.place(q) for q in runner.evaluate(join([steps]), TIMES)[0]])

    def lsoda(self, accuracy):
        """CPU time and path by LSODA."""

        def rates(t, y):
            out = np.empty_like(y)
            derivatives(self.problem, t, y, out)
            return out

        begun = time.process_time()
        states = odeint(rates, self.start, TIMES, tfirst=True, rtol=accuracy, atol=1e-3 * accuracy, mxstep=10**6)
        spent = time.process_time() - begun
        q = np.tile(self.system.assembly.q, (len(TIMES), 1))
        q[:, self.free] = states[:, : len(self.free)]
        return spent, np.array(list(map(self.place, q)))

    def exudyn(self, steps):
        """CPU time and path by Exudyn's implicit trapezoidal rule."""
        model = Model(self.system)
        exudyn, items, solver = model.exudyn, model.items, model.solver
        seen = exudyn.OutputVariableType.Position
        node = model.nodes[self.link]
        sensor = solver.AddSensor(items.SensorNode(nodeNumber=node, outputVariableType=seen, storeInternal=True))
        solver.Assemble()
        settings = exudyn.SimulationSettings()
        settings.solution.file.write = False
        settings.solution.sensors.writePeriod = TIMES[1]
        integration = settings.timeIntegration
        integration.verboseMode, integration.newton.useModifiedNewton = 0, True
        integration.newton.relativeTolerance, integration.newton.absoluteTolerance = 1e-2 * NEWTON, 1e-4 * NEWTON
        integration.endTime, integration.numberOfSteps = DURATION, steps
        begun = time.process_time()
        if not solver.SolveDynamic(settings, solverType=exudyn.DynamicSolverType.TrapezoidalIndex2):
            raise RuntimeError(f"Exudyn's Newton iteration failed with {steps} steps")
        spent = time.process_time() - begun
        stored = solver.GetSensorStoredData(sensor)
        if len(stored) != len(TIMES):
            raise RuntimeError(f"Exudyn stored {len(stored)} of {len(TIMES)} places")
        return spent, stored[:, 1:3]


def measured(system, repeat):
    """Lines of all codes, their errors against the converged path, in turns."""
    motion = Motion(system)
    exact = motion.ours(1e-12)[1]
    size = float(np.ptp(exact, axis=0).max())
    cases = [("compiled", "ours", ACCURACIES), ("LSODA", "lsoda", ACCURACIES), ("Exudyn", "exudyn", STEPS)]
    lines = []
    for code, method, settings in cases:
        run = getattr(motion, method)
        for setting in settings:
            found = [run(setting) for _ in range(repeat)]
            error = float(np.hypot(*(found[0][1] - exact).T).max()) / size
            line = Line(code, f"{setting:g}", lambda: None)
            line.walls, line.error = [one[0] for one in found], error
            print(f"{code:10} {setting:8g} {1e3 * line.wall:10.3f} ms {error:10.1e}", flush=True)
            lines.append(line)
    return lines


def main() -> None:
    """Print the tables; write the last into the page, if there is one."""
    parser = argparse.ArgumentParser(description=__doc__.split(":")[0])
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--page", type=Path)
    options = parser.parse_args()
    codes = ("compiled", "LSODA", "Exudyn")
    rows = [["machine, CPU [ms/s] at an error of", *codes]]
    with tempfile.TemporaryDirectory() as folder:
        for name, make in MACHINES.items():
            print(name)
            lines = measured(make(Path(folder)), options.repeat)
            for level in LEVELS:
                walls = [1e3 * wall_at(level, [line for line in lines if line.code == code]) for code in codes]
                cells = (f"{wall:{'.3g' if wall < 1e3 else '.0f'}} ({wall / walls[0]:.0f} x)" for wall in walls)
                rows.append([f"{name}, {level:.0e}", *cells])
    text = markdown(rows)
    print(text)
    if options.page:
        page, _, rest = options.page.read_text(encoding="utf-8").partition(BEGIN)
        rest = "".join(rest.partition("\n## ")[1:])
        about = __doc__.partition("\n\n")[2].replace("``", "`").strip()
        options.page.write_text(f"{page.rstrip()}\n{BEGIN}\n{COMMAND} {about}\n\n{text}{rest}", encoding="utf-8")


if __name__ == "__main__":
    main()
