"""Nonlinear dynamics of driven linkages, and comparison of the two engines. It may import all lower folders.

| module   | responsibility                                                                            |
|----------|-------------------------------------------------------------------------------------------|
| range_of_motion | how far drives can be moved: dead points                                                  |
| transmission | transmission angles of linkages with any number of loops                              |
| flow     | a run of the compiled engine that stops where it is told and goes on from there           |
| sections | Poincaré sections: once per revolution, or where an output crosses a level; the horizon   |
| sweep    | sections over the values of one variable: bifurcation diagrams                            |
| lyapunov | largest Lyapunov exponent: two trajectories, renormalised                                 |
| modes    | natural frequencies and mode shapes of a linkage that stands still                        |
| mode_shapes | how points move in them                                                                |
| bearing  | a journal bearing under a static load: equilibrium, coefficients, stability               |
| spectra  | power spectral densities                                                                  |
| wear     | wear of joints over a machine's life: blocks of cycles, and jumps between them            |
| compare  | both engines on one system: how far apart, and up to when that means anything             |

A *revolution* is the period of the named drive; default: the first drive with constant speed, otherwise the first
periodic one. Sections are taken at multiples of it, counted from t = 0, so that the drive is at its start angle in all
of them. Exponents are natural: 1/s.
"""
