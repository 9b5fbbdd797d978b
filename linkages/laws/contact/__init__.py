"""Normal contact of a journal in a bearing; imports only `linkages.base.kernel` and the record of a joint.

| module         | content                                                                 |
|----------------|-------------------------------------------------------------------------|
| contact_forces | the forces: power law, Kelvin-Voigt, conformal cylinders                |
| contact_laws   | the contact laws by name, each a force and a hysteresis factor          |
| material       | stiffness and damping from material and geometry; effective restitution |

A contact law is a function ``force(delta, ddelta, ddelta0, joint) -> F``:

delta, ddelta
    Penetration |e| - c > 0 [m] and its rate v.n [m/s], positive while journal and bearing approach.
ddelta0
    Speed of approach at the start of *this* contact [m/s], latched by the caller, at least `contact_forces.GRAZING`.
joint
    Record of `linkages.laws.PARAMETERS` with the parameters of the law.
F
    Normal force [N]; a negative one is set to zero by the caller (a contact does not pull).

A law with states (`linkages.laws.states`) is ``force(delta, ddelta, ddelta0, ..., joint) -> F, ...``: it takes their
values, and returns their rates. Without contact it is called with delta = ddelta = 0, for the rates alone.

All but Kelvin-Voigt and Maxwell have the form F = F_e(delta)*(1 + chi*ddelta/ddelta0), with a hysteresis factor chi(e)
that depends on the nominal coefficient of restitution e alone. Their *effective* restitution e' depends on chi alone,
whatever stiffness, exponent, mass and speed (divide m*v*dv = -F*d(delta) by 1 + chi*v/ddelta0 and integrate over the
impact):

    chi - ln(1 + chi) = -chi*e' - ln(1 - chi*e')        (`material.effective_restitution`)

**Why the ratio is clipped.** chi is derived for a free impact, where |ddelta| <= ddelta0. A journal that swings inside
a contact which never separates can move many times faster than the latched speed, and the damping explodes. Clipped to
`contact_forces.CLIP`, the force stays below F_e*(1 + chi). Latched speeds below `contact_forces.GRAZING` are taken as
`GRAZING`, which keeps the force continuous in a contact that starts without any speed.
"""
