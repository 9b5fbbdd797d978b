"""What every folder uses: types of arrays, errors, checked arguments, short texts, files, interrupts, the compiler.

| module    | responsibility                                                                                       |
|-----------|------------------------------------------------------------------------------------------------------|
| arrays    | types of arrays, for annotations                                                                     |
| errors    | exceptions for bad input and failed runs, named statuses of runs with remedies                       |
| brief     | short texts: an object in one line, counted nouns, cells of tables                                   |
| palette   | colours, lines and sizes of all media                                                                |
| signals   | SIGINT (Ctrl-C) and SIGTERM end a command alike, and can be deferred to the end of a short block     |
| disk      | atomic writing of files, and a cache on disk whose entries are verified when read                    |
| packages  | packages that an environment may lack: one line says which, and how to install it                    |
| arguments | arguments of public functions: converted and checked at the call, errors in one line                 |
| kernel    | how functions are compiled: `kernel` and its relatives, named tuples by reference, calls by address  |
"""
