"""Files: SDFormat and TOML read, shipped ones found, results written whole or not at all.

It may import errors and `flexible`.

| module         | responsibility                                                          |
|----------------|-------------------------------------------------------------------------|
| xml            | elements of a file, as lenient as other readers                         |
| models         | the one model of an SDFormat file, without models in it                 |
| places         | where its numbers stand, by dotted path                                 |
| sdf            | the part of SDFormat that describes a mechanism                         |
| raw_model      | what a machine's file says, in world coordinates                        |
| elements       | numbers of elements, and of annotations                                 |
| beams          | the beam of a link, and the mass that follows from it                   |
| rigid          | links moved, and links that are fixed to one another made into one      |
| urdf           | URDF in the terms of SDFormat                                           |
| importing      | machines of other programs, and what was left out of them               |
| foreign        | elements that change the motion: entries of an experiment, refusals     |
| constraints    | welds, ball joints and springs between links                            |
| sdf_text       | a machine written as SDFormat                                           |
| description    | a machine in a few lines: points, links, parameters                     |
| described_beam | the beam of a described link: ends, section, material                   |
| shorthand      | one entry for many links, values with units, written out                |
| angles         | its angles need a unit                                                  |
| drafting       | its points found, its links weighed                                     |
| formula        | arithmetic on names, parsed and never executed                          |
| unit_conversion | values with units, in SI units                                          |
| toml           | typed tables, comments as sources, values replaced by dotted path       |
| table_keys     | what the keys of tables take, in which units                            |
| magnitudes     | which numbers of a file are plausible, how they are written for readers |
| table_formats  | columns with units for other programs: CSV, MATLAB, Parquet, NetCDF     |
| shipped        | the machines and experiments that come with the package                 |
| archives       | NumPy archives, read safely                                             |
| reading        | files of the user's, read whole                                         |
| writing        | files and folders that are written whole or not at all                  |
| lock           | one process at a time                                                   |
| versions       | of the packages that determine the numbers                              |
"""
