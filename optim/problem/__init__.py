"""Study files, checked: variables, bounds, operating points, objectives, constraints. Builds systems, runs nothing.

| module  | responsibility                                            |
|---------|-----------------------------------------------------------|
| schema  | the tables of a study file                                |
| shipped | where the shipped studies are                             |
| study   | `Study`, `OperatingPoint`                                 |
| load    | study file -> `Study`, checked against its experiment     |
"""
