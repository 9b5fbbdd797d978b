"""One registry of named outputs: name, unit, meaning, owner and kernel; states become numbers here.

| module   | responsibility                                                      |
|----------|---------------------------------------------------------------------|
| registry | which outputs a system has, their units, the records of each        |
| formulas | the value of each output at a state, in compiled code               |
| columns  | outputs over time, from the states of a run or of an ideal motion   |
| segment_outputs | those of links that bend, from a run of rigid pieces              |
"""
