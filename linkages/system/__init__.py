"""The numeric model: a `System`, built once from a mechanism and an experiment; all later steps read it.

| module                  | responsibility                                                               |
|-------------------------|------------------------------------------------------------------------------|
| system                  | `System`: the assembled start, all arrays; `load`                            |
| identity                | the input of a system, for records of results and for comparison             |
| unassembled             | `Unassembled`: tree, motions, loads, contacts and their records              |
| facts                   | what mechanism and experiment say of a system: its fields                    |
| settings                | `Settings`: duration, accuracy, method, outputs and windows of a run         |
| description             | `Description`: title, names, files                                           |
| joints                  | `SystemJoint`: a joint's places, axis, clearance and model                   |
| parts                   | named elements by table and name                                             |
| tree                    | spanning tree: carrying joints, cut joints, coordinates                      |
| spanning                | construction of the spanning tree                                            |
| flexible_link           | a flexible link in the tree: frames, modes and sections of its substructures |
| deflection              | quasi-static shape of flexible links at t = 0                                |
| linear_systems          | systems of linear models: held in a pose, or with changed inputs             |
| rigid_segments          | the same linkage with chains of rigid segments instead of flexible links     |
| film_steps              | longest steps of films with history                                          |
| beam_records            | substructures of flexible links -> records of the kernels                    |
| drive_travel            | how far drives travel, before a run                                          |
| memory                  | results that variants of a system share                                      |
| law_records             | joint models -> records of the force laws                                    |
| lightness               | links without mass or moment of inertia, which cannot move alone             |
| load_records            | applied loads, barriers, points at lines -> records of the kernels           |
| assembly                | loop closure on the branch of the reference configuration, mobility, t = 0   |
| loose_start             | start of prescribed motions of loosely coupled joints                        |
| feedforward             | torques of the ideal machine along the references of controllers             |
| equilibrium             | reactions of the ideal linkage; offsets of journals in static equilibrium    |
| ideal_motion            | motion of the ideal linkage over time                                        |
| reference_configuration | a pose with closed loops and all joints within their limits                  |
"""

from linkages.system.system import System, load

__all__ = ["System", "load"]
