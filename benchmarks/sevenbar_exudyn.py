"""The seven-bar in Exudyn: ``python benchmarks/sevenbar_exudyn.py [--steps N]`` prints wall time and orbit error.

Exudyn (J. Gerstmayr, Multibody System Dynamics 60, 2024, pp. 533-561; ``pip install exudyn``): rigid bodies in the
plane with absolute coordinates, ideal revolute joints, cranks and guide held by constraints on speeds, the film as user
function of a connector that calls this package's compiled law; implicit trapezoidal rule, constraints at index 2. A
centred journal starts with time constants of microseconds: the first millisecond has steps that grow tenfold five
times.
"""

from __future__ import annotations

import argparse
import time
from itertools import pairwise
from pathlib import Path

import numpy as np
from numba import njit
from seven_bar_reference import orbit_error, reference

from linkages import load
from linkages.laws.journal import clearance_force
from linkages.mechanics.planar.kinematics import body_states

GRADED = 1e-3  # s
DECADES, PER_DECADE = 5, 20  # its parts, steps in each
NEWTON = 1e-6  # relative tolerance; the error that it leaves is below 2e-6 of the orbit


def film(law, table, omega_bearing):
    """Force on the bearing as a compiled function of e, its rate, and the journal's relative angular velocity."""

    @njit
    def force(ex, ey, vx, vy, omega):
        both = omega_bearing + omega
        fx, fy = clearance_force(law, table, ex, ey, vx, vy, omega_bearing, both, (0.0, 0.0, 0.0, 0.0))[:2]
        return -fx, -fy

    return force


