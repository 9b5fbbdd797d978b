"""Study files, checked: variables, bounds, operating points, objectives, constraints. Builds systems, runs nothing.

| module        | responsibility                                            |
|---------------|-----------------------------------------------------------|
| schema        | the tables of a study file                                |
| distributions | distributions of scattering values                        |
| scatter       | `Scatter`: scattering values that depend on each other    |
| study         | `Study`, `OperatingPoint`                                 |
| load          | study file, yours or shipped -> `Study`, checked          |
"""
