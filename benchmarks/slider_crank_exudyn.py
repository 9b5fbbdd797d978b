"""Compare Simeon's slider-crank with Exudyn's floating frame: ``python benchmarks/slider_crank_exudyn.py``.

Needs ``pip install exudyn ngsolve``. The rod is of steel, pinned at both ends, damped in proportion to its stiffness
and straight at t = 0 (B. Simeon, Mathematical Modelling of Systems 2, 1996, 1-18); the run lasts 0.1 s, 2.4
revolutions. Both codes take a floating frame whose axis goes through both pins, four modes of bending and one of
stretching, and linear strain: Exudyn knows no other for such bodies. Exudyn (J. Gerstmayr, Multibody System Dynamics
60, 2024, 533-561): solid finite elements by NGSolve, modes of Hurty, Craig and Bampton, implicit trapezoidal rule at
index 2 with a modified Newton method, range checks off.

Each code's error is the error of the mid-span deflection against its converged solution, over the largest deflection;
the difference of both solutions is printed too. Times are CPU times, medians of the repeated turns, without set-up.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from linkages import load, simulate
from linkages.engines.compiled.run.runner import Runner
from linkages.input.files.shipped import data_folder

sys.exudynFast = True
CRANK, LENGTH, HEIGHT = 0.15, 0.3, 0.008  # m
MODULUS, DENSITY, SLIDER = 2e11, 7870.0, 0.075552  # Pa, kg/m3, kg
SPEED, DURATION, DAMPING = 150.0, 0.1, 1.5e-5  # rad/s, s, s: damping over stiffness
BENDING, MODES = 4, 5
FIRST_MODE = 1276.7  # rad/s, of the pinned rod: its damping ratio is DAMPING times half of it
TIMES = np.linspace(0.0, DURATION, 201)
WIDER = 2.0  # width factor of Exudyn's rod, with less dense and softer material: separates the modes in the plane
MESH = 0.02  # m
NEWTON = 1e-8
ACCURACIES = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7)
STEPS = (1000, 2000, 4000, 8000, 16000)
CONVERGED = 64000
LEVELS = (1e-2, 1e-3, 1e-4)
EXPERIMENT = f"""mechanism = "{data_folder() / "slider_crank_flexible.sdf"}"
duration = {DURATION}
outputs = ["rod_mid.deflection"]
[drives.O]
speed = {SPEED}
[links.rod]
model = "flexible"
bending = {BENDING}
axial = {MODES - BENDING}
stiffening = false
damping = {0.5 * DAMPING * FIRST_MODE}
start = "undeformed"
"""


class Ours:
    """The machine as this package runs it."""

    def __init__(self, folder):
        (folder / "machine.toml").write_text(EXPERIMENT)
        self.system = load(folder / "machine.toml")
        self.exact = self.deflection(1e-10)

    def deflection(self, accuracy):
        """At `TIMES` [m]."""
        return simulate(self.system.replaced({"solver.accuracy": accuracy}), "compiled").evaluate(TIMES)[
            "rod_mid.deflection"
        ]

    def spent(self, accuracy):
        """CPU seconds of a run."""
        runner = Runner(self.system.replaced({"solver.accuracy": accuracy}))
        begun = time.process_time()
        runner.run(0.0, runner.start, 0.0, 10**7)
        return time.process_time() - begun


class Exudyn:
    """The machine as Exudyn runs it."""

    def __init__(self):
        import exudyn
        from exudyn import itemInterface as items  # noqa: N813

        self.exudyn, self.items = exudyn, items
        self.rod, self.ends = self._rod()
        self.exact = self.run(CONVERGED)[1]

    def _rod(self):
        """Finite elements of the rod with their modes in the plane, and the nodes of its two ends."""
        import ngsolve
        from exudyn.FEM import FEMinterface, HCBstaticModeSelection
        from netgen.csg import CSGeometry, OrthoBrick, Pnt

        side, half = 0.5 * HEIGHT, 0.5 * WIDER * HEIGHT
        shape = CSGeometry()
        shape.Add(OrthoBrick(Pnt(0.0, -side, -half), Pnt(LENGTH, side, half)))
        mesh = ngsolve.Mesh(shape.GenerateMesh(maxh=MESH))
        rod = FEMinterface()
        material = {"density": DENSITY / WIDER, "youngsModulus": MODULUS / WIDER, "poissonsRatio": 0.0}
        rod.ImportMeshFromNGsolve(mesh, meshOrder=2, **material)
        ends = [rod.GetNodesInPlane([x, 0.0, 0.0], [1.0, 0.0, 0.0]) for x in (0.0, LENGTH)]
        rod.ComputeHurtyCraigBamptonModes(ends, 6, computationMode=HCBstaticModeSelection.RBE2)
        places = rod.GetNodePositionsAsArray()
        modes = rod.modeBasis["matrix"].reshape(len(places), 3, -1)
        size = (modes**2).sum(axis=0)
        twist = np.abs(places[:, 2] @ modes[:, 1]) / np.sqrt((places[:, 2] @ places[:, 2]) * size[1])
        modes = modes[..., np.flatnonzero((size[2] < 0.5 * size.sum(axis=0)) & (twist < 0.5))[:MODES]].copy()
        # a rigid motion of each mode, so that both pins stay on the axis, and the first one in its place
        weights = [np.asarray(rod.GetNodeWeightsFromSurfaceAreas(nodes)) for nodes in ends]
        for mode in np.moveaxis(modes, 2, 0):
            (x, y, _), (_, other, _) = (weight @ mode[nodes] for weight, nodes in zip(weights, ends, strict=True))
            slope = (other - y) / LENGTH
            mode[:, 0] += slope * places[:, 1] - x
            mode[:, 1] -= y + slope * places[:, 0]
        rod.modeBasis["matrix"] = np.ascontiguousarray(modes.reshape(-1, MODES))
        self.weights, self.middle = weights, int(np.argmin(np.linalg.norm(places - [0.5 * LENGTH, 0.0, 0.0], axis=1)))
        return rod, ends

    def _model(self):
        """Make the system at its start, with sensors of the rod's middle and of its end at the slider."""
        from exudyn.FEM import ObjectFFRFreducedOrderInterface

        items, container = self.items, self.exudyn.SystemContainer()
        system = container.AddSystem()
        start = {"initialVelocity": [0.0, CRANK * SPEED, 0.0]}
        start["initialAngularVelocity"] = [0.0, 0.0, -CRANK * SPEED / LENGTH]
        rod = ObjectFFRFreducedOrderInterface(self.rod).AddObjectFFRFreducedOrder(
            system, positionRef=[CRANK, 0.0, 0.0], stiffnessProportionalDamping=DAMPING, **start
        )["oFFRFreducedOrder"]

        def node_coordinate(node, coordinate):
            return system.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))

        still = node_coordinate(system.AddNode(items.NodePointGround()), 0)
        node = system.AddNode(items.NodeRigidBody2D(initialVelocities=[0.0, 0.0, SPEED]))
        crank = system.AddObject(items.ObjectRigidBody2D(mass=1.0, inertia=1.0, nodeNumber=node))
        for coordinate, rate in enumerate((0.0, 0.0, SPEED)):
            ends = [still, node_coordinate(node, coordinate)]
            system.AddObject(items.ObjectConnectorCoordinate(markerNumbers=ends, offset=rate, velocityLevel=True))
        node = system.AddNode(items.NodePoint2D(referenceCoordinates=[CRANK + LENGTH, 0.0]))
        slider = system.AddObject(items.ObjectMassPoint2D(mass=SLIDER, nodeNumber=node))
        system.AddObject(items.ObjectConnectorCoordinate(markerNumbers=[still, node_coordinate(node, 1)]))
        pin = system.AddMarker(items.MarkerBodyRigid(bodyNumber=crank, localPosition=[CRANK, 0.0, 0.0]))
        first, last = (
            {"bodyNumber": rod, "meshNodeNumbers": np.array(nodes), "weightingFactors": weights}
            for nodes, weights in zip(self.ends, self.weights, strict=True)
        )
        ends = [pin, system.AddMarker(items.MarkerSuperElementRigid(**first))]
        system.AddObject(items.ObjectJointGeneric(markerNumbers=ends, constrainedAxes=[1, 1, 1, 1, 1, 0]))
        tip = system.AddMarker(items.MarkerSuperElementPosition(**last))
        ends = [system.AddMarker(items.MarkerBodyPosition(bodyNumber=slider)), tip]
        system.AddObject(items.ObjectJointSpherical(markerNumbers=ends, constrainedAxes=[1, 1, 0]))
        seen = {"storeInternal": True, "outputVariableType": self.exudyn.OutputVariableType.Position}
        sensors = [
            system.AddSensor(items.SensorSuperElement(bodyNumber=rod, meshNodeNumber=self.middle, **seen)),
            system.AddSensor(items.SensorMarker(markerNumber=tip, **seen)),
        ]
        system.Assemble()
        return system, sensors

    def run(self, steps):
        """CPU seconds of a run, and the deflection at `TIMES` [m]."""
        system, sensors = self._model()
        settings = self.exudyn.SimulationSettings()
        settings.solution.file.write = False
        settings.solution.sensors.writePeriod = DURATION / (len(TIMES) - 1)
        integration = settings.timeIntegration
        integration.endTime, integration.numberOfSteps, integration.verboseMode = DURATION, steps, 0
        integration.newton.useModifiedNewton = True
        integration.newton.relativeTolerance, integration.newton.absoluteTolerance = NEWTON, 1e-2 * NEWTON
        begun = time.process_time()
        if not system.SolveDynamic(settings, solverType=self.exudyn.DynamicSolverType.TrapezoidalIndex2):
            raise RuntimeError(f"Exudyn's Newton iteration failed with {steps} steps")
        spent = time.process_time() - begun
        middle, tip = (system.GetSensorStoredData(sensor)[:, 1:3] @ [1.0, 1.0j] for sensor in sensors)
        pin = CRANK * np.exp(1j * SPEED * TIMES)
        return spent, ((middle - pin) * np.exp(-1j * np.angle(tip - pin))).imag


