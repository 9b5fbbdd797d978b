"""A run as a Meshcat recording in one HTML file: the linkage, and its clearance joints magnified beside it.

Draws with `pydrake.geometry` and takes the plant from `linkages.engines.drake.plant`; runs no simulation.

| module       | responsibility                                                               |
|--------------|------------------------------------------------------------------------------|
| recording    | `write_animation`: plant, camera, one pose for each frame                    |
| surroundings | hatched ground, rails, a scale, the paths of points                          |
| magnified    | what both magnified views share: a place in the scene, arrows, spots         |
| journal_view | journals in their bearings                                                   |
| guide_view   | blocks in their slots                                                        |
| captions     | labels in the scene; below it clock, legend and a curve over time            |
"""
