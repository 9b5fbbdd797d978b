"""Films on the developed surface of a bearing: cavitation with mass conservation, grooves, holes, a tilted journal.

| module          | content                                                                        |
|-----------------|--------------------------------------------------------------------------------|
| grooves         | grooves and holes: regions at a supply pressure                                |
| surface_mesh    | cells of the surface, faces on the edges of grooves                            |
| balance         | volume balance of a cell: conductances, transport of the film content          |
| cavity          | pressure and film content by block principal pivoting                          |
| surface_film    | a solved film: force, moment, flows, shear, mass balance                       |
| transient       | films with history, along an orbit or with the motion of a loaded journal       |
| equilibrium     | a loaded journal: equilibrium, dynamic coefficients, stability                 |

The frame is the bearing's, theta positive in the sense of rotation; h = 1 - x cos(theta) - y sin(theta) in units of
the clearance, (x, y) the eccentricity from the bearing's centre to the journal's. Forces act on the journal.
"""

from linkages.laws.film.surface.grooves import Groove
from linkages.laws.film.surface.surface_film import FilmSurface
from linkages.laws.film.surface.surface_mesh import surface_mesh
from linkages.laws.film.surface.transient import Journal, at_rest, follow, move

__all__ = ["FilmSurface", "Groove", "Journal", "at_rest", "follow", "move", "surface_mesh"]
