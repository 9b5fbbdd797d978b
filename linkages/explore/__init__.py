"""Nonlinear dynamics of driven linkages, on the compiled engine.

| module    | what it holds                                                                             |
|-----------|-------------------------------------------------------------------------------------------|
| flow      | a run that stops where it is told, goes on, and can be put elsewhere                      |
| sections  | Poincare sections: once per revolution, or where a signal crosses a level; the horizon    |
| sweep     | sections over the values of one variable: bifurcation diagrams                            |
| lyapunov  | largest Lyapunov exponent: two trajectories, renormalised                                 |
| spectra   | power spectral densities                                                                  |

A *revolution* is the period of the drive that is named, or of the first one of constant speed. Sections are taken at
its multiples, counted from t = 0, so that the drive is at its start angle in all of them. Exponents are natural: 1/s.
"""
