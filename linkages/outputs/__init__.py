"""One registry of named outputs: name, unit, meaning, owner and kernel; computes numbers from states.

| module          | responsibility                                                 |
|-----------------|----------------------------------------------------------------|
| registry        | outputs of a system, their units, the record of each           |
| formulas        | formulas of all outputs at a state, in compiled code           |
| columns         | outputs over time, from the states of a run or an ideal motion |
| segment_outputs | outputs of flexible links from a run with rigid segments       |
"""
