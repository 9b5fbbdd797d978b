"""A run as an animation in one HTML file: the linkage, and next to it its clearance joints, magnified.

A Meshcat recording: `pydrake.geometry` draws it, with the plant of `linkages.engines.drake.plant`; no simulation runs.
Without Drake the drawing of `linkages.show.plots.drawing` moves instead.

| module       | responsibility                                                            |
|--------------|---------------------------------------------------------------------------|
| animated     | `write_animation`: the recording, or the moved drawing                    |
| recording    | `write_recording`: plant, camera, one pose for each frame, captions       |
| bounds       | corners of all shapes over the motion                                     |
| surroundings | hatched ground, rails, a scale, the paths of points                       |
| magnified    | common part of the magnified views: positions in the scene, arrows, spots |
| joint_views  | journals in their bearings, blocks in their slots                         |
"""
