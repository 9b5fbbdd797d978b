"""The commands that this package adds to ``linkages``, through entry points of the group ``linkages.commands``.

| module     | responsibility                                                                 |
|------------|--------------------------------------------------------------------------------|
| optimise   | ``linkages optimise``: solve design studies                                    |
| identify   | ``linkages identify``: values that explain measurements, plans                 |
| tolerances | ``linkages tolerances``: yields by tolerances                                  |
| study      | ``linkages study show``, ``export``, ``sensitivity``                           |
| seeds      | seeds of a command line                                                        |
"""
