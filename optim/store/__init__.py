"""The file of a study, which keeps every evaluation and iteration; it runs nothing.

| module | responsibility                                        |
|--------|-------------------------------------------------------|
| sqlite | SQLite files: recognised, checked, errors of one line |
| store  | `Store`, `create`, `open_store`, `read_store`         |
"""
