"""Analyses of one linkage: nonlinear dynamics, linear models, derivatives, bearings, wear, comparison of the engines.

It may import all lower folders.

| module            | responsibility                                                                          |
|-------------------|-----------------------------------------------------------------------------------------|
| range_of_motion   | range of motion of drives: dead points                                                  |
| transmission      | transmission angles of linkages with any number of loops                                |
| flow              | a run of the compiled engine that can be paused, continued and moved                    |
| sections          | Poincaré sections: once per revolution, or where an output crosses a level; the horizon |
| sweep             | sections over the values of one variable: bifurcation diagrams                          |
| grid              | sections over a grid of the values of two variables                                     |
| lyapunov          | largest Lyapunov exponent: two trajectories, renormalised                               |
| modes             | natural frequencies and mode shapes of a linkage at rest; shapes at points and lines |
| linearisation     | linear state-space models, frequency responses                                          |
| operating_point   | a state or an equilibrium, and the equations there                                      |
| local_coordinates | minimal coordinates near a state of closed loops                                        |
| sensitivity       | derivatives of peaks, means and works with respect to values                            |
| prediction        | how far derivatives predict, by runs at changed values                                  |
| bearing           | a journal bearing under a static load: equilibrium, coefficients, stability             |
| bearing_heat      | temperature of its oil by a lumped heat balance                                         |
| periodic          | periodic motions: shooting, Floquet multipliers, branches by continuation               |
| spectra           | power spectral densities                                                                |
| wear              | wear of joints over the service life: blocks of cycles, and jumps                       |
| compare           | both engines on one system: differences up to the horizon                               |
| numerics          | numbers that tune these analyses, with unit and effect                                   |

A *revolution* is the period of the named drive; default: the first drive with constant speed, otherwise the first
periodic one. Sections are taken at multiples of it, counted from t = 0, so that the drive is at its start angle in all
of them. Exponents are natural: 1/s.
"""
