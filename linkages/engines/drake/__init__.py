"""The Drake engine: the mechanism as a continuous `MultibodyPlant`, its joints with play as a `LeafSystem`.

| module    | what it holds                                                                    |
|-----------|----------------------------------------------------------------------------------|
| plant     | the mechanism's spanning tree as SDFormat that Drake accepts, and as a plant      |
| clearance | `ClearanceJoints(LeafSystem)`: film forces from the plant's state                 |
| drives    | `Drives(LeafSystem)`: prescribed motions, torques, reactions of closing joints    |
| diagram   | `add_linkage`, `build_diagram`: the systems connected                             |
| simulation | a run of the diagram as a `Trajectory`                                            |
| animate   | Meshcat recording of a run                                                        |
| magnified | what the magnified views in that recording share: frames, arrows, spots           |
| joint_view, guide_view | journals in bearings, blocks in slots, magnified                     |
| captions  | text over that recording: labels, clock, legend                                   |
| visuals   | what links look like whose SDF file does not say                                  |
| picture   | a diagram drawn, or its connections as a table                                    |

Monogram notation for frames as in Drake: X_WB is the pose of B in W.
"""

from linkages.engines.drake.diagram import Linkage, add_linkage, build_diagram
from linkages.engines.drake.picture import picture
from linkages.engines.drake.simulation import simulate

__all__ = ["Linkage", "add_linkage", "build_diagram", "picture", "simulate"]
