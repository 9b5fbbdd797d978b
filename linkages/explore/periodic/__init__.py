"""Periodic motions, their stability, and their branches over one value.

| module       | responsibility                                                                  |
|--------------|---------------------------------------------------------------------------------|
| multipliers  | Floquet multipliers: stability, kinds of bifurcations                           |
| continuation | Newton's method and pseudo-arclength continuation of any equations, as shooting |
| tracing      | a branch with its bifurcations; the start of a doubled branch                   |
| return_map   | the return map of a linkage, with exact derivatives                             |
| motion       | a periodic motion of a linkage                                                  |
| settings     | defaults                                                                        |
| branches     | all branches of a linkage from one motion                                       |
"""
