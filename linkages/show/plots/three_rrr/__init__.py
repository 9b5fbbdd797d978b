"""Figures and the animation of the 3-RRR robot, drawn from its results; matplotlib is imported only for drawing.

| module         | figures                                                                        |
|----------------|--------------------------------------------------------------------------------|
| figures        | the paper's figures 5 to 12; maps over the drive angles; convergence; speed     |
| robot_lines    | the robot as lines; a mode over the moving pose, as one HTML file              |
"""

from linkages.show.plots.three_rrr.robot_lines import draw_pose, shape_lines

__all__ = ["draw_pose", "shape_lines"]
