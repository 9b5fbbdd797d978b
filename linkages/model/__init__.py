"""What a user writes, checked: the machine for ever, and what is done with it. It may import files, laws and `planar`.

| module         | responsibility                                                               |
|----------------|------------------------------------------------------------------------------|
| mechanism      | `Mechanism`: links, joints, frames in the drawn pose, from SDFormat          |
| experiment     | `Experiment`: drives, joint models, loads, settings, from TOML               |
| experiment_tables | the tables of an experiment: drives, joint models, solver                    |
| law_tables     | tables that name a law, with the parameters that the law declares            |
| load_tables    | its tables of applied loads: forces, torques, springs                        |
| gear           | the table of its gears and belts                                             |
| contact_tables | its tables of limit stops and points at straight lines                       |
| link_tables    | its tables of links: which of them bend                                      |
| beam_interfaces | links that bend: where they are held and loaded                              |
| segment_model  | flexible links as rows of rigid segments with springs                        |
| functions      | formulas and tables of time, positions and speeds                            |
| skeleton       | what a link looks like: bars between its joints and frames                   |
| plausibility   | values that look like those of another unit                                  |
| check          | do a mechanism and an experiment fit each other?                             |
"""
