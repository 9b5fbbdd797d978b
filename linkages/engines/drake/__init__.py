"""The Drake engine: the mechanism as a continuous `MultibodyPlant`, its joints with play as a `LeafSystem`.

| module     | responsibility                                                                    |
|------------|-----------------------------------------------------------------------------------|
| plant      | the mechanism's spanning tree as SDFormat that Drake accepts, and as a plant      |
| clearance  | `ClearanceJoints(LeafSystem)`: forces in joints with play from the plant's state  |
| drives     | `Drives(LeafSystem)`: prescribed motions, torques, reactions of closing joints    |
| joint_forces | what both ask of the compiled kernels                                             |
| diagram    | `add_linkage`, `build_diagram`: the systems connected                             |
| steps      | Drake's simulator, led past habits that spoil a run's steps                       |
| advance    | a simulator of the user's own diagram, advanced to a time                         |
| simulation | a run of the diagram as a `Trajectory`                                            |
| visuals    | shapes for links whose SDF file gives none                                        |
| wiring     | a diagram drawn, or its connections as a table                                    |

Monogram notation for frames as in Drake: X_WB is the pose of B in W.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import lazy_loader

# ruff: noqa: F401 - for type checkers; what compiles ahead needs no Drake
if TYPE_CHECKING:
    from linkages.engines.drake.clearance import JOINT_OUTPUTS
    from linkages.engines.drake.diagram import Linkage, add_linkage, build_diagram
    from linkages.engines.drake.simulation import simulate
    from linkages.engines.drake.wiring import picture

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submod_attrs={
        "clearance": ("JOINT_OUTPUTS",),
        "diagram": ("Linkage", "add_linkage", "build_diagram"),
        "wiring": ("picture",),
        "simulation": ("simulate",),
    },
)
