"""Files: reading of SDFormat and TOML, shipped files, atomic writing of results.

It may import errors and `flexible`.

| module          | responsibility                                                      |
|-----------------|---------------------------------------------------------------------|
| xml             | tolerant reader of XML                                              |
| models          | the single model of an SDFormat file, without nested models         |
| places          | places of the numbers in an SDFormat file, by dotted path           |
| poses           | pose and inertia of one element                                     |
| sdf             | the part of SDFormat that describes a mechanism                     |
| raw_model       | content of a mechanism's file, in world coordinates                 |
| elements        | numbers in elements and annotations                                 |
| beams           | beam of a link, and the mass that follows from it                   |
| rigid           | move links; merge links that are fixed to each other                |
| urdf            | conversion of URDF to SDFormat                                      |
| importing       | import of mechanisms of other programs                              |
| foreign         | elements of other programs: converted, marked or rejected           |
| inertials       | mass and inertia that an SDFormat file leaves to its reader         |
| constraints     | welds, ball joints and springs between links                        |
| sdf_text        | write a mechanism as SDFormat                                       |
| description     | a mechanism in a few lines: points, links, parameters               |
| described_beam  | beam of a described link: ends, section, material                   |
| shorthand       | expansion of shorthand: one entry for many links, values with units |
| angles          | angles in descriptions need a unit                                  |
| drafting        | geometry and mass of a described mechanism                          |
| formula         | arithmetic on names, parsed and never executed                      |
| unit_conversion | values with units -> SI units                                       |
| toml            | typed tables, comments as sources, values replaced by dotted path   |
| table_keys      | keys of tables: allowed values, units                               |
| magnitudes      | plausible magnitudes, numbers as text                               |
| table_formats   | columns with units for other programs: CSV, MATLAB, Parquet, NetCDF |
| shipped         | mechanisms and experiments of the package                           |
| archives        | safe reading of NumPy archives                                      |
| reading         | complete text of a user's file                                      |
| writing         | atomic writing of files and folders                                 |
| lock            | one process at a time                                               |
| versions        | versions of the packages that determine the results                 |
"""
