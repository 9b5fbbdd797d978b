"""Figures and animations of results; only this folder of `linkages` imports matplotlib; it runs no engine.

| module             | figures                                                                              |
|--------------------|--------------------------------------------------------------------------------------|
| style              | none: palette, line styles, labels and settings of all figures                       |
| presentation       | none: format, size and style of the files of figures                                 |
| quantities         | none: numbers with units, changes, shares, as people read them                       |
| names              | none: values and outputs in words                                                    |
| panels             | none: panels in the two widths of a page, the answer above, the legend below         |
| headlines          | none: the answer above a figure, and from when curves are drawn                      |
| histories          | outputs, forces and torques, ideal and real; deflection and stress of flexible links |
| journals           | orbits of journals in their clearances, blocks in their slots, contacts over time    |
| pages              | none: HTML pages from templates; curves as data, and the script that draws them      |
| lines              | none: pages of lines that change: wearing bearings, modes of the robot               |
| shown              | none: base class of figures for notebooks                                            |
| linear_figures     | natural frequencies and mode shapes; Bode plots                                      |
| changes            | none: changes of peaks with 1 % of values as data, and sentences about them          |
| instants           | none: the instants that frames of magnified joints show                              |
| matrix             | changes of peaks with 1 % of values as a matrix                                      |
| attractors         | Poincaré sections, bifurcation diagrams, branches, Lyapunov exponents, spectra       |
| overlaid           | several runs, also of different machines, in one figure                              |
| swept              | peaks over one variable in small panels, over two as maps with contours              |
| bearings           | chart and pressure of a film                                                         |
| worn               | worn profiles; clearance, forces, jitter over cycles                                 |
| drawing            | a mechanism before a run: a labelled, movable picture                                |
| animation          | a run as an animation, its clearance joints magnified                                |
| three_rrr          | the flexible 3-RRR robot                                                             |
"""

from __future__ import annotations

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
