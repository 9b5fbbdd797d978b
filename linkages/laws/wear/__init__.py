"""Wear of a journal and its bearing: worn profiles, contact on them, Archard's law; imports only `laws` of the package.

| module  | content                                                                             |
|---------|-------------------------------------------------------------------------------------|
| profile | depth over the angle of a part, a periodic cubic B-spline; depth and removed volume |
| overlap | overlap of a journal with a worn bearing, over the arc of contact                   |
| force   | the force pair of a worn joint                                                      |
| archard | wear at held loads: each load spread over the arc where journal and bearing overlap |

**Profiles.** Depth is measured along the radius of the part it is worn from, over the angle in the part's frame,
counted from x_P in the reference configuration; a profile rotates with its part.

**Contact.** A worn pocket carries its load over an arc, at more than one place if need be. With delta(theta) the
overlap of the two profiles along the bearing's radius, the elastic state is measured by
U = 1/2 integral of delta_+^2 dtheta, as in an elastic foundation. The joint's own contact law keeps its meaning: the
worn joint has the elastic energy that the round joint of the same clearance has at the same U. Its force is therefore

    F = law(d) * grad U / U_0'(d),        U_0(d) = U,

where U_0 belongs to the round joint at the penetration d and grad is the gradient by the eccentricity. The force is
conservative where the law is, a round profile gives the law itself, and for Hertz's law the stiffness follows the local
difference of the curvatures (F ~ delta^1.5/sqrt(curvature)), as in Hertz's theory.

**Archard.** dV = k N |v_t| dt, N the magnitude of the contact's normal load. It is taken from the arc in proportion to
delta_+, so that the removed volume is k N |v_t| dt whatever the profile.

Sources: Archard, J. Appl. Phys. 24, 1953; Johnson, Contact Mechanics, 1985, section 4.3 (elastic foundation).
"""
