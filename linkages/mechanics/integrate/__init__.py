"""Integrators and event location for any equations, without mechanics. They may import only the compiler.

A method is a tableau with a stage solver (`explicit` or `implicit`); both use the same step-size controller.

| module       | responsibility                                                                           |
|--------------|------------------------------------------------------------------------------------------|
| tableau      | Butcher tableaus: ``RADAU_IIA_5`` for stiff equations, ``DORMAND_PRINCE_5_4`` for others |
| explicit     | a step of an explicit pair                                                               |
| implicit     | a step of a three-stage collocation method: prediction, error estimate                   |
| newton       | simplified Newton iterations for its stages                                              |
| shifted      | the real and the complex system of linear equations of these iterations                  |
| controller   | ratio of the next step size to the present one                                           |
| events       | the first event within a step, and a step that ends there                                |
| driver       | the loop over steps: first step, error control, events, records                          |
| sensitivity  | derivatives of a step of given size                                                      |
| stepper      | arrays of a method                                                                       |
| factor       | linear algebra of small matrices                                                         |
| peak_search  | the highest value of a curve between its samples, integrals over them                    |
"""
