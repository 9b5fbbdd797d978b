"""Integrators and the location of events, for any equations: they know no mechanics. They may import only the compiler.

| module         | responsibility                                                                     |
|----------------|------------------------------------------------------------------------------------|
| driver         | steps, error control, events, records, for any method and any equations            |
| stepper        | what a method keeps between two attempts at a step                                 |
| radau          | Radau IIA of order 5, for stiff equations                                          |
| dormand_prince | Dormand and Prince's explicit pair 5(4)                                            |
| factor         | LU factorisation of small matrices                                                 |
| shifted        | inverses at a real and at a complex shift                                          |
| parabola       | the top of a parabola, for every search of an extreme                              |
"""
