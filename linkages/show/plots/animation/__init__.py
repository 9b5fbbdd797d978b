"""A run as a Meshcat recording in one HTML file: the linkage, and next to it its clearance joints, magnified.

Draws with `pydrake.geometry` and takes the plant from `linkages.engines.drake.plant`; runs no simulation.

| module       | responsibility                                                            |
|--------------|---------------------------------------------------------------------------|
| recording    | `write_animation`: plant, camera, one pose for each frame, captions       |
| bounds       | corners of all shapes over the motion                                     |
| surroundings | hatched ground, rails, a scale, the paths of points                       |
| magnified    | common part of the magnified views: positions in the scene, arrows, spots |
| joint_views  | journals in their bearings, blocks in their slots                         |
"""
