"""Elastic bodies in the plane, without mechanisms; imports only `errors` and `kernel` of the package.

| module          | responsibility                                                                                |
|-----------------|-----------------------------------------------------------------------------------------------|
| beam            | beam element (Euler-Bernoulli, Timoshenko): matrices, velocity terms, internal forces; chains |
| triangle        | constant-strain triangle in plane stress                                                      |
| rotation        | element matrices in plane axes, as functions of the element's angle                           |
| component_modes | Craig-Bampton modes of a beam and its constants in a floating frame                           |
| modes           | natural frequencies and shapes, dense or sparse; modes followed by MAC                        |
| response        | quasi-static displacements, the exact step of a mode, generalised-alpha                       |

Conventions: SI units. Elastic displacements are small and relative to the rigid motion. Arrays over poses or times have
these as their first axis.
"""
