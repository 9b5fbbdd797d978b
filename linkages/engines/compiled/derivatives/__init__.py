"""Derivatives of a finished run with respect to values.

| module             | responsibility                                                                    |
|--------------------|-----------------------------------------------------------------------------------|
| variation          | the equations of a model of duals, differentiated along columns and values        |
| step_derivatives   | a step of a run, differentiated                                                   |
| event_derivatives  | start and end of a contact, differentiated                                        |
| run_derivatives    | a run, differentiated at its steps and at any times                               |
| neighbours         | derivatives of a system's numbers: the register, systems at neighbouring values   |
| start_derivatives  | derivatives of the state at t = 0                                                 |
| output_derivatives | derivatives of outputs                                                            |
| sensitivity        | `differentiate`: derivatives of a finished run                                    |
"""
