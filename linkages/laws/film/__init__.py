"""Films of a journal bearing as dimensionless forces; imports nothing of ours but `linkages.base.kernel`.

| module         | content                                                                 |
|----------------|-------------------------------------------------------------------------|
| closed_form    | exact half film, Pinkus-Sternlicht, short bearing                       |
| surface        | the film on the developed surface: mesh, volume balance, cavity         |
| map_table      | the table of a film map, evaluated by splines                           |
| map_nodes      | the films at the nodes of a map                                         |
| film_map       | which films are given by maps, how a map is built, maps on disk         |
| tilted_film    | the finite film under a tilted journal, solved at each evaluation       |
| film_history   | the film whose content is a state: its force                            |
| film_steps     | its steps: the content moves on, the film step follows from its error   |
| films          | the films by name, and the evaluation of any of them                    |

A film is a function ``film(eps, deps, ew, slenderness) -> (f_n, f_t, extent)``:

eps
    Eccentricity ratio |e|/c, in [0, 1).
deps
    Its rate of change v.n/c [1/s].
ew
    Wedge rate eps*(omega_j + omega_b) - 2*v.t/c [1/s]. It is eps*(omega_j + omega_b - 2*dgamma/dt), written so that
    it stays regular at eps = 0. Both angular velocities are inertial: only with their *sum* is the force the same for
    every rotating observer. (Chen 2025 eqs. (9)-(11) print the relative speed, which holds only if the attitude rate
    dgamma/dt is measured in the bearing's own frame.)
slenderness
    L/D, used by films of finite or small length.
f_n, f_t
    Normal and tangential force on the journal in units of mu*L*R^3/c^2.
extent
    Integral of dtheta/(1 + eps*cos(theta)) over the half film that carries pressure, for its shear torque.

All films are isoviscous, homogeneous of degree one in (deps, ew), and passive: f_n*deps - f_t*ew/2 <= 0.
"""
