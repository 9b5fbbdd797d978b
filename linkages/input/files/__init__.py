"""Files: reading of SDFormat and TOML, shipped files, atomic writing of results.

It may import errors and `flexible`.

| module             | responsibility                                                      |
|--------------------|---------------------------------------------------------------------|
| reading            | complete reading of files: texts, NumPy archives                    |
| fits               | limits and fits of ISO 286                                          |
| general_tolerances | general tolerances of ISO 2768                                      |
| shipped            | mechanisms and experiments of the package                           |
| toml               | typed tables, comments as sources, values replaced by dotted path   |
| entry              | objects of files of results: attributes in a program, keys in a file |
| table_keys         | keys of tables: allowed values, units                               |
| unit_conversion    | values with units -> SI units                                       |
| formula            | arithmetic on names, parsed and never executed                      |
| magnitudes         | plausible magnitudes, numbers as text                               |
| xml                | tolerant reader of XML                                              |
| elements           | content of single elements: numbers, poses, inertia                 |
| beams              | beam of a link, and the mass that follows from it                   |
| models             | the single model of an SDFormat file, without nested models         |
| raw_model          | content of a mechanism's file, in world coordinates                 |
| rigid              | move links, merge fixed ones; inertia that a file leaves out        |
| sdf                | the part of SDFormat that describes a mechanism                     |
| description        | a mechanism in a few lines: points, links, parameters               |
| shorthand          | expansion of shorthand: one entry for many links, values with units |
| drafting           | geometry and mass of a described mechanism                          |
| described_model    | its tables, and the links, joints, beams and frames of it           |
| importing          | import of mechanisms of other programs                              |
| urdf               | conversion of URDF to SDFormat                                      |
| mjcf               | conversion of MJCF, MuJoCo's format, to SDFormat                    |
| mjcf_defaults      | its included files, default classes, angles and frames              |
| mjcf_shapes        | its inertia of shapes, its visuals                                  |
| mjcf_actuators     | its actuators: springs, dampers, notes                              |
| xacro_text         | expansion of xacro                                                  |
| formats            | formats that are not read, by name                                  |
| joint_places       | joints at their own poses, or at frames named as their parents      |
| pairs              | universal and ball joints, written as hinges at one place           |
| foreign            | elements of other programs: converted, marked or rejected           |
| constraints        | welds, ball joints and springs between links                        |
| writing            | atomic writing of files and folders, locks                          |
| sdf_text           | write a mechanism as SDFormat                                       |
| table_formats      | columns with units for other programs: CSV, MATLAB, Parquet, NetCDF |
| recorded           | data files: columns with units of CSV, MATLAB, Parquet, NumPy       |
| versions           | versions of the packages that determine the results                 |
"""