def main():
    """Print both codes' lines, then times at equal error."""
    parser = argparse.ArgumentParser(description=__doc__.split(":")[0])
    parser.add_argument("--repeat", type=int, default=5)
    repeat = parser.parse_args().repeat
    with tempfile.TemporaryDirectory() as folder:
        ours, other = Ours(Path(folder)), Exudyn()
        largest = np.abs(ours.exact).max()
        apart = np.abs(ours.exact - other.exact).max() / largest
        print(f"largest deflection {1e3 * largest:.4f} mm; the two converged solutions differ by {apart:.1e} of it\n")
        errors = {("linkages", a): np.abs(ours.deflection(a) - ours.exact).max() / largest for a in ACCURACIES}
        spent = {key: [] for key in [*errors, *(("exudyn", n) for n in STEPS)]}
        for _ in range(repeat):
            for code, size in spent:
                if code == "linkages":
                    spent[code, size].append(ours.spent(size))
                else:
                    seconds, found = other.run(size)
                    spent[code, size].append(seconds)
                    errors[code, size] = np.abs(found - other.exact).max() / largest
    print("code       accuracy or steps   error     CPU time [ms]")
    for (code, size), times in spent.items():
        print(f"{code:11s}{size:17g}{errors[code, size]:8.0e}{1e3 * np.median(times):18.2f}")
    print("\nerror      linkages [ms]  exudyn [ms]  ratio")
    for level in LEVELS:
        found = []
        for code in ("linkages", "exudyn"):
            lines = sorted((errors[key], np.median(times)) for key, times in spent.items() if key[0] == code)
            error, seconds = np.array(lines).T
            within = error[0] <= level <= error[-1]
            found.append(1e3 * np.exp(np.interp(np.log(level), *np.log([error, seconds]))) if within else np.nan)
        print(f"{level:.0e}{found[0]:18.2f}{found[1]:13.1f}{found[1] / found[0]:7.0f}")


if __name__ == "__main__":
    main()
