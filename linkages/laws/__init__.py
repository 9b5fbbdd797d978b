"""Force laws of a clearance joint: scalar, pure, compiled; one file per kind of law.

| module     | what it holds                                                          |
|------------|------------------------------------------------------------------------|
| parameters | the record of numbers that describes one joint to every law            |
| film       | closed-form films: exact half film, Pinkus-Sternlicht, short bearing   |
| films      | all films by name, and their dispatcher                                |
| reynolds   | the 2D Reynolds equation of a finite film, with two rules of cavitation |
| film_map   | the finite film as a map, evaluated by a spline                        |
| map_cache  | film maps on disk                                                      |
| contact    | normal contact laws                                                    |
| friction   | friction laws                                                          |
| mixed      | between film and contact: blend, asperities                            |
| material   | from material and geometry to the constants of the contact laws        |
| viscosity  | viscosity of an oil at a temperature                                   |
| journal    | journal kinematics and the force pair on journal and bearing           |
| table      | all of them as tables for the documentation                            |

Conventions (all laws): the eccentricity vector e points from the bearing's centre to the journal's;
n = e/|e| is radial and outward, t = z x n. Forces act on the **journal**; the bearing gets the opposite
force on the same line of action. Angular velocities are positive counter-clockwise about the normal of
the mechanism's plane. SI units throughout.
"""

from linkages.laws.contact import CONTACTS
from linkages.laws.films import FILMS
from linkages.laws.friction import FRICTIONS
from linkages.laws.parameters import PARAMETERS

__all__ = ["CONTACTS", "FILMS", "FRICTIONS", "PARAMETERS"]
