"""The claims of Lu et al. (2010) on the flexible 3-RRR robot beside our numbers."""

from __future__ import annotations

from replication import robot_elastic, robot_motion, robot_stress

#: Sections that `python docs/replicate.py robot.NAME` repeats.
SECTIONS = {
    "kinematics": robot_motion.kinematics,
    "modes": robot_elastic.modes,
    "displacement": robot_elastic.displacement,
    "drift": robot_elastic.drift,
    "recursion": robot_elastic.recursion_,
    "stress": robot_stress.stress,
    "formulas": robot_stress.formulas,
}
