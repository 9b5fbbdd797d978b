"""The numeric model: a `System`, built once from a mechanism and an experiment; all later steps read it.

| module                  | responsibility                                                               |
|-------------------------|------------------------------------------------------------------------------|
| system                  | `System`: its parts in the order in which each follows from the others       |
| loading                 | `load`                                                                       |
| replacing               | numbers of the input by path: other values, units                            |
| identity                | the input of a system, for records of results and for comparison             |
| ideal_linkage           | `IdealLinkage`: tree, motions and loads; its reactions                       |
| masses                  | masses of the bodies, with rotors and negligible ones                        |
| rates                   | rates of the motion before a run                                             |
| contacts                | `Contacts`: their ends and laws                                              |
| model_arrays            | all arrays that kernels read                                                 |
| facts                   | what mechanism and experiment say of a system: its fields                    |
| owners                  | which value fills which numbers: a register by path                          |
| settings                | `Settings`: duration, accuracy, method, outputs and windows of a run         |
| description             | `Description`: title, names, files                                           |
| joints                  | `SystemJoint`: a joint's places, axis, clearance and model                   |
| parts                   | named elements by table and name                                             |
| tree                    | spanning tree: carrying joints, cut joints, coordinates                      |
| spanning                | construction of the spanning tree                                            |
| deformable              | what the tree knows of deformable bodies                                     |
| flexible_link           | a flexible link: its substructures as deformable bodies, their records       |
| deflection              | quasi-static shape of flexible links at t = 0                                |
| linear_systems          | systems of linear models: held in a pose, or with changed inputs             |
| rigid_segments          | the same linkage with chains of rigid segments instead of flexible links     |
| film_steps              | longest steps of films with history                                          |
| drive_travel            | how far drives travel, before a run                                          |
| memory                  | results that variants of a system share                                      |
| law_records             | joint models -> records of the force laws                                    |
| lightness               | links without mass or moment of inertia, which cannot move alone             |
| load_records            | applied loads, barriers, points at lines -> records of the kernels           |
| assembly                | loop closure on the branch of the reference configuration, mobility, t = 0   |
| loose_start             | start of prescribed motions of loosely coupled joints                        |
| feedforward             | torques of the ideal machine along the references of controllers             |
| equilibrium             | offsets of journals and blocks in static equilibrium                         |
| ideal_motion            | motion of the ideal linkage over time                                        |
| reference_configuration | a pose with closed loops and all joints within their limits                  |
"""

from linkages.system.loading import load
from linkages.system.system import System

__all__ = ["System", "load"]
