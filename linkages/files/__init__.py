"""Files: SDFormat and TOML read, shipped ones found, results written whole or not at all. It may import only errors.

| module   | responsibility                                                              |
|----------|-----------------------------------------------------------------------------|
| sdf      | the part of SDFormat that describes a mechanism; its numbers by dotted path |
| toml     | typed tables, comments as sources, values replaced by dotted path           |
| numbers  | which numbers of a file are plausible                                         |
| shipped  | the machines and experiments that come with the package                     |
| writing  | files and folders that are written whole or not at all                      |
| lock     | one process at a time                                                       |
| versions | of the packages that determine the numbers                                  |
"""
