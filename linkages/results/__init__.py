"""Results of runs: named outputs (`outputs`), trajectories, numbers over continuous time. It imports no engine.

| module            | responsibility                                                            |
|-------------------|---------------------------------------------------------------------------|
| outputs           | one registry of named outputs; numbers from states                        |
| trajectory        | outputs over time, status, provenance, gaps of loops; save and load       |
| derivatives       | derivatives of outputs with respect to values                             |
| extremes          | smallest and largest values over continuous time, integrals               |
| quadrature        | samples of a column for its mean and integral                             |
| statistic_derivatives | derivatives of statistics over windows of a run                       |
| characteristics   | extremes, forces, torques, work and contacts of a run or a part of it     |
| start_up          | end of the start-up: journals cross clearances, films take up their loads |
| steady_state      | classification of the motion at the end of a run, and its steady cycle    |
| akima             | interpolation between samples                                             |
| measured          | comparison of measured with computed curves                               |
| impacts           | individual contacts; flight, impact and sustained contact                 |
| soundness         | singular positions, indeterminate forces: numbers without meaning         |
| divergence        | configurations of a linkage; time up to which two runs of one system agree |
| peak_errors       | errors of peaks, from a run at a tighter tolerance; rounding of outputs   |
| joint_validity    | validity of joint laws in a run                                           |
| films             | heat balance of the oil, error of a closed-form film in a run             |
| validity          | rules of validity, and their warnings; rules of flexible links            |
| warnings          | warnings about the reliability of a summary's numbers                     |
| assessment        | a run with its ideal linkage and error estimate                           |
| parts             | the whole run and its windows: numbers, differences, errors               |
| summary           | the summary of an assessment                                              |
| link_loads        | balanced loads of each link at an instant                                 |
| load_files        | the same for finite elements: loads.csv, LINK.inp                         |
| numerics          | numbers that tune the evaluation of results                               |
| shape             | a summary as data, and the schema of summary.json                         |
| file_shapes       | schemas of wear.json and record.json                                      |
"""
