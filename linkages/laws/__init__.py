"""Force laws of a clearance joint: scalar, pure, compiled; one file per kind of law.

| module     | what it holds                                                          |
|------------|------------------------------------------------------------------------|
| parameters | the record of numbers that describes one joint to every law            |
| film       | hydrodynamic films: exact half film, Pinkus-Sternlicht, short bearing  |
| journal    | journal kinematics and the force pair on journal and bearing           |

Conventions (all laws): the eccentricity vector e points from the bearing's centre to the journal's;
n = e/|e| is radial and outward, t = z x n. Forces act on the **journal**; the bearing gets the opposite
force on the same line of action. Angular velocities are positive counter-clockwise about the normal of
the mechanism's plane. SI units throughout.
"""

from linkages.laws.film import FILMS
from linkages.laws.parameters import PARAMETERS

__all__ = ["FILMS", "PARAMETERS"]