class Model:
    """The mechanism in Exudyn, at its start.

    Every bearing with play has to be on a driven body: the connector applies the force to the bearing at the bearing's
    centre, which is e away from its line of action, and only a driven body does not feel that.
    """

    def __init__(self, system) -> None:
        import exudyn
        from exudyn import itemInterface as items  # noqa: N813

        self.exudyn, self.items = exudyn, items
        self.container = exudyn.SystemContainer()
        self.solver = self.container.AddSystem()
        self.tree, self.assembly, self.gravity = system.tree, system.assembly, system.gravity[:2]
        mechanism, drives = system.mechanism, system.experiment.drives
        self._add_bodies()
        laws, tables = system.laws, system.tables
        self.sensors = []
        for joint in mechanism.joints:
            ends = [self._point(joint.parent, joint.on_parent), self._point(joint.child, joint.on_child)]
            if joint.name in self.tree.play:
                k = self.tree.play.index(joint.name)
                (drive,) = (name for name in self.tree.driven if mechanism.joint[name].child == joint.parent)
                self._add_film(ends, film(laws[k], tables[k], drives[drive].speed))
            elif joint.type == "revolute":
                self.solver.AddObject(items.ObjectJointRevolute2D(markerNumbers=ends))
            else:  # along x
                self._hold(joint.child, 1, 0.0)
                self._hold(joint.child, 2, 0.0)
        for name in self.tree.driven:
            self._hold(mechanism.joint[name].child, 2, drives[name].speed)
        self.bearings = [self.tree.index[mechanism.joint[name].parent] for name in self.tree.play]
        self.speeds = np.array([self.velocity[body, 0] for body in self.bearings])
        self.angles = np.array([self.pose[body, 2] for body in self.bearings])
        self.solver.Assemble()

    def _add_bodies(self) -> None:
        tree, items = self.tree, self.items
        self.pose, self.velocity = np.empty((len(tree.bodies.records), 5)), np.empty((len(tree.bodies.records), 3))
        body_states(tree.bodies, self.assembly.q, self.assembly.v, self.pose, self.velocity)
        self.nodes, self.objects = {}, {"world": self.solver.AddObject(items.ObjectGround())}
        ground = self.solver.AddNode(items.NodePointGround())
        self.still = self.solver.AddMarker(items.MarkerNodeCoordinate(nodeNumber=ground, coordinate=0))
        for link in tree.mechanism.links:
            i = tree.index[link.name]
            body, (x, y, angle, c, s), (omega, vx, vy) = tree.bodies.records[i], self.pose[i], self.velocity[i]
            rx, ry = c * body.cx - s * body.cy, s * body.cx + c * body.cy
            place, rates = [x + rx, y + ry, angle], [vx - omega * ry, vy + omega * rx, omega]
            node = items.NodeRigidBody2D(referenceCoordinates=place, initialVelocities=rates)
            self.nodes[link.name] = number = self.solver.AddNode(node)
            rigid = items.ObjectRigidBody2D(mass=body.mass, inertia=body.inertia, nodeNumber=number)
            self.objects[link.name] = self.solver.AddObject(rigid)
            if np.any(self.gravity):
                marker = self.solver.AddMarker(items.MarkerBodyMass(bodyNumber=self.objects[link.name]))
                self.solver.AddLoad(items.LoadMassProportional(markerNumber=marker, loadVector=[*self.gravity, 0.0]))

    def _point(self, link, drawn):
        index, x, y = self.tree.marker(link, drawn)
        place = [x - self.tree.bodies.records[index].cx, y - self.tree.bodies.records[index].cy, 0.0]
        marker = self.items.MarkerBodyRigid(bodyNumber=self.objects[link], localPosition=place)
        return self.solver.AddMarker(marker)

    def _hold(self, link, coordinate, rate) -> None:
        """Keep the rate of a coordinate of a link: 0, 1 position, 2 angle."""
        marker = self.items.MarkerNodeCoordinate(nodeNumber=self.nodes[link], coordinate=coordinate)
        ends = [self.still, self.solver.AddMarker(marker)]
        connector = self.items.ObjectConnectorCoordinate(markerNumbers=ends, offset=rate, velocityLevel=True)
        self.solver.AddObject(connector)

    def _add_film(self, ends, force) -> None:
        force(1e-6, 0.0, 0.0, 0.0, 0.0)  # compiles

        def connector(system, t, item, displacement, rotation, velocity, omega, *_):
            fx, fy = force(displacement[0], displacement[1], velocity[0], velocity[1], omega[2])
            return [fx, fy, 0.0, 0.0, 0.0, 0.0]

        zero = np.zeros((6, 6))
        item = self.solver.AddObject(
            self.items.ObjectConnectorRigidBodySpringDamper(
                markerNumbers=ends, stiffness=zero, damping=zero, springForceTorqueUserFunction=connector
            )
        )
        seen = self.exudyn.OutputVariableType.DisplacementLocal
        sensor = self.items.SensorObject(objectNumber=item, outputVariableType=seen, storeInternal=True)
        self.sensors.append(self.solver.AddSensor(sensor))

    def run(self, duration, steps):
        """Integrate with this many steps after the graded ones; wall seconds, times, eccentricities (nt, nj, 2)."""
        settings = self.exudyn.SimulationSettings()
        settings.solution.file.write = False
        integration = settings.timeIntegration
        integration.verboseMode = 0
        integration.newton.useModifiedNewton = True
        integration.newton.relativeTolerance, integration.newton.absoluteTolerance = NEWTON, 1e-2 * NEWTON
        rule = self.exudyn.DynamicSolverType.TrapezoidalIndex2
        graded = np.concatenate([[0.0], GRADED * 10.0 ** np.arange(1 - DECADES, 1)])
        parts = [(a, b, PER_DECADE) for a, b in pairwise(graded)]
        wall, seen = 0.0, []
        for a, b, count in [*parts, (GRADED, duration, steps)]:
            integration.startTime, integration.endTime, integration.numberOfSteps = a, b, count
            settings.solution.sensors.writePeriod = max((b - a) / count, 2e-3)
            begun = time.perf_counter()
            done = self.solver.SolveDynamic(settings, solverType=rule, updateInitialValues=True)
            wall += time.perf_counter() - begun
            if not done:
                raise RuntimeError(f"Exudyn's Newton iteration failed between {a:g} and {b:g} s")
            stored = np.array([self.solver.GetSensorStoredData(sensor) for sensor in self.sensors])
            seen.append(stored[:, stored[0, :, 0] > a])
        table = np.concatenate(seen, axis=1)
        times = table[0, :, 0]
        local = (table[..., 1] + 1j * table[..., 2]).T  # in the bearings' frames
        orbit = local * np.exp(1j * (self.angles + self.speeds * times[:, None]))
        return wall, times, np.stack([orbit.real, orbit.imag], axis=-1)


def main() -> None:
    """Print one line for each number of steps."""
    parser = argparse.ArgumentParser(description=__doc__.split(":")[0])
    parser.add_argument("--steps", type=int, nargs="+", default=[1000, 2000, 4000, 8000])
    options = parser.parse_args()
    system = load(Path(__file__).with_name("seven_bar_fast.toml"), {"duration": 1.0})
    exact = reference(system)
    print("  steps   wall [s/s]   orbit error")
    for steps in options.steps:
        wall, times, orbit = Model(system).run(system.experiment.duration, steps)
        print(f"{steps:7d}{wall:13.3f}{orbit_error(orbit, exact(times)):14.1e}")


if __name__ == "__main__":
    main()
