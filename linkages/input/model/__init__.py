"""Validated input: mechanism (SDFormat) and experiment (TOML). It may import files, laws and `planar`.

| module            | responsibility                                                                   |
|-------------------|----------------------------------------------------------------------------------|
| mechanism         | `Mechanism`: links, joints, frames in the reference configuration, from SDFormat |
| experiment        | `Experiment`: drives, joint models, loads, settings, from TOML                   |
| experiment_tables | tables of joint models, solver                                                   |
| output_names      | names of outputs that can be requested, with meanings and units                  |
| beam_interfaces   | flexible links: interfaces at joints and loads, substructures                    |
| segment_model     | flexible links as chains of rigid segments with springs                          |
| editing           | texts of experiments with other values                                           |
| worn              | worn profiles of joints from a ``wear.json``                                     |
| skeleton          | default shape of a link: bars between its joints and frames                      |
| plausibility      | questions about values that suggest a wrong unit                                 |
| capabilities      | which model does not support which analysis: one table, one check                |
| check             | consistency of a mechanism and an experiment                                     |
"""
