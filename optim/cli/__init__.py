"""The commands that this package adds to ``linkages``, through entry points of the group ``linkages.cli``.

| module   | command                                                            |
|----------|--------------------------------------------------------------------|
| optimise | ``linkages optimise``: solve design problems                       |
| study    | ``linkages study show`` and ``export``: look into a study's store  |
"""
