"""The Drake engine: the mechanism as a continuous `MultibodyPlant`, its clearance joints as a `LeafSystem`.

| module       | responsibility                                                                   |
|--------------|----------------------------------------------------------------------------------|
| plant        | the spanning tree as SDFormat that Drake accepts, with visuals, and as a plant   |
| clearance    | `ClearanceJoints(LeafSystem)`: forces in clearance joints from the plant's state |
| drives       | `Drives(LeafSystem)`: prescribed motions, torques, reactions of closing joints   |
| joint_forces | calls of the compiled kernels by both systems                                    |
| diagram      | `add_linkage`, `build_diagram`: the connected systems; a picture of a diagram    |
| steps        | control of Drake's simulator that avoids defects of its steps                    |
| simulation   | a run of the diagram as a `Trajectory`                                           |

Monogram notation for frames as in Drake: X_WB is the pose of B in W.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import lazy_loader

# ruff: noqa: F401 - for type checkers; precompilation needs no Drake
if TYPE_CHECKING:
    from linkages.engines.drake.clearance import JOINT_OUTPUTS
    from linkages.engines.drake.diagram import Linkage, add_linkage, build_diagram, picture
    from linkages.engines.drake.simulation import simulate

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submod_attrs={
        "clearance": ("JOINT_OUTPUTS",),
        "diagram": ("Linkage", "add_linkage", "build_diagram", "picture"),
        "simulation": ("simulate",),
    },
)
