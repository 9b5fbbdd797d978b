"""The live page: change a value, and see motion, orbits and forces of the machine at once.

| module    | responsibility                                                                              |
|-----------|---------------------------------------------------------------------------------------------|
| controls  | which values of an experiment and its machine can be changed, and within which ranges       |
| units     | systems of units in which the page shows values                                             |
| edits     | changes of parts as values: models of joints and links                                      |
| changes   | changed values that change nothing in a run are refused                                     |
| pins      | pins that are moved in a shown pose, as changes of lengths                                  |
| exploring | sweeps, sensitivities and tolerances around the run that is shown                           |
| keeping   | files of the run that a page shows: experiments, folders of results, notebooks              |
| pinned    | the page of runs that were pinned                                                           |
| watch     | ends computations whose requests are outdated, or that take too long                        |
| session   | one machine that is changed again and again: the steady motion for the values of a request  |
| view      | a run as the numbers that the page draws: poses, curves, orbits, a table of peaks           |
| answers   | requests of the front end -> replies, files; the front end, and as a notebook's widget      |
| server    | the page on 127.0.0.1: token, checks of each request, one computation at a time             |

The front end is a few ES modules, which serve page and notebook, with ``curves.js`` of the reports. Values from it have
the rights of values in a file, and no others.
"""
