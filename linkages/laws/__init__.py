"""Laws of joints with clearance (contact, film, friction, wear, oil): scalar, pure, compiled.

| module         | content                                                                 |
|----------------|-------------------------------------------------------------------------|
| parameters     | declared parameters; the record of numbers that describes one joint     |
| states         | states of contacts, which laws declare                                  |
| film           | films: closed forms, the finite film by Reynolds' equation and as a map |
| contact        | normal contact laws, and their constants from material and geometry     |
| friction       | friction laws                                                           |
| control        | controllers in Python                                                   |
| declared       | the laws by kind and name, with their parameters                        |
| user_laws      | user-defined laws                                                       |
| mixed          | transition between film and contact: blend, asperities                  |
| viscosity      | viscosity of an oil at a temperature                                    |
| heat           | temperature of an oil from a lumped heat balance                        |
| journal        | the force pair on journal and bearing                                   |
| journal_motion | motion of a journal in its bearing                                      |
| wear           | worn profiles, contact on them, Archard's law                           |

Conventions (all laws): the eccentricity vector e points from the bearing's centre to the journal's;
n = e/|e| is radial and outward, t = z x n. Forces act on the **journal**; the bearing gets the opposite
force on the same line of action. Angular velocities are positive counter-clockwise about the normal of
the mechanism's plane. SI units throughout.
"""

from linkages.laws.contact.contact_laws import CONTACTS
from linkages.laws.control import CONTROLLERS
from linkages.laws.film.films import FILMS
from linkages.laws.friction import FRICTIONS
from linkages.laws.parameters import PARAMETERS, Parameter
from linkages.laws.states import State
from linkages.laws.user_laws import (
    Registered,
    register_contact,
    register_controller,
    register_film,
    register_friction,
    registered,
    restore,
)

__all__ = [
    "CONTACTS",
    "CONTROLLERS",
    "FILMS",
    "FRICTIONS",
    "PARAMETERS",
    "Parameter",
    "Registered",
    "State",
    "register_contact",
    "register_controller",
    "register_film",
    "register_friction",
    "registered",
    "restore",
]
