"""The parts of a flexible link, for `linkages.elements.flexible_link`.

| module          | responsibility                                                                 |
|-----------------|--------------------------------------------------------------------------------|
| substructure    | a substructure as a deformable body: modes, sections, stations                 |
| internal_forces | kernels: forces and moments in its sections, stress, deflection; their records |
| segment_chain   | the rigid segments that Drake runs instead, and their outputs                  |
| inertia         | its weight and inertia as forces at nodes                                      |
| numerics        | numbers that tune these                                                        |
| choice          | flexible and rigid as models that the live page offers                         |
| rules           | rules on the validity of the model in a run                                    |
"""
